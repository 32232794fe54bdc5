//! The two sockets beside the line: the camera, and a hand that arranges objects and presses buttons.

use std::io::{self, ErrorKind, Read, Write};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

use pschema_vision::image::RgbImage;

/// Clients of one socket at a time.
const CLIENTS_MAX: usize = 8;
/// Longest line taken, in bytes.
const LINE_BYTES_MAX: usize = 256;

/// A Unix stream socket on which each line that comes in is answered.
pub(crate) struct Socket {
    path: PathBuf,
    listener: UnixListener,
    clients: Vec<Client>,
}

struct Client {
    stream: UnixStream,
    line: Vec<u8>,
}

impl Socket {
    /// Listens at `path`, which only its owner may use. A socket that a dead process left there is replaced.
    pub(crate) fn bind(path: &Path) -> io::Result<Self> {
        // Who connects to a plain file is refused as well.
        if path.metadata().is_ok_and(|found| found.file_type().is_socket())
            && UnixStream::connect(path).is_err_and(|error| error.kind() == ErrorKind::ConnectionRefused)
        {
            std::fs::remove_file(path)?;
        }
        let listener = UnixListener::bind(path)?;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o600))?;
        listener.set_nonblocking(true)?;
        Ok(Self { path: path.to_owned(), listener, clients: Vec::new() })
    }

    /// The file descriptors to wait for.
    pub(crate) fn fds(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        std::iter::once(self.listener.as_fd()).chain(self.clients.iter().map(|client| client.stream.as_fd()))
    }

    /// Serves the clients that have sent a line; `answer` makes the bytes of the answer to a line.
    pub(crate) fn serve(&mut self, mut answer: impl FnMut(&str) -> Vec<u8>) {
        while let Ok((stream, _)) = self.listener.accept() {
            // Answers are written whole; a client that does not read them is waited for a moment only.
            let ready =
                stream.set_nonblocking(false).and_then(|()| stream.set_write_timeout(Some(CLIENT_WAIT)));
            if ready.is_ok() && self.clients.len() < CLIENTS_MAX {
                self.clients.push(Client { stream, line: Vec::new() });
            }
        }
        self.clients.retain_mut(|client| client.serve(&mut answer).is_ok());
    }
}

/// How long a client may take to read an answer.
const CLIENT_WAIT: std::time::Duration = std::time::Duration::from_millis(500);

impl Client {
    fn serve(&mut self, answer: &mut impl FnMut(&str) -> Vec<u8>) -> io::Result<()> {
        let mut bytes = [0; LINE_BYTES_MAX];
        self.stream.set_nonblocking(true)?;
        let read = self.stream.read(&mut bytes);
        self.stream.set_nonblocking(false)?;
        let read = match read {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(read) => read,
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
            Err(error) => return Err(error),
        };
        for byte in bytes.iter().take(read) {
            match byte {
                b'\n' => {
                    let line = std::mem::take(&mut self.line);
                    self.stream.write_all(&answer(String::from_utf8_lossy(&line).trim()))?;
                }
                _ if self.line.len() >= LINE_BYTES_MAX => return Err(ErrorKind::InvalidData.into()),
                byte => self.line.push(*byte),
            }
        }
        Ok(())
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        if let Err(error) = std::fs::remove_file(&self.path) {
            tracing::debug!(%error, path = %self.path.display(), "cannot remove the socket");
        }
    }
}

/// A picture as a binary PPM.
pub(crate) fn ppm(image: &RgbImage) -> Vec<u8> {
    let mut bytes = format!("P6\n{} {}\n255\n", image.width_px(), image.height_px()).into_bytes();
    bytes.extend_from_slice(image.as_rgb_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_socket_that_nobody_serves_is_replaced_and_a_file_is_not() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("camera");
        drop(UnixListener::bind(&path).unwrap());
        drop(Socket::bind(&path).unwrap());
        assert!(!path.exists(), "it is removed in the end");
        std::fs::write(&path, "mine").unwrap();
        assert!(Socket::bind(&path).is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
    }
}
