//! A step of a learner in one of the three worlds, at each of three sizes of memory: frame in, effects and decision out.

use std::path::{Path, PathBuf};

use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::parameters::Parameters;
use pschema_store::{Opened, Options, Store};
use pschema_worlds::{Mix, Surroundings, World, curriculum};

use crate::counted::{Tally, counted};
use crate::failure::CountFailure;

/// Sizes of memory, in schemas, at which steps are counted.
pub(crate) const SIZES: [usize; 3] = [1_000, 10_000, 100_000];
/// Steps that are counted at each size.
const ROUNDS: usize = 400;
/// Everything drawn by lot follows from it.
const SEED: u64 = 1;

/// Lives in a world until memory has come to the largest size, and keeps it in `lives` at each.
pub(crate) fn live(mix: Mix, lives: &Path) -> Result<(), CountFailure> {
    let mut world = World::new(mix, SEED).map_err(CountFailure::of("a life"))?;
    for schemas in SIZES {
        while world.schemas() < schemas {
            let frame = world.frame();
            let step = world.learner_mut().step(&frame);
            world.follow(&step.output);
        }
        keep(&world, mix, &place(lives, mix, schemas))?;
    }
    Ok(())
}

/// The directory of memory in a mix at a size; what surrounds the learner is in a file beside it.
fn place(lives: &Path, mix: Mix, schemas: usize) -> PathBuf {
    lives.join(format!("{}-{schemas}", mix.name()))
}

fn keep(world: &World, mix: Mix, place: &Path) -> Result<(), CountFailure> {
    let Opened { store, .. } = open(mix, place)?;
    store.finish(world.learner().memory()).map_err(CountFailure::of("a life"))?;
    let surroundings = place.with_extension("json");
    let text = serde_json::to_vec(world.surroundings())?;
    std::fs::write(&surroundings, text).map_err(CountFailure::file(surroundings))
}

/// Finds the world again as it was kept.
pub(super) fn resume(mix: Mix, schemas: usize, lives: &Path) -> Result<(World, Store), CountFailure> {
    let place = place(lives, mix, schemas);
    let Opened { learner, store, .. } = open(mix, &place)?;
    let surroundings = place.with_extension("json");
    let text = std::fs::read(&surroundings).map_err(CountFailure::file(surroundings))?;
    let surroundings: Surroundings = serde_json::from_slice(&text)?;
    Ok((World::resume(mix, learner, surroundings), store))
}

pub(super) fn open(mix: Mix, place: &Path) -> Result<Opened, CountFailure> {
    let (parameters, curriculum) = (Parameters::default(), curriculum(mix));
    let options = Options::new("counts", SEED, &parameters, &curriculum);
    pschema_store::open(place, options, || ()).map_err(CountFailure::of("a life"))
}

/// Steps of a learner with all mechanisms before its steps are counted, and the steps that are.
const FULL_STEPS: [usize; 2] = [300, 100];

/// A learner with all mechanisms keeps claims beside schemas, and looks ahead before it chooses.
pub(super) fn carry_out_fully() -> Result<Tally, CountFailure> {
    let mut world = World::new(Mix::Scenario1, SEED).map_err(CountFailure::of("a life"))?;
    world.learner_mut().set_mechanisms(Mechanisms::FULL);
    let mut tally = Tally::default();
    let [before, rounds] = FULL_STEPS;
    for round in 0..before + rounds {
        let frame = world.frame();
        let step = if round < before {
            world.learner_mut().step(&frame)
        } else {
            counted(&mut tally, || world.learner_mut().step(&frame))
        };
        tally.result = tally.result.wrapping_mul(31).wrapping_add(step.effects.len() as u64);
        world.follow(&step.output);
    }
    Ok(tally)
}

pub(super) fn carry_out(mix: Mix, schemas: usize, lives: &Path) -> Result<Tally, CountFailure> {
    let (mut world, _store) = resume(mix, schemas, lives)?;
    let mut tally = Tally::default();
    for _ in 0..ROUNDS {
        let frame = world.frame();
        let step = counted(&mut tally, || world.learner_mut().step(&frame));
        tally.result = tally.result.wrapping_mul(31).wrapping_add(step.effects.len() as u64);
        world.follow(&step.output);
    }
    tally.result = tally.result.wrapping_add(world.schemas() as u64);
    Ok(tally)
}
