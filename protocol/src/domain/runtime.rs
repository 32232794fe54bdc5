//! The runtime directory. It is private to one user, because whoever can write there can pretend to be a daemon.

use std::fmt;
use std::fs::{self, DirBuilder, File, OpenOptions, Permissions};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use super::DomainError;
use super::error::io;
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
    /// symbolic link, is where others could put another in its place, or its path is longer than sockets allow.
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
        trusted_way(&path)?;
        private_directory(&path)?;
        Ok(Self(path))
    }

    /// Its absolute path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }
}

/// Makes sure that nobody else can put another directory in the place of `path`: whoever owns a directory above it,
/// or may write there where no sticky bit keeps files to their owners, could.
fn trusted_way(path: &Path) -> Result<(), DomainError> {
    let Some(parent) = path.parent() else { return Ok(()) };
    // As it is named and as it is: a link on the way can be replaced as well as a directory.
    let real = parent.canonicalize().ok();
    let above = parent.ancestors().chain(real.iter().flat_map(|real| real.ancestors()));
    let user = rustix::process::geteuid().as_raw();
    for directory in above {
        // One that is not there is told of when the directory is made.
        let Ok(found) = fs::symlink_metadata(directory) else { continue };
        let problem = |problem: String| DomainError::Runtime { path: path.to_owned(), problem };
        if !is_trusted(found.uid(), user) {
            return Err(problem(format!(
                "{} above it belongs to user {}, who could put another in its place: set PSCHEMA_RUNTIME_DIR to a \
                 directory below ones of your own or root's",
                directory.display(),
                found.uid()
            )));
        }
        let (writable, sticky) = (found.mode() & 0o022 != 0, found.mode() & 0o1000 != 0);
        if writable && !sticky && !found.is_symlink() {
            return Err(problem(format!(
                "{} above it can be written by others (mode {:o}), who could put another in its place: run `chmod \
                 go-w {}`, or `chmod +t` if others need it",
                directory.display(),
                found.mode() & 0o7777,
                directory.display()
            )));
        }
    }
    Ok(())
}

/// Whether a directory's owner may do as they like anyway. In a user namespace (a container without root) the owner
/// of what is outside, root's directories among them, is told as the overflow user.
fn is_trusted(owner: u32, user: u32) -> bool {
    let overflow = || fs::read_to_string("/proc/sys/kernel/overflowuid").ok()?.trim().parse::<u32>().ok();
    owner == user || owner == 0 || (!maps_every_user() && overflow() == Some(owner))
}

/// Whether every user of the machine is known here: false in a user namespace.
fn maps_every_user() -> bool {
    let map = fs::read_to_string("/proc/self/uid_map").unwrap_or_default();
    map.split_whitespace().eq(["0", "0", "4294967295"])
}

/// Makes sure that a directory is there, is the user's own and is closed to others.
pub(crate) fn private_directory(path: &Path) -> Result<(), DomainError> {
    let problem = |problem: String| DomainError::Runtime { path: path.to_owned(), problem };
    match DirBuilder::new().mode(0o700).create(path) {
        // Once more: iceoryx2 changes the umask of the process while it makes a socket, and of two threads that do so
        // one may leave it changed.
        Ok(()) => {
            fs::set_permissions(path, Permissions::from_mode(0o700)).map_err(io("close to others", path))?
        }
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

/// Opens a file for reading and writing, made (closed to others) when it is not there. It is not looked for behind a
/// symbolic link, whose target would be overwritten.
pub(crate) fn private_file(path: &Path) -> Result<File, DomainError> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false).mode(0o600);
    options.custom_flags(rustix::fs::OFlags::NOFOLLOW.bits().cast_signed());
    let file = options.open(path).map_err(io("open", path))?;
    if file.metadata().map_err(io("examine", path))?.mode() & 0o777 != 0o600 {
        file.set_permissions(Permissions::from_mode(0o600)).map_err(io("close to others", path))?;
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

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
        fs::set_permissions(&open, Permissions::from_mode(0o750)).unwrap();
        let error = RuntimeDir::at(&open).unwrap_err().to_string();
        assert!(error.contains("mode 750"), "{error}");

        let own = parent.path().join("own");
        assert_eq!(RuntimeDir::at(&own).unwrap().path(), own);
        assert_eq!(fs::metadata(&own).unwrap().mode() & 0o777, 0o700);
        let link = parent.path().join("link");
        symlink(&own, &link).unwrap();
        let error = RuntimeDir::at(&link).unwrap_err().to_string();
        assert!(error.contains("symbolic link"), "{error}");

        let shared = parent.path().join("shared");
        fs::create_dir(&shared).unwrap();
        for mode in [0o777, 0o770, 0o702] {
            fs::set_permissions(&shared, Permissions::from_mode(mode)).unwrap();
            let error = RuntimeDir::at(&shared.join("run")).unwrap_err().to_string();
            assert!(error.contains("chmod go-w") && error.contains(&format!("{mode:o}")), "{error}");
            assert!(!shared.join("run").exists(), "refused before it is made");
        }
        fs::set_permissions(&shared, Permissions::from_mode(0o1777)).unwrap();
        RuntimeDir::at(&shared.join("run")).unwrap();

        let error = RuntimeDir::at(&parent.path().join("none/below")).unwrap_err().to_string();
        assert!(error.contains("does not exist"), "{error}");
        let error = RuntimeDir::at(&parent.path().join("x".repeat(60))).unwrap_err().to_string();
        assert!(error.contains("shorter"), "{error}");
    }
}
