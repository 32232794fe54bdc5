//! What numbers may refer to. Memory refers to its parts by number, so a number that was read is looked up nowhere before
//! it is known that something has it.

use std::sync::Arc;

use pschema_learner::Frame;
use pschema_learner::claim::{Condition, Expression, Reference, Sketch};
use pschema_learner::execution::{ChainLink, Execution};
use pschema_learner::experience::Experience;
use pschema_learner::item::{EVENTS_MAX, Item};
use pschema_learner::memory::Content;
use pschema_learner::observation::{Observation, Pattern, PropertyId, Substitution, TypeId};
use pschema_learner::policy::Policy;
use pschema_learner::probability::Count;
use pschema_learner::progress::Progress;
use pschema_learner::pursuit::{Goal, PLANS_KEPT_MAX, Pursuit};
use pschema_learner::schema::{ASSOCIATIONS_MAX, Form, ObservationId, PostCondition, Schema, SchemaId};
use pschema_learner::vocabulary::{BodyId, PrimitiveId, Vocabulary};

use crate::content_error::ContentError;

type Checked = Result<(), ContentError>;

/// Steps that a memory can have taken: as many as every reader of JSON can count. At 1,000 steps a second they take some
/// 285,000 years.
pub(crate) const STEPS_MAX: u64 = 1 << 53;

/// What there is in a memory, and how much of it.
#[derive(Clone, Debug)]
pub(crate) struct Extent {
    pub(crate) vocabulary: Arc<Vocabulary>,
    pub(crate) observations: usize,
    pub(crate) schemas: usize,
}

impl Extent {
    /// Of a memory as it is.
    pub(crate) fn of(content: &Content) -> Self {
        let vocabulary = content.vocabulary.clone();
        Self { vocabulary, observations: content.observations.len(), schemas: content.schemas.len() }
    }

    /// An observation.
    pub(crate) fn observation(&self, observation: &Observation) -> Checked {
        declared(self.vocabulary.knows(observation))
    }

    /// A frame of a body.
    pub(crate) fn frame(&self, frame: &Frame) -> Checked {
        self.body(frame.body)?;
        frame.observations.iter().try_for_each(|one| self.observation(one))
    }

    /// A schema, which may refer to later ones.
    pub(crate) fn schema(&self, schema: &Schema) -> Checked {
        match &schema.form {
            Form::Concrete(form) => {
                self.primitive(form.action)?;
                form.pre.iter().try_for_each(|id| self.observation_id(*id))?;
                posts(&form.post, |id| self.observation_id(*id))?;
                form.contradicts.map_or(Ok(()), |id| self.schema_id(id))?;
            }
            Form::Generalised(form) => {
                form.pre.iter().chain(&form.target).try_for_each(|pattern| self.pattern(pattern))?;
                posts(&form.post, |pattern| self.pattern(pattern))?;
                form.examples.iter().chain(&form.counter_examples).try_for_each(|id| self.schema_id(*id))?;
            }
        }
        counted(schema.executions)?;
        limited("associations of a schema", schema.associations.len(), ASSOCIATIONS_MAX)?;
        schema.associations.iter().try_for_each(|one| {
            counted(one.count)?;
            self.observation_id(one.observation)
        })?;
        schema.parent.map_or(Ok(()), |id| self.schema_id(id))
    }

    /// Where a curriculum stands.
    pub(crate) fn progress(&self, progress: &Progress) -> Checked {
        progress.student.map_or(Ok(()), |body| self.body(body))
    }

    /// A goal and the plans for it.
    pub(crate) fn pursuit(&self, pursuit: &Pursuit) -> Checked {
        self.body(pursuit.body)?;
        self.goal(&pursuit.goal)?;
        limited("plans", pursuit.plans.len(), PLANS_KEPT_MAX)?;
        pursuit.plans.iter().flat_map(|plan| &plan.chain).try_for_each(|link| self.link(link))
    }

    /// What is wanted.
    pub(crate) fn goal(&self, goal: &Goal) -> Checked {
        goal.patterns().iter().try_for_each(|pattern| self.pattern(pattern))?;
        declared(goal.most().is_none_or(|kind| self.vocabulary.is_value(kind)))
    }

    /// What to do on the way to a goal.
    pub(crate) fn policy(&self, policy: &Policy) -> Checked {
        self.kinds(&policy.kinds)?;
        self.kinds(&policy.chance)?;
        let contexts = policy.rows.iter().flat_map(|row| &row.context);
        contexts.chain(&policy.circumstances).try_for_each(|one| self.observation(one))?;
        policy.rows.iter().try_for_each(|row| self.primitive(row.action))?;
        if policy.is_sound() {
            return Ok(());
        }
        Err(ContentError::new("a policy has too many contexts, or parts that do not fit together".to_owned()))
    }

    /// What a body was sent to do.
    pub(crate) fn execution(&self, body: BodyId, execution: &Execution) -> Checked {
        self.body(body)?;
        self.primitive(execution.action)?;
        execution.schema.iter().chain(&execution.carrier).try_for_each(|id| self.schema_id(*id))?;
        self.binding(&execution.binding)?;
        execution.chain.iter().try_for_each(|link| self.link(link))?;
        execution.before.observations().iter().try_for_each(|one| self.observation(one))
    }

    /// An experience. Which pool it may be in, and so with which primitive, is for evidence to say.
    pub(crate) fn experience(&self, experience: &Experience) -> Checked {
        let Experience { body, primitive: _, parameters, before, after, sensed, recalled } = experience;
        self.body(*body)?;
        let recalled = recalled.as_ref().map_or(&[][..], |recalled| &recalled.observations);
        before.iter().chain(after.iter()).chain(recalled).try_for_each(|one| self.observation(one))?;
        declared(parameters.iter().flatten().all(|value| self.vocabulary.knows_value(*value)))?;
        self.kinds(sensed)?;
        let ordered = [before, after, recalled].iter().all(|list| list.is_sorted_by(|a, b| a < b));
        if ordered && sensed.is_sorted_by(|a, b| a < b) {
            return Ok(());
        }
        Err(ContentError::new("the lists of an experience are out of order"))
    }

    /// Types, by number.
    pub(crate) fn kinds(&self, kinds: &[TypeId]) -> Checked {
        let types = self.vocabulary.types().len();
        kinds.iter().try_for_each(|kind| within("observation type", usize::from(kind.0), types))
    }

    /// A condition of a claim about what is done with so many parameters.
    pub(crate) fn condition(&self, parameters: usize, condition: &Condition) -> Checked {
        match condition {
            Condition::Observed(sketch) | Condition::Recalled(sketch) => self.sketch(parameters, sketch),
            Condition::Is(anchor, value) => {
                declared(self.vocabulary.knows_value(*value))?;
                self.reference(parameters, (*anchor).into())
            }
            Condition::AtLeast(anchor, _) => self.reference(parameters, (*anchor).into()),
        }
    }

    /// An observation in such a claim.
    pub(crate) fn sketch(&self, parameters: usize, sketch: &Sketch) -> Checked {
        self.kinds(&[sketch.kind])?;
        for (property, expression) in &sketch.properties {
            self.property(*property)?;
            match expression {
                Expression::Named(reference, _) => self.reference(parameters, *reference)?,
                Expression::Constant(value) => declared(self.vocabulary.knows_value(*value))?,
            }
        }
        if sketch.properties.is_sorted_by(|a, b| a.0 < b.0) {
            return Ok(());
        }
        Err(ContentError::new("the properties in a claim are out of order"))
    }

    fn reference(&self, parameters: usize, reference: Reference) -> Checked {
        match reference {
            Reference::Parameter(at) => within("parameter", usize::from(at), parameters),
            Reference::Itself(property) => self.property(property),
            Reference::Age => Ok(()),
            Reference::Effect(kind, property)
            | Reference::Only(kind, property)
            | Reference::Recalled(kind, property) => {
                self.kinds(&[kind])?;
                self.property(property)
            }
            Reference::Tied { from, kind, at, to } => {
                self.reference(parameters, from.into())?;
                self.kinds(&[kind])?;
                self.property(at)?;
                self.property(to)
            }
        }
    }

    fn property(&self, property: PropertyId) -> Checked {
        within("property", usize::from(property.0), self.vocabulary.properties().len())
    }

    /// The same of a body's own experience, which is with one of the primitives.
    pub(crate) fn lived(&self, experience: &Experience) -> Checked {
        if experience.is_beginning() {
            return self.body(experience.body);
        }
        self.primitive(experience.primitive)?;
        self.experience(experience)
    }

    /// A synthetic item.
    pub(crate) fn item(&self, item: &Item) -> Checked {
        let Item { kind, property, primitive, kinds, updates, dropped: _ } = item;
        self.primitive(*primitive)?;
        let types = self.vocabulary.types().len();
        let mut all = [kind].into_iter().chain(kinds);
        all.try_for_each(|kind| within("observation type", usize::from(kind.0), types))?;
        self.observation(&item.observation(true))?;
        within("property", usize::from(property.0), self.vocabulary.properties().len())?;
        limited("events of a synthetic item", updates.len(), EVENTS_MAX)?;
        for (event, _) in updates.iter().filter(|(event, _)| !event.is_beginning()) {
            self.primitive(event.primitive)?;
            event.after.iter().try_for_each(|one| self.observation(one))?;
        }
        let ordered = kinds.is_sorted_by(|a, b| a < b)
            && updates.is_sorted_by(|a, b| a.0 < b.0)
            && updates.iter().all(|(event, _)| event.after.is_sorted_by(|a, b| a < b));
        if ordered {
            Ok(())
        } else {
            Err(ContentError::new("the lists of a synthetic item are out of order"))
        }
    }

    fn link(&self, link: &ChainLink) -> Checked {
        self.schema_id(link.schema)?;
        link.carrier.map_or(Ok(()), |carrier| self.schema_id(carrier))?;
        self.binding(&link.binding)
    }

    fn pattern(&self, pattern: &Pattern) -> Checked {
        declared(self.vocabulary.knows_pattern(pattern))
    }

    fn binding(&self, binding: &Substitution) -> Checked {
        declared(binding.bindings().iter().all(|(_, value)| self.vocabulary.knows_value(*value)))
    }

    fn schema_id(&self, id: SchemaId) -> Checked {
        within("schema", id.index(), self.schemas)
    }

    fn observation_id(&self, id: ObservationId) -> Checked {
        within("observation", id.index(), self.observations)
    }

    fn primitive(&self, id: PrimitiveId) -> Checked {
        within("primitive", id.0 as usize, self.vocabulary.primitives().len())
    }

    pub(crate) fn body(&self, id: BodyId) -> Checked {
        within("body", usize::from(id.0), self.vocabulary.bodies().len())
    }
}

fn posts<T>(posts: &[PostCondition<T>], check: impl Fn(&T) -> Checked) -> Checked {
    posts.iter().try_for_each(|post| {
        counted(post.count)?;
        check(&post.what)
    })
}

/// Whether nothing happened more often than it was tried.
pub(crate) fn counted(Count { occurrences, trials }: Count) -> Checked {
    if occurrences <= trials {
        Ok(())
    } else {
        Err(ContentError::new(format!("something happened {occurrences} times in {trials} trials")))
    }
}

fn declared(known: bool) -> Checked {
    if known {
        Ok(())
    } else {
        Err(ContentError::new(
            "it speaks of an observation type, a property or a symbol that was never declared",
        ))
    }
}

/// Whether one of `count` things has this number.
pub(crate) fn within(what: &'static str, number: usize, count: usize) -> Checked {
    if number < count {
        Ok(())
    } else {
        Err(ContentError::new(format!(
            "it refers to {what} {number}, and there are {count}, numbered from 0"
        )))
    }
}

/// Whether so many are not too many.
pub(crate) fn limited(what: &'static str, count: usize, limit: usize) -> Checked {
    if count <= limit { Ok(()) } else { Err(ContentError::limit(what, limit)) }
}
