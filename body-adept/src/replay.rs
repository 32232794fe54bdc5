//! Replaying a recording: the driver gets the same orders and receives the same bytes as then, and must send the same
//! bytes as then.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pschema_arm::JointPositions;
use thiserror::Error;

use crate::arm::{Permissions, word};
use crate::config::ArmSetup;
use crate::connect::arm_on;
use crate::line::record::{LineRecording, ReplayLine};
use crate::line::recorder::LineRecorder;

/// Why a recording was not replayed, or differs.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error("cannot replay {path}: {source}")]
    Read {
        /// Path of the recording.
        path: String,
        /// The cause.
        source: std::io::Error,
    },
    /// The driver cannot be set up.
    #[error("cannot set up the driver: {0}")]
    Driver(String),
    /// The driver did not do the same as then.
    #[error("line {line} of the recording: {problem}")]
    Differs {
        /// Number of the line in the recording.
        line: usize,
        /// The difference.
        problem: String,
    },
}

/// Replays a recording of the arm of a setup. Returns how many orders the driver had.
///
/// # Errors
/// When it cannot be read, or the driver does not do the same as then.
pub fn replay(setup: &Arc<ArmSetup>, path: &Path) -> Result<u64, ReplayError> {
    let unread = |source| ReplayError::Read { path: path.display().to_string(), source };
    let recording = LineRecording::read(path).map_err(unread)?;
    let lines = recording.clone();
    let open = Box::new(move || Ok(Box::new(ReplayLine::new(lines.clone())) as Box<dyn crate::line::Line>));
    let driver = |error: std::io::Error| ReplayError::Driver(error.to_string());
    let stop = Arc::new(AtomicBool::new(false));
    let mut arm =
        arm_on(setup, open, LineRecorder::default(), Permissions { moves: true, home: true }, stop, None)
            .map_err(driver)?;
    arm.replaying();
    let mut orders = 0;
    while let Some((line, order)) = recording.next_order() {
        orders += 1;
        let outcome = obey(&mut arm, &order).map_err(|problem| ReplayError::Differs { line, problem })?;
        match recording.next_outcome() {
            Some((_, recorded)) if recorded == outcome => {}
            Some((line, recorded)) => {
                let problem = format!("{order} came to {outcome} where it had come to {recorded}");
                return Err(ReplayError::Differs { line, problem });
            }
            None => return ended(&recording, &order, &outcome).map(|()| orders),
        }
    }
    match recording.peek() {
        None => {
            tracing::info!(orders, "the driver said what it said then");
            Ok(orders)
        }
        Some((line, next)) => {
            Err(ReplayError::Differs { line, problem: format!("{next:?} belongs to no order") })
        }
    }
}

/// A recording may end in the middle of an order, as when the process was killed; anything else is a difference.
fn ended(recording: &LineRecording, order: &str, outcome: &str) -> Result<(), ReplayError> {
    let Some((line, next)) = recording.peek() else { return Ok(()) };
    let problem = format!("{order} came to {outcome} where the driver had gone on with {next:?}");
    Err(ReplayError::Differs { line, problem })
}

/// Gives the driver one order of the recording. Returns its outcome.
fn obey(arm: &mut crate::arm::Arm, order: &str) -> Result<String, String> {
    let words: Vec<&str> = order.split(' ').collect();
    Ok(match words.as_slice() {
        ["connect"] => arm.connect().map_or("not connected", |()| "connected").to_owned(),
        ["enable", home @ ..] => {
            arm.may_home(*home == ["home"]);
            arm.enable().map_or("not enabled", |()| "enabled").to_owned()
        }
        ["signals"] => {
            arm.signals().map_or_else(|_| "unknown".to_owned(), |signals| format!("{signals:04b}"))
        }
        ["park"] => word(&arm.park()).to_owned(),
        ["go", j1, j2] => {
            let number = |text: &str| text.parse::<f64>().map_err(|_| format!("{text:?} in an order"));
            word(&arm.go(JointPositions { j1: number(j1)?, j2: number(j2)? })).to_owned()
        }
        _ => return Err(format!("{order:?} is no order")),
    })
}
