//! Directories that people name for a program, and why one of them can't be had.

use std::fs;
use std::io;
use std::path::Path;

/// The error of a directory that was to be made or read, with what is in its place and what to do about that, where the system
/// says only that there is something.
#[must_use]
pub fn no_directory(path: &Path, error: io::Error) -> io::Error {
    match obstacle(path) {
        Some(problem) => io::Error::new(error.kind(), problem),
        None => error,
    }
}

/// The nearest thing on the way to `path`, if it is not a directory.
fn obstacle(path: &Path) -> Option<String> {
    let there = path.ancestors().find(|at| at.symlink_metadata().is_ok()).filter(|at| !at.is_dir())?;
    let shown = there.display();
    Some(match fs::read_link(there) {
        Ok(target) if !there.exists() => {
            format!(
                "{shown} is a link to {}, which is not there; make that directory, or name another",
                target.display()
            )
        }
        _ => format!(
            "{shown} is a file and no directory; name a directory, or a path where there is nothing yet"
        ),
    })
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    /// A file in the place of a directory was told as `File exists (os error 17)`.
    #[test]
    fn what_is_in_the_place_of_a_directory_is_told() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        fs::write(at("file"), "").unwrap();
        symlink("none", at("link")).unwrap();
        symlink("file", at("to the file")).unwrap();
        let file = |name: &str| format!("{} is a file and no directory;", at(name).display());
        let link = format!("{} is a link to none, which is not there;", at("link").display());
        for (path, problem) in [
            ("file", file("file")),
            ("file/below/it", file("file")),
            ("to the file", file("to the file")),
            ("link", link.clone()),
            ("link/below", link),
        ] {
            let error = fs::create_dir_all(at(path)).unwrap_err();
            let kind = error.kind();
            let told = no_directory(&at(path), error);
            assert!(told.kind() == kind && told.to_string().starts_with(&problem), "{told}");
        }
        let other = no_directory(&at("none"), io::ErrorKind::PermissionDenied.into());
        assert_eq!(other.to_string(), "permission denied");
    }
}
