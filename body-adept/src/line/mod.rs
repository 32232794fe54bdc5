//! The line to the controller: bytes out, bytes in, each wait with its end.

pub mod record;
pub mod serial;

use std::io;
use std::path::PathBuf;
use std::time::Duration;

use thiserror::Error;

/// Why the line cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LineError {
    /// It cannot be opened.
    #[error("cannot open serial line {path}: {problem}")]
    Open {
        /// Which.
        path: PathBuf,
        /// Why, and what to do.
        problem: String,
    },
    /// It has gone: unplugged, or the other end closed it.
    #[error(
        "the serial line is gone ({0}): check cable and adapter; it is opened again as soon as it is back"
    )]
    Gone(io::Error),
    /// It took no bytes for too long.
    #[error("the serial line takes no bytes: check that flow control is off at both ends")]
    Stuck,
    /// The recording being replayed says otherwise.
    #[error("line {line} of the recording: {problem}")]
    Replay {
        /// Which line.
        line: usize,
        /// What does not agree.
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

    /// Receives what has come, or comes within `wait`. Returns how many bytes; 0 when none came.
    ///
    /// # Errors
    /// When the line is gone.
    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize, LineError>;

    /// Throws away what has come and was not received.
    ///
    /// # Errors
    /// When the line is gone.
    fn discard(&mut self) -> Result<(), LineError>;

    /// A way to send an order to stop at once, from any thread, before anything not yet sent.
    ///
    /// # Errors
    /// When the line is gone.
    fn stopper(&self) -> Result<Box<dyn Stopper>, LineError>;
}

/// Sends an order to stop, whatever else the line is doing.
pub trait Stopper: Send {
    /// Drops what waits to be sent, and sends `bytes`.
    ///
    /// # Errors
    /// When the line is gone or stuck.
    fn stop(&mut self, bytes: &[u8]) -> Result<(), LineError>;

    /// Where it is to be recorded that it was sent: by whoever has sent it, once nothing waits for that any more.
    fn recorder(&self) -> record::Recorder {
        record::Recorder::default()
    }
}
