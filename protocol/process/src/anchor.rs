//! A file or directory that is in use, compared with the path at which others look for it.

use std::fs::{self, File, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// A file or directory that this process holds open, and its path. Whoever moves, removes or replaces it does not tell
/// the process, which would go on with a file that nobody else finds.
///
/// The file itself is held by others: as long as it is open, no other file gets its inode.
#[derive(Debug)]
pub struct Anchor {
    path: PathBuf,
    identity: Identity,
}

/// A file's device and inode, which no two files have that exist at one time.
type Identity = (u64, u64);

impl Anchor {
    /// Notes that `file` was opened at `path`.
    ///
    /// # Errors
    /// What the operating system said when it was asked for the file's inode.
    pub fn of(file: &File, path: &Path) -> io::Result<Self> {
        Ok(Self { path: path.to_owned(), identity: identity(&file.metadata()?) })
    }

    /// Notes the file that is at `path`, which another part of the process holds open.
    ///
    /// # Errors
    /// What the operating system said when there is none.
    pub fn at(path: &Path) -> io::Result<Self> {
        Ok(Self { path: path.to_owned(), identity: identity(&fs::metadata(path)?) })
    }

    /// Whether the path still leads to the file that is held.
    ///
    /// # Errors
    /// When another file is there, or none, or the operating system does not say. The message names the path.
    pub fn check(&self) -> io::Result<()> {
        let path = self.path.display();
        match fs::metadata(&self.path) {
            Ok(found) if identity(&found) == self.identity => Ok(()),
            Ok(_) => {
                Err(io::Error::other(format!("{path} was moved or removed, and another is in its place")))
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(io::Error::new(error.kind(), format!("{path} was moved or removed")))
            }
            Err(error) => Err(io::Error::new(error.kind(), format!("cannot look for {path}: {error}"))),
        }
    }
}

fn identity(found: &Metadata) -> Identity {
    (found.dev(), found.ino())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_moved_removed_or_replaced_is_noticed() {
        let directory = tempfile::tempdir().unwrap();
        let (path, other) = (directory.path().join("held"), directory.path().join("other"));
        fs::write(&path, "one").unwrap();
        let file = File::open(&path).unwrap();
        let held = Anchor::of(&file, &path).unwrap();
        held.check().unwrap();
        fs::rename(&path, &other).unwrap();
        assert!(held.check().unwrap_err().to_string().ends_with("held was moved or removed"));
        fs::copy(&other, &path).unwrap();
        assert!(held.check().unwrap_err().to_string().contains("another is in its place"));
        fs::rename(&other, &path).unwrap();
        held.check().unwrap();
        fs::remove_file(&path).unwrap();
        held.check().unwrap_err();
    }

    #[test]
    fn a_directory_is_held_as_a_file_is() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("held");
        fs::create_dir(&path).unwrap();
        let _open = File::open(&path).unwrap();
        let held = Anchor::at(&path).unwrap();
        held.check().unwrap();
        fs::rename(&path, directory.path().join("other")).unwrap();
        fs::create_dir(&path).unwrap();
        held.check().unwrap_err();
    }
}
