//! The line to the controller: bytes go out and come in, and every wait ends.

pub mod record;
pub mod recorder;
pub mod serial;

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use thiserror::Error;

/// Why the line cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LineError {
    /// The line cannot be opened.
    #[error("cannot open serial line {path}: {problem}")]
    Open {
        /// Path of the port.
        path: PathBuf,
        /// The cause, and advice.
        problem: String,
    },
    /// The line has gone: it was unplugged, or the other end closed it.
    #[error(
        "the serial line is gone ({0}): check cable and adapter; it is opened again as soon as it is back"
    )]
    Gone(io::Error),
    /// The line took no bytes for too long.
    #[error("the serial line takes no bytes: check that flow control is off at both ends")]
    Stuck,
    /// The driver did not do the same as in the recording that is replayed.
    #[error("line {line} of the recording: {problem}")]
    Replay {
        /// Number of the line in the recording.
        line: usize,
        /// The difference.
        problem: String,
    },
}

/// A line to a controller.
pub trait Line: Send {
    /// Sends bytes, all of them.
    ///
    /// # Errors
    /// When the line is gone or stuck.
    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError>;

    /// Receives the bytes that have come, or come within `wait`. Returns how many; 0 when none came.
    ///
    /// # Errors
    /// When the line is gone.
    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize, LineError>;

    /// Throws away the bytes that have come and were not received.
    ///
    /// # Errors
    /// When the line is gone.
    fn discard(&mut self) -> Result<(), LineError>;

    /// A way to send an order to stop at once, from any thread, before all bytes that were not sent yet.
    ///
    /// # Errors
    /// When the line is gone.
    fn stopper(&self) -> Result<Box<dyn Stopper>, LineError>;
}

/// Sends an order to stop, whatever else the line is doing.
pub trait Stopper: Send {
    /// Drops the bytes that wait to be sent, and sends `bytes`.
    ///
    /// # Errors
    /// When the line is gone or stuck.
    fn stop(&mut self, bytes: &[u8]) -> Result<(), LineError>;
}
