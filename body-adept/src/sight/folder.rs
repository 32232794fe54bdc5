//! A camera whose program writes pictures into a directory.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use pschema_vision::image::RgbImage;

use super::picture;
use super::source::{FrameSource, PICTURE_WAIT, SightError, sized};

/// How often the directory is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Files looked at in one directory.
const FILES_MAX: usize = 100_000;

pub(super) struct Folder {
    path: PathBuf,
    size_px: (usize, usize),
}

impl Folder {
    pub(super) fn new(path: PathBuf, size_px: (usize, usize)) -> Self {
        Self { path, size_px }
    }

    fn place(&self) -> String {
        format!("folder:{}", self.path.display())
    }

    /// The newest picture written after `asked`.
    fn newest(&self, asked: SystemTime) -> io::Result<Option<PathBuf>> {
        let mut newest: Option<(SystemTime, PathBuf)> = None;
        for entry in std::fs::read_dir(&self.path)?.take(FILES_MAX) {
            let path = entry?.path();
            let is_picture = path.extension().is_some_and(|ending| ending == "png" || ending == "ppm");
            // A file that vanishes meanwhile was not the newest.
            let Some(written) =
                path.metadata().ok().filter(|_| is_picture).and_then(|data| data.modified().ok())
            else {
                continue;
            };
            if written > asked && newest.as_ref().is_none_or(|(latest, _)| written > *latest) {
                newest = Some((written, path));
            }
        }
        Ok(newest.map(|(_, path)| path))
    }
}

fn read(path: &Path) -> Result<RgbImage, String> {
    let mut file = BufReader::new(File::open(path).map_err(|error| error.to_string())?);
    if path.extension().is_some_and(|ending| ending == "png") {
        picture::png(file)
    } else {
        picture::ppm(&mut file)
    }
}

impl FrameSource for Folder {
    fn frame(&mut self) -> Result<RgbImage, SightError> {
        let (asked, since) = (SystemTime::now(), Instant::now());
        let mut problem = None;
        while since.elapsed() < PICTURE_WAIT {
            let newest =
                self.newest(asked).map_err(|source| SightError::Io { place: self.place(), source })?;
            match newest.map(|path| read(&path)) {
                Some(Ok(image)) => return sized(&self.place(), image, self.size_px),
                // It may not be written whole yet.
                Some(Err(why)) => problem = Some(why),
                None => {}
            }
            std::thread::sleep(LOOK_EVERY);
        }
        Err(match problem {
            Some(problem) => SightError::NoPicture { place: self.place(), problem },
            None => SightError::Stale { place: self.place() },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_picture_written_since_it_was_asked_for_counts() {
        let directory = tempfile::tempdir().unwrap();
        let mut bytes = b"P6\n2 1\n255\n".to_vec();
        bytes.extend([1, 2, 3, 4, 5, 6]);
        let (old, new) = (directory.path().join("1.ppm"), directory.path().join("2.ppm"));
        std::fs::write(&old, &bytes).unwrap();
        let folder = Folder::new(directory.path().to_owned(), (2, 1));
        let asked = old.metadata().unwrap().modified().unwrap() + Duration::from_millis(1);
        assert_eq!(folder.newest(asked).unwrap(), None, "the one there is older");
        std::fs::write(&new, &bytes).unwrap();
        std::fs::write(directory.path().join("notes.txt"), "x").unwrap();
        File::options()
            .append(true)
            .open(&new)
            .unwrap()
            .set_modified(asked + Duration::from_millis(5))
            .unwrap();
        assert_eq!(folder.newest(asked).unwrap(), Some(new.clone()));
        assert_eq!(read(&new).unwrap().pixels()[1], [4, 5, 6]);
        assert!(sized("x", read(&new).unwrap(), (3, 1)).unwrap_err().to_string().contains("(2, 1)"));
    }
}
