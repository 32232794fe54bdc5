//! How long the simulated body takes for an action, against the physics engine alone on the very same way: every step of
//! it, with the same blocks. What the body does beside that (inverse kinematics, what the finger feels, when to stop) is in
//! its figure; steps that it can tell to be without any effect it does not have the engine take.

use std::time::Duration;

use pschema_tools::kit::{Columns, Failure, show, wrapped};
use serde::Serialize;

use crate::bare_engine::BareEngine;
use crate::scenes::{Scenes, ScenesArgs};
use crate::times::Times;

/// What the product promises: a step within this many times the engine's.
const RATIO_WANTED: f64 = 1.2;
/// Actions after which the blocks are put elsewhere.
const ACTIONS_A_SCENE: u32 = 25;

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct SimMeasurement {
    world: String,
    seed: u64,
    blocks: usize,
    actions: usize,
    /// Steps of simulated time in them, 1/240 s each.
    steps: usize,
    actions_per_s: f64,
    action_ms_p50: f64,
    action_ms_p99: f64,
    step_us: f64,
    /// The same of the engine alone.
    rapier_action_ms_p50: f64,
    rapier_action_ms_p99: f64,
    rapier_step_us: f64,
    /// Of all time taken, ours to the engine's; and of the medians and 99th percentiles of actions.
    ratio: f64,
    ratio_p50: f64,
    ratio_p99: f64,
    ratio_wanted: f64,
    within: bool,
    /// How far a block was from its twin at the worst, after an action: shows that both did the same.
    apart_mm_max: f64,
    /// How much faster than the clock on the wall simulated time goes.
    times_real_time: f64,
}

pub(crate) fn run(args: &ScenesArgs, quiet: bool) -> Result<(), Failure> {
    show(args.json, &measured(args, quiet)?, text)
}

fn measured(args: &ScenesArgs, quiet: bool) -> Result<SimMeasurement, Failure> {
    let mut scenes = Scenes::new(args)?;
    let mut alone = BareEngine::beside(&scenes.body);
    let (mut ours, mut rapier) = (Times::default(), Times::default());
    let (mut took, mut alone_took, mut steps, mut apart_m) = (Duration::ZERO, Duration::ZERO, 0, 0.0_f64);
    scenes.run(ACTIONS_A_SCENE, quiet, |body, action, new_scene| {
        if new_scene {
            alone.be_as(body);
        }
        let lap = alone.lap(body, action);
        ours.push(lap.body);
        rapier.push(lap.alone);
        (took, alone_took, steps) = (took + lap.body, alone_took + lap.alone, steps + lap.steps);
        apart_m = apart_m.max(alone.apart_m(body));
        Ok(lap.outcome)
    })?;
    let a_step = |time: Duration| time.as_secs_f64() * 1e6 / steps.max(1) as f64;
    let ratio = took.as_secs_f64() / alone_took.as_secs_f64();
    Ok(SimMeasurement {
        world: args.world.clone(),
        seed: args.seed,
        blocks: scenes.body.world().block_count(),
        actions: ours.len(),
        steps,
        actions_per_s: f64::from(args.rounds) / took.as_secs_f64(),
        action_ms_p50: ours.p50() / 1e3,
        action_ms_p99: ours.p99() / 1e3,
        step_us: a_step(took),
        rapier_action_ms_p50: rapier.p50() / 1e3,
        rapier_action_ms_p99: rapier.p99() / 1e3,
        rapier_step_us: a_step(alone_took),
        ratio,
        ratio_p50: ours.p50() / rapier.p50(),
        ratio_p99: ours.p99() / rapier.p99(),
        ratio_wanted: RATIO_WANTED,
        within: ratio <= RATIO_WANTED,
        apart_mm_max: apart_m * 1e3,
        times_real_time: steps as f64 * pschema_sim::world::STEP_S / took.as_secs_f64(),
    })
}

fn text(f: &SimMeasurement) -> String {
    let mut table = Columns::new(&["", "action p50", "p99", "step", "actions/s"]).figures(&[1, 2, 3, 4]);
    let row = |name: &str, p50: f64, p99: f64, step: f64, rate: String| {
        [name.to_owned(), format!("{p50:.2} ms"), format!("{p99:.2} ms"), format!("{step:.1} us"), rate]
    };
    table.row(row(
        "the body",
        f.action_ms_p50,
        f.action_ms_p99,
        f.step_us,
        format!("{:.0}", f.actions_per_s),
    ));
    table.row(row(
        "rapier alone",
        f.rapier_action_ms_p50,
        f.rapier_action_ms_p99,
        f.rapier_step_us,
        String::new(),
    ));
    let told = format!(
        "{} actions of {} steps in world {}, {} blocks, seed {}, the two taking turns. In all the body takes {:.2} times what          rapier alone does (wanted: at most {}; medians {:.2}, 99th percentiles {:.2}); no block was ever more than {:.2} mm          from its twin. Simulated time goes {:.0} times as fast as the clock on the wall.",
        f.actions,
        f.steps,
        f.world,
        f.blocks,
        f.seed,
        f.ratio,
        f.ratio_wanted,
        f.ratio_p50,
        f.ratio_p99,
        f.apart_mm_max,
        f.times_real_time
    );
    format!("{}\n{}", table.text(&[0]), wrapped(&told, ""))
}
