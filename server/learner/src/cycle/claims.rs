//! What claims say of schemas: which observations a schema's conditions are, what it brings about, and which laws hold.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::cycle::generalisation::Hypothesis;
use crate::memory::evidence::{Foretold, Part, View, parameters};
use crate::memory::{Content, Memory};
use crate::nouns::claim::{Change, Condition, Expression, Reference, Sketch};
use crate::nouns::effect::Effect;
use crate::nouns::execution::Execution;
use crate::nouns::experience::{Experience, Recalled};
use crate::nouns::observation::{
    Observation, Pattern, PropertyId, Substitution, Term, TypeId, Value, Variable,
};
use crate::nouns::schema::{Generalised, SchemaId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// How often it is taken in that an episode ends in one and the same context: claims know it by then.
const ENDS_KNOWN: u32 = 16;

/// The part of a world state that claims may ask for: what lasts and does not come from others.
pub(crate) fn context(content: &Content, world: &WorldState) -> WorldState {
    let declared = |o: &Observation| content.vocabulary.types().get(usize::from(o.kind().0));
    world.filter(|o| declared(o).is_some_and(|known| !known.declared.transient && !known.declared.heard))
}

/// The same of what an action makes of a context, with what is supposed then.
pub(crate) fn context_after(
    content: &Content,
    before: &[Observation],
    action: PrimitiveId,
    after: &WorldState,
) -> WorldState {
    let on = content.items.all.iter().map(|item| {
        let on = before.binary_search(&item.observation(true)).is_ok();
        item.follow(on, action, after.observations())
    });
    context(content, &content.items.with(on, after))
}

/// What claims foretell of `primitive` in `world`, of each facet; nothing while no claims are kept.
pub(crate) fn foretell(
    content: &Content,
    body: Option<BodyId>,
    primitive: PrimitiveId,
    world: &WorldState,
) -> Vec<Foretold> {
    if !content.mechanisms.claims {
        return Vec::new();
    }
    content.evidence.foretell(&content.vocabulary, body, primitive, context(content, world).observations())
}

/// What an execution that was carried out teaches, as evidence.
pub(crate) fn experience(
    memory: &Memory,
    body: BodyId,
    execution: &Execution,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
) -> Effect {
    let content = memory.content();
    let after = outcome(memory, after);
    let recalled = content.mechanisms.recalls().then(|| {
        content.evidence.recalled(&content.vocabulary, body, execution.action, after.observations())
    });
    Effect::Experienced(Box::new(Experience {
        body,
        recalled: recalled.flatten(),
        primitive: execution.action,
        parameters: parameters(&content.vocabulary, execution.action),
        before: context(content, &execution.before).observations().into(),
        after: after.observations().into(),
        sensed: sensed(memory, lifted),
    }))
}

/// What it teaches that an episode had ended where an execution was decided, so that it was not carried out: nothing leads on from
/// there, whatever is done. It is evidence until it is known well.
pub(crate) fn end(
    memory: &Memory,
    body: BodyId,
    execution: &Execution,
    lifted: &dyn Fn(TypeId) -> bool,
) -> Option<Effect> {
    let Content { vocabulary, evidence, .. } = memory.content();
    let before = context(memory.content(), &execution.before);
    if evidence.ended(before.observations()).0 >= ENDS_KNOWN {
        return None;
    }
    let after: Arc<[_]> = outcome(memory, &before).observations().into();
    Some(Effect::Experienced(Box::new(Experience {
        body,
        recalled: Some(Recalled { observations: Arc::clone(&after), age: 0 }),
        primitive: execution.action,
        parameters: parameters(vocabulary, execution.action),
        before: before.observations().into(),
        after,
        sensed: sensed(memory, lifted),
    })))
}

/// Whether an episode had ended whenever something was to be done in this world state, as far as is remembered; and that was so.
pub(crate) fn ended(memory: &Memory, world: &WorldState) -> bool {
    let content = memory.content();
    let (ends, all) = content.evidence.ended(context(content, world).observations());
    content.mechanisms.claims && all > 0 && ends == all
}

/// The part of a world state that comes of what was done: neither what comes from others, nor what is supposed, which is not sensed and may be
/// a condition only.
fn outcome(memory: &Memory, world: &WorldState) -> WorldState {
    let items = &memory.content().items;
    world.filter(|o| !memory.rules().of(o.kind()).heard && items.of_kind(o.kind()).is_none())
}

/// The types of which it is known whether anything was there.
fn sensed(memory: &Memory, lifted: &dyn Fn(TypeId) -> bool) -> Arc<[TypeId]> {
    let types = 0..u16::try_from(memory.content().vocabulary.types().len()).unwrap_or(u16::MAX);
    let sensed = types.map(TypeId).filter(|kind| {
        lifted(*kind) && !memory.rules().of(*kind).heard && memory.content().items.of_kind(*kind).is_none()
    });
    sensed.collect()
}

/// What claims say of an action in one world state.
pub(crate) struct Expectation {
    /// What is likely to change, but for what claims tell of all numbers alike, by a difference, or of each observation by itself: there they
    /// say more than schemas could.
    pub(crate) told: Part,
    foretold: Vec<Foretold>,
}

/// What is expected of `primitive` in `before`: of each facet the outcome that follows often enough to be predicted.
pub(crate) fn expectation(
    memory: &Memory,
    body: BodyId,
    primitive: PrimitiveId,
    before: &WorldState,
) -> Expectation {
    let content = memory.content();
    let context = context(content, before);
    let mut foretold =
        content.evidence.foretell(&content.vocabulary, Some(body), primitive, context.observations());
    // No schema tells of a value, unless a parameter says so.
    foretold.retain(|facet| !facet.kinds.iter().any(|kind| memory.rules().of(*kind).is_apart()));
    let share = memory.parameters().prediction_ratio_min;
    let often = |count: u32, trials: u32| f64::from(count) >= share * f64::from(trials);
    let (mut parts, mut together) = (Vec::new(), Vec::new());
    for mut facet in foretold {
        if facet.is_of_each {
            let likely = |part: &Part| part.attributed && often(part.count, part.trials);
            parts.extend(std::mem::take(&mut facet.parts).into_iter().filter(likely));
            continue;
        }
        let Some((after, count)) = facet.outcomes.first() else { continue };
        // What came once in this very context is no memory of it yet.
        if facet.view == View::Remembered && facet.trials < 2 {
            continue;
        }
        if !facet.attributed || !often(*count, facet.trials) {
            continue;
        }
        let of_facet = |o: &&Observation| facet.kinds.binary_search(&o.kind()).is_ok();
        if !context.observations().iter().filter(of_facet).eq(after.iter()) {
            let gone = context.observations().iter().filter(of_facet).filter(|o| !after.contains(o));
            let change = facet.claim.as_ref().map(|(_, change)| change);
            parts.push(Part {
                observed: after.clone(),
                vanished: gone.cloned().collect(),
                relied_on: facet.relied_on.clone(),
                count: *count,
                trials: facet.trials,
                of_all: change.is_some_and(|change| change.sketches().any(Sketch::differs)),
                names_action: false,
                attributed: true,
            });
        }
        together.push(facet);
    }
    let mut told = Part::default();
    for part in parts.iter().filter(|part| !part.of_all) {
        told.observed.extend(part.observed.iter().cloned());
        told.vanished.extend(part.vanished.iter().cloned());
        told.relied_on.extend(part.relied_on.iter().cloned());
    }
    Expectation { told, foretold: together }
}

impl Expectation {
    /// The law that the general claims in force are, if they name what they are about by the action's own effect; with none of the
    /// values given that they need not give.
    pub(crate) fn law(
        &self,
        memory: &Memory,
        primitive: PrimitiveId,
        before: &WorldState,
    ) -> Option<Hypothesis> {
        let general = self.foretold.iter().filter(|facet| facet.view == View::General);
        let claims: Vec<_> = general.filter_map(|facet| facet.claim.as_ref()).collect();
        let effect = memory.content().evidence.effect(&memory.content().vocabulary, primitive)?;
        let context = context(memory.content(), before);
        let mut law = Lifting {
            context: &context,
            effect,
            parameters: parameters(&memory.content().vocabulary, primitive),
            count: 0,
            named: BTreeMap::new(),
            pre: Vec::new(),
        };
        let conditional = claims.iter().any(|(conditions, _)| !conditions.is_empty());
        for (conditions, _) in &claims {
            conditions.iter().try_for_each(|condition| law.condition(condition))?;
        }
        let mut post = Vec::new();
        for (_, change) in &claims {
            law.change(change, &mut post)?;
        }
        let target = law.target()?;
        law.subsume(&target);
        let pre = law.pre;
        let told = post.iter().any(|(what, absent)| !absent && !target.contains(what));
        // The target comes about as well, whichever claims tell so.
        post.extend(target.iter().map(|what| (what.clone(), false)));
        post.sort_unstable();
        post.dedup();
        (conditional && told && !target.is_empty()).then_some(Hypothesis { pre, target, post })
    }
}

/// A law in the making.
struct Lifting<'a> {
    context: &'a WorldState,
    effect: &'a [Observation],
    parameters: Arc<[Option<Value>]>,
    /// How many variables there are.
    count: u8,
    named: BTreeMap<Reference, Variable>,
    pre: Vec<Pattern>,
}

impl Lifting<'_> {
    /// A variable that is nowhere else.
    fn fresh(&mut self) -> Option<Variable> {
        let next = Variable(self.count);
        self.count = self.count.checked_add(1)?;
        Some(next)
    }

    /// The observation that the action brings about of itself of this type.
    fn brought(&self, kind: TypeId) -> Option<&Observation> {
        self.effect.iter().rfind(|o| o.kind() == kind)
    }

    /// The value of a parameter, as one that the action brings about.
    fn brings_about(&self, parameter: u8) -> Option<Reference> {
        let value = (*self.parameters.get(usize::from(parameter))?)?;
        self.effect.iter().find_map(|o| {
            let (property, _) = o.properties().iter().find(|(_, brought)| *brought == value)?;
            Some(Reference::Effect(o.kind(), *property))
        })
    }

    /// The target: what the action brings about of itself, as far as conditions speak of it. What they do not speak of is as it is here.
    fn target(&self) -> Option<Vec<Pattern>> {
        let mut kinds: Vec<_> = self
            .named
            .keys()
            .filter_map(|reference| match reference {
                Reference::Effect(kind, _) => Some(*kind),
                _ => None,
            })
            .collect();
        kinds.dedup();
        let pattern = |kind: TypeId| {
            let terms = self.brought(kind)?.properties().iter().map(|(property, value)| {
                let variable = self.named.get(&Reference::Effect(kind, *property));
                (*property, variable.map_or(Term::Constant(*value), |variable| Term::Variable(*variable)))
            });
            Some(Pattern::new(kind, terms))
        };
        kinds.into_iter().map(pattern).collect()
    }

    /// The variable of a reference, with what binds it: the target, or a pre-condition.
    fn variable(&mut self, reference: Reference) -> Option<Variable> {
        if let Some(known) = self.named.get(&reference) {
            return Some(*known);
        }
        match reference {
            // Which parameter has the value is known of the primitive that was carried out; a target needs what it brings about.
            Reference::Parameter(at) => {
                let brought = self.brings_about(at)?;
                let variable = self.variable(brought)?;
                self.named.insert(reference, variable);
            }
            Reference::Effect(..) => {
                let variable = self.fresh()?;
                self.named.insert(reference, variable);
            }
            Reference::Only(kind, _) => {
                let one = self.context.observations().iter().find(|o| o.kind() == kind)?.clone();
                let pattern = self.whole(&one, |property| Reference::Only(kind, property))?;
                self.pre.push(pattern);
            }
            // A claim about each observation is no law.
            Reference::Itself(_) | Reference::Recalled(..) | Reference::Age => return None,
            Reference::Tied { from, kind, at, to } => {
                let anchor = self.variable(from.into())?;
                let variable = self.fresh()?;
                self.named.insert(reference, variable);
                let given = vec![(at, Term::Variable(anchor)), (to, Term::Variable(variable))];
                let pattern = self.completed(kind, given)?;
                self.pre.push(pattern);
            }
        }
        self.named.get(&reference).copied()
    }

    /// An observation with a variable for each of its properties, by the reference to it.
    fn whole(&mut self, one: &Observation, reference: impl Fn(PropertyId) -> Reference) -> Option<Pattern> {
        let mut terms = Vec::new();
        for (property, _) in one.properties() {
            let variable = self.fresh()?;
            self.named.insert(reference(*property), variable);
            terms.push((*property, Term::Variable(variable)));
        }
        Some(Pattern::new(one.kind(), terms))
    }

    /// A pattern of these terms, with a variable of its own for each other property of the type.
    fn completed(&mut self, kind: TypeId, mut terms: Vec<(PropertyId, Term)>) -> Option<Pattern> {
        let one = self.context.observations().iter().find(|o| o.kind() == kind)?.clone();
        for (property, _) in one.properties() {
            if !terms.iter().any(|(known, _)| known == property) {
                terms.push((*property, Term::Variable(self.fresh()?)));
            }
        }
        Some(Pattern::new(kind, terms))
    }

    /// The term in a condition, or in what follows.
    fn term(&mut self, expression: Expression, condition: bool) -> Option<Term> {
        match expression {
            Expression::Named(reference @ Reference::Effect(kind, property), 0)
                if !condition && !self.named.contains_key(&reference) =>
            {
                let brought =
                    self.brought(kind)?.properties().iter().find(|(known, _)| *known == property)?;
                Some(Term::Constant(brought.1))
            }
            Expression::Constant(value) => Some(Term::Constant(value)),
            Expression::Named(reference, 0) => self.variable(reference).map(Term::Variable),
            Expression::Named(..) => None,
        }
    }

    fn terms(&mut self, sketch: &Sketch, condition: bool) -> Option<Vec<(PropertyId, Term)>> {
        sketch.properties.iter().map(|(property, e)| Some((*property, self.term(*e, condition)?))).collect()
    }

    fn condition(&mut self, condition: &Condition) -> Option<()> {
        let Condition::Observed(sketch) = condition else { return None };
        let terms = self.terms(sketch, true)?;
        let pattern = self.completed(sketch.kind, terms)?;
        self.pre.push(pattern);
        Some(())
    }

    fn change(&mut self, change: &Change, post: &mut Vec<(Pattern, bool)>) -> Option<()> {
        for (sketches, absent) in
            [(&change.becomes, false), (&change.appears, false), (&change.vanishes, true)]
        {
            for sketch in sketches {
                post.push((Pattern::new(sketch.kind, self.terms(sketch, false)?), absent));
            }
        }
        Some(())
    }

    /// Drops each pre-condition that another says with more constants or names: both are of one observation.
    fn subsume(&mut self, target: &[Pattern]) {
        let shared: Vec<_> = self.pre.clone();
        let counts = |variable: Variable| {
            let terms = shared.iter().chain(target).flat_map(Pattern::terms);
            terms.filter(|(_, term)| *term == Term::Variable(variable)).count()
        };
        let loose = |term: &Term| matches!(term, Term::Variable(v) if counts(*v) == 1);
        let says = |a: &Pattern, b: &Pattern| {
            a.kind() == b.kind()
                && a.terms().iter().zip(b.terms()).all(|((p, x), (q, y))| p == q && (x == y || loose(y)))
        };
        let mut kept: Vec<Pattern> = Vec::new();
        for (at, pattern) in shared.iter().enumerate() {
            let others = shared.iter().enumerate().filter(|(other, _)| *other != at);
            let said = others
                .into_iter()
                .any(|(other, more)| says(more, pattern) && (!says(pattern, more) || other < at));
            if !said {
                kept.push(pattern.clone());
            }
        }
        self.pre = kept;
    }
}

/// Whether a law is what the claims in force make of an action here: where others are in force, others are "selected instead".
pub(crate) fn makes(
    memory: &Memory,
    body: BodyId,
    action: PrimitiveId,
    world: &WorldState,
    law: &Generalised,
) -> bool {
    let made = expectation(memory, body, action, world).law(memory, action, world);
    made.is_some_and(|made| made.equals(law))
}

/// Whether claims let a law be executed here by an action that achieves its target, or what is left of it when others have achieved what is
/// then `held`. It must be what the claims in force make of the action, unless the action was never carried out where the law's pre-conditions
/// held with that: then nobody knows otherwise.
pub(crate) fn allow(
    memory: &Memory,
    (body, action): (BodyId, PrimitiveId),
    world: &WorldState,
    (law, binding): (&Generalised, &Substitution),
    held: &[Observation],
) -> bool {
    if makes(memory, body, action, world, law) {
        return true;
    }
    if held.is_empty() {
        return false;
    }
    let pre = law.pre.iter().filter_map(|what| what.apply(binding));
    let there = WorldState::new(pre.chain(held.iter().cloned()));
    let content = memory.content();
    !content.evidence.was_tried_with(&content.vocabulary, action, there.observations())
}

/// The law that is made of the claims in force, if it is new.
pub(crate) fn generalise(
    memory: &Memory,
    execution: &Execution,
    expectation: &Expectation,
    parent: SchemaId,
) -> Option<Effect> {
    if memory.is_full() || !memory.parameters().generalisation {
        return None;
    }
    let law = expectation.law(memory, execution.action, &execution.before)?;
    if law.is_known(memory) {
        return None;
    }
    let Hypothesis { pre, target, post } = law;
    Some(Effect::Generalised { pre, target, post, parent, examples: vec![parent] })
}
