//! The runtime directory: private to one user, for whoever writes there can impersonate a daemon.

use std::fmt;
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt};
use std::path::{Path, PathBuf};

use super::{DomainError, io};
use crate::limits::LEARNER_NAME_BYTES_MAX;

/// The name of a learner: 1 to 32 of `a-z`, `0-9`, `_` and `-`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LearnerName(String);

impl LearnerName {
    /// The name, once checked.
    ///
    /// # Errors
    /// [`DomainError::LearnerName`] when it is not one.
    pub fn new(name: &str) -> Result<Self, DomainError> {
        let allowed = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_' | b'-');
        if name.is_empty() || name.len() > LEARNER_NAME_BYTES_MAX || !name.bytes().all(allowed) {
            return Err(DomainError::LearnerName { name: name.to_owned() });
        }
        Ok(Self(name.to_owned()))
    }

    /// The name as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for LearnerName {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(&self.0)
    }
}

impl std::str::FromStr for LearnerName {
    type Err = DomainError;

    fn from_str(name: &str) -> Result<Self, DomainError> {
        Self::new(name)
    }
}

/// A directory checked to be the user's own and closed to others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RuntimeDir(PathBuf);

/// Longest path of a runtime directory, in bytes. iceoryx2 puts Unix sockets below it, whose paths end at
/// 107 bytes: `/` + `.ps0123456789-` + `/` + the prefix + 39 digits + `.event`.
pub(super) const RUNTIME_PATH_BYTES_MAX: usize = 107 - 1 - 14 - 1 - 13 - 39 - 6;

impl RuntimeDir {
    /// The directory that the environment says: `PSCHEMA_RUNTIME_DIR`, else `XDG_RUNTIME_DIR/pschema`, else
    /// `/tmp/pschema-<uid>`. It is created when it is not there.
    ///
    /// # Errors
    /// As [`RuntimeDir::at`].
    pub fn from_environment() -> Result<Self, DomainError> {
        let variable =
            |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        if let Some(path) = variable("PSCHEMA_RUNTIME_DIR") {
            return Self::at(&path);
        }
        if let Some(path) = variable("XDG_RUNTIME_DIR").filter(|path| path.is_absolute() && path.is_dir()) {
            return Self::at(&path.join("pschema"));
        }
        let user = rustix::process::geteuid().as_raw();
        Self::at(Path::new(&format!("/tmp/pschema-{user}")))
    }

    /// The directory at `path`, created (closed to others) when it is not there.
    ///
    /// # Errors
    /// [`DomainError::Runtime`] when it is not a directory, belongs to another user, is open to others, is a
    /// symbolic link, or its path is longer than sockets allow.
    pub fn at(path: &Path) -> Result<Self, DomainError> {
        let path = std::path::absolute(path).map_err(io("find", path))?;
        let problem = |problem: String| DomainError::Runtime { path: path.clone(), problem };
        let length = path.as_os_str().as_bytes().len();
        if length > RUNTIME_PATH_BYTES_MAX {
            return Err(problem(format!(
                "its path has {length} bytes, sockets allow {RUNTIME_PATH_BYTES_MAX}: set PSCHEMA_RUNTIME_DIR to a shorter one"
            )));
        }
        if path.to_str().is_none() {
            return Err(problem("its path is not UTF-8: set PSCHEMA_RUNTIME_DIR to another".to_owned()));
        }
        private_directory(&path)?;
        Ok(Self(path))
    }

    /// Its absolute path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// Makes sure that a directory is there, is the user's own and is closed to others.
pub(super) fn private_directory(path: &Path) -> Result<(), DomainError> {
    let problem = |problem: String| DomainError::Runtime { path: path.to_owned(), problem };
    match DirBuilder::new().mode(0o700).create(path) {
        Ok(()) => {}
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(problem(
                "the directory it should be in does not exist: create that first".to_owned(),
            ));
        }
        Err(error) => return Err(io("create", path)(error)),
    }
    let found = fs::symlink_metadata(path).map_err(io("examine", path))?;
    let user = rustix::process::geteuid().as_raw();
    if found.is_symlink() {
        return Err(problem("it is a symbolic link: remove it, or name the directory itself".to_owned()));
    }
    if !found.is_dir() {
        return Err(problem("it is not a directory: remove it".to_owned()));
    }
    if found.uid() != user {
        return Err(problem(format!(
            "it belongs to user {}, not to {user}: set PSCHEMA_RUNTIME_DIR to one of your own",
            found.uid()
        )));
    }
    let mode = found.mode() & 0o777;
    if mode & 0o077 != 0 {
        return Err(problem(format!("it is open to others (mode {mode:o}): run `chmod 700` on it")));
    }
    Ok(())
}

/// Opens a file for reading and writing, made (closed to others) when it is not there.
pub(super) fn private_file(path: &Path) -> Result<File, DomainError> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false).mode(0o600);
    options.open(path).map_err(io("open", path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{PermissionsExt, symlink};

    #[test]
    fn names_are_small_and_plain() {
        for good in ["a", "demo", "robot-1_b", &"x".repeat(32)] {
            assert_eq!(LearnerName::new(good).unwrap().as_str(), good);
        }
        for bad in ["", "Demo", "a b", "../etc", ".", "é", &"x".repeat(33)] {
            assert!(LearnerName::new(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_directory_open_to_others_or_a_link_is_refused() {
        let parent = tempfile::Builder::new().tempdir_in("/tmp").unwrap();
        let open = parent.path().join("open");
        fs::create_dir(&open).unwrap();
        fs::set_permissions(&open, fs::Permissions::from_mode(0o750)).unwrap();
        let error = RuntimeDir::at(&open).unwrap_err().to_string();
        assert!(error.contains("mode 750"), "{error}");

        let own = parent.path().join("own");
        assert_eq!(RuntimeDir::at(&own).unwrap().path(), own);
        assert_eq!(fs::metadata(&own).unwrap().mode() & 0o777, 0o700);
        let link = parent.path().join("link");
        symlink(&own, &link).unwrap();
        let error = RuntimeDir::at(&link).unwrap_err().to_string();
        assert!(error.contains("symbolic link"), "{error}");

        let error = RuntimeDir::at(&parent.path().join("none/below")).unwrap_err().to_string();
        assert!(error.contains("does not exist"), "{error}");
        let error = RuntimeDir::at(&parent.path().join("x".repeat(60))).unwrap_err().to_string();
        assert!(error.contains("shorter"), "{error}");
    }
}
