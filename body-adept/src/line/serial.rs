//! A serial port, opened for this process alone.

use std::io::{self, ErrorKind, IsTerminal, Read, Write};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::time::Duration;

use rustix::fs::OFlags;
use serialport::{ClearBuffer, SerialPort, TTYPort};

use super::{Line, LineError, Stopper};

/// Longest wait for the port to take bytes.
const WRITE_WAIT: Duration = Duration::from_millis(200);
/// The same for an order to stop.
const STOP_WAIT: Duration = Duration::from_millis(10);

/// What helps with every port that cannot be opened.
const HINT: &str = "the ports of this machine are in /dev/serial/by-id, they are for the group dialout, and the line has 8 \
                    data bits, no parity, 1 stop bit and no flow control";

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
        let refused = |problem: String| LineError::Open {
            path: path.to_owned(),
            problem: format!("{problem}; {HINT}"),
        };
        if let Some(problem) = no_port(path) {
            return Err(refused(problem));
        }
        let port = serialport::new(path.to_string_lossy(), baud).timeout(WRITE_WAIT).open_native();
        let port = port.map_err(|error| match error.kind() {
            serialport::ErrorKind::NoDevice => {
                refused(format!("{error}: plug it in, and end whatever else uses it"))
            }
            serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
                refused(format!("{error}: this user may not use it; log in anew after you joined its group"))
            }
            _ if is_other_device(path) => refused("it is a device and no serial port".to_owned()),
            _ => refused(error.to_string()),
        })?;
        Ok(Self { port })
    }
}

/// The reason why there can be no port at `path`. None when there may be one.
fn no_port(path: &Path) -> Option<String> {
    let link = std::fs::read_link(path);
    let found = match (std::fs::metadata(path), link) {
        (Ok(found), _) => found,
        (Err(error), Ok(target)) if error.kind() == ErrorKind::NotFound => {
            let target = target.display();
            return Some(format!("it is a link to {target}, which is not there: plug the adapter in"));
        }
        (Err(error), _) if error.kind() == ErrorKind::NotFound => {
            return Some("it is not there: plug the adapter in, or name another".to_owned());
        }
        (Err(error), _) => return Some(error.to_string()),
    };
    let kind = found.file_type();
    if kind.is_char_device() {
        return None;
    }
    let kind = match () {
        () if kind.is_file() => "a file",
        () if kind.is_dir() => "a directory",
        () if kind.is_fifo() => "a FIFO",
        () if kind.is_socket() => "a socket",
        () => "a block device",
    };
    Some(format!("it is {kind} and no serial port"))
}

/// Whether the device at `path`, which could not be used as a port, is of another kind.
fn is_other_device(path: &Path) -> bool {
    let mut options = std::fs::OpenOptions::new();
    options
        .read(true)
        .custom_flags(OFlags::NOCTTY.bits().cast_signed() | OFlags::NONBLOCK.bits().cast_signed());
    options.open(path).is_ok_and(|device| !device.is_terminal())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_serial_port_is_named_with_advice() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        std::os::unix::fs::symlink("ttyUSB9", at("dangling")).unwrap();
        std::fs::write(at("file"), "").unwrap();
        assert!(std::process::Command::new("mkfifo").arg(at("fifo")).status().unwrap().success());
        let cases = [
            (at("none"), "it is not there"),
            (at("dangling"), "a link to ttyUSB9, which is not there"),
            (at("file"), "it is a file and no serial port"),
            (at("fifo"), "it is a FIFO and no serial port"),
            (directory.path().to_owned(), "it is a directory and no serial port"),
            ("/dev/null".into(), "it is a device and no serial port"),
        ];
        for (path, problem) in cases {
            let error = SerialLine::open(&path, 9600).err().unwrap().to_string();
            for part in [problem, "/dev/serial/by-id", "group dialout", "8 data bits, no parity"] {
                assert!(error.contains(part), "{path:?}: {error}");
            }
        }
    }
}
