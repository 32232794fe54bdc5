//! A serial port, opened for this process alone.

use std::io::{self, ErrorKind, Read, Write};
use std::path::Path;
use std::time::Duration;

use serialport::{ClearBuffer, SerialPort, TTYPort};

use super::{Line, LineError, Stopper};

/// Longest wait for the port to take bytes.
const WRITE_WAIT: Duration = Duration::from_millis(200);
/// The same for an order to stop.
const STOP_WAIT: Duration = Duration::from_millis(10);

/// A serial port: 8 data bits, no parity, 1 stop bit, no flow control.
pub struct SerialLine {
    port: TTYPort,
}

impl SerialLine {
    /// Opens a port for this process alone.
    ///
    /// # Errors
    /// When it is not there, not permitted, or another process has it.
    pub fn open(path: &Path, baud: u32) -> Result<Self, LineError> {
        let port = serialport::new(path.to_string_lossy(), baud).timeout(WRITE_WAIT).open_native();
        let port = port.map_err(|error| {
            let problem = match error.kind() {
                serialport::ErrorKind::NoDevice => format!(
                    "{error}: plug it in, end whatever else uses it, and check that this user may (group dialout)"
                ),
                _ => error.to_string(),
            };
            LineError::Open { path: path.to_owned(), problem }
        })?;
        Ok(Self { port })
    }
}

fn gone(error: serialport::Error) -> LineError {
    LineError::Gone(error.into())
}

/// Writes all bytes.
fn write(port: &mut TTYPort, bytes: &[u8]) -> Result<(), LineError> {
    match port.write_all(bytes) {
        Ok(()) => Ok(()),
        Err(error) if error.kind() == ErrorKind::TimedOut => Err(LineError::Stuck),
        Err(error) => Err(LineError::Gone(error)),
    }
}

impl Line for SerialLine {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        self.port.set_timeout(WRITE_WAIT).map_err(gone)?;
        write(&mut self.port, bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize, LineError> {
        self.port.set_timeout(wait).map_err(gone)?;
        match self.port.read(buffer) {
            // The port is readable and has no bytes: the other end has closed it.
            Ok(0) => Err(LineError::Gone(io::Error::from(ErrorKind::UnexpectedEof))),
            Ok(read) => Ok(read),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => Ok(0),
            Err(error) => Err(LineError::Gone(error)),
        }
    }

    fn discard(&mut self) -> Result<(), LineError> {
        self.port.clear(ClearBuffer::Input).map_err(gone)
    }

    fn stopper(&self) -> Result<Box<dyn Stopper>, LineError> {
        let mut port = self.port.try_clone_native().map_err(gone)?;
        port.set_timeout(STOP_WAIT).map_err(gone)?;
        Ok(Box::new(SerialStopper { port }))
    }
}

struct SerialStopper {
    port: TTYPort,
}

impl Stopper for SerialStopper {
    fn stop(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        // This may cut short an order on its way, at worst just before its line end. The bytes that stop begin with one
        // that spoils the rest of such an order, so that no line end completes it. A port that cannot drop the order
        // sends it first.
        self.port.clear(ClearBuffer::Output).ok();
        write(&mut self.port, bytes)
    }
}
