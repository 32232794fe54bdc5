//! What holds of every run: replay, determinism, attention, explanations, counts, frozen stages, and frames
//! that no honest body would send. A failure prints the smallest set-up found, seed included.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

#[path = "reference/checks.rs"]
mod checks;
#[path = "reference/curricula.rs"]
mod curricula;
#[path = "reference/effects.rs"]
mod effects;
#[path = "reference/plans.rs"]
mod plans;
#[path = "reference/worlds.rs"]
mod worlds;

use checks::{counted, explained, only_what_was_attended};
use plans::{GoalOrder, Setup, setup};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{RngSeed, TestRunner};
use pschema_learner::curriculum::{Afterwards, Curriculum, Stage};
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::{Content, Memory};
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::progress::StageCommand;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::BodyId;
use pschema_learner::{ActionOutcome, Frame, Learner, Output, Step};
use worlds::World;

/// A learner that has been told of every body of the set-up, and the effects of that.
fn born(setup: &Setup) -> (Learner, Vec<Effect>) {
    let parameters = setup.parameters.clone();
    let mut learner = Learner::new(setup.plan.seed, parameters, setup.curriculum.clone()).unwrap();
    // Half of them with all mechanisms beyond the paper.
    let mechanisms = if setup.plan.seed.is_multiple_of(2) { Mechanisms::PAPER } else { Mechanisms::FULL };
    let mut effects = learner.set_mechanisms(mechanisms);
    let declarations = setup.plan.declarations().into_iter();
    effects.extend(declarations.flat_map(|declaration| learner.declare(declaration).unwrap().1));
    (learner, effects)
}

/// What a learner is given.
#[derive(Clone)]
enum Input {
    Frame(Frame),
    Command(StageCommand),
    Goal(GoalOrder),
    Full(bool),
}

/// Gives it. An operator's command or goal is a step that asks nothing of a body.
fn give(learner: &mut Learner, input: &Input) -> Step {
    match input {
        Input::Frame(frame) => learner.step(frame),
        Input::Command(command) => {
            // A refused command changes nothing.
            let effects = learner.stage(command).unwrap_or_default();
            Step { output: Output::Hold, effects, decision: None }
        }
        Input::Goal(order) => {
            let effects = match order.clone() {
                Some((body, goal, actions_max)) => learner.pursue(body, goal, actions_max),
                None => learner.cancel_goal(),
            };
            Step { output: Output::Hold, effects: effects.unwrap_or_default(), decision: None }
        }
        Input::Full(full) => Step { output: Output::Hold, effects: learner.set_full(*full), decision: None },
    }
}

/// Lives a set-up through, showing `watch` each input with what it found and what came of it.
fn live(
    learner: &mut Learner,
    setup: &Setup,
    mut watch: impl FnMut(&Input, &Content, &Step, &Learner) -> Result<(), TestCaseError>,
) -> Result<(), TestCaseError> {
    let mut world = World::new(setup.plan.clone());
    let bodies = setup.plan.declarations().len();
    let mut give = |learner: &mut Learner, input: &Input| {
        let before = learner.memory().content().clone();
        let step = give(learner, input);
        watch(input, &before, &step, learner).map(|()| step.output)
    };
    for _ in 0..setup.steps {
        for command in setup.operator(&mut world) {
            give(learner, &Input::Command(command))?;
        }
        if let Some(order) = setup.goal(&mut world) {
            give(learner, &Input::Goal(order))?;
        }
        if let Some(full) = setup.limit(&mut world) {
            give(learner, &Input::Full(full))?;
        }
        let body = world.random.below(bodies);
        let (outcome, observations) = world.perceive(body);
        let frame = Frame { body: BodyId(u16::try_from(body).unwrap()), outcome, observations };
        let output = give(learner, &Input::Frame(frame))?;
        world.follow(body, &output);
    }
    Ok(())
}

fn config(cases: u32) -> ProptestConfig {
    let given = ProptestConfig::default();
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { given.cases } else { cases };
    // The gate must say the same of the same tree: without a seed of one's own (PROPTEST_RNG_SEED) always the
    // same worlds. `PROPTEST_CASES=10000 PROPTEST_RNG_SEED=$RANDOM cargo test …` looks further.
    let rng_seed = match given.rng_seed {
        RngSeed::Random => RngSeed::Fixed(2011),
        chosen => chosen,
    };
    ProptestConfig { cases, rng_seed, failure_persistence: None, max_shrink_time: 60_000, ..given }
}

fn replayed(memory: &mut Memory, effects: &[Effect]) -> Result<(), TestCaseError> {
    for effect in effects {
        memory.apply(effect).map_err(|error| TestCaseError::fail(format!("{effect:?}: {error}")))?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn replaying_effects_gives_the_same_memory(setup in setup(150)) {
        let (mut learner, mut effects) = born(&setup);
        let mut middle = None;
        live(&mut learner, &setup, |_, _, step, learner| {
            effects.extend(step.effects.clone());
            if learner.memory().content().step == setup.steps as u64 / 2 {
                middle = Some((effects.len(), learner.memory().content().clone()));
            }
            Ok(())
        })?;
        let lived = digest(learner.memory().content());
        let mut memory = Memory::new(setup.plan.seed, setup.parameters.clone());
        replayed(&mut memory, &effects)?;
        prop_assert_eq!(digest(memory.content()), lived.clone());
        // From a snapshot half way, and the effects since.
        let (done, content) = middle.unwrap();
        let mut memory = Memory::restore(content, setup.parameters.clone());
        replayed(&mut memory, &effects[done..])?;
        prop_assert_eq!(digest(memory.content()), lived);
    }

    #[test]
    fn the_order_and_repetition_of_observations_change_nothing(setup in setup(150)) {
        let (mut learner, _) = born(&setup);
        let (mut same, _) = born(&setup);
        let (mut shuffled, _) = born(&setup);
        let mut random = Random::from_seed(setup.plan.seed);
        live(&mut learner, &setup, |input, _, step, _| {
            prop_assert_eq!(&give(&mut same, input), step);
            let mut input = input.clone();
            if let Input::Frame(Frame { observations, .. }) = &mut input {
                for at in (1..observations.len()).rev() {
                    observations.swap(at, random.below(at + 1));
                }
                observations.extend(observations.first().cloned());
            }
            prop_assert_eq!(&give(&mut shuffled, &input), step);
            Ok(())
        })?;
        let lived = digest(learner.memory().content());
        prop_assert_eq!(digest(same.memory().content()), lived.clone());
        prop_assert_eq!(digest(shuffled.memory().content()), lived);
    }

    #[test]
    fn decisions_explain_themselves_counts_are_possible_and_bystanders_are_not_attended_to(
        mut setup in setup(150)
    ) {
        // What a teacher says is perceived without being in the body's frame.
        setup.curriculum.stages.iter_mut().for_each(|stage| stage.say.clear());
        let (mut learner, _) = born(&setup);
        live(&mut learner, &setup, |input, before, step, learner| {
            if let Some(decision) = &step.decision {
                explained(decision)?;
            }
            let after = learner.memory().content();
            let frame = match input {
                Input::Frame(frame) => Some(frame),
                Input::Command(_) | Input::Goal(_) | Input::Full(_) => None,
            };
            let pending = frame.and_then(|frame| before.pending[usize::from(frame.body.0)].as_ref());
            match (frame, pending) {
                (Some(frame), Some(execution)) => only_what_was_attended(frame, execution, before, after)?,
                _ => prop_assert!(before.attention.iter().eq(after.attention.iter())),
            }
            counted(after)
        })?;
    }

    #[test]
    fn a_full_memory_takes_in_nothing_new(setup in setup(150)) {
        let setup = Setup { commands: 20, ..setup };
        let (mut learner, _) = born(&setup);
        live(&mut learner, &setup, |_, before, step, learner| {
            let after = learner.memory().content();
            if before.full && after.full {
                let grows = |effect: &Effect| matches!(
                    effect,
                    Effect::Created { .. }
                        | Effect::Generalised { .. }
                        | Effect::OutcomeAdded { .. }
                        | Effect::Associated { .. }
                );
                prop_assert!(!step.effects.iter().any(grows), "{:?}", step.effects);
                prop_assert_eq!(before.observations.len(), after.observations.len());
            }
            Ok(())
        })?;
    }

    #[test]
    fn a_frozen_stage_teaches_nothing(setup in setup(100), frozen_steps in 1..60_usize) {
        let mut setup = Setup { commands: 0, ..setup };
        let learning = Stage::free("learning");
        let mut frozen = Stage::free("frozen");
        frozen.learning = false;
        let stages = vec![learning, frozen];
        let afterwards = Afterwards::Continue;
        setup.curriculum = Curriculum { name: "frozen".into(), pools: Vec::new(), stages, afterwards };
        let (mut learner, _) = born(&setup);
        live(&mut learner, &setup, |_, _, _, _| Ok(()))?;
        learner.stage(&StageCommand::Set("frozen".into())).unwrap();
        let learnt = learner.memory().content().clone();
        setup.steps = frozen_steps;
        live(&mut learner, &setup, |_, _, _, _| Ok(()))?;
        let content = learner.memory().content();
        prop_assert!(content.schemas.iter().eq(learnt.schemas.iter()));
        prop_assert!(content.attention.iter().eq(learnt.attention.iter()));
        prop_assert!(content.attempts.iter().eq(learnt.attempts.iter()));
    }
}

/// A frame that no honest body sends: unknown bodies, types, properties and symbols, repetitions, crowds.
fn wild_frame() -> impl Strategy<Value = Frame> {
    let value = prop_oneof![
        any::<i64>().prop_map(Value::Integer),
        (0..3_i64).prop_map(Value::Integer),
        any::<u32>().prop_map(|symbol| Value::Symbol(SymbolId(symbol))),
        any::<bool>().prop_map(Value::Boolean),
        any::<i64>().prop_map(Value::Bin),
    ];
    let property = prop_oneof![3 => 0..3_u16, 1 => any::<u16>()];
    let kind = prop_oneof![4 => 0..4_u16, 1 => any::<u16>()];
    let observation = (kind, vec((property.prop_map(PropertyId), value), 0..4))
        .prop_map(|(kind, properties)| Observation::new(TypeId(kind), properties));
    let crowd = prop_oneof![8 => vec(observation.clone(), 0..6), 1 => vec(observation, 500)];
    let outcome = prop::sample::select(vec![
        None,
        Some(ActionOutcome::Done),
        Some(ActionOutcome::Done),
        Some(ActionOutcome::Done),
        Some(ActionOutcome::Refused),
        Some(ActionOutcome::Failed),
        Some(ActionOutcome::TimedOut),
        Some(ActionOutcome::EpisodeEnded),
        Some(ActionOutcome::EpisodeCut),
    ]);
    let body = prop_oneof![9 => 0..2_u16, 1 => any::<u16>()];
    (body, outcome, crowd).prop_map(|(body, outcome, observations)| Frame {
        body: BodyId(body),
        outcome,
        observations,
    })
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn no_frame_stops_the_learner(setup in setup(100), frames in vec(wild_frame(), 1..60)) {
        let (mut learner, mut effects) = born(&setup);
        for frame in &frames {
            let step = learner.step(frame);
            if let Some(decision) = &step.decision {
                explained(decision)?;
            }
            effects.extend(step.effects);
        }
        counted(learner.memory().content())?;
        let mut memory = Memory::new(setup.plan.seed, setup.parameters);
        replayed(&mut memory, &effects)?;
        prop_assert_eq!(digest(memory.content()), digest(learner.memory().content()));
    }
}

/// The number of the variant, for counting.
fn variant(effect: &Effect) -> String {
    let text = format!("{effect:?}");
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_owned()
}

proptest! {
    #![proptest_config(config(200))]

    #[test]
    fn whatever_an_effect_says_it_is_applied_or_changes_nothing(
        setup in setup(80),
        effects in vec(effects::effect(), 1..60)
    ) {
        let (mut learner, _) = born(&setup);
        live(&mut learner, &setup, |_, _, _, _| Ok(()))?;
        let mut memory = learner.into_memory();
        for (effect, mend) in effects {
            let effect = if mend { effects::mended(&effect, memory.content()) } else { effect };
            let before = digest(memory.content());
            if memory.apply(&effect).is_err() {
                prop_assert_eq!(digest(memory.content()), before, "{:?}", effect);
            }
        }
        // What it has become can be lived with, and its indexes are those that it would be given anew.
        let restored = Memory::restore(memory.content().clone(), setup.parameters.clone());
        let mut learner = Learner::resume(memory, setup.curriculum.clone()).unwrap();
        let mut again = Learner::resume(restored, setup.curriculum.clone()).unwrap();
        live(&mut learner, &setup, |input, _, step, _| {
            prop_assert_eq!(&give(&mut again, input), step);
            Ok(())
        })?;
    }
}

/// The property above would hold of a memory that refuses everything.
#[test]
fn of_every_kind_of_effect_some_are_applied_and_some_refused() {
    let mut runner = TestRunner::new(config(1));
    let mut applied = BTreeMap::<String, [usize; 2]>::new();
    for _ in 0..80 {
        let setup = setup(80).new_tree(&mut runner).unwrap().current();
        let (mut learner, _) = born(&setup);
        live(&mut learner, &setup, |_, _, _, _| Ok(())).unwrap();
        let mut memory = learner.into_memory();
        for _ in 0..200 {
            let (effect, mend) = effects::effect().new_tree(&mut runner).unwrap().current();
            let effect = if mend { effects::mended(&effect, memory.content()) } else { effect };
            applied.entry(variant(&effect)).or_default()[usize::from(memory.apply(&effect).is_ok())] += 1;
        }
    }
    assert_eq!(applied.len(), 22, "{applied:?}");
    // Symbols are refused only when there are a million.
    applied.remove("SymbolsMet");
    // Memory may be full or have room at any time.
    applied.remove("Full");
    // And mechanisms switched.
    applied.remove("Mechanisms");
    assert!(applied.values().all(|[refused, applied]| *refused > 0 && *applied > 0), "{applied:?}");
}
