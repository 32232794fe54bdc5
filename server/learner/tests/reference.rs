//! The learner, with its indexes and caches, does exactly what the plain one beside it does: in random
//! worlds, through random curricula, under random parameters, step by step, output and effects.
//!
//! A failure prints the smallest set-up found, seed included, and the first difference.

#[path = "reference/chains.rs"]
mod chains;
#[path = "reference/choosing.rs"]
mod choosing;
#[path = "reference/compare.rs"]
mod compare;
#[path = "reference/generalising.rs"]
mod generalising;
#[path = "reference/learner.rs"]
mod learner;
#[path = "reference/learning.rs"]
mod learning;
#[path = "reference/memory.rs"]
mod memory;
#[path = "reference/plans.rs"]
mod plans;
#[path = "reference/staging.rs"]
mod staging;
#[path = "reference/worlds.rs"]
mod worlds;

use compare::Pair;
use plans::{Setup, setup};
use proptest::prelude::*;
use pschema_learner::progress::StageCommand;
use pschema_learner::step::Frame;
use pschema_learner::vocabulary::BodyId;
use worlds::World;

fn operator(world: &mut World, setup: &Setup) -> StageCommand {
    let stages = &setup.curriculum.stages;
    match world.random.below(5) {
        0 => StageCommand::Hold,
        1 => StageCommand::Next,
        2 => StageCommand::Set(stages[world.random.below(stages.len())].name.clone()),
        3 => StageCommand::Set("nowhere".into()),
        _ => StageCommand::Resume,
    }
}

/// Lives one set-up through with both learners.
fn live(setup: &Setup) -> Result<(), TestCaseError> {
    let mut world = World::new(setup.plan.clone());
    let mut pair = Pair::new(setup)?;
    let bodies = setup.plan.declarations().len();
    for at in 0..setup.steps {
        if world.happens(setup.commands) {
            let command = operator(&mut world, setup);
            pair.command(at, &command)?;
            // So that a hold does not last to the end.
            if world.happens(128) {
                pair.command(at, &StageCommand::Resume)?;
            }
        }
        let body = world.random.below(bodies);
        let (outcome, observations) = world.perceive(body);
        let frame = Frame { body: BodyId(u16::try_from(body).unwrap()), outcome, observations };
        let output = pair.step(at, &frame)?;
        world.follow(body, &output);
    }
    pair.same_memory()
}

fn config(cases: u32) -> ProptestConfig {
    let given = ProptestConfig::default();
    let cases = if std::env::var_os("PROPTEST_CASES").is_some() { given.cases } else { cases };
    ProptestConfig { cases, failure_persistence: None, max_shrink_iters: 20_000, ..given }
}

proptest! {
    #![proptest_config(config(300))]

    #[test]
    fn the_indexed_learner_does_what_the_plain_one_does(setup in setup(300)) {
        live(&setup)?;
    }
}

#[test]
#[ignore]
fn dev_smallest_difference() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::{TestRunner, TestRng, RngAlgorithm};
    let n: usize = std::env::var("DEV_N").map_or(400, |n| n.parse().unwrap());
    let seed: u8 = std::env::var("DEV_SEED").map_or(1, |n| n.parse().unwrap());
    let steps: usize = std::env::var("DEV_STEPS").map_or(300, |n| n.parse().unwrap());
    let mut runner = TestRunner::new_with_rng(config(1), TestRng::from_seed(RngAlgorithm::ChaCha, &[seed; 32]));
    let strategy = setup(steps);
    let mut best: Option<(usize, String, Setup)> = None;
    let mut failures = 0;
    for _ in 0..n {
        let setup = strategy.new_tree(&mut runner).unwrap().current();
        let r = std::panic::catch_unwind(|| live(&setup));
        let message = match r { Ok(Ok(())) => continue, Ok(Err(e)) => e.to_string(), Err(_) => "frame 0 panic".to_string() };
        failures += 1;
        let at: usize = message.split("frame ").nth(1).and_then(|s| s.split(|c: char| !c.is_ascii_digit()).next()).and_then(|s| s.parse().ok()).unwrap_or(9999);
        let size = at * 1000 + message.len();
        if best.as_ref().is_none_or(|(b, _, _)| size < *b) { best = Some((size, message, setup)); }
    }
    println!("{failures} of {n} differ");
    if let Some((_, message, setup)) = best {
        println!("{message}\n{setup:?}");
        panic!();
    }
}
