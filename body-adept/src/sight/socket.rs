//! A camera behind a Unix stream socket: a line feed asks for a picture taken now, a binary PPM answers.

use std::io::{self, BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;

use pschema_vision::image::RgbImage;

use super::picture;
use super::source::{FrameSource, PICTURE_WAIT, SightError, sized};

pub(super) struct Socket {
    path: PathBuf,
    size_px: (usize, usize),
    stream: Option<BufReader<UnixStream>>,
}

impl Socket {
    pub(super) fn new(path: PathBuf, size_px: (usize, usize)) -> Self {
        Self { path, size_px, stream: None }
    }

    fn place(&self) -> String {
        format!("socket:{}", self.path.display())
    }

    fn ask(&mut self) -> Result<RgbImage, SightError> {
        let failed = |source| SightError::Io { place: format!("socket:{}", self.path.display()), source };
        let stream = match &mut self.stream {
            Some(stream) => stream,
            none => {
                let stream = UnixStream::connect(&self.path).map_err(failed)?;
                stream.set_read_timeout(Some(PICTURE_WAIT)).map_err(failed)?;
                stream.set_write_timeout(Some(PICTURE_WAIT)).map_err(failed)?;
                none.insert(BufReader::new(stream))
            }
        };
        // A picture that is here before it is asked for was taken before.
        if unasked(stream).map_err(failed)? {
            let problem = "it sent what nobody had asked for: it must send one picture for each line feed";
            return Err(SightError::NoPicture { place: self.place(), problem: problem.to_owned() });
        }
        stream.get_mut().write_all(b"\n").map_err(failed)?;
        let image = picture::ppm(stream);
        image.map_err(|problem| SightError::NoPicture { place: self.place(), problem })
    }
}

/// Whether bytes are here already.
fn unasked(stream: &mut BufReader<UnixStream>) -> io::Result<bool> {
    if !stream.buffer().is_empty() {
        return Ok(true);
    }
    stream.get_ref().set_nonblocking(true)?;
    let here = stream.fill_buf().map(|bytes| !bytes.is_empty());
    stream.get_ref().set_nonblocking(false)?;
    match here {
        // The other end is closed.
        Ok(false) => Err(io::ErrorKind::UnexpectedEof.into()),
        Err(error) if error.kind() == io::ErrorKind::WouldBlock => Ok(false),
        here => here,
    }
}

impl FrameSource for Socket {
    fn frame(&mut self) -> Result<RgbImage, SightError> {
        let image = self.ask();
        if image.is_err() {
            // The rest of a broken answer would be taken for the next picture.
            self.stream = None;
        }
        sized(&self.place(), image?, self.size_px)
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::net::UnixListener;

    use super::*;

    #[test]
    fn a_picture_that_came_unasked_is_none_and_the_next_connection_serves() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("camera");
        let listener = UnixListener::bind(&path).unwrap();
        let picture = |value: u8| [b"P6 1 1 255\n".as_slice(), &[value; 3]].concat();
        let camera = std::thread::spawn(move || {
            for pictures in [[picture(1), picture(2)].concat(), picture(3)] {
                let (stream, _) = listener.accept().unwrap();
                let mut line = String::new();
                BufReader::new(&stream).read_line(&mut line).unwrap();
                (&stream).write_all(&pictures).unwrap();
                // It waits for the other end to be closed.
                BufReader::new(&stream).read_line(&mut line).unwrap();
            }
        });
        let mut socket = Socket::new(path, (1, 1));
        assert_eq!(socket.frame().unwrap().pixels(), [[1; 3]]);
        let unasked = socket.frame().unwrap_err().to_string();
        assert!(unasked.contains("nobody had asked for"), "{unasked}");
        assert_eq!(socket.frame().unwrap().pixels(), [[3; 3]], "a connection of its own");
        drop(socket);
        camera.join().unwrap();
    }
}
