//! A camera behind a Unix stream socket: a line feed asks for a picture taken now, a binary PPM answers.

use std::io::{BufReader, Write};
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
        stream.get_mut().write_all(b"\n").map_err(failed)?;
        let image = picture::ppm(stream);
        image.map_err(|problem| SightError::NoPicture { place: self.place(), problem })
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
