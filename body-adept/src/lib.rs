//! The real body: an Adept arm on a serial line, its camera and its touch sensors (section III-A of the paper).
//!
//! To the daemon it is a body like the simulated one, with the same senses and actions. Every motion passes the [gate],
//! every stop goes through the [switch], and the arm moves only after a person has enabled it. `docs/ADEPT.md` lists
//! the hazards and the answer to each.
//!
//! ```text
//! body -> arm -> gate -> controller/{program, monitor} -> v_plus (text) -> line/{serial, record}
//!           watch (daemon's pulse, own loop, signals) -> switch ------------^
//! ```
//!
//! ```
//! use pschema_adept::config::ArmSetup;
//! use pschema_adept::gate::Leg;
//! use pschema_arm::route::Waypoint;
//!
//! let setup = ArmSetup::load("emulated")?;
//! let gate = &setup.gate;
//! let rest = gate.taught().at(Waypoint { joints: setup.rest, lift_m: 0.0 }).ok_or("the rest posture is taught")?;
//! let leg = |to: &[f64]| vec![Leg { to: to.to_vec(), speed_percent: 10 }];
//! assert!(gate.permit(&rest, leg(&rest), true).is_ok());
//! // A joint beyond its limit is refused, with figures.
//! let mut beyond = rest.clone();
//! beyond[0] = 1000.0;
//! let refusal = gate.permit(&rest, leg(&beyond), true).unwrap_err();
//! assert_eq!(refusal.to_string(), "joint 1 at 1000: its limits in arm.toml are -95 to 95");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs)]

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, ValueEnum};
use pschema_arm::FileError;
use pschema_process::{Occupied, OutputError, SignalError, Stop, stream};
use pschema_protocol::body::{RunError, RunOptions, RunSummary};
use pschema_protocol::domain::{DomainError, LearnerName, Place, RuntimeDir};
use thiserror::Error;

pub mod arm;
pub mod body;
pub mod calibration;
pub mod config;
mod connect;
pub mod controller;
pub mod gate;
pub mod line;
mod motion;
pub mod operator;
mod path;
mod priority;
mod pulse;
pub mod replay;
pub mod sight;
pub mod switch;
pub mod taught;
pub mod v_plus;
pub mod watch;

use arm::Permissions;
use body::AdeptBody;
use calibration::{ArmFile, CalibrationError};
use config::ArmSetup;
use controller::ControllerError;
use line::recorder::LineRecorder;
use operator::{Operator, OperatorError, OperatorPlace, Wish};
use replay::ReplayError;
use sight::{CameraSource, SightError};
use watch::Beat;

pub use connect::{OpenLine, arm_on};

/// How long the consent of `--enable` holds while the controller is not ready.
const CONSENT_HOLDS: Duration = Duration::from_secs(30);
/// Longest wait for a person at the beginning.
const PERSON_WAIT: Duration = Duration::from_secs(3600);

/// How to run the Adept body.
#[derive(Args, Clone, Debug)]
pub struct AdeptArgs {
    /// The learner to attach to.
    #[arg(long, value_name = "LEARNER", default_value = "default")]
    pub name: String,
    /// The name this body gives itself; a body that comes back under the same name continues.
    #[arg(long, value_name = "NAME", default_value = "arm")]
    pub body: String,
    /// The serial port that the controller is on.
    #[arg(long, value_name = "DEVICE")]
    pub port: Option<PathBuf>,
    /// The description of the arm, with its limits: `emulated`, an arm file, or `-` for stdin.
    #[arg(long, value_name = "NAME|FILE", default_value = "emulated")]
    pub arm: String,
    /// Where pictures come from: folder:DIRECTORY (the newest one), socket:PATH, or exec:COMMAND that prints raw
    /// RGB pictures.
    #[arg(long, value_name = "CAMERA")]
    pub camera: Option<CameraSource>,
    /// The person who places objects and resets faults: terminal, socket:PATH, or none.
    #[arg(long, value_name = "WHERE", default_value = "terminal")]
    pub operator: OperatorPlace,
    /// Enable the arm at once. Whoever types this has made sure that the work space is clear and stands at the
    /// emergency stop; without it the operator is asked.
    #[arg(long)]
    pub enable: bool,
    /// Calibrate the arm when it is enabled, if the controller says that it is not calibrated. The arm then moves by
    /// itself, in ways that the limits of the arm file cannot hold.
    #[arg(long)]
    pub home: bool,
    /// Connect, sense and check every motion, but move nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// Write every exchange with the controller to a file.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Replace what is in the file of --record already.
    #[arg(long, requires = "record")]
    pub overwrite: bool,
    /// Replay a recording instead of using a port: check that this driver sends the same bytes as then, and end.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["port", "record"])]
    pub replay: Option<PathBuf>,
    /// End when the daemon has gone, instead of waiting for it to come back.
    #[arg(long)]
    pub exit_with_daemon: bool,
    /// A task other than serving a daemon.
    // No command of its own: of a port that was named before it and behind it as well, clap would obey the second alone.
    #[arg(value_enum, conflicts_with_all = ["replay", "exit_with_daemon"])]
    pub task: Option<AdeptTask>,
}

/// A task of the Adept body other than serving a daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AdeptTask {
    /// Visit taught points, find the finger in the picture at each, and write the map from table to pixels into the
    /// arm file.
    Calibrate,
}

/// Why the Adept body could not run.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum AdeptError {
    /// A necessary argument is missing.
    #[error("{0}")]
    Usage(&'static str),
    /// The arm file cannot be used.
    #[error(transparent)]
    ArmFile(#[from] FileError),
    /// The camera cannot be used.
    #[error(transparent)]
    Sight(#[from] SightError),
    /// The controller cannot be used.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// Signals cannot be handled.
    #[error(transparent)]
    Signals(#[from] SignalError),
    /// Nobody enabled the arm.
    #[error("the arm is not enabled: {0}")]
    NotEnabled(#[from] OperatorError),
    /// The learner's name or place is not usable.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// The recording cannot be written.
    #[error(transparent)]
    Recording(#[from] OutputError),
    /// The system refused something.
    #[error("cannot {doing}: {source}")]
    System {
        /// The action that was refused, after "cannot".
        doing: String,
        /// The cause.
        source: std::io::Error,
    },
    /// The replay differs.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// The calibration failed.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The session with the daemon failed.
    #[error(transparent)]
    Run(#[from] RunError),
}

fn system(doing: &str) -> impl FnOnce(std::io::Error) -> AdeptError {
    let doing = doing.to_owned();
    move |source| AdeptError::System { doing, source }
}

/// Reads the arm file that the arguments name.
///
/// # Errors
/// When it cannot be used.
pub fn setup(args: &AdeptArgs) -> Result<Arc<ArmSetup>, AdeptError> {
    Ok(Arc::new(ArmSetup::load(&args.arm)?))
}

/// Builds the body that the arguments ask for, without attaching it to anything. `stop` ends its waits; `daemon` is the
/// sign of life without which the arm does not move, if it is to depend on one.
///
/// # Errors
/// When the arm file, the camera or the recording cannot be used. The controller is connected to later.
pub fn build(args: &AdeptArgs, stop: Arc<AtomicBool>, daemon: Option<Beat>) -> Result<AdeptBody, AdeptError> {
    let setup = setup(args)?;
    let port = args.port.clone().ok_or(AdeptError::Usage(
        "which serial port is the controller on? Give --port DEVICE, as in --port /dev/ttyS0",
    ))?;
    let camera = args.camera.as_ref().ok_or(AdeptError::Usage(
        "where do pictures come from? Give --camera folder:DIRECTORY, socket:PATH or exec:COMMAND",
    ))?;
    let recorder = match &args.record {
        Some(path) => LineRecorder::to(stream(path, Occupied::overwritten(args.overwrite), &stop)?),
        None => LineRecorder::default(),
    };
    let size_px = (setup.file.camera.width_px.count(), setup.file.camera.height_px.count());
    let source = sight::open(camera, size_px)?;
    let may = Permissions { moves: !args.dry_run, home: args.home };
    let open = connect::serial(&setup, port, recorder.clone());
    let arm = arm_on(&setup, open, recorder, may, stop.clone(), daemon).map_err(system("start the watch"))?;
    let operator = Operator::new(args.operator.clone());
    Ok(AdeptBody::new(&args.body, arm, source, operator, stop))
}

/// Has the arm enabled: at once with `--enable`, otherwise by asking the operator.
///
/// # Errors
/// When the arm cannot be enabled, or nobody enables it.
pub fn enable(args: &AdeptArgs, body: &mut AdeptBody, stop: &AtomicBool) -> Result<(), AdeptError> {
    if !args.enable && !args.dry_run {
        body.operator().ask(&Wish::Enable("A learner will move the arm."), PERSON_WAIT, stop)?;
    }
    let since = Instant::now();
    while let Err(fault) = body.arm().ensure_connected() {
        if since.elapsed() > CONSENT_HOLDS || stop.load(Ordering::Relaxed) {
            return Err(fault.into());
        }
        tracing::debug!(%fault, "not connected yet");
        std::thread::sleep(Duration::from_millis(100));
    }
    // Once only: a failure from here on may be a person who thought better of it.
    Ok(body.arm().enable()?)
}

/// Runs the Adept body until SIGINT or SIGTERM comes, the daemon sends it away, or, if that was asked for, the daemon
/// has gone. A replay or another task has no summary.
///
/// # Errors
/// When a part of the body cannot be used, nobody enables the arm, or the session with the daemon fails.
pub fn run(args: &AdeptArgs) -> Result<Option<RunSummary>, AdeptError> {
    if let Some(recording) = &args.replay {
        replay::replay(&setup(args)?, recording)?;
        return Ok(None);
    }
    // A signal first stops the arm, whichever it is. A second one ends the process at once; by then the watch has stopped the arm.
    let stop = Stop::on_every_signal()?.flag();
    if args.task == Some(AdeptTask::Calibrate) {
        // All that can be wrong without a motion is found out before the first.
        let file = ArmFile::prepare(&args.arm, &stop)?;
        let mut body = build(args, stop.clone(), None)?;
        body.find_finger()?;
        enable(args, &mut body, &stop)?;
        calibration::calibrate(&mut body, file, &stop)?;
        return Ok(None);
    }
    let place = Place::new(RuntimeDir::from_environment()?, LearnerName::new(&args.name)?);
    let beat = Beat::default();
    let mut body = build(args, stop.clone(), Some(beat.clone()))?;
    let silence_max = Duration::from_secs_f64(body.arm().setup().file.motion.heartbeat_ms.get() / 1000.0);
    enable(args, &mut body, &stop)?;
    let _pulse = pulse::begin(place.clone(), beat, silence_max).map_err(system("feel the daemon's pulse"))?;
    let options = RunOptions::new(place).exit_when_daemon_gone(args.exit_with_daemon).stop(stop);
    Ok(Some(pschema_protocol::body::run(body, &options)?))
}
