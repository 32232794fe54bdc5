//! What the store asks of a file system, so that tests can put one in its place that loses power.

use std::fmt::Debug;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

/// A directory of files. Names are relative, with `/` between directory and file.
pub(crate) trait Storage: Send + Sync + Debug {
    /// Names of the files in `directory`, in order; none when it isn't there.
    ///
    /// # Errors
    /// When it can't be read.
    fn list(&self, directory: &str) -> io::Result<Vec<String>>;

    /// The whole of a file.
    ///
    /// # Errors
    /// When it can't be read; [`io::ErrorKind::NotFound`] when it isn't there.
    fn read(&self, name: &str) -> io::Result<Vec<u8>>;

    /// A new, empty file in place of any of that name, to be written.
    ///
    /// # Errors
    /// When it can't be made.
    fn create(&self, name: &str) -> io::Result<Box<dyn Writing>>;

    /// Makes what a file holds durable, whoever wrote it.
    ///
    /// # Errors
    /// When the disk does not confirm it.
    fn sync(&self, name: &str) -> io::Result<()>;

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
}

/// A file that is written.
pub(crate) trait Writing: Send + Debug {
    /// Writes all of `bytes` at `offset`.
    ///
    /// # Errors
    /// When not all of it could be written.
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()>;

    /// Makes what was written durable.
    ///
    /// # Errors
    /// When the disk does not confirm it. It is not known then what is on disk, and must not be tried again.
    fn sync(&mut self) -> io::Result<()>;
}

/// A real directory.
#[derive(Clone, Debug)]
pub(crate) struct Directory {
    root: PathBuf,
}

impl Directory {
    /// The directory at `root`, which is there.
    pub(crate) fn new(root: &Path) -> Self {
        Self { root: root.to_owned() }
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
            // Names that are no text are none of ours.
            names.extend(entry?.file_name().into_string());
        }
        names.sort_unstable();
        Ok(names)
    }

    fn read(&self, name: &str) -> io::Result<Vec<u8>> {
        fs::read(self.at(name))
    }

    fn create(&self, name: &str) -> io::Result<Box<dyn Writing>> {
        let mut options = OpenOptions::new();
        let file = options.write(true).create(true).truncate(true).mode(0o600).open(self.at(name))?;
        Ok(Box::new(RealFile(file)))
    }

    fn sync(&self, name: &str) -> io::Result<()> {
        File::open(self.at(name))?.sync_all()
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        fs::rename(self.at(from), self.at(to))
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        fs::remove_file(self.at(name))
    }

    fn directory(&self, name: &str) -> io::Result<()> {
        fs::create_dir_all(self.at(name))
    }

    fn sync_directory(&self, name: &str) -> io::Result<()> {
        File::open(self.at(name))?.sync_all()
    }

    fn path(&self, name: &str) -> String {
        self.at(name).display().to_string()
    }
}

#[derive(Debug)]
struct RealFile(File);

impl Writing for RealFile {
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
        self.0.write_all_at(bytes, offset)
    }

    fn sync(&mut self) -> io::Result<()> {
        self.0.sync_data()
    }
}
