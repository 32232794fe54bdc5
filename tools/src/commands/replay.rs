//! `pschema replay`: rebuilds memory as it was at a step.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use pschema_inspect::{StageState, StatusQuery};
use pschema_store::past::DataDirectory;
use serde::Serialize;

use crate::failure::Failure;
use crate::output;
use crate::past::MemoryOnDisk;
use crate::render::status;
use crate::render::table::Columns;
use crate::render::words::{count, duration, plain};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema replay --data ~/arm --until 5000\n  \
    pschema replay --data ~/arm --until 5000 --out ~/arm-at-5000\n  \
    pschema server --data ~/arm-at-5000")]
pub(crate) struct ReplayArgs {
    /// The data directory; a daemon may be running on it
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// To this step; to the last one unless named
    #[arg(long, value_name = "N")]
    until: Option<u64>,
    /// Write it as a data directory, which is made: a life that branches off there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Memory as it was at a step.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct ReplayReport {
    /// The step.
    step: u64,
    /// The last frame of the journal that belongs to it.
    frame: u64,
    /// The curriculum.
    curriculum: String,
    /// The stage of the curriculum.
    stage: String,
    /// What the stage was doing.
    stage_state: StageState,
    /// Schemas in memory.
    schemas_total: u32,
    /// Those with constants only.
    schemas_concrete: u32,
    /// Those with variables.
    schemas_generalised: u32,
    /// Digest of everything learnt.
    memory_digest: String,
    /// The step of the snapshot that memory was rebuilt from; none: from its beginning.
    snapshot_step: Option<u64>,
    /// Frames of the journal that were replayed after that snapshot.
    frames_replayed: u64,
    /// How long that took.
    replay_s: f64,
    /// The data directory that was made; none when none was asked for.
    made: Option<DataDirectory>,
}

pub(crate) fn run(args: ReplayArgs) -> Result<(), Failure> {
    let memory = MemoryOnDisk::open(&args.data, args.until)?;
    let began = Instant::now();
    let moment = memory.past().moment(args.until)?;
    let replay_s = began.elapsed().as_secs_f64();
    let (frame, snapshot_step, frames_replayed) = (moment.frame, moment.snapshot_step, moment.frames);
    let status = memory.answer(moment, &StatusQuery {})?;
    let made = match &args.out {
        Some(out) => Some(memory.past().branch(args.until, out)?),
        None => None,
    };
    let report = ReplayReport {
        step: status.step,
        frame,
        curriculum: status.curriculum,
        stage: status.stage,
        stage_state: status.stage_state,
        schemas_total: status.schemas_total,
        schemas_concrete: status.schemas_concrete,
        schemas_generalised: status.schemas_generalised,
        memory_digest: status.memory_digest.unwrap_or_default(),
        snapshot_step,
        frames_replayed,
        replay_s,
        made,
    };
    output::show(args.json, &report, text)
}

fn text(f: &ReplayReport) -> String {
    let mut facts = Columns::new(&[]);
    let mut fact = |name: &str, value: String| facts.fact(name, value);
    fact("step", f.step.to_string());
    fact(
        "stage",
        format!("{} ({}) of {}", plain(&f.stage), status::state(&f.stage_state), plain(&f.curriculum)),
    );
    let (concrete, generalised) = (f.schemas_concrete, f.schemas_generalised);
    fact("schemas", format!("{}: {concrete} concrete, {generalised} generalised", f.schemas_total));
    fact("digest", f.memory_digest.clone());
    let from =
        f.snapshot_step.map_or("its beginning".to_owned(), |step| format!("the snapshot of step {step}"));
    let frames = count(f.frames_replayed, "frame");
    fact("rebuilt", format!("from {from} and {frames} after it, in {}", duration(f.replay_s)));
    let mut text = facts.text(&[0]);
    if let Some(made) = &f.made {
        text.push_str(&format!("\nGo on from there with: pschema server --data {}\n", made.directory));
    }
    text
}
