//! Files that people name for a program to write: found fit before the work whose result they are to hold, written through
//! links, and never over what is there unless a person says so.

use std::fs::{self, File, OpenOptions, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use tempfile::NamedTempFile;

use crate::stream::Stream;

/// Links that are followed to a file which is not there yet, as many as Linux follows.
const LINKS_MAX: usize = 40;

/// What becomes of a file that is there already and has something in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Occupied {
    /// It stays, and the output is refused.
    Refused,
    /// Its content is replaced, as a person asked with `--overwrite`.
    Replaced,
}

impl Occupied {
    /// The wish behind a flag `--overwrite`.
    #[must_use]
    pub fn overwritten(overwrite: bool) -> Self {
        if overwrite { Self::Replaced } else { Self::Refused }
    }

    /// Refuses a file with something in it, if that is to stay.
    ///
    /// # Errors
    /// [`OutputError::Occupied`].
    pub fn check(self, path: &Path) -> Result<(), OutputError> {
        match fs::metadata(path) {
            Ok(found) if self == Self::Refused && found.is_file() && found.len() > 0 => {
                Err(OutputError::Occupied { path: path.to_owned() })
            }
            _ => Ok(()),
        }
    }
}

/// Why a file that a person named is not written.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// There is something in it.
    #[error(
        "cannot write {}: it is there already; name another file, or replace its content with --overwrite",
        path.display()
    )]
    Occupied {
        /// The path as it was named.
        path: PathBuf,
    },
    /// There is no directory for it.
    #[error(
        "cannot write {}: there is no directory {}; make it, or name another file", path.display(), directory.display()
    )]
    NoDirectory {
        /// The path as it was named.
        path: PathBuf,
        /// The directory, behind all links.
        directory: PathBuf,
    },
    /// The system refused it.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The path as it was named.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

impl OutputError {
    /// Whether whoever read the output went away (`| head -1`): that is their wish, and no failure of who writes.
    #[must_use]
    pub fn nobody_reads(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
    }
}

fn refused(path: &Path) -> impl Fn(io::Error) -> OutputError + use<> {
    let path = path.to_owned();
    move |source| {
        let directory = behind_links(&path).ok().map(|target| parent(&target).to_owned());
        match directory.filter(|directory| source.kind() == io::ErrorKind::NotFound && !directory.exists()) {
            Some(directory) => OutputError::NoDirectory { path: path.clone(), directory },
            None => OutputError::Io { path: path.clone(), source },
        }
    }
}

/// Opens what a person named for a stream, which is read while it is written: a new file, the one that is there if it is
/// empty or may be replaced, a FIFO, a device, or an output of this process itself (`/dev/stdout`, `-`). A FIFO is waited for until
/// somebody reads it, which is logged once, or until `stop` is set.
///
/// # Errors
/// When it cannot be written, or something is in it that is to stay; an error that is [`unread`](crate::unread) when `stop` was set.
pub fn stream(path: &Path, occupied: Occupied, stop: &Arc<AtomicBool>) -> Result<Stream, OutputError> {
    let failed = refused(path);
    if let Some(own) = Stream::own(path, stop) {
        return own.map_err(failed);
    }
    occupied.check(path)?;
    let mut options = OpenOptions::new();
    options.write(true);
    match fs::metadata(path) {
        // Not with O_CREAT: Linux refuses that for a FIFO of another user in a directory that all share.
        Ok(found) if found.file_type().is_fifo() => return Stream::into_fifo(path, stop).map_err(failed),
        Ok(_) => {}
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(error)),
        Err(_) if fs::symlink_metadata(path).is_ok() => _ = options.create(true),
        Err(_) => _ = options.create_new(true),
    }
    let file = options.open(path).map_err(&failed)?;
    let found = file.metadata().map_err(&failed)?;
    if found.is_file() && found.len() > 0 {
        if occupied == Occupied::Refused {
            return Err(OutputError::Occupied { path: path.to_owned() });
        }
        file.set_len(0).map_err(&failed)?;
    }
    Stream::new(file, stop).map_err(failed)
}

/// A file that a person named, to be written as a whole: until [`OutputFile::finish`] what was there before is there still, and
/// where there was nothing there is nothing. A file that is there keeps its mode, its owner and all its names, and links to it
/// stay links. A FIFO, a device, or an output of this process gets what is written as it comes.
#[derive(Debug)]
pub struct OutputFile {
    path: PathBuf,
    occupied: Occupied,
    to: To,
}

/// The place that takes what is written.
#[derive(Debug)]
enum To {
    /// No regular file.
    Stream(Stream),
    /// A file beside the one that was named, which takes its place in the end.
    Beside { temporary: NamedTempFile, target: PathBuf, is_new: bool },
    /// A file without a name, whose content is copied in the end into one that can't be replaced: it has several names or
    /// another owner, or no file can be made beside it.
    Copied { content: File, target: File },
}

impl OutputFile {
    /// Finds out whether the file can be written, before the work that fills it begins. A FIFO is waited for as [`stream`] does.
    ///
    /// # Errors
    /// When it cannot, or something is in it that is to stay.
    pub fn prepare(path: &Path, occupied: Occupied, stop: &Arc<AtomicBool>) -> Result<Self, OutputError> {
        let failed = refused(path);
        let here = |to| Self { path: path.to_owned(), occupied, to };
        if let Some(own) = Stream::own(path, stop) {
            return Ok(here(To::Stream(own.map_err(failed)?)));
        }
        occupied.check(path)?;
        let found = match fs::metadata(path) {
            Ok(found) => Some(found),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(failed(error)),
        };
        let Some(found) = found else {
            let target = behind_links(path).map_err(&failed)?;
            let temporary = beside(&target).map_err(failed)?;
            return Ok(here(To::Beside { temporary, target, is_new: true }));
        };
        if found.file_type().is_fifo() {
            return Ok(here(To::Stream(Stream::into_fifo(path, stop).map_err(failed)?)));
        }
        let file = OpenOptions::new().write(true).open(path).map_err(&failed)?;
        if !found.is_file() {
            return Ok(here(To::Stream(Stream::new(file, stop).map_err(failed)?)));
        }
        let target = fs::canonicalize(path).map_err(&failed)?;
        if let Some(temporary) = beside(&target).ok().filter(|_| found.nlink() == 1) {
            let made = temporary.as_file().metadata().map_err(&failed)?;
            let keeps_its_owner = (made.uid(), made.gid()) == (found.uid(), found.gid());
            if keeps_its_owner && temporary.as_file().set_permissions(found.permissions()).is_ok() {
                return Ok(here(To::Beside { temporary, target, is_new: false }));
            }
        }
        Ok(here(To::Copied { content: tempfile::tempfile().map_err(failed)?, target: file }))
    }

    /// Makes a file that is new its owner's alone.
    ///
    /// # Errors
    /// When the system refuses it.
    pub fn private(self) -> Result<Self, OutputError> {
        if let To::Beside { temporary, is_new: true, .. } = &self.to {
            let closed = Permissions::from_mode(0o600);
            temporary.as_file().set_permissions(closed).map_err(refused(&self.path))?;
        }
        Ok(self)
    }

    /// Makes `bytes` the content of the file, on the disk.
    ///
    /// # Errors
    /// As [`OutputFile::finish`].
    pub fn hold(mut self, bytes: &[u8]) -> Result<(), OutputError> {
        self.write_all(bytes).map_err(refused(&self.path))?;
        self.finish()
    }

    /// Puts what was written in its place, on the disk.
    ///
    /// # Errors
    /// When the system refuses it, or another file took the place meanwhile.
    pub fn finish(mut self) -> Result<(), OutputError> {
        let failed = refused(&self.path);
        self.flush().map_err(&failed)?;
        match self.to {
            To::Stream(_) => Ok(()),
            To::Beside { temporary, target, is_new } => {
                temporary.as_file().sync_all().map_err(&failed)?;
                let placed = match (is_new, self.occupied) {
                    (true, Occupied::Refused) => temporary.persist_noclobber(&target),
                    _ => temporary.persist(&target),
                };
                match placed {
                    Ok(_) => Ok(()),
                    Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {
                        Err(OutputError::Occupied { path: self.path })
                    }
                    Err(error) => Err(failed(error.error)),
                }
            }
            To::Copied { mut content, mut target } => {
                io::Seek::rewind(&mut content).map_err(&failed)?;
                target.set_len(0).map_err(&failed)?;
                io::copy(&mut content, &mut target).and_then(|_| target.sync_all()).map_err(failed)
            }
        }
    }

    /// The error that says of this file why it could not be written.
    pub fn refused(&self) -> impl Fn(io::Error) -> OutputError + use<> {
        refused(&self.path)
    }

    fn file(&mut self) -> &mut dyn Write {
        match &mut self.to {
            To::Stream(stream) => stream,
            To::Copied { content, .. } => content,
            To::Beside { temporary, .. } => temporary.as_file_mut(),
        }
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file().flush()
    }
}

/// The path to which dangling links lead.
fn behind_links(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_owned();
    for _ in 0..LINKS_MAX {
        match fs::read_link(&target) {
            Ok(next) => target = parent(&target).join(next),
            Err(_) => return Ok(target),
        }
    }
    Err(io::Error::other("too many links lead on"))
}

fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file beside `target`, with the mode of any new file.
fn beside(target: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pschema-").permissions(Permissions::from_mode(0o666)).tempfile_in(parent(target))
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::os::unix::fs::symlink;

    use super::*;

    fn goes_on() -> Arc<AtomicBool> {
        Arc::default()
    }

    fn write(path: &Path, occupied: Occupied, text: &str) -> Result<(), OutputError> {
        OutputFile::prepare(path, occupied, &goes_on())?.hold(text.as_bytes())
    }

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().mode() & 0o7777
    }

    fn names_in(directory: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(directory)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_there_whole_or_not_at_all_and_what_was_there_stays() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        let mut given_up = OutputFile::prepare(&path, Occupied::Refused, &goes_on()).unwrap();
        given_up.write_all(b"half").unwrap();
        drop(given_up);
        assert_eq!(names_in(directory.path()), [""; 0], "nothing is left");
        write(&path, Occupied::Refused, "one").unwrap();
        let refusal = write(&path, Occupied::Refused, "two").unwrap_err().to_string();
        assert!(refusal.contains("it is there already") && refusal.contains("--overwrite"), "{refusal}");
        assert!(stream(&path, Occupied::Refused, &goes_on()).is_err());
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
        let mut given_up = OutputFile::prepare(&path, Occupied::Replaced, &goes_on()).unwrap();
        given_up.write_all(b"half").unwrap();
        drop(given_up);
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
        write(&path, Occupied::Replaced, "two").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "two");
        assert_eq!(names_in(directory.path()), ["a.txt"]);
    }

    #[test]
    fn a_file_that_came_meanwhile_is_not_replaced() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a.txt");
        let file = OutputFile::prepare(&path, Occupied::Refused, &goes_on()).unwrap();
        fs::write(&path, "another's").unwrap();
        assert!(matches!(file.finish(), Err(OutputError::Occupied { .. })));
        assert_eq!(fs::read_to_string(&path).unwrap(), "another's");
    }

    #[test]
    fn links_modes_and_names_are_kept() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::write(at("real"), "old").unwrap();
        fs::set_permissions(at("real"), Permissions::from_mode(0o640)).unwrap();
        symlink("real", at("link")).unwrap();
        write(&at("link"), Occupied::Replaced, "new").unwrap();
        assert!(at("link").symlink_metadata().unwrap().is_symlink());
        assert_eq!((fs::read_to_string(at("real")).unwrap().as_str(), mode(&at("real"))), ("new", 0o640));
        // A file of two names has them still.
        fs::hard_link(at("real"), at("other")).unwrap();
        write(&at("real"), Occupied::Replaced, "n").unwrap();
        assert_eq!(fs::read_to_string(at("other")).unwrap(), "n");
        // A link to nothing leads to the new file.
        symlink("made", at("dangling")).unwrap();
        write(&at("dangling"), Occupied::Refused, "through").unwrap();
        assert!(at("dangling").symlink_metadata().unwrap().is_symlink());
        assert_eq!(fs::read_to_string(at("made")).unwrap(), "through");
        symlink("streamed", at("dangling too")).unwrap();
        stream(&at("dangling too"), Occupied::Refused, &goes_on()).unwrap().write_all(b"s").unwrap();
        assert_eq!(fs::read_to_string(at("streamed")).unwrap(), "s");
        let private =
            OutputFile::prepare(&at("private"), Occupied::Refused, &goes_on()).unwrap().private().unwrap();
        private.finish().unwrap();
        assert_eq!(mode(&at("private")), 0o600);
    }

    #[test]
    fn a_file_that_cannot_be_written_is_found_out_first() {
        let directory = tempfile::tempdir().unwrap();
        let none = directory.path().join("none");
        let dangling = directory.path().join("dangling");
        symlink("none/a.txt", &dangling).unwrap();
        let missing = format!("there is no directory {}; make it", none.display());
        let cases = [(directory.path().to_owned(), ""), (none.join("a.txt"), &missing), (dangling, &missing)];
        for (path, problem) in cases {
            for occupied in [Occupied::Refused, Occupied::Replaced] {
                for error in [
                    OutputFile::prepare(&path, occupied, &goes_on()).err(),
                    stream(&path, occupied, &goes_on()).err(),
                ] {
                    let error = error.unwrap().to_string();
                    let named = format!("cannot write {}", path.display());
                    assert!(error.starts_with(&named) && error.contains(problem), "{error}");
                }
            }
        }
    }

    #[test]
    fn a_fifo_and_a_device_take_what_comes() {
        let directory = tempfile::tempdir().unwrap();
        let fifo = directory.path().join("fifo");
        assert!(std::process::Command::new("mkfifo").arg(&fifo).status().unwrap().success());
        for live in [true, false] {
            let from = fifo.clone();
            let reader = std::thread::spawn(move || {
                let mut text = String::new();
                File::open(from).unwrap().read_to_string(&mut text).unwrap();
                text
            });
            if live {
                stream(&fifo, Occupied::Refused, &goes_on()).unwrap().write_all(b"news").unwrap();
            } else {
                write(&fifo, Occupied::Refused, "news").unwrap();
            }
            assert_eq!(reader.join().unwrap(), "news");
        }
        write(Path::new("/dev/null"), Occupied::Refused, "gone").unwrap();
        stream(Path::new("/dev/stderr"), Occupied::Refused, &goes_on()).unwrap();
        OutputFile::prepare(Path::new("/dev/stdout"), Occupied::Refused, &goes_on()).unwrap();
        // By every command that takes the name of an output.
        OutputFile::prepare(Path::new("-"), Occupied::Refused, &goes_on()).unwrap();
        stream(Path::new("-"), Occupied::Refused, &goes_on()).unwrap();
        assert!(!Path::new("-").exists());
    }
}
