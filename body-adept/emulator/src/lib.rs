//! An emulator of the V+ controller of an Adept arm, with a simulated arm, table, blocks and camera behind it:
//! everything that a driver meets at a real arm - text on a serial line, pictures, digital inputs - without the arm.
//!
//! It speaks on a pseudo-terminal, either as the controller's monitor ([`Dialect::Monitor`]) or as the program
//! `pschema.v2` on a user serial line ([`Dialect::Program`]). Beside the line it has a camera socket (a line feed in, a
//! binary PPM out) and an operator's socket for the deeds of a person in the room, one line each, answered by `done` or
//! `refused WHY`:
//!
//! | line | |
//! |---|---|
//! | `place OBJECT POSITION`, `remove OBJECT` | arranges the objects on the table |
//! | `estop press`, `estop release` | presses or releases the emergency stop |
//! | `halt` | stops the arm, as with a pendant |
//! | `trip` | has the program that serves the line meet an error of V+ |
//! | `power cycle` | switches the controller off and on |
//! | `unplug MS` | pulls the plug of the line, and puts it back after so long |
//! | `say TEXT` | has the controller say something unasked |
//! | `faults on`, `faults off` | turns the faults that the line was started with on or off |
//! | `enable WHY`, `reset WHY` | asks for the person's consent, which is given if the emulator was started with `--consent` |
//! | `record` | tells the figures of the arm's record so far |
//!
//! The heads of `monitor`, `messages` and `machine` say which parts of the behaviour are documented and which are from
//! memory. The driver (`pschema-adept`) and this crate do not depend on each other: both follow the documents.
//!
//! Time: the arm moves in its own time, `fast` times as fast as the clock on the wall. The guards and the pace of the
//! line - the program's watchdog, faults, characters - always go by the clock on the wall. The world moves only while
//! the arm does, so that the same orders and seed give the same pictures however long the pauses between them.
//!
//! ```
//! use pschema_vplus_emulator::{Emulator, EmulatorArgs};
//!
//! let directory = tempfile::tempdir()?;
//! let line = directory.path().join("line");
//! let emulator = Emulator::start(EmulatorArgs::at(&line))?;
//! // A driver opens `line` like a serial port now.
//! assert!(line.exists());
//! assert_eq!(emulator.record().motions, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(missing_docs)]

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pschema_process::Worker;

mod args;
mod console;
mod decimal;
mod faults;
mod line;
mod machine;
mod messages;
mod monitor;
mod path;
mod pty;
mod record;
mod rig;
mod server_program;
mod sockets;
mod sum;
pub mod teach;

pub use args::{Dialect, EmulatorArgs, EmulatorError};
pub use faults::FaultSetting;
pub use machine::SOFTSTOPS_DEG;
pub use messages::VPlusMessage;
pub use path::{JOINTS, Joints};
pub use record::EmulatorRecord;

/// Runs the emulator until `stop` is set. `ready` is called once drivers and clients may come.
///
/// # Errors
/// When the world cannot be used, or the line or a socket cannot be made or fails.
pub fn run(args: &EmulatorArgs, stop: &AtomicBool, ready: impl FnOnce()) -> Result<(), EmulatorError> {
    let mut rig = rig::Rig::new(args)?;
    ready();
    while !stop.load(Ordering::Relaxed) {
        rig.turn()?;
    }
    Ok(())
}

/// An emulator in this process, in a thread of its own. Dropping it ends it.
#[derive(Debug)]
pub struct Emulator {
    record: Arc<Mutex<EmulatorRecord>>,
    _thread: Worker,
}

impl Emulator {
    /// Starts an emulator, and returns when drivers may come.
    ///
    /// # Errors
    /// The same as of [`run`].
    pub fn start(args: EmulatorArgs) -> Result<Self, EmulatorError> {
        let (sender, receiver) = std::sync::mpsc::channel();
        let thread = Worker::start("emulator", move |stop| {
            let mut rig = match rig::Rig::new(&args) {
                Ok(rig) => rig,
                Err(error) => return drop(sender.send(Err(error))),
            };
            drop(sender.send(Ok(rig.watched())));
            while !stop.load(Ordering::Relaxed) {
                if let Err(error) = rig.turn() {
                    return tracing::error!(%error, "the emulator ended");
                }
            }
        });
        let thread = thread.map_err(|error| EmulatorError::Thread(error.to_string()))?;
        let record = receiver
            .recv()
            .map_err(|_| EmulatorError::Thread("it died before it was ready".to_owned()))??;
        Ok(Self { record, _thread: thread })
    }

    /// The record of the arm so far.
    #[must_use]
    pub fn record(&self) -> EmulatorRecord {
        self.record.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
