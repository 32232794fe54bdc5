//! Outputs that somebody reads while they are written: FIFOs, devices, and the outputs of this process itself. A reader that
//! takes nothing keeps a writer waiting, but not a writer that is to end.

use std::fs::{File, OpenOptions};
use std::io::{self, IsTerminal, Write};
use std::os::fd::{AsFd, AsRawFd};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::io::Errno;

use crate::stop::asked_to_end;

/// How often it is looked whether this process is to end, while nobody reads.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// The time that a reader has to take something once this process is to end.
const PATIENCE: Duration = Duration::from_millis(500);
/// The bytes for which a pipe that has room at all has room (`PIPE_BUF` of Linux), so that their write does not wait.
const PIECE_MAX: usize = 4_096;

/// A file that is read while it is written. A write waits until a pipe or a terminal has room for it; once this process is to end, it
/// waits for half a second at most, and what was not taken by then is not written.
#[derive(Debug)]
pub struct Stream {
    file: File,
    /// A regular file always has room, or none at all.
    is_regular: bool,
    stop: Arc<AtomicBool>,
    is_given_up: bool,
}

/// Nobody took what was written until this process was asked to end.
#[derive(Debug, thiserror::Error)]
#[error("nobody read it until the end was asked for")]
struct Unread;

/// Whether something was not written because nobody read it until this process was asked to end. Such an error is not of the
/// kind [`Interrupted`](io::ErrorKind::Interrupted), after which a write is tried again.
#[must_use]
pub fn unread(error: &io::Error) -> bool {
    error.get_ref().is_some_and(|cause| cause.is::<Unread>())
}

impl Stream {
    /// Streams into `file` until `stop` is set.
    pub(crate) fn new(file: File, stop: &Arc<AtomicBool>) -> io::Result<Self> {
        let is_regular = file.metadata()?.is_file();
        // A terminal of another user can't be opened anew.
        let file = if file.is_terminal() { opened_anew(&file).unwrap_or(file) } else { file };
        Ok(Self { file, is_regular, stop: Arc::clone(stop), is_given_up: false })
    }

    /// The stdout of this process, until a signal asks the process to end.
    ///
    /// # Errors
    /// When the system has no more descriptors.
    pub fn stdout() -> io::Result<Self> {
        Self::new(File::from(io::stdout().as_fd().try_clone_to_owned()?), &asked_to_end())
    }

    /// An output of this process, if it is named by its path, or by `-`, which is stdout. Opened by that path, a file behind it
    /// would be written from its beginning again, and a socket could not be opened at all.
    pub(crate) fn own(path: &Path, stop: &Arc<AtomicBool>) -> Option<io::Result<Self>> {
        let output = match path.to_str()? {
            "-" | "/dev/stdout" | "/dev/fd/1" | "/proc/self/fd/1" => {
                io::stdout().as_fd().try_clone_to_owned()
            }
            "/dev/stderr" | "/dev/fd/2" | "/proc/self/fd/2" => io::stderr().as_fd().try_clone_to_owned(),
            _ => return None,
        };
        Some(output.and_then(|output| Self::new(File::from(output), stop)))
    }

    /// Opens a FIFO when somebody reads it. An open that waits would not be ended by a signal that only raises a flag.
    pub(crate) fn into_fifo(path: &Path, stop: &Arc<AtomicBool>) -> io::Result<Self> {
        let mut options = OpenOptions::new();
        options.write(true).custom_flags(OFlags::NONBLOCK.bits().cast_signed());
        let mut told = false;
        loop {
            match options.open(path) {
                Ok(file) => {
                    fcntl_setfl(&file, fcntl_getfl(&file)? - OFlags::NONBLOCK)?;
                    return Self::new(file, stop);
                }
                Err(error) if error.raw_os_error() == Some(Errno::NXIO.raw_os_error()) => {
                    if stop.load(Ordering::Relaxed) {
                        return Err(io::Error::other(Unread));
                    }
                    if !told {
                        tracing::warn!("nobody reads {} yet: waiting until somebody does", path.display());
                    }
                    told = true;
                    thread::sleep(LOOK_EVERY);
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Sees to it that what was written is on the disk, where it is kept on one.
    ///
    /// # Errors
    /// When the system refuses it.
    pub fn sync(&self) -> io::Result<()> {
        if self.is_regular { self.file.sync_all() } else { Ok(()) }
    }

    /// Whether a write has room, waiting a moment for it.
    fn has_room(&self) -> io::Result<bool> {
        let pause = Timespec::try_from(LOOK_EVERY).map_err(io::Error::other)?;
        // Of a pipe that nobody will read again this says that it is ready, and the write says the rest.
        match poll(&mut [PollFd::new(&self.file, PollFlags::OUT)], Some(&pause)) {
            Ok(0) | Err(Errno::INTR) => Ok(false),
            Ok(_) => Ok(true),
            Err(error) => Err(error.into()),
        }
    }
}

/// The terminal behind a file, opened anew so that no write to it waits: one that has room at all may have less than is
/// written. The file itself is shared with other processes, and so is how it is written.
fn opened_anew(terminal: &File) -> io::Result<File> {
    let flags = (OFlags::NONBLOCK | OFlags::NOCTTY).bits().cast_signed();
    let path = format!("/proc/self/fd/{}", terminal.as_raw_fd());
    OpenOptions::new().write(true).custom_flags(flags).open(path)
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_regular {
            return self.file.write(bytes);
        }
        let mut asked: Option<Instant> = None;
        while !self.is_given_up {
            if self.has_room()? {
                match self.file.write(&bytes[..bytes.len().min(PIECE_MAX)]) {
                    // A terminal had less room than the end of a line takes, or another program was faster.
                    Err(error) if error.kind() == io::ErrorKind::WouldBlock => thread::sleep(LOOK_EVERY),
                    written => return written,
                }
            }
            self.is_given_up = self.stop.load(Ordering::Relaxed)
                && asked.get_or_insert_with(Instant::now).elapsed() >= PATIENCE;
        }
        Err(io::Error::other(Unread))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

    use super::*;

    /// A recording into a pipe whose reader was halted hung in its write, and no first signal ended it.
    #[test]
    fn a_reader_that_takes_nothing_does_not_keep_a_writer_that_is_to_end() {
        let (mut reader, writer) = io::pipe().unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let mut stream = Stream::new(File::from(std::os::fd::OwnedFd::from(writer)), &stop).unwrap();
        let (begun, has_begun) = std::sync::mpsc::channel();
        let writing = thread::spawn(move || {
            begun.send(()).unwrap();
            // More than a pipe holds.
            let error = stream.write_all(&[7; 1 << 20]).unwrap_err();
            // Nothing is waited for a second time.
            let again = stream.write(&[7]).unwrap_err();
            (unread(&error), unread(&again), error.kind(), stream)
        });
        has_begun.recv().unwrap();
        stop.store(true, Ordering::Relaxed);
        let (first, again, kind, stream) = writing.join().unwrap();
        assert!(first && again && kind != io::ErrorKind::Interrupted, "{kind:?}");
        drop(stream);
        let mut taken = Vec::new();
        reader.read_to_end(&mut taken).unwrap();
        assert!(taken.len() >= PIECE_MAX && taken.len() < 1 << 20, "{}", taken.len());
    }

    /// A terminal takes part of a line, and waits with the rest.
    #[test]
    fn a_terminal_that_takes_nothing_does_not_keep_a_writer_that_is_to_end() {
        let screen = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&screen).unwrap();
        unlockpt(&screen).unwrap();
        let name = ptsname(&screen, Vec::new()).unwrap();
        let flags = OFlags::NOCTTY.bits().cast_signed();
        let terminal =
            OpenOptions::new().write(true).custom_flags(flags).open(name.to_str().unwrap()).unwrap();
        let shared = terminal.try_clone().unwrap();
        let mut stream = Stream::new(terminal, &Arc::new(AtomicBool::new(true))).unwrap();
        let lines = "a line of a recording\n".repeat(50_000);
        let error = stream.write_all(lines.as_bytes()).unwrap_err();
        assert!(unread(&error), "{error}");
        let is_waited_for = !fcntl_getfl(&shared).unwrap().contains(OFlags::NONBLOCK);
        assert!(is_waited_for, "for others that write to it the terminal is as it was");
    }

    #[test]
    fn a_reader_that_goes_on_gets_all_of_it_after_the_end_was_asked_for() {
        let (mut reader, writer) = io::pipe().unwrap();
        let stop = Arc::new(AtomicBool::new(true));
        let mut stream = Stream::new(File::from(std::os::fd::OwnedFd::from(writer)), &stop).unwrap();
        let reading = thread::spawn(move || {
            let mut taken = Vec::new();
            reader.read_to_end(&mut taken).unwrap();
            taken
        });
        stream.write_all(&[7; 1 << 20]).unwrap();
        drop(stream);
        assert_eq!(reading.join().unwrap(), [7; 1 << 20]);
        // Nobody reads any more.
        let (reader, writer) = io::pipe().unwrap();
        drop(reader);
        let mut stream = Stream::new(File::from(std::os::fd::OwnedFd::from(writer)), &stop).unwrap();
        assert_eq!(stream.write(&[7]).unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }
}
