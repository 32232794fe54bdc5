//! A camera whose program writes pictures into a directory.
//!
//! What makes a picture new is that it was not there when it was asked for: this is looked at here, whatever the clock of its
//! writer says. The date of a file is looked at besides, for a file can be copied or renamed into the directory long after its
//! picture was taken.

use std::collections::HashSet;
use std::fs::{File, Metadata};
use std::io::{self, BufReader};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use pschema_vision::image::RgbImage;

use super::picture;
use super::source::{FrameSource, PICTURE_WAIT, SightError, sized};

/// How often the directory is looked at.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Files looked at in one directory.
const FILES_MAX: usize = 100_000;
/// A file that is dated later than this from now was dated by another clock than that of this machine.
const AHEAD_MAX: Duration = Duration::from_secs(1);

pub(super) struct Folder {
    path: PathBuf,
    size_px: (usize, usize),
}

/// A picture file.
struct PictureFile {
    path: PathBuf,
    written: SystemTime,
    version: FileVersion,
}

/// What changes when a file is written, or another takes its place: device, inode, size, and two times, of which no program
/// can choose the second.
#[derive(PartialEq, Eq, Hash)]
struct FileVersion(u64, u64, u64, (i64, i64), (i64, i64));

impl FileVersion {
    fn of(data: &Metadata) -> Self {
        let (written, changed) = ((data.mtime(), data.mtime_nsec()), (data.ctime(), data.ctime_nsec()));
        Self(data.dev(), data.ino(), data.size(), written, changed)
    }
}

/// The directory when a picture was asked for.
struct Asked {
    at: SystemTime,
    /// Those files that were there and are dated later: a clock is wrong, and none of them is new.
    later: HashSet<FileVersion>,
}

impl Folder {
    pub(super) fn new(path: PathBuf, size_px: (usize, usize)) -> Self {
        Self { path, size_px }
    }

    fn place(&self) -> String {
        format!("folder:{}", self.path.display())
    }

    fn pictures(&self) -> io::Result<Vec<PictureFile>> {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(&self.path)?.take(FILES_MAX) {
            let path = entry?.path();
            let is_picture = path.extension().is_some_and(|ending| ending == "png" || ending == "ppm");
            // A file that vanishes meanwhile was not the newest.
            if let Some(data) = path.metadata().ok().filter(|_| is_picture)
                && let Ok(written) = data.modified()
            {
                files.push(PictureFile { path, written, version: FileVersion::of(&data) });
            }
        }
        Ok(files)
    }

    /// Looks at the directory, for a picture asked for at a time of this machine's clock.
    fn ask(&self, at: SystemTime) -> io::Result<Asked> {
        let later = self.pictures()?.into_iter().filter(|file| file.written > at);
        Ok(Asked { at, later: later.map(|file| file.version).collect() })
    }

    /// The newest picture since it was asked for. Without one: the reason why the newest that is there is none, if there is
    /// anything to say.
    fn newest(&self, asked: &Asked, now: SystemTime) -> io::Result<Result<PathBuf, Option<String>>> {
        let mut files = self.pictures()?;
        files.sort_by_key(|file| file.written);
        let is_new = |file: &PictureFile| {
            file.written > asked.at && file.written <= now + AHEAD_MAX && !asked.later.contains(&file.version)
        };
        if let Some(newest) = files.iter().rposition(is_new) {
            return Ok(Ok(files.swap_remove(newest).path));
        }
        Ok(Err(files.pop().map(|newest| not_new(&newest, asked, now))))
    }
}

/// The reason why the newest picture of a directory is not new.
fn not_new(newest: &PictureFile, asked: &Asked, now: SystemTime) -> String {
    let name = newest.path.file_name().unwrap_or_default().display();
    if let Ok(ahead) = newest.written.duration_since(now)
        && ahead > AHEAD_MAX
    {
        return format!(
            "{name} is dated {} s ahead of this machine's clock: such a picture may be old, and none counts; set the clock of \
             the machine that writes it, or of this one, and remove it",
            ahead.as_secs()
        );
    }
    if newest.written > asked.at {
        return format!("{name} was there before it was asked for, and has not changed; check the camera");
    }
    let before = asked.at.duration_since(newest.written).unwrap_or_default();
    format!(
        "no new picture within {} s: the newest, {name}, is dated {:.1} s before it was asked for; check the camera, and the \
         clock of the machine that writes the pictures",
        PICTURE_WAIT.as_secs(),
        before.as_secs_f64()
    )
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
        let failed = |source| SightError::Io { place: self.place(), source };
        let since = Instant::now();
        let asked = self.ask(SystemTime::now()).map_err(failed)?;
        let mut problem = None;
        while since.elapsed() < PICTURE_WAIT {
            match self.newest(&asked, SystemTime::now()).map_err(failed)?.map(|path| read(&path)) {
                Ok(Ok(image)) => return sized(&self.place(), image, self.size_px),
                // It may not be written whole yet.
                Ok(Err(why)) => problem = Some(why),
                Err(why) => problem = why,
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

    const HOUR: Duration = Duration::from_secs(3600);

    fn dated(path: &Path, written: SystemTime) {
        File::options().append(true).open(path).unwrap().set_modified(written).unwrap();
    }

    /// A directory with two names for pictures, and the bytes of one.
    fn camera() -> (tempfile::TempDir, Folder, PathBuf, PathBuf, Vec<u8>) {
        let directory = tempfile::tempdir().unwrap();
        let mut bytes = b"P6\n2 1\n255\n".to_vec();
        bytes.extend([1, 2, 3, 4, 5, 6]);
        let (old, new) = (directory.path().join("1.ppm"), directory.path().join("2.ppm"));
        let folder = Folder::new(directory.path().to_owned(), (2, 1));
        (directory, folder, old, new, bytes)
    }

    #[test]
    fn only_a_picture_written_since_it_was_asked_for_counts() {
        let (directory, folder, old, new, bytes) = camera();
        std::fs::write(&old, &bytes).unwrap();
        let at = old.metadata().unwrap().modified().unwrap() + Duration::from_millis(1);
        let (asked, now) = (folder.ask(at).unwrap(), at + Duration::from_millis(10));
        let stale = folder.newest(&asked, now).unwrap().unwrap_err().unwrap();
        assert!(stale.contains("1.ppm, is dated 0.0 s before"), "the one there is older: {stale}");
        std::fs::write(&new, &bytes).unwrap();
        std::fs::write(directory.path().join("notes.txt"), "x").unwrap();
        dated(&new, at + Duration::from_millis(5));
        assert_eq!(folder.newest(&asked, now).unwrap(), Ok(new.clone()));
        assert_eq!(read(&new).unwrap().pixels()[1], [4, 5, 6]);
        assert!(sized("x", read(&new).unwrap(), (3, 1)).unwrap_err().to_string().contains("(2, 1)"));
    }

    /// A clock was set back, or that of the camera's machine is ahead: for an hour the same picture was new each time.
    #[test]
    fn a_picture_dated_ahead_is_refused_and_named_and_hides_no_new_one() {
        let (_directory, folder, old, new, bytes) = camera();
        let now = SystemTime::now();
        std::fs::write(&old, &bytes).unwrap();
        dated(&old, now + HOUR);
        let asked = folder.ask(now).unwrap();
        let refused = |now| folder.newest(&asked, now).unwrap().unwrap_err().unwrap();
        let ahead = refused(now);
        assert!(ahead.contains("1.ppm is dated 3600 s ahead"), "{ahead}");
        let frozen = refused(now + 2 * HOUR);
        assert!(frozen.contains("1.ppm was there before"), "nor is it new when its time has come: {frozen}");
        // Written anew by a clock that is ahead: it may have been taken at any time.
        std::fs::write(&old, &bytes).unwrap();
        dated(&old, now + HOUR + Duration::from_secs(7));
        assert!(refused(now).contains("1.ppm is dated 3607 s ahead"));
        std::fs::write(&new, &bytes).unwrap();
        dated(&new, now + Duration::from_millis(1));
        assert_eq!(folder.newest(&asked, now).unwrap(), Ok(new));
    }

    #[test]
    fn a_picture_dated_a_little_ahead_counts_once() {
        let (_directory, folder, old, _, bytes) = camera();
        let now = SystemTime::now();
        let asked = folder.ask(now).unwrap();
        std::fs::write(&old, &bytes).unwrap();
        dated(&old, now + AHEAD_MAX / 2);
        assert_eq!(folder.newest(&asked, now).unwrap(), Ok(old.clone()));
        let asked = folder.ask(now).unwrap();
        let repeated = folder.newest(&asked, now).unwrap().unwrap_err().unwrap();
        assert!(repeated.contains("1.ppm was there before"), "{repeated}");
        std::fs::write(&old, &bytes).unwrap();
        dated(&old, now + AHEAD_MAX / 3);
        assert_eq!(folder.newest(&asked, now).unwrap(), Ok(old));
    }
}
