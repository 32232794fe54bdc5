//! Pictures of the work space, from wherever the camera's own driver puts them. Every picture was taken after it was
//! asked for: one from before a motion would show a world that is no more.
//!
//! There is no driver for cameras here. The crates that drive them need libraries that a bare machine does not have,
//! and each serves one kind of camera; `exec:` takes raw pictures from any grabber (`ffmpeg -f v4l2 ...`, `dc1394_...`).

mod exec;
mod folder;
mod picture;
mod socket;

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use pschema_vision::image::{ImageError, RgbImage};
use thiserror::Error;

/// Longest wait for a picture.
pub const PICTURE_WAIT: Duration = Duration::from_secs(5);

/// Where pictures come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Camera {
    /// The newest PNG or PPM file of a directory.
    Folder(PathBuf),
    /// A Unix stream socket: a line feed in, a binary PPM out.
    Socket(PathBuf),
    /// A command whose standard output is raw RGB pictures, one after the other.
    Exec(String),
}

impl FromStr for Camera {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("folder", path)) if !path.is_empty() => Ok(Self::Folder(path.into())),
            Some(("socket", path)) if !path.is_empty() => Ok(Self::Socket(path.into())),
            Some(("exec", command)) if !command.trim().is_empty() => Ok(Self::Exec(command.to_owned())),
            _ => Err(format!("{text:?} is no camera: use folder:DIRECTORY, socket:PATH or exec:COMMAND")),
        }
    }
}

/// Why there is no picture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SightError {
    /// The source cannot be read.
    #[error("camera {place}: {source}")]
    Io {
        /// Which source.
        place: String,
        /// Why.
        source: std::io::Error,
    },
    /// No picture was taken since it was asked for.
    #[error("camera {place}: no new picture within {} s; check the camera", PICTURE_WAIT.as_secs())]
    Stale {
        /// Which source.
        place: String,
    },
    /// What came is no picture.
    #[error("camera {place}: {problem}")]
    NoPicture {
        /// Which source.
        place: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The picture has another size than the arm file says.
    #[error(
        "camera {place}: the picture is {found_px:?} px, camera in arm.toml says {expected_px:?}; correct one of them"
    )]
    Size {
        /// Which source.
        place: String,
        /// Width and height of the picture.
        found_px: (usize, usize),
        /// Width and height expected.
        expected_px: (usize, usize),
    },
    /// The picture cannot be held.
    #[error(transparent)]
    Image(#[from] ImageError),
}

/// A source of pictures.
pub trait FrameSource: Send {
    /// A picture that was taken after this was called.
    ///
    /// # Errors
    /// When there is none.
    fn frame(&mut self) -> Result<RgbImage, SightError>;
}

/// Opens a source of pictures of a size.
///
/// # Errors
/// When it cannot be used at all.
pub fn open(camera: &Camera, size_px: (usize, usize)) -> Result<Box<dyn FrameSource>, SightError> {
    Ok(match camera {
        Camera::Folder(path) => Box::new(folder::Folder::new(path.clone(), size_px)),
        Camera::Socket(path) => Box::new(socket::Socket::new(path.clone(), size_px)),
        Camera::Exec(command) => Box::new(exec::Exec::start(command, size_px)?),
    })
}

/// A picture, if it has the size expected.
fn sized(place: &str, image: RgbImage, expected_px: (usize, usize)) -> Result<RgbImage, SightError> {
    let found_px = (image.width_px(), image.height_px());
    if found_px == expected_px {
        return Ok(image);
    }
    Err(SightError::Size { place: place.to_owned(), found_px, expected_px })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_are_read() {
        assert_eq!("folder:/a:b".parse(), Ok(Camera::Folder("/a:b".into())));
        assert_eq!("exec:ffmpeg -i x -".parse(), Ok(Camera::Exec("ffmpeg -i x -".into())));
        for text in ["", "folder:", "/dev/video0", "exec: "] {
            assert!(text.parse::<Camera>().unwrap_err().contains("socket:PATH"), "{text}");
        }
    }
}
