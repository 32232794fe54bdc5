//! How long a step takes, learning included, as memory grows to the size of the paper's scenario 3: no stages, 224
//! postures, a block put in one place after another.
//!
//! `cargo run --release -p pschema-learner --example scenario_3 [-- HIDDEN DISPLACED PLACEMENTS [BLOCKS [1]]]` prints one
//! JSON line for each 2,000 schemas and one for the whole, for the mixes below or the one given: in how many frames
//! of 1,000 a block is not seen, and in how many it was shifted to a field beside its own. With the last argument
//! the finger is babbled with first, so that there is something to generalise from. Times are the processor's;
//! `wall_p99_us` is by the clock, and no better than what else the machine is doing allows.

// What is measured here is time; the learner itself has none.
#![allow(clippy::disallowed_types, missing_docs)]

use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

use pschema_learner::Output;
use pschema_learner::curriculum::{
    Afterwards, Argument, Curriculum, Lift, Pool, Saturation, SceneCommand, Stage,
};
use pschema_learner::observation::Observation;
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;

#[path = "../tests/common/mod.rs"]
mod common;

use common::{OBJECT, Table, stage};

/// Postures of the arm, and fields that the finger comes to: those of the paper's simulated robot, roughly.
const FIELDS: i64 = 224;
/// Schemas between two lines.
const EVERY: usize = 2_000;

/// What happens to the blocks.
#[derive(Clone, Copy)]
struct Mix {
    /// Of 1,000 frames, in how many a block is not seen.
    hidden: usize,
    /// Of 1,000 frames, in how many a block has been shifted.
    displaced: usize,
    placements: u32,
    /// Blocks on the table; all but one stay where they are.
    blocks: i64,
    /// Whether the postures are learnt without blocks first.
    babbled: bool,
}

const MIXES: [Mix; 6] = [
    Mix { hidden: 0, displaced: 0, placements: 100, blocks: 1, babbled: false },
    Mix { hidden: 0, displaced: 5, placements: 100, blocks: 1, babbled: false },
    Mix { hidden: 5, displaced: 0, placements: 150, blocks: 1, babbled: false },
    Mix { hidden: 5, displaced: 5, placements: 150, blocks: 1, babbled: false },
    Mix { hidden: 5, displaced: 5, placements: 150, blocks: 2, babbled: false },
    Mix { hidden: 5, displaced: 5, placements: 150, blocks: 1, babbled: true },
];

fn curriculum(mix: Mix) -> Curriculum {
    let saturation = || Some(Saturation { excitation_below: 1.0, actions: 5 });
    let place = SceneCommand {
        command: "place".into(),
        arguments: vec![("position".into(), Argument::Draw("table".into()))],
    };
    let playing = Stage {
        lift: Lift::All,
        trials: mix.placements,
        arrange: vec![place],
        saturation: saturation(),
        ..stage("free play", &[])
    };
    let babbling = Stage { saturation: saturation(), ..stage("babbling", &["finger"]) };
    Curriculum {
        name: "scenario 3".into(),
        pools: vec![Pool { name: "table".into(), from: 0, to: FIELDS - 1 }],
        stages: if mix.babbled { vec![babbling, playing] } else { vec![playing] },
        afterwards: Afterwards::Hold,
    }
}

/// Steps and how long each took.
#[derive(Default)]
struct Times {
    processor: Vec<Duration>,
    clock: Vec<Duration>,
}

/// What this thread has used of the processor.
fn used() -> Duration {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or(0))
}

impl Times {
    fn print(&mut self, mix: Mix, table: &Table, what: &str) {
        self.processor.sort_unstable();
        self.clock.sort_unstable();
        let at = |times: &[Duration], share: f64| {
            let last = times.len().saturating_sub(1);
            times.get((last as f64 * share) as usize).map_or(0.0, |time| time.as_secs_f64() * 1e6)
        };
        let content = table.learner.memory().content();
        let Mix { hidden, displaced, blocks, babbled, .. } = mix;
        println!(
            "{{\"what\": \"{what}\", \"hidden\": {hidden}, \"displaced\": {displaced}, \"blocks\": {blocks}, \"babbled\": {babbled}, \
             \"steps\": {}, \
             \"schemas\": {}, \"generalised\": {}, \"p50_us\": {:.1}, \"p99_us\": {:.1}, \"max_us\": {:.1}, \
             \"total_s\": {:.2}, \"wall_p99_us\": {:.1}}}",
            self.processor.len(),
            content.schemas.len(),
            content.generalised_count,
            at(&self.processor, 0.5),
            at(&self.processor, 0.99),
            at(&self.processor, 1.0),
            self.processor.iter().sum::<Duration>().as_secs_f64(),
            at(&self.clock, 0.99),
        );
    }
}

fn live(mix: Mix) {
    let mut table = Table::new(2011, FIELDS, FIELDS, curriculum(mix), Parameters::default());
    let mut random = Random::from_seed(2011);
    let (mut all, mut part) = (Times::default(), Times::default());
    let mut next = EVERY;
    loop {
        if let Some((_, field)) = table.blocks.first_mut().filter(|_| random.below(1_000) < mix.displaced) {
            *field = (*field + [1, FIELDS - 1][random.below(2)]) % FIELDS;
        }
        let mut frame = table.frame();
        if random.below(1_000) < mix.hidden {
            let seen = |observation: &Observation| observation.kind() != OBJECT;
            frame.observations.retain(seen);
        }
        let (began, used_before) = (Instant::now(), used());
        let step = table.learner.step(&frame);
        let (processor, clock) = (used() - used_before, began.elapsed());
        for times in [&mut all, &mut part] {
            times.processor.push(processor);
            times.clock.push(clock);
        }
        let arranging = matches!(step.output, Output::Arrange(_));
        if !table.follow(step.output) {
            break;
        }
        if arranging {
            table.blocks.extend((1..mix.blocks).map(|other| (2, other * 7)));
        }
        if table.learner.memory().content().schemas.len() >= next {
            part.print(mix, &table, "part");
            part = Times::default();
            next += EVERY;
        }
    }
    part.print(mix, &table, "part");
    all.print(mix, &table, "whole");
}

fn main() {
    let given: Vec<usize> = std::env::args().skip(1).filter_map(|number| number.parse().ok()).collect();
    match given[..] {
        [hidden, displaced, placements, ref rest @ ..] => live(Mix {
            hidden,
            displaced,
            placements: u32::try_from(placements).unwrap_or(100).min(FIELDS as u32),
            blocks: rest.first().map_or(1, |blocks| (*blocks).clamp(1, 20) as i64),
            babbled: rest.get(1).is_some_and(|babbled| *babbled > 0),
        }),
        _ => MIXES.into_iter().for_each(live),
    }
}
