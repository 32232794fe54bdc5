//! Schema creation (paper, II-D and figure 1): what was not predicted is remembered.

use crate::cycle::claims::Expectation;
use crate::memory::Memory;
use crate::memory::draft::Draft;
use crate::memory::evidence::Part;
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
    /// As much of it as claims expect from now on. The rest is noise, or not known to be of this action yet; and where a law fails, it is
    /// no candidate any more.
    fn expected(&self, part: &Part) -> Self {
        let of = |list: &[Observation], expected: &[Observation]| -> Vec<_> {
            list.iter().filter(|o| expected.contains(o)).cloned().collect()
        };
        Self {
            appeared: of(&self.appeared, &part.observed),
            vanished: of(&self.vanished, &part.vanished),
            missing: Vec::new(),
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

/// What came of a step's experience: which schemas now stand for it, and which are new.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Creation {
    /// The schemas made.
    pub(crate) created: Vec<SchemaId>,
    /// The schemas, other than the one executed, that took the new outcome or tell of it already.
    pub(crate) updated: Vec<SchemaId>,
    /// Whether a schema made is a counter-example.
    pub(crate) counter_example: bool,
}

/// What one schema is to say: under these observations, what is new.
#[derive(Default)]
struct Lesson<'a> {
    /// What claims expect; none without claims.
    part: Option<&'a Part>,
    context: WorldState,
    surprise: Surprise,
    /// The observations that may be its post-conditions.
    seen: Vec<Observation>,
    contradicts: Option<SchemaId>,
}

/// Makes the schemas, or adds the outcomes, that the surprise calls for.
pub(crate) fn create(
    draft: &mut Draft<'_>,
    execution: &Execution,
    surprise: &Surprise,
    expectation: Option<&Expectation>,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
) -> Creation {
    let mut creation = Creation::default();
    for lesson in lessons(draft.memory(), execution, surprise, expectation, after) {
        teach(draft, execution, &lesson, after, lifted, &mut creation);
    }
    creation
}

/// What there is to be said: without claims one thing, with the whole context; with them one for all that changes together.
fn lessons<'a>(
    memory: &Memory,
    execution: &Execution,
    surprise: &Surprise,
    expectation: Option<&'a Expectation>,
    after: &WorldState,
) -> Vec<Lesson<'a>> {
    let rules = memory.rules();
    let lasting = execution.before.lasting(rules);
    let first = execution.schema.is_none();
    let seen = |context: &WorldState, may_be_told: &dyn Fn(&Observation) -> bool| {
        let seen = after.observations().iter().filter(|o| may_be_told(o));
        seen.filter(|o| !lasting.contains(o) || context.contains(o)).cloned().collect()
    };
    let Some(expectation) = expectation else {
        let contradicts = execution.schema.filter(|executed| {
            !surprise.missing.is_empty() && memory.content().generalised(*executed).is_some()
        });
        let nothing_new =
            surprise.appeared.is_empty() && surprise.vanished.is_empty() && contradicts.is_none();
        if !first && nothing_new {
            return Vec::new();
        }
        let context = execution.before.context(rules);
        // The first schema of a primitive that no schema covered here is about what is new in this context.
        let seen = if first { seen(&context, &|_| true) } else { after.observations().to_vec() };
        return vec![Lesson { part: None, context, seen, surprise: surprise.clone(), contradicts }];
    };
    let mut lessons = Vec::new();
    let surprise = surprise.expected(&expectation.told);
    if surprise != Surprise::default() {
        let context = WorldState::new(expectation.told.relied_on.iter().cloned()).context(rules);
        let seen = seen(&context, &|o| expectation.told.observed.contains(o));
        lessons.push(Lesson { part: Some(&expectation.told), context, seen, surprise, contradicts: None });
    }
    // A primitive that no schema covers is covered from now on.
    if first && lessons.is_empty() {
        lessons.push(Lesson::default());
    }
    lessons
}

/// Makes the schema of a lesson, or adds its outcome to the one that there is.
fn teach(
    draft: &mut Draft<'_>,
    execution: &Execution,
    lesson: &Lesson<'_>,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
    creation: &mut Creation,
) {
    let Lesson { context, surprise, seen, contradicts, part } = lesson;
    let memory = draft.memory();
    // "If the observations present prior to the execution of the schema are the same as the
    // pre-conditions to the schema then the new outcome is added" (II-D). What a generalised schema did
    // not predict concerns this binding only, so it always goes to a concrete schema.
    let pre: Vec<_> = context.observations().iter().collect();
    if let Some(existing) = memory.index().exact(&pre, execution.action) {
        if execution.schema == Some(existing) {
            add_outcomes(draft, existing, surprise);
            return;
        }
        // The outcome of a primitive that no schema covered goes here too: another body tried the same in the meantime.
        update(draft, existing, execution, *part, after, lifted);
        creation.updated.push(existing);
        return;
    }
    if memory.is_full() {
        return;
    }
    let gone = context.observations().iter().filter(|o| !after.contains(o));
    let gone = gone.filter(|o| part.is_none_or(|part| part.vanished.contains(o)));
    let post = outcome(memory, gone, seen.iter());
    creation.created.push(memory.next_id());
    creation.counter_example |= contradicts.is_some();
    draft.emit(Effect::Created {
        pre: context.observations().to_vec(),
        action: execution.action,
        post,
        parent: execution.schema,
        contradicts: *contradicts,
    });
}

/// `seen` as post-conditions, and what is `gone` as absences, in canonical order.
fn outcome<'a>(
    memory: &Memory,
    gone: impl Iterator<Item = &'a Observation>,
    seen: impl Iterator<Item = &'a Observation>,
) -> Vec<(Observation, bool)> {
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
    part: Option<&Part>,
    after: &WorldState,
    lifted: &dyn Fn(TypeId) -> bool,
) {
    let memory = draft.memory();
    let Some(bound) = Instance::new(memory.content(), existing, &Substitution::new()) else { return };
    let new = surprise(memory, Some(&bound), &execution.before, after, lifted);
    let new = part.map_or_else(|| new.clone(), |part| new.expected(part));
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
