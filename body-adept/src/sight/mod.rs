//! Pictures of the work space, from wherever the camera's own driver puts them. Every picture was taken after it was
//! asked for: a picture from before a motion would show a world that is no more.
//!
//! There is no driver for cameras here. The crates that drive them need libraries that a bare machine does not have,
//! and each serves one kind of camera; `exec:` takes raw pictures from any grabber (`ffmpeg -f v4l2 ...`,
//! `dc1394_...`).

mod exec;
mod folder;
mod picture;
mod socket;
mod source;

pub use source::{CameraSource, FrameSource, PICTURE_WAIT, SightError};

/// Opens a source of pictures of a size.
///
/// # Errors
/// When the source cannot be used at all.
pub fn open(camera: &CameraSource, size_px: (usize, usize)) -> Result<Box<dyn FrameSource>, SightError> {
    Ok(match camera {
        CameraSource::Folder(path) => Box::new(folder::Folder::new(path.clone(), size_px)),
        CameraSource::Socket(path) => Box::new(socket::Socket::new(path.clone(), size_px)),
        CameraSource::Exec(command) => Box::new(exec::Exec::start(command, size_px)?),
    })
}
