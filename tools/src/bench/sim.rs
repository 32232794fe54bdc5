//! How long the simulated body takes for an action, against the physics engine alone on the very same way: every step of
//! it, with the same blocks. What the body does beside that (inverse kinematics, what the finger feels, when to stop) is in
//! its figure; steps that it can tell to be without any effect it does not have the engine take.

use std::time::Duration;

use pschema_arm::scene;
use pschema_protocol::body::{Body, Outcome};
use pschema_protocol::description::{Action, Value};
use pschema_sim::body::{Alone, SimBody};
use pschema_sim::config::WorldFile;
use serde::Serialize;

use super::{Draw, Times};
use crate::cli::BenchSimArgs;
use crate::failure::Failure;
use crate::output;
use crate::render::schema::wrapped;
use crate::render::table::Columns;
use crate::run::Stop;

/// What the product promises: a step within this many times the engine's.
const RATIO_WANTED: f64 = 1.2;
/// Actions after which the blocks are put elsewhere.
const ACTIONS_A_SCENE: u32 = 25;

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Figures {
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

pub(super) fn run(args: &BenchSimArgs, quiet: bool) -> Result<(), Failure> {
    let figures = measured(args, quiet)?;
    if args.json { output::print_json(&figures) } else { output::print(&text(&figures)) }
}

fn measured(args: &BenchSimArgs, quiet: bool) -> Result<Figures, Failure> {
    let stop = Stop::on_signals()?;
    let bar = crate::bar::Bar::count(quiet);
    let file = WorldFile::load(&args.world).map_err(Failure::of)?;
    let mut body = SimBody::new("arm", file, &args.world, args.seed, false).map_err(Failure::of)?;
    let mut draw = Draw::new(args.seed);
    let repertoire = body.describe().repertoire;
    let mut alone = Alone::beside(&body);
    let (mut ours, mut rapier) = (Times::default(), Times::default());
    let (mut took, mut alone_took, mut steps, mut apart_m) = (Duration::ZERO, Duration::ZERO, 0, 0.0_f64);
    for round in 0..args.rounds {
        stop.check()?;
        if round.is_multiple_of(ACTIONS_A_SCENE) {
            put_blocks(&mut body, &mut draw);
            alone.be_as(&body);
        }
        let Some(action) = repertoire.get(draw.below(repertoire.len())) else {
            return Err(Failure::Failed(format!("world {} has no repertoire", args.world)));
        };
        let lap = alone.lap(&mut body, action);
        if lap.outcome != Outcome::Done {
            return Err(Failure::Failed(format!("an action of the repertoire ended as {:?}", lap.outcome)));
        }
        ours.push(lap.body);
        rapier.push(lap.alone);
        (took, alone_took, steps) = (took + lap.body, alone_took + lap.alone, steps + lap.steps);
        apart_m = apart_m.max(alone.apart_m(&body));
        bar.show(u64::from(round), u64::from(args.rounds), "actions".to_owned());
    }
    drop(bar);
    let a_step = |time: Duration| time.as_secs_f64() * 1e6 / steps.max(1) as f64;
    let ms = |times: &Times, of: f64| times.at(of) / 1e3;
    let ratio = took.as_secs_f64() / alone_took.as_secs_f64();
    Ok(Figures {
        world: args.world.clone(),
        seed: args.seed,
        blocks: body.world().block_count(),
        actions: ours.0.len(),
        steps,
        actions_per_s: f64::from(args.rounds) / took.as_secs_f64(),
        action_ms_p50: ms(&ours, 0.5),
        action_ms_p99: ms(&ours, 0.99),
        step_us: a_step(took),
        rapier_action_ms_p50: ms(&rapier, 0.5),
        rapier_action_ms_p99: ms(&rapier, 0.99),
        rapier_step_us: a_step(alone_took),
        ratio,
        ratio_p50: ours.at(0.5) / rapier.at(0.5),
        ratio_p99: ours.at(0.99) / rapier.at(0.99),
        ratio_wanted: RATIO_WANTED,
        within: ratio <= RATIO_WANTED,
        apart_mm_max: apart_m * 1e3,
        times_real_time: steps as f64 * pschema_sim::world::STEP_S / took.as_secs_f64(),
    })
}

/// Puts every block somewhere, each at a place that is free.
pub(super) fn put_blocks(body: &mut SimBody, draw: &mut Draw) {
    /// Tries for each block: the table has far more places than there are blocks.
    const TRIES: usize = 20;
    for object in 0..body.world().block_count() {
        let places = body.workspace().places.len();
        let (Ok(object), true) = (u32::try_from(object), places > 0) else { continue };
        for _ in 0..TRIES {
            let Ok(place) = i64::try_from(draw.below(places)) else { continue };
            let parameters = vec![Value::Symbol(object), Value::Integer(place)];
            if body.arrange(&Action { action: scene::PLACE, parameters }) == Outcome::Done {
                break;
            }
        }
    }
}

fn text(f: &Figures) -> String {
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
