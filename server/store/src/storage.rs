//! The seam to the file system: all that the store asks of it, so that tests can put one in its place that loses power.

use std::fmt::{Debug, Display};
use std::fs::{self, DirBuilder, File, OpenOptions, Permissions};
use std::io::{self, Read};
use std::os::unix::fs::{DirBuilderExt, FileExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pschema_process::Anchor;

/// The longest file that is read as a whole, in bytes: twice as long as a segment of the journal can get.
pub(crate) const READ_BYTES_MAX: u64 = 256 * 1024 * 1024;

/// A directory of files. Names are relative, with `/` between directory and file.
pub(crate) trait Storage: Send + Sync + Debug {
    /// Names of the files in `directory`, in order; none when it isn't there.
    ///
    /// # Errors
    /// When it can't be read.
    fn list(&self, directory: &str) -> io::Result<Vec<String>>;

    /// Whether there is a directory of that name.
    fn is_there(&self, directory: &str) -> bool;

    /// A file, to be read from its beginning.
    ///
    /// # Errors
    /// When it can't be read; [`io::ErrorKind::NotFound`] when it isn't there.
    fn open(&self, name: &str) -> io::Result<Box<dyn Read>>;

    /// The whole of a file.
    ///
    /// # Errors
    /// As [`Storage::open`], and when it is longer than [`READ_BYTES_MAX`].
    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.open(name)?.take(READ_BYTES_MAX + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > READ_BYTES_MAX {
            let problem = format!("it is longer than {READ_BYTES_MAX} bytes, so it is none of ours");
            return Err(io::Error::new(io::ErrorKind::InvalidData, problem));
        }
        Ok(bytes)
    }

    /// The length of a file in bytes.
    ///
    /// # Errors
    /// When it isn't there.
    fn size(&self, name: &str) -> io::Result<u64>;

    /// Whether a file of at least `bytes` bytes, which nobody changes any more, is still there.
    ///
    /// # Errors
    /// When it was moved or removed; [`io::ErrorKind::UnexpectedEof`] when it was cut short. The message names the file.
    fn is_whole(&self, name: &str, bytes: u64) -> io::Result<()> {
        let path = self.path(name);
        match self.size(name) {
            Ok(found) => uncut(path, found, bytes),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(io::Error::new(error.kind(), format!("{path} was moved or removed")))
            }
            Err(error) => Err(io::Error::new(error.kind(), format!("cannot look for {path}: {error}"))),
        }
    }

    /// Cuts a file off after so many bytes.
    ///
    /// # Errors
    /// When it can't be done.
    fn truncate(&self, name: &str, to: u64) -> io::Result<()>;

    /// A new, empty file in place of any of that name, to be written.
    ///
    /// # Errors
    /// When it can't be made.
    fn create(&self, name: &str) -> io::Result<Box<dyn OpenFile>>;

    /// Makes the content of a file durable, whoever wrote it.
    ///
    /// # Errors
    /// When the disk does not confirm it.
    fn sync(&self, name: &str) -> io::Result<()>;

    /// Makes the first `to` bytes of a file durable, of which an earlier daemon may have been told that they are not: writes
    /// the same bytes once more and syncs the file. After a failed sync the system may take pages for clean that the disk does
    /// not have, and a sync alone would confirm them.
    ///
    /// # Errors
    /// When the disk does not confirm it.
    fn confirm(&self, name: &str, to: u64) -> io::Result<()>;

    /// Gives a file another name, in place of any file of that name.
    ///
    /// # Errors
    /// When it can't be done.
    fn rename(&self, from: &str, to: &str) -> io::Result<()>;

    /// Removes a file.
    ///
    /// # Errors
    /// When it can't be done.
    fn remove(&self, name: &str) -> io::Result<()>;

    /// Makes the directory `name` if it isn't there.
    ///
    /// # Errors
    /// When it can't be made.
    fn directory(&self, name: &str) -> io::Result<()>;

    /// Makes durable which files are in the directory.
    ///
    /// # Errors
    /// When the disk does not confirm it.
    fn sync_directory(&self, name: &str) -> io::Result<()>;

    /// How a file is called in messages.
    fn path(&self, name: &str) -> String;

    /// Whether this is still the storage that others find, and nobody else can use it.
    ///
    /// # Errors
    /// When its directory or its lock was moved, removed or replaced.
    fn check(&self) -> io::Result<()> {
        Ok(())
    }
}

/// Makes sure that a file has the bytes that were written, `written` of them.
fn uncut(path: impl Display, found: u64, written: u64) -> io::Result<()> {
    if found >= written {
        return Ok(());
    }
    let problem =
        format!("{path} was cut short by another program: {written} bytes were written, {found} are left");
    Err(io::Error::new(io::ErrorKind::UnexpectedEof, problem))
}

/// A file that is open for writing.
pub(crate) trait OpenFile: Send + Debug {
    /// Writes all of `bytes` at `offset`.
    ///
    /// # Errors
    /// When not all of it could be written.
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()>;

    /// Makes the bytes that were written durable.
    ///
    /// # Errors
    /// When the disk does not confirm it. Nobody knows then what is on disk, so it must not be tried again.
    fn sync(&mut self) -> io::Result<()>;

    /// Whether this is still the file that others find by its name, and has all that was written.
    ///
    /// # Errors
    /// When it was moved, removed or replaced; [`io::ErrorKind::UnexpectedEof`] when it was cut short.
    fn check(&self) -> io::Result<()> {
        Ok(())
    }
}

/// So many bytes are written once more at a time.
const CONFIRMED_AT_ONCE: usize = 1024 * 1024;

/// Makes a directory that nobody else can look into, whatever the umask is at that moment.
pub(crate) fn own_directory(path: &Path) -> io::Result<()> {
    DirBuilder::new().mode(0o700).create(path)?;
    fs::set_permissions(path, Permissions::from_mode(0o700))
}

/// A real directory.
#[derive(Clone, Debug)]
pub(crate) struct Directory {
    root: PathBuf,
    /// The directory and its lock, if it is this process's alone.
    held: Option<Arc<Held>>,
}

/// What a process has of its own directory.
#[derive(Debug)]
struct Held {
    /// Open, so that its inode is not used again.
    _root: File,
    root: Anchor,
    /// Open, because the lock is the open file's.
    _lock: File,
    lock: Anchor,
}

impl Directory {
    /// The directory at `root`, which is there.
    pub(crate) fn new(root: &Path) -> Self {
        Self { root: root.to_owned(), held: None }
    }

    /// The directory at `root`, whose lock this process has.
    pub(crate) fn locked(root: &Path, (_lock, lock): (File, Anchor)) -> io::Result<Self> {
        let open = File::open(root)?;
        let held = Held { root: Anchor::of(&open, root)?, _root: open, _lock, lock };
        Ok(Self { root: root.to_owned(), held: Some(Arc::new(held)) })
    }

    fn at(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }
}

impl Storage for Directory {
    fn list(&self, directory: &str) -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        let entries = match fs::read_dir(self.at(directory)) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(names),
            Err(error) => return Err(error),
        };
        for entry in entries {
            // A name that is not text is not the name of one of our files.
            names.extend(entry?.file_name().into_string());
        }
        names.sort_unstable();
        Ok(names)
    }

    fn is_there(&self, directory: &str) -> bool {
        self.at(directory).is_dir()
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Read>> {
        Ok(Box::new(File::open(self.at(name))?))
    }

    fn size(&self, name: &str) -> io::Result<u64> {
        Ok(fs::metadata(self.at(name))?.len())
    }

    fn truncate(&self, name: &str, to: u64) -> io::Result<()> {
        OpenOptions::new().write(true).open(self.at(name))?.set_len(to)
    }

    fn create(&self, name: &str) -> io::Result<Box<dyn OpenFile>> {
        let mut options = OpenOptions::new();
        let path = self.at(name);
        let file = options.write(true).create(true).truncate(true).mode(0o600).open(&path)?;
        let anchor = Anchor::of(&file, &path)?;
        Ok(Box::new(RealFile { file, anchor, path, written: 0 }))
    }

    fn sync(&self, name: &str) -> io::Result<()> {
        File::open(self.at(name))?.sync_all()
    }

    fn confirm(&self, name: &str, to: u64) -> io::Result<()> {
        let file = OpenOptions::new().read(true).write(true).open(self.at(name))?;
        let mut bytes = vec![0; CONFIRMED_AT_ONCE];
        let mut at = 0;
        while at < to {
            let left = usize::try_from(to - at).unwrap_or(CONFIRMED_AT_ONCE).min(CONFIRMED_AT_ONCE);
            let part = bytes.get_mut(..left).unwrap_or_default();
            file.read_exact_at(part, at)?;
            file.write_all_at(part, at)?;
            at += left as u64;
        }
        file.sync_all()
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.at(from), self.at(to))
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        fs::remove_file(self.at(name))
    }

    fn directory(&self, name: &str) -> io::Result<()> {
        match own_directory(&self.at(name)) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
            made => made,
        }
    }

    fn sync_directory(&self, name: &str) -> io::Result<()> {
        File::open(self.at(name))?.sync_all()
    }

    fn path(&self, name: &str) -> String {
        self.at(name).display().to_string()
    }

    fn check(&self) -> io::Result<()> {
        let Some(held) = &self.held else { return Ok(()) };
        held.root.check().and_then(|()| held.lock.check())
    }
}

#[derive(Debug)]
struct RealFile {
    file: File,
    anchor: Anchor,
    path: PathBuf,
    /// Where the last of the written bytes ends.
    written: u64,
}

impl RealFile {
    fn uncut(&self) -> io::Result<()> {
        uncut(self.path.display(), self.file.metadata()?.len(), self.written)
    }
}

impl OpenFile for RealFile {
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
        // A file that was cut short grows again with what is written next, and then has a hole that nobody sees.
        self.uncut()?;
        self.file.write_all_at(bytes, offset)?;
        self.written = self.written.max(offset + bytes.len() as u64);
        Ok(())
    }

    fn sync(&mut self) -> io::Result<()> {
        self.file.sync_data()?;
        // A file without its name is gone with the process.
        self.check()
    }

    fn check(&self) -> io::Result<()> {
        self.anchor.check().and_then(|()| self.uncut())
    }
}
