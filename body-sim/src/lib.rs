//! The simulated body: an arm, a table, blocks, a camera (section III of the paper).
//!
//! Blocks and finger move in a physics engine; the camera's picture is rendered and looked at with the same
//! eye as a real one's. The same seed gives the same run, bit for bit. The exact worlds of `pschema-exact`, which have no physics,
//! are run by the same arguments.
//!
//! ```
//! use pschema_protocol::body::{Body, Outcome, Senses};
//! use pschema_protocol::description::{Action, Value};
//! use pschema_sim::body::SimBody;
//! use pschema_sim::config::WorldFile;
//!
//! let mut body = SimBody::new("arm", WorldFile::load("wide")?, "wide", 7, false)?;
//! // A person puts the first object at a place, and the arm reaches for it.
//! let position = 40;
//! let field = body.workspace().places[position].field;
//! let posture = *body.workspace().taught_for(field).ok_or("a posture is taught for each place within reach")?;
//! let ids = body.ids();
//! let place = Action::new(ids.place, (Value::symbol(0), position as i64));
//! assert_eq!(body.arrange(&place), Outcome::Done);
//! let reach = Action::new(ids.move_to, [posture.joints.j1, posture.joints.j2]);
//! assert_eq!(body.act(&reach), Outcome::Done);
//! // What it senses then goes to the learner.
//! let mut senses = Senses::default();
//! body.sense(&mut senses);
//! assert!(senses.observations().iter().count() > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs)]

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use pschema_arm::FileError;
use pschema_exact::{ExactBody, WorldError};
use pschema_process::{Occupied, OutputFile, SignalError, Stop};
use pschema_protocol::body::{Body, RunError, RunOptions, RunSummary};
use pschema_protocol::domain::{DomainError, LearnerName, Place, RuntimeDir};
use thiserror::Error;

pub mod body;
pub mod camera;
pub mod config;
pub mod declare;
pub mod eye;
pub mod gap;
pub mod kinematics;
pub mod manifold;
pub mod noise;
pub mod objects;
pub mod pace;
pub mod scene;
pub mod snapshot;
pub mod touch;
pub mod workspace;
pub mod world;

use body::SimBody;
use config::WorldFile;
use noise::NoiseSetting;
use snapshot::SnapshotError;

/// How to run the simulated body.
#[derive(Args, Clone, Debug)]
pub struct SimArgs {
    /// The learner to attach to.
    #[arg(long, value_name = "LEARNER", default_value = "default")]
    pub name: String,
    /// The name this body gives itself; a body that comes back under the same name continues. `arm` unless given, or the
    /// name of the exact world.
    #[arg(long, value_name = "NAME")]
    pub body: Option<String>,
    /// The world it lives in: `wide`, `narrow`, `block-and-ball`, a world file, or `-` for stdin. Or an exact world without
    /// physics, with numbers of its own: `flip`, `float-reset`, `modified-float-reset`, `gripper:blocks=7`, `grid`, `cart`,
    /// `lamps`, `one-kind`, `push`, `posture`, `hand-eye`, `blocks`, `puzzle`, `toys`; or an environment of gymnasium or minigrid: `lake-4`,
    /// `lake-8`, `lake-4-slippery`, `lake-8-slippery`, `cliff`, `taxi`, `empty-8`, `door-key-5`, `empty-5-seen`, `door-key-5-seen`.
    #[arg(long, value_name = "NAME|FILE", default_value = "wide")]
    pub world: String,
    /// The seed of all chances: of the small errors of the hand that places blocks, of the faults of `[noise]`, and of
    /// everything in an exact world. The same seed gives the same run.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// A fault rate that replaces one of the world file's `[noise]`: finger_misplaced, blob_missed, touch_false,
    /// touch_missed (shares, 0 to 1) or move_error_mm. May be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    pub noise: Vec<NoiseSetting>,
    /// Move at the speed of the real arm, instead of as fast as can be computed.
    #[arg(long)]
    pub realtime: bool,
    /// End when the daemon has gone, instead of waiting for it to come back.
    #[arg(long)]
    pub exit_with_daemon: bool,
    /// Attach to nothing: arrange a scene, write the camera's picture with the visual fields drawn in, and end.
    #[arg(long, value_name = "PNG", conflicts_with_all = ["name", "realtime", "exit_with_daemon"])]
    pub snapshot: Option<PathBuf>,
    /// Replace the file of --snapshot if it is there.
    #[arg(long, requires = "snapshot")]
    pub overwrite: bool,
}

/// Why the simulated body could not run.
#[derive(Debug, Error)]
pub enum SimError {
    /// The world cannot be used.
    #[error(transparent)]
    World(#[from] FileError),
    /// There is no file of this name, and no world.
    #[error("{0}, or an exact world: {names}", names = pschema_exact::names())]
    NoWorld(FileError),
    /// The exact world cannot be used.
    #[error(transparent)]
    Exact(#[from] WorldError),
    /// An option that only an arm obeys.
    #[error("--{option} is for a world with an arm, and {world} has none; leave the option out")]
    NoArm {
        /// The option.
        option: &'static str,
        /// The world.
        world: String,
    },
    /// The snapshot failed.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// The learner's name or place is not usable.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Signals cannot be handled.
    #[error(transparent)]
    Signals(#[from] SignalError),
    /// The session with the daemon failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Builds the body that the arguments ask for, without attaching it to anything.
///
/// # Errors
/// When the world cannot be used.
pub fn build(args: &SimArgs) -> Result<SimBody, FileError> {
    let mut file = WorldFile::load(&args.world)?;
    args.noise.iter().for_each(|setting| file.noise.set(*setting));
    SimBody::new(args.body.as_deref().unwrap_or("arm"), file, &args.world, args.seed, args.realtime)
}

/// The body in the exact world that the arguments name; none when they name another.
fn exact(args: &SimArgs) -> Result<Option<ExactBody>, SimError> {
    let Some(kind) = pschema_exact::kind(&args.world) else { return Ok(None) };
    let given = [
        ("noise", !args.noise.is_empty()),
        ("realtime", args.realtime),
        ("snapshot", args.snapshot.is_some()),
    ];
    if let Some((option, _)) = given.into_iter().find(|(_, given)| *given) {
        return Err(SimError::NoArm { option, world: args.world.clone() });
    }
    Ok(Some(ExactBody::new(args.body.as_deref().unwrap_or(kind.name), &args.world, args.seed)?))
}

/// Runs the body until SIGINT or SIGTERM comes, the daemon sends it away, or, if that was asked for, the
/// daemon has gone. With `snapshot` it writes the picture and ends, without a summary.
///
/// # Errors
/// When the world cannot be used, the picture cannot be written, or the session with the daemon fails.
pub fn run(args: &SimArgs) -> Result<Option<RunSummary>, SimError> {
    if let Some(body) = exact(args)? {
        return live(body, args);
    }
    if let Some(path) = &args.snapshot {
        let file = OutputFile::prepare(path, Occupied::overwritten(args.overwrite), &Arc::default());
        let file = file.map_err(SnapshotError::from)?;
        return match snapshot::snapshot(&mut build(args).map_err(unknown)?, file) {
            Err(SnapshotError::Write(error)) if error.nobody_reads() => Ok(None),
            written => Ok(written.map(|()| None)?),
        };
    }
    live(build(args).map_err(unknown)?, args)
}

/// A name that is neither a world's nor a file's may be a slip in the name of an exact world.
fn unknown(error: FileError) -> SimError {
    if matches!(error, FileError::Read { .. }) { SimError::NoWorld(error) } else { SimError::World(error) }
}

/// Runs `body` until it is to end.
fn live(body: impl Body, args: &SimArgs) -> Result<Option<RunSummary>, SimError> {
    let place = Place::new(RuntimeDir::from_environment()?, LearnerName::new(&args.name)?);
    // A second signal ends the process at once, in case an action never ends.
    let stop = Stop::on_signals()?.flag();
    let options = RunOptions::new(place).exit_when_daemon_gone(args.exit_with_daemon).stop(stop);
    Ok(Some(pschema_protocol::body::run(body, &options)?))
}
