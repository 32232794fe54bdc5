//! Schema creation (paper, II-D and figure 1): what was not predicted is remembered.

use crate::cycle::claims::Expectation;
use crate::memory::Memory;
use crate::memory::draft::Draft;
use crate::memory::instance::Instance;
use crate::nouns::effect::{Effect, Score};
use crate::nouns::execution::Execution;
use crate::nouns::observation::{Observation, Substitution, TypeId};
use crate::nouns::schema::{POST_CONDITIONS_MAX, PostCondition, SchemaId};
use crate::nouns::world_state::WorldState;

/// What happened that the executed schema does not know.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Surprise {
    /// Observed now; neither before nor predicted: the relative complement of II-D.
    pub(crate) appeared: Vec<Observation>,
    /// Part of the context before, gone now, and its loss was not predicted.
    pub(crate) vanished: Vec<Observation>,
    /// Predicted, each as observed or as absent, and it did not come about.
    pub(crate) missing: Vec<(Observation, bool)>,
}

impl Surprise {
    /// The part of it that is to be expected from now on. The rest is noise, or not known to be of this action yet.
    fn believed(&self, expectation: &Expectation) -> Self {
        let Self { appeared, vanished, missing } = self;
        let appears = |o: &&Observation| expectation.observed.contains(o);
        // It failed once, and is to be expected all the same.
        let still = |(o, absent): &&(Observation, bool)| expectation.observed.contains(o) == *absent;
        let vanishes = |o: &&Observation| expectation.vanished.contains(o);
        Self {
            appeared: appeared.iter().filter(appears).cloned().collect(),
            vanished: vanished.iter().filter(vanishes).cloned().collect(),
            missing: missing.iter().filter(still).cloned().collect(),
        }
    }
}

/// Compares `after` with `before` and the schema's predictions.
pub(crate) fn surprise(
    memory: &Memory,
    bound: Option<&Instance>,
    before: &WorldState,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
) -> Surprise {
    let rules = memory.rules();
    let known = |observation: &Observation, absent: bool| {
        bound.is_some_and(|b| b.post.iter().any(|p| p.absent == absent && p.what == *observation))
    };
    let lasted = |o: &Observation| !rules.of(o.kind()).transient && before.contains(o);
    let appeared = after
        .observations()
        .iter()
        .filter(|o| rules.of(o.kind()).postcondition && !lasted(o) && !known(o, false))
        .cloned()
        .collect();
    let vanished = before
        .observations()
        .iter()
        .filter(|o| rules.of(o.kind()).precondition && !after.contains(o) && !known(o, true))
        .cloned()
        .collect();
    let missed =
        |p: &&PostCondition<Observation>| lifted(p.what.kind()) && after.contains(&p.what) == p.absent;
    let predicted = bound.into_iter().flat_map(|b| b.predicted(memory.parameters()));
    let missing = predicted.filter(missed).map(|p| (p.what.clone(), p.absent)).collect();
    Surprise { appeared, vanished, missing }
}

/// What came of a step's experience: which schema now stands for it, and whether it is new.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Creation {
    /// The schema made.
    pub(crate) created: Option<SchemaId>,
    /// The schema, other than the one executed, that took the new outcome.
    pub(crate) updated: Option<SchemaId>,
    /// Whether the schema made is a counter-example.
    pub(crate) counter_example: bool,
}

/// Makes the schema, or adds the outcome, that the surprise calls for.
pub(crate) fn create(
    draft: &mut Draft<'_>,
    execution: &Execution,
    surprise: &Surprise,
    expectation: Option<&Expectation>,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
) -> Creation {
    let believed = expectation.map(|expectation| surprise.believed(expectation));
    let surprise = believed.as_ref().unwrap_or(surprise);
    let memory = draft.memory();
    let contradicts = execution
        .schema
        .filter(|executed| !surprise.missing.is_empty() && memory.content().generalised(*executed).is_some());
    let nothing_new = surprise.appeared.is_empty() && surprise.vanished.is_empty() && contradicts.is_none();
    if execution.schema.is_some() && nothing_new {
        return Creation::default();
    }
    // "If the observations present prior to the execution of the schema are the same as the
    // pre-conditions to the schema then the new outcome is added" (II-D). What a generalised schema did
    // not predict concerns this binding only, so it always goes to a concrete schema.
    let context = execution.before.context(memory.rules());
    let context = expectation.map_or(context, |expectation| expectation.relied_on.clone());
    let pre: Vec<_> = context.observations().iter().collect();
    if let Some(existing) = memory.index().exact(&pre, execution.action) {
        if execution.schema == Some(existing) {
            add_outcomes(draft, existing, surprise);
            return Creation::default();
        }
        // The outcome of a primitive that no schema covered goes here too: another body tried the same in the meantime.
        update(draft, existing, execution, after, lifted);
        return Creation { updated: Some(existing), ..Creation::default() };
    }
    if memory.is_full() {
        return Creation::default();
    }
    let seen = after.observations().iter();
    let post = match execution.schema {
        Some(_) if expectation.is_none() => outcome(memory, &context, after, seen),
        // The first schema of a primitive that no schema covered here is about what is new in this context.
        _ => {
            let seen =
                seen.filter(|o| expectation.is_none_or(|expectation| expectation.observed.contains(o)));
            let lasting = execution.before.lasting(memory.rules());
            outcome(memory, &context, after, seen.filter(|o| !lasting.contains(o) || context.contains(o)))
        }
    };
    let created = memory.next_id();
    draft.emit(Effect::Created {
        pre: context.observations().to_vec(),
        action: execution.action,
        post,
        parent: execution.schema,
        contradicts,
    });
    Creation { created: Some(created), updated: None, counter_example: contradicts.is_some() }
}

/// `seen` as post-conditions, and what is gone from the context as absences, in canonical order.
fn outcome<'a>(
    memory: &Memory,
    context: &WorldState,
    after: &WorldState,
    seen: impl Iterator<Item = &'a Observation>,
) -> Vec<(Observation, bool)> {
    let gone = context.observations().iter().filter(|o| !after.contains(o));
    let mut post: Vec<_> = seen
        .filter(|o| memory.rules().of(o.kind()).postcondition)
        .map(|o| (o.clone(), false))
        .chain(gone.map(|o| (o.clone(), true)))
        .collect();
    post.sort_unstable();
    post.truncate(POST_CONDITIONS_MAX);
    post
}

/// The schema with just this context and action takes the experience as an execution of its own.
fn update(
    draft: &mut Draft<'_>,
    existing: SchemaId,
    execution: &Execution,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
) {
    let memory = draft.memory();
    let Some(bound) = Instance::new(memory.content(), existing, &Substitution::new()) else { return };
    let new = surprise(memory, Some(&bound), &execution.before, after, lifted);
    // One execution is one trial: the carrier of a generalised schema has been scored already.
    if execution.carrier != Some(existing) {
        let scored = score(memory, existing, &bound, &execution.before, after, lifted);
        draft.emit_all(scored);
    }
    add_outcomes(draft, existing, &new);
}

fn add_outcomes(draft: &mut Draft<'_>, schema: SchemaId, surprise: &Surprise) {
    let known = draft.memory().content().concrete(schema).map_or(0, |c| c.post.len());
    let room = if draft.memory().content().full { 0 } else { POST_CONDITIONS_MAX.saturating_sub(known) };
    let appeared = surprise.appeared.iter().map(|o| (o, false));
    let vanished = surprise.vanished.iter().map(|o| (o, true));
    for (observation, absent) in appeared.chain(vanished).take(room) {
        draft.emit(Effect::OutcomeAdded { schema, observation: observation.clone(), absent });
    }
}

/// The effect that scores the predictions of `schema`, which reads as `bound` (II-A).
pub(crate) fn score(
    memory: &Memory,
    schema: SchemaId,
    bound: &Instance,
    before: &WorldState,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
) -> Option<Effect> {
    let content = memory.content();
    let seen = |kind: TypeId, held: bool| match (lifted(kind), held) {
        (false, _) => Score::Constrained,
        (true, true) => Score::Held,
        (true, false) => Score::Missed,
    };
    let post: Vec<_> =
        bound.post.iter().map(|p| seen(p.what.kind(), after.contains(&p.what) != p.absent)).collect();
    let success = bound
        .post
        .iter()
        .zip(&post)
        .all(|(p, seen)| *seen != Score::Missed || !bound.predicts(p, memory.parameters()));
    let associations = content
        .schema(schema)?
        .associations
        .iter()
        .map(|association| {
            let observation = content.observation(association.observation);
            seen(observation.kind(), before.contains(observation) || after.contains(observation))
        })
        .collect();
    Some(Effect::Executed { schema, success, post, associations })
}
