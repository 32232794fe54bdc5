//! The learner, with its indexes and caches, does exactly what the plain one beside it does: in random
//! worlds, through random curricula, under random parameters, step by step, output and effects.
//!
//! A failure prints the smallest set-up found, seed included, and the first difference.

// A test may stop at what cannot be; every number here is small.
#![allow(clippy::unwrap_used)]

#[path = "reference/binding.rs"]
mod binding;
#[path = "reference/chains.rs"]
mod chains;
#[path = "reference/choosing.rs"]
mod choosing;
#[path = "reference/compare.rs"]
mod compare;
#[path = "reference/curricula.rs"]
mod curricula;
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
#[path = "reference/pursuing.rs"]
mod pursuing;
#[path = "reference/schema.rs"]
mod schema;
#[path = "reference/staging.rs"]
mod staging;
#[path = "reference/standing.rs"]
mod standing;
#[path = "reference/worlds.rs"]
mod worlds;

use compare::Pair;
use plans::{Setup, setup};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use pschema_learner::Frame;
use pschema_learner::vocabulary::BodyId;
use worlds::World;

/// Lives one set-up through with both learners.
fn live(setup: &Setup) -> Result<(), TestCaseError> {
    let mut world = World::new(setup.plan.clone());
    let mut pair = Pair::new(setup)?;
    let bodies = setup.plan.declarations().len();
    for at in 0..setup.steps {
        for command in setup.operator(&mut world) {
            pair.command(at, &command)?;
        }
        if let Some(order) = setup.goal(&mut world) {
            pair.goal(at, &order)?;
        }
        if let Some(full) = setup.limit(&mut world) {
            pair.full(full);
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
    // The gate must say the same of the same tree: without a seed of one's own (PROPTEST_RNG_SEED) always the
    // same worlds. `PROPTEST_CASES=10000 PROPTEST_RNG_SEED=$RANDOM cargo test …` looks further.
    let rng_seed = match given.rng_seed {
        RngSeed::Random => RngSeed::Fixed(2011),
        chosen => chosen,
    };
    ProptestConfig {
        cases,
        rng_seed,
        failure_persistence: None,
        max_shrink_iters: 20_000,
        max_shrink_time: 60_000,
        ..given
    }
}

proptest! {
    #![proptest_config(config(1500))]

    #[test]
    fn the_indexed_learner_does_what_the_plain_one_does(setup in setup(300)) {
        live(&setup)?;
    }
}
