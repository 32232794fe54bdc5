//! What an effect must be to be applied. All of it is checked before anything changes, and covers what memory relies on
//! afterwards: every number refers to something, every list is within its limit and in its order, and nothing is there twice
//! that may be there once. A check takes no more time than the effect and the schema that it is about are long.

use std::collections::BTreeMap;

use crate::memory::content::Content;
use crate::memory::index::Index;
use crate::nouns::curriculum::UTTERANCES_MAX;
use crate::nouns::effect::Effect;
use crate::nouns::effect_error::EffectError;
use crate::nouns::execution::{ChainLink, Execution};
use crate::nouns::experience::Experience;
use crate::nouns::item::{EVENTS_MAX, Event, ITEMS_MAX, Update};
use crate::nouns::observation::{Observation, Pattern, Substitution, TypeId};
use crate::nouns::parameters::CHAIN_LENGTH_MAX;
use crate::nouns::policy::Policy;
use crate::nouns::progress::{Progress, StageEffect};
use crate::nouns::pursuit::{GOAL_ACTIONS_MAX, GOAL_PATTERNS_MAX, Goal, PlanRecord, Pursuit, PursuitEffect};
use crate::nouns::schema::{
    ASSOCIATIONS_MAX, Concrete, Form, Generalised, POST_CONDITIONS_MAX, SCHEMAS_MAX, Schema, SchemaId,
};
use crate::nouns::vocabulary::limits::{DESCRIPTION_BYTES_MAX, SYMBOLS_MAX};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

/// The memory that an effect is to change.
pub(crate) struct Check<'a> {
    pub(crate) content: &'a Content,
    pub(crate) index: &'a Index,
}

impl Check<'_> {
    /// Whether `effect` can be applied.
    pub(crate) fn effect(&self, effect: &Effect) -> Result<(), EffectError> {
        match effect {
            Effect::Declared(declaration) => Ok(self.content.vocabulary.check(declaration)?),
            Effect::SymbolsMet(symbols) => {
                let known = self.content.vocabulary.symbols().len();
                at_most("symbols", known.saturating_add(symbols.len()), SYMBOLS_MAX)
            }
            Effect::Attempted { primitive, .. } => self.primitive(*primitive),
            Effect::Executed { schema: id, post, associations, .. } => {
                let schema = self.schema(*id)?;
                let known = match &schema.form {
                    Form::Concrete(concrete) => concrete.post.len(),
                    Form::Generalised(generalised) => generalised.post.len(),
                };
                for (given, known) in [(post.len(), known), (associations.len(), schema.associations.len())] {
                    if given != known {
                        return Err(EffectError::Length { schema: id.0, given, known });
                    }
                }
                Ok(())
            }
            Effect::OutcomeAdded { schema, observation, absent } => {
                self.outcome(*schema, observation, *absent)
            }
            Effect::Created { pre, action, post, parent, contradicts } => {
                self.created(pre, *action, post)?;
                parent.map_or(Ok(()), |id| self.schema(id).map(|_| ()))?;
                contradicts.map_or(Ok(()), |id| self.generalised(id).map(|_| ()))
            }
            Effect::Generalised { pre, target, post, parent, examples } => {
                self.patterns(pre.iter().chain(target).chain(post.iter().map(|(what, _)| what)))?;
                examples.iter().chain([parent]).try_for_each(|id| self.concrete(*id).map(|_| ()))?;
                at_most("post-conditions", post.len(), POST_CONDITIONS_MAX)?;
                self.room_for_schema()
            }
            Effect::Supported { generalised, example } => {
                self.concrete(*example)?;
                self.generalised(*generalised).map(|_| ())
            }
            Effect::Retired { generalised } => self.generalised(*generalised).map(|_| ()),
            Effect::Associated { schema, observation, replaces } => {
                self.association(*schema, observation, *replaces)
            }
            Effect::Happened(observations) | Effect::Attended(observations) => self.known(observations),
            Effect::Stage(effect) => self.stage(effect),
            Effect::Pursuit(effect) => self.pursuit(effect),
            Effect::StepEnded { body, pending, .. } => {
                self.body(*body)?;
                pending.as_ref().map_or(Ok(()), |execution| self.execution(execution))
            }
            Effect::Full(_) | Effect::Mechanisms(_) => Ok(()),
            Effect::Experienced(experience) => self.experience(experience),
            Effect::Followed { body, on } => {
                self.body(*body)?;
                let known = self.content.items.all.len();
                if on.len() == known { Ok(()) } else { Err(EffectError::Items { given: on.len(), known }) }
            }
            Effect::Supposed { body, primitive, kinds, updates, .. } => {
                self.body(*body)?;
                self.primitive(*primitive)?;
                self.item(kinds, updates)
            }
            Effect::Dropped { item } => {
                let known = self.content.items.all.len();
                let given = *item as usize;
                if given < known { Ok(()) } else { Err(EffectError::Items { given, known }) }
            }
            Effect::Described { body, text } => {
                self.body(*body)?;
                at_most("bytes of a description", text.len(), DESCRIPTION_BYTES_MAX)
            }
        }
    }

    fn experience(&self, experience: &Experience) -> Result<(), EffectError> {
        let Experience { body, primitive, parameters, before, after, sensed, recalled } = experience;
        self.body(*body)?;
        if experience.is_beginning() {
            return Ok(());
        }
        self.primitive(*primitive)?;
        let recalled = recalled.as_ref().map_or(&[][..], |recalled| &recalled.observations);
        self.known(before.iter().chain(after.iter()).chain(recalled))?;
        let vocabulary = &self.content.vocabulary;
        let declared = parameters.iter().flatten().all(|value| vocabulary.knows_value(*value))
            && sensed.iter().all(|kind| usize::from(kind.0) < vocabulary.types().len());
        declared.then_some(()).ok_or(EffectError::Undeclared)?;
        let ordered = [before, after, recalled].iter().all(|list| list.is_sorted_by(|a, b| a < b))
            && sensed.is_sorted_by(|a, b| a < b);
        ordered.then_some(()).ok_or(EffectError::Order)
    }

    fn item(&self, kinds: &[TypeId], updates: &[(Event, Update)]) -> Result<(), EffectError> {
        let items = self.content.items.all.len();
        at_most("items", items + 1, ITEMS_MAX)?;
        at_most("events of an item", updates.len(), EVENTS_MAX)?;
        for (event, _) in updates.iter().filter(|(event, _)| !event.is_beginning()) {
            self.primitive(event.primitive)?;
            self.known(event.after.iter())?;
        }
        let types = self.content.vocabulary.types().len();
        let declared = kinds.iter().all(|kind| usize::from(kind.0) < types)
            && self.content.vocabulary.may_suppose(items);
        declared.then_some(()).ok_or(EffectError::Undeclared)?;
        let ordered = kinds.is_sorted_by(|a, b| a < b)
            && updates.is_sorted_by(|a, b| a.0 < b.0)
            && updates.iter().all(|(event, _)| event.after.is_sorted_by(|a, b| a < b));
        ordered.then_some(()).ok_or(EffectError::Order)
    }

    fn schema(&self, id: SchemaId) -> Result<&Schema, EffectError> {
        self.content.schema(id).ok_or(EffectError::Schema(id.0))
    }

    fn concrete(&self, id: SchemaId) -> Result<&Concrete, EffectError> {
        self.content.concrete(id).ok_or(EffectError::Schema(id.0))
    }

    fn generalised(&self, id: SchemaId) -> Result<&Generalised, EffectError> {
        self.content.generalised(id).ok_or(EffectError::Schema(id.0))
    }

    fn primitive(&self, id: PrimitiveId) -> Result<(), EffectError> {
        let known = self.content.vocabulary.primitives().get(id.0 as usize);
        known.map(|_| ()).ok_or(EffectError::Primitive(id.0))
    }

    fn body(&self, id: BodyId) -> Result<(), EffectError> {
        let known = self.content.pending.get(usize::from(id.0));
        known.map(|_| ()).ok_or(EffectError::Body(id.0))
    }

    fn known<'a>(&self, observations: impl IntoIterator<Item = &'a Observation>) -> Result<(), EffectError> {
        let known = observations.into_iter().all(|o| self.content.vocabulary.knows(o));
        known.then_some(()).ok_or(EffectError::Undeclared)
    }

    fn patterns<'a>(&self, patterns: impl IntoIterator<Item = &'a Pattern>) -> Result<(), EffectError> {
        let known = patterns.into_iter().all(|pattern| self.content.vocabulary.knows_pattern(pattern));
        known.then_some(()).ok_or(EffectError::Undeclared)
    }

    fn room_for_schema(&self) -> Result<(), EffectError> {
        at_most("schemas", self.content.schemas.len() + 1, SCHEMAS_MAX)
    }

    fn outcome(&self, id: SchemaId, observation: &Observation, absent: bool) -> Result<(), EffectError> {
        let post = &self.concrete(id)?.post;
        self.known([observation])?;
        let what = self.index.id(observation);
        if post.iter().any(|known| (Some(known.what), known.absent) == (what, absent)) {
            return Err(EffectError::Twice(id.0));
        }
        at_most("post-conditions", post.len() + 1, POST_CONDITIONS_MAX)
    }

    fn created(
        &self,
        pre: &[Observation],
        action: PrimitiveId,
        post: &[(Observation, bool)],
    ) -> Result<(), EffectError> {
        self.primitive(action)?;
        self.known(pre.iter().chain(post.iter().map(|(what, _)| what)))?;
        if !pre.is_sorted_by(|a, b| a < b) || !post.is_sorted_by(|a, b| a < b) {
            return Err(EffectError::Order);
        }
        at_most("post-conditions", post.len(), POST_CONDITIONS_MAX)?;
        // An index finds one schema by its pre-conditions and its action.
        let pre: Vec<_> = pre.iter().collect();
        match self.index.exact(&pre, action) {
            Some(known) => Err(EffectError::Twice(known.0)),
            None => self.room_for_schema(),
        }
    }

    fn association(
        &self,
        id: SchemaId,
        observation: &Observation,
        replaces: Option<usize>,
    ) -> Result<(), EffectError> {
        let associations = &self.schema(id)?.associations;
        self.known([observation])?;
        let known = associations.len();
        if replaces.map_or(known >= ASSOCIATIONS_MAX, |at| at >= known) {
            return Err(EffectError::Length { schema: id.0, given: replaces.unwrap_or(known), known });
        }
        let what = self.index.id(observation);
        let mut others = associations.iter().enumerate().filter(|(at, _)| Some(*at) != replaces);
        match others.any(|(_, known)| Some(known.observation) == what) {
            true => Err(EffectError::Twice(id.0)),
            false => Ok(()),
        }
    }

    fn stage(&self, effect: &StageEffect) -> Result<(), EffectError> {
        match effect {
            StageEffect::Begun { student, .. } => self.body(*student),
            StageEffect::TrialBegun { drawn } => draws(&self.content.progress, drawn),
            StageEffect::Spoken { utterances, .. } => {
                let beyond = utterances.iter().find(|at| **at >= UTTERANCES_MAX);
                beyond.map_or(Ok(()), |at| Err(EffectError::Utterance(*at)))
            }
            // Which stages there are, the curriculum knows and memory does not: a stage that it does not have counts as its
            // last one.
            StageEffect::Entered { .. }
            | StageEffect::Acted { .. }
            | StageEffect::Quiet(_)
            | StageEffect::TrialEnded { .. }
            | StageEffect::Saturated
            | StageEffect::Ended
            | StageEffect::Finished
            | StageEffect::Held(_)
            | StageEffect::Stuck(_)
            | StageEffect::Left => Ok(()),
        }
    }

    fn pursuit(&self, effect: &PursuitEffect) -> Result<(), EffectError> {
        let under_way = self.content.pursuit.as_deref().is_some_and(Pursuit::under_way);
        if under_way == matches!(effect, PursuitEffect::Begun { .. }) {
            return Err(EffectError::Goal);
        }
        match effect {
            PursuitEffect::Begun { body, goal, actions_max } => {
                self.body(*body)?;
                self.patterns(goal.patterns())?;
                let sound = match goal {
                    Goal::Observed(patterns) | Goal::Again(patterns) => {
                        (1..=GOAL_PATTERNS_MAX).contains(&patterns.len())
                    }
                    Goal::Most(kind) => self.content.vocabulary.is_value(*kind),
                };
                match sound && (1..=GOAL_ACTIONS_MAX).contains(actions_max) {
                    true => Ok(()),
                    false => Err(EffectError::Goal),
                }
            }
            PursuitEffect::Planned(PlanRecord { chain, policy, probability, .. }) => {
                self.chain(chain)?;
                policy.as_ref().map_or(Ok(()), |policy| self.policy(policy))?;
                let sound = (0.0..=1.0).contains(probability);
                sound.then_some(()).ok_or(EffectError::Probability(*probability))
            }
            PursuitEffect::Revised(policy) => {
                let plan = self.content.pursuit.as_ref().and_then(|pursuit| pursuit.plans.last());
                plan.and_then(|plan| plan.policy.as_ref()).ok_or(EffectError::Goal)?;
                self.policy(policy)
            }
            PursuitEffect::Came(more) => {
                let wanted = self.content.pursuit.as_ref().and_then(|pursuit| pursuit.goal.most());
                (wanted.is_some() && more.is_finite()).then_some(()).ok_or(EffectError::Goal)
            }
            PursuitEffect::Acted | PursuitEffect::Ended(_) => Ok(()),
        }
    }

    fn policy(&self, policy: &Policy) -> Result<(), EffectError> {
        let types = self.content.vocabulary.types().len();
        let declared = policy.kinds.iter().chain(&policy.chance).all(|kind| usize::from(kind.0) < types);
        declared.then_some(()).ok_or(EffectError::Undeclared)?;
        self.known(policy.rows.iter().flat_map(|row| &row.context).chain(&policy.circumstances))?;
        policy.rows.iter().try_for_each(|row| self.primitive(row.action))?;
        policy.is_sound().then_some(()).ok_or(EffectError::Policy)
    }

    fn chain(&self, chain: &[ChainLink]) -> Result<(), EffectError> {
        at_most("schemas of a chain", chain.len(), CHAIN_LENGTH_MAX as usize)?;
        chain.iter().try_for_each(|link| self.link(Some(link.schema), link.carrier, &link.binding))
    }

    fn link(
        &self,
        schema: Option<SchemaId>,
        carrier: Option<SchemaId>,
        binding: &Substitution,
    ) -> Result<(), EffectError> {
        schema.map_or(Ok(()), |id| self.schema(id).map(|_| ()))?;
        carrier.map_or(Ok(()), |id| self.concrete(id).map(|_| ()))?;
        let known = binding.bindings().iter().all(|(_, value)| self.content.vocabulary.knows_value(*value));
        known.then_some(()).ok_or(EffectError::Undeclared)
    }

    fn execution(&self, execution: &Execution) -> Result<(), EffectError> {
        let Execution { schema, binding, carrier, action, before, chain, for_goal: _ } = execution;
        self.primitive(*action)?;
        self.link(*schema, *carrier, binding)?;
        self.known(before.observations())?;
        self.chain(chain)
    }
}

/// Whether these are the next numbers of their pools.
fn draws(progress: &Progress, drawn: &[(usize, i64)]) -> Result<(), EffectError> {
    let mut left: BTreeMap<usize, &[i64]> = BTreeMap::new();
    for (pool, number) in drawn {
        let numbers = progress.pools.get(*pool).map_or(&[][..], |left| left.as_slice());
        let left = left.entry(*pool).or_insert(numbers);
        match left.split_last() {
            Some((next, rest)) if next == number => *left = rest,
            _ => return Err(EffectError::Draw(*number)),
        }
    }
    Ok(())
}

fn at_most(what: &'static str, count: usize, limit: usize) -> Result<(), EffectError> {
    if count <= limit { Ok(()) } else { Err(EffectError::TooMany { what, count, limit }) }
}
