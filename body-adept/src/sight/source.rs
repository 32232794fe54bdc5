//! What a source of pictures is, and why it may have none.

use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

use pschema_vision::image::{ImageError, RgbImage};
use thiserror::Error;

/// Longest wait for a picture.
pub const PICTURE_WAIT: Duration = Duration::from_secs(5);

/// The source of pictures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraSource {
    /// The newest PNG or PPM file of a directory.
    Folder(PathBuf),
    /// A Unix stream socket: a line feed in, a binary PPM out.
    Socket(PathBuf),
    /// A command whose standard output is raw RGB pictures, one after the other.
    Exec(String),
}

impl FromStr for CameraSource {
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
        /// The source.
        place: String,
        /// The cause.
        source: std::io::Error,
    },
    /// No picture was taken since it was asked for.
    #[error("camera {place}: no new picture within {} s; check the camera", PICTURE_WAIT.as_secs())]
    Stale {
        /// The source.
        place: String,
    },
    /// The bytes that came are no picture.
    #[error("camera {place}: {problem}")]
    NoPicture {
        /// The source.
        place: String,
        /// The mistake in them.
        problem: String,
    },
    /// The picture has another size than the arm file says.
    #[error(
        "camera {place}: the picture is {found_px:?} px, camera in arm.toml says {expected_px:?}; correct one of them"
    )]
    Size {
        /// The source.
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
    /// A picture that was taken after this call.
    ///
    /// # Errors
    /// When there is none.
    fn frame(&mut self) -> Result<RgbImage, SightError>;
}

/// A picture, if it has the size expected.
pub(super) fn sized(
    place: &str,
    image: RgbImage,
    expected_px: (usize, usize),
) -> Result<RgbImage, SightError> {
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
        assert_eq!("folder:/a:b".parse(), Ok(CameraSource::Folder("/a:b".into())));
        assert_eq!("exec:ffmpeg -i x -".parse(), Ok(CameraSource::Exec("ffmpeg -i x -".into())));
        for text in ["", "folder:", "/dev/video0", "exec: "] {
            assert!(text.parse::<CameraSource>().unwrap_err().contains("socket:PATH"), "{text}");
        }
    }
}
