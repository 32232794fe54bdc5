//! The cycle: one frame in, one decision out (paper, II).
//!
//! A step is a deterministic function of the frame and of memory. It changes memory only by the effects
//! that it returns, through [`Memory::apply`]; applying them to a copy of the earlier memory gives the same
//! memory. No clock, no I/O, no thread; the only randomness is the seeded generator in memory.

use std::borrow::Cow;
use std::sync::Arc;

use crate::cycle::association::{associate, happened};
use crate::cycle::attention::attend;
use crate::cycle::babbling::executable;
use crate::cycle::chaining::Reach;
use crate::cycle::choice::{self, Choice, Situation};
use crate::cycle::claims;
use crate::cycle::creation::{self, Creation};
use crate::cycle::curiosity::Curiosity;
use crate::cycle::excitation::PairCounts;
use crate::cycle::generalisation;
use crate::cycle::habituation::unhabituated;
use crate::cycle::match_cache::MatchCache;
use crate::cycle::pursue;
use crate::cycle::stages::{self, Demand, Novelty, is_lifted};
use crate::cycle::supposing;
use crate::memory::Memory;
use crate::memory::draft::Draft;
use crate::memory::evidence::Foresight;
use crate::memory::instance::Instance;
use crate::nouns::curriculum::Curriculum;
use crate::nouns::decision::Decision;
use crate::nouns::effect::Effect;
use crate::nouns::execution::{ChainLink, Execution};
use crate::nouns::experience::{Experience, NOTHING_DONE};
use crate::nouns::frame::{ActionOutcome, Frame, Output, Step};
use crate::nouns::observation::{Substitution, TypeId};
use crate::nouns::progress::StageEffect;
use crate::nouns::random::Random;
use crate::nouns::schema::SchemaId;
use crate::nouns::vocabulary::BodyId;
use crate::nouns::world_state::WorldState;

/// What the steps before found out and the next may still use. It follows from memory and from what was perceived, and is
/// never part of memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Caches {
    /// The last search for chains.
    reach: Option<Reach>,
    /// The last matches of laws.
    matched: MatchCache,
    /// What the last search for something new, and the last for a way to a goal, foretold.
    to_new: Foresight,
    to_goal: Foresight,
}

/// One step. The numbers are those of the cycle in `docs/LEARNING.md`.
pub(crate) fn step(memory: &mut Memory, curriculum: &Curriculum, caches: &mut Caches, frame: &Frame) -> Step {
    let body = frame.body;
    let Some(pending) = memory.content().pending.get(usize::from(body.0)).cloned() else {
        return Step { output: Output::Hold, effects: Vec::new(), decision: None };
    };
    let mut draft = Draft::new(memory);
    // 1. A frame arrives.
    stages::begin(&mut draft, curriculum, body);
    let student = draft.memory().content().progress.student == Some(body);
    let frame = &*hear(&mut draft, curriculum, student, frame);
    let (world, lifted) = lift(draft.memory(), curriculum, frame);
    // 2 to 7. Learn from the execution that it ends.
    let for_goal = pending.as_ref().is_some_and(|execution| execution.for_goal);
    let outcome = frame.outcome;
    if pending.is_none() && student {
        arranged(&mut draft, outcome);
    }
    let (acted, chain) = match &pending {
        Some(execution) => end(&mut draft, curriculum, body, execution, outcome, &world, &lifted),
        None => (None, Vec::new()),
    };
    // What is supposed may have changed by what came about.
    let world = draft.memory().content().perceived(body, &world);
    // 8. Where the curriculum stands.
    let came = outcome
        .filter(|outcome| for_goal && !outcome.begins_episode())
        .and_then(|_| pursue::came(&mut draft, body, &world));
    let novelty = acted.filter(|_| student && !for_goal);
    if let Some(novelty) = novelty {
        stages::acted(&mut draft, curriculum, novelty, &world);
    }
    let decided_in = pending.as_ref().filter(|_| acted.is_some()).map(|execution| &execution.before);
    pursue::observed(&mut draft, curriculum, body, &world, decided_in);
    // 9 and 10. Choose, and resolve to a primitive: for the goal, if one is pursued.
    let sent = pending.as_ref().filter(|_| for_goal).map(|execution| &execution.before);
    let outcome = outcome.filter(|_| for_goal);
    let before = pursue::PreviousExecution { outcome, chain: &chain, world: sent, came };
    let world = world.lived_by(draft.memory().rules());
    let turn = pursue(&mut draft, caches, body, &world, &before).unwrap_or_else(|| {
        let chain = if for_goal { &[][..] } else { &chain };
        choose(&mut draft, curriculum, caches, frame, novelty, chain)
    });
    let Turn { output, decision, execution, random } = turn;
    draft.emit(Effect::StepEnded { body, random: random.state(), pending: execution.map(Arc::new) });
    Step { output, effects: draft.effects(), decision }
}

/// The frame with what a teacher says in it. While a goal is pursued the curriculum waits, its teacher included.
fn hear<'a>(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    student: bool,
    frame: &'a Frame,
) -> Cow<'a, Frame> {
    if !student || draft.memory().content().pursuit_of(frame.body).is_some() {
        return Cow::Borrowed(frame);
    }
    let heard = stages::spoken(draft, curriculum, &frame.observations);
    if heard.is_empty() {
        return Cow::Borrowed(frame);
    }
    let mut frame = frame.clone();
    frame.observations.extend(heard);
    Cow::Owned(frame)
}

/// Takes account of what came of arranging the surroundings, if that was asked of the student.
fn arranged(draft: &mut Draft<'_>, outcome: Option<ActionOutcome>) {
    let failed = outcome.is_some_and(|outcome| outcome != ActionOutcome::Done);
    if failed && draft.memory().content().progress.trial_open {
        let reason = "the body could not arrange its surroundings as the curriculum asks".to_owned();
        draft.emit(Effect::Stage(StageEffect::Stuck(reason)));
    }
}

/// Steps 2 to 7: what was made of the execution that the frame ends and what is left of its chain, if it was carried out.
fn end(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    body: BodyId,
    execution: &Execution,
    outcome: Option<ActionOutcome>,
    world: &WorldState,
    lifted: &[bool],
) -> (Option<Novelty>, Vec<ChainLink>) {
    let learning = stages::present(draft.memory(), curriculum).learning;
    if outcome.is_some_and(ActionOutcome::begins_episode) {
        let ended = learning && outcome == Some(ActionOutcome::EpisodeEnded);
        begin_episode(draft, body, execution, ended, lifted);
        return (None, Vec::new());
    }
    if let Some(outcome) = outcome.filter(|_| learning) {
        let carried_out = outcome == ActionOutcome::Done;
        draft.emit(Effect::Attempted { primitive: execution.action, carried_out });
    }
    if outcome != Some(ActionOutcome::Done) {
        return (None, Vec::new());
    }
    let supposes = draft.memory().content().mechanisms.supposes();
    let on =
        if supposes { supposing::follow(draft.memory(), body, execution.action, world) } else { Vec::new() };
    let after = draft.memory().content().items.with(on.iter().copied(), world);
    if learning && draft.memory().content().mechanisms.claims && !draft.memory().is_full() {
        let lifted = |kind: TypeId| is_lifted(lifted, kind);
        let experience = claims::experience(draft.memory(), body, execution, &after, &lifted);
        draft.emit(experience);
    }
    if supposes {
        draft.emit(Effect::Followed { body, on });
    }
    let novelty = if learning { learn(draft, body, execution, &after, lifted) } else { Novelty::default() };
    if supposes && learning && !draft.memory().is_full() {
        let supposed = supposing::suppose(draft.memory(), body);
        draft.emit_all(supposed);
    }
    (Some(novelty), execution.chain.clone())
}

/// A new episode begins: of that before there is only to learn that it ended where an execution was decided, if it did. What was lived
/// through, recalled and supposed in it is not of the new one.
fn begin_episode(draft: &mut Draft<'_>, body: BodyId, execution: &Execution, ended: bool, lifted: &[bool]) {
    let mechanisms = draft.memory().content().mechanisms;
    if ended && mechanisms.claims && !draft.memory().is_full() {
        let end = claims::end(draft.memory(), body, execution, &|kind| is_lifted(lifted, kind));
        draft.emit_all(end);
    }
    if mechanisms.claims {
        draft.emit(Effect::Experienced(Box::new(Experience::beginning(body))));
    }
    if mechanisms.supposes() {
        let on = supposing::follow(draft.memory(), body, NOTHING_DONE, &WorldState::new([]));
        draft.emit(Effect::Followed { body, on });
    }
}

/// The world state under the constraints of the present stage, with what is supposed, and which types it lifts.
fn lift(memory: &Memory, curriculum: &Curriculum, frame: &Frame) -> (WorldState, Vec<bool>) {
    let vocabulary = &memory.content().vocabulary;
    let lifted = stages::lifted(memory.content(), stages::present(memory, curriculum));
    // What was never declared can't be referred to, and is not perceived.
    let seen = frame.observations.iter().filter(|o| is_lifted(&lifted, o.kind()) && vocabulary.knows(o));
    (memory.content().perceived(frame.body, &WorldState::new(seen.cloned())), lifted)
}

/// Steps 2 to 7: what an execution that was carried out teaches.
fn learn(
    draft: &mut Draft<'_>,
    body: BodyId,
    execution: &Execution,
    after: &WorldState,
    lifted: &[bool],
) -> Novelty {
    let lifted = |kind: TypeId| is_lifted(lifted, kind);
    let after = &after.lived_by(draft.memory().rules());
    let before = &execution.before;
    let claims = draft.memory().content().mechanisms.claims;
    let expectation = claims.then(|| claims::expectation(draft.memory(), body, execution.action, before));
    let none = Substitution::new();
    let executed: Vec<(SchemaId, &Substitution)> = execution
        .schema
        .map(|schema| (schema, &execution.binding))
        .into_iter()
        .chain(execution.carrier.map(|carrier| (carrier, &none)))
        .collect();
    let content = draft.memory().content();
    let reads = |(schema, binding): &(SchemaId, &Substitution)| Instance::new(content, *schema, binding);
    let bounds: Vec<_> = executed.iter().map(reads).collect();
    let bound = execution.schema.and_then(|_| bounds.first()?.as_ref());
    // 3 comes before 2 is applied: a schema's surprise is measured against what it knew beforehand.
    let surprise = creation::surprise(draft.memory(), bound, before, after, &lifted);
    for ((schema, _), bound) in executed.iter().zip(&bounds) {
        let Some(bound) = bound else { continue };
        let scored = creation::score(draft.memory(), *schema, bound, before, after, &lifted);
        draft.emit_all(scored);
    }
    // 4. Create.
    let Creation { created, updated, counter_example } =
        creation::create(draft, execution, &surprise, expectation.as_ref(), after, &lifted);
    // 5. Associate.
    let happened = happened(draft.memory(), before, after);
    draft.emit_all(happened);
    let mut concerned = executed.clone();
    concerned.extend(created.iter().chain(&updated).map(|schema| (*schema, &none)));
    let content = draft.memory().content();
    let reads = |(schema, binding): &(SchemaId, &Substitution)| Instance::new(content, *schema, binding);
    let explained: Vec<_> = concerned.iter().map(reads).collect();
    let around = WorldState::new(before.observations().iter().chain(after.observations()).cloned());
    for (schema, _) in &concerned {
        let associated = associate(draft.memory(), *schema, &explained, &around);
        draft.emit_all(associated);
    }
    // 6. Attend: to what the executed schema refers to, or the first schema of a primitive.
    let attending = if executed.is_empty() { concerned.len() } else { executed.len() };
    let attending = concerned.into_iter().map(|(schema, _)| schema).zip(&explained).take(attending);
    let attended = attend(draft.memory(), attending, before, after);
    draft.emit_all(attended);
    // 7. Generalise on every new schema, and retire what has failed too often.
    let before_generalising = draft.memory().content().generalised_count;
    // Of what claims tell apart, that with the most conditions.
    let told = created.iter().chain(&updated).copied();
    let conditions = |id: &SchemaId| draft.memory().content().concrete(*id).map(|known| known.pre.len());
    let known = told.rev().max_by_key(conditions).or(execution.carrier).or(execution.schema);
    if let Some((expectation, parent)) = expectation.as_ref().zip(known) {
        let concrete = draft.memory().content().concrete(parent).is_some();
        let law =
            concrete.then(|| claims::generalise(draft.memory(), execution, expectation, parent)).flatten();
        draft.emit_all(law);
    } else if let Some(seed) = created.first().copied().filter(|_| draft.memory().parameters().generalisation)
    {
        let generalised = generalisation::generalise(draft.memory(), seed);
        draft.emit_all(generalised);
    }
    // Where a claim is in force no more its law is no candidate; it is not taken out of use for good.
    let refuted = execution.schema.filter(|id| !claims && generalisation::refuted(draft.memory(), *id));
    if let Some(generalised) = refuted {
        draft.emit(Effect::Retired { generalised });
    }
    Novelty {
        concrete: u32::try_from(created.len()).unwrap_or(u32::MAX),
        generalised: draft.memory().content().generalised_count - before_generalising,
        counter_examples: u32::from(counter_example),
    }
}

/// What a step comes to: what the body is to do and why, and the state from which the generator goes on.
struct Turn {
    output: Output,
    decision: Option<Decision>,
    execution: Option<Execution>,
    random: Random,
}

impl Turn {
    /// The body is to act.
    fn acting((execution, decision): (Execution, Decision), random: Random) -> Self {
        let output = Output::Act(execution.action);
        Self { output, decision: Some(decision), execution: Some(execution), random }
    }

    /// The body is to do something else, or nothing.
    fn other(output: Output, random: Random) -> Self {
        Self { output, decision: None, execution: None, random }
    }
}

/// Steps 9 and 10 in pursuit of a goal; none when there is none, or when it is given up.
fn pursue(
    draft: &mut Draft<'_>,
    caches: &mut Caches,
    body: BodyId,
    world: &WorldState,
    before: &pursue::PreviousExecution<'_>,
) -> Option<Turn> {
    let memory = draft.memory();
    if memory.content().progress.held || memory.content().pursuit_of(body).is_none() {
        return None;
    }
    let reach = Reach::renew(&mut caches.reach, memory, body, world);
    let random = memory.content().random;
    let next = pursue::next(draft, body, world, reach, &mut caches.to_goal, before)?;
    Some(Turn::acting(next, random))
}

/// Steps 8 to 10: follows the curriculum, then goes on with the chain or takes the most exciting schema.
fn choose(
    draft: &mut Draft<'_>,
    curriculum: &Curriculum,
    caches: &mut Caches,
    frame: &Frame,
    mut acted: Option<Novelty>,
    chain: &[ChainLink],
) -> Turn {
    let body = frame.body;
    let entered = |draft: &Draft<'_>| {
        let progress = &draft.memory().content().progress;
        (progress.stage, progress.finished)
    };
    let at_first = entered(draft);
    let student = draft.memory().content().progress.student == Some(body);
    loop {
        let mut random = draft.memory().content().random;
        match stages::demand(draft, curriculum, student) {
            Demand::Hold => return Turn::other(Output::Hold, random),
            Demand::Arrange(commands) => return Turn::other(Output::Arrange(commands), random),
            Demand::Free => (),
        }
        let (world, _) = lift(draft.memory(), curriculum, frame);
        let memory = draft.memory();
        let world = world.lived_by(memory.rules());
        let Caches { reach, matched, to_new, .. } = &mut *caches;
        let reach = Reach::renew(reach, memory, body, &world);
        let perceived = PairCounts::new(&world);
        let executable = executable(memory, body, &memory.index().known_ids(&world));
        let wanting = |memory: &Memory| {
            let progress = &memory.content().progress;
            let first_step = progress.report().map_or(0, |report| report.first_step);
            let rule = stages::present(memory, curriculum).habituation.as_ref();
            rule.map_or_else(Vec::new, |rule| unhabituated(memory, rule, first_step, &executable))
        };
        let unhabituated = if memory.content().progress.habituating { wanting(memory) } else { Vec::new() };
        let curiosity = Curiosity::new(memory, body, &world);
        let situation = Situation {
            body,
            world: &world,
            perceived: &perceived,
            reach,
            unhabituated: &unhabituated,
            executable: &executable,
            curiosity: &curiosity,
        };
        // Scored only where that decides anything: a chain goes on whatever else there is.
        let mut scored: Option<Choice> = None;
        if let Some(novelty) = acted.take() {
            // Only the first turn follows an action; a stage entered here starts its own count.
            let top = |memory: &Memory| scored.insert(Choice::new(memory, &situation, matched, to_new)).top;
            if stages::saturate(draft, curriculum, novelty, top, |memory| !wanting(memory).is_empty()) {
                continue;
            }
            if draft.memory().content().progress.habituating && unhabituated.is_empty() {
                continue;
            }
        }
        let memory = draft.memory();
        let on = (entered(draft) == at_first).then(|| choice::continue_chain(memory, &situation, chain));
        let next = on.flatten().or_else(|| {
            let scored = scored.unwrap_or_else(|| Choice::new(memory, &situation, matched, to_new));
            scored.decide(memory, &situation, &mut random)
        });
        return match next {
            Some(next) => Turn::acting(next, random),
            None => Turn::other(Output::Hold, random),
        };
    }
}
