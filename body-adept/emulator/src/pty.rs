//! The line: a pseudo-terminal whose other end a driver opens like a serial port. It can be unplugged and plugged in
//! again.

use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// A pseudo-terminal, with a name that stays the same when it is plugged in anew.
pub(crate) struct Pty {
    link: PathBuf,
    ends: Option<Ends>,
}

struct Ends {
    ours: OwnedFd,
    /// The driver's end is kept open here as well: without it, reading fails while no driver is there.
    _theirs: OwnedFd,
}

impl Pty {
    /// A line, plugged in, which drivers find under `link`.
    pub(crate) fn new(link: &Path) -> io::Result<Self> {
        let mut pty = Self { link: link.to_owned(), ends: None };
        pty.plug()?;
        Ok(pty)
    }

    /// Plugs the line in.
    pub(crate) fn plug(&mut self) -> io::Result<()> {
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&ours)?;
        unlockpt(&ours)?;
        let name = ptsname(&ours, Vec::new())?;
        let theirs = rustix::fs::open(
            name.as_c_str(),
            OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC,
            Mode::empty(),
        )?;
        // Like a serial port: no byte is echoed, changed, or kept until the end of a line.
        let mut settings = tcgetattr(&theirs)?;
        settings.make_raw();
        tcsetattr(&theirs, OptionalActions::Now, &settings)?;
        rustix::io::ioctl_fionbio(&ours, true)?;
        let target = name.to_str().map_err(io::Error::other)?;
        remove_link(&self.link)?;
        std::os::unix::fs::symlink(target, &self.link)?;
        self.ends = Some(Ends { ours, _theirs: theirs });
        Ok(())
    }

    /// Pulls the plug: the driver's end hangs up.
    pub(crate) fn unplug(&mut self) {
        // Without a line there is no link of ours.
        if self.ends.take().is_some()
            && let Err(error) = remove_link(&self.link)
        {
            tracing::warn!(%error, link = %self.link.display(), "cannot remove the link");
        }
    }

    /// The file descriptor to wait for. None while the line is unplugged.
    pub(crate) fn fd(&self) -> Option<BorrowedFd<'_>> {
        self.ends.as_ref().map(|ends| ends.ours.as_fd())
    }

    /// Reads the bytes that have come. Returns how many; 0 when none has.
    pub(crate) fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let Some(ends) = &self.ends else { return Ok(0) };
        match rustix::io::read(&ends.ours, into) {
            Err(rustix::io::Errno::AGAIN | rustix::io::Errno::INTR | rustix::io::Errno::IO) => Ok(0),
            read => Ok(read?),
        }
    }

    /// Writes bytes. Those that nobody takes are lost, as on a real line.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let Some(ends) = &self.ends else { return Ok(()) };
        let mut left = bytes;
        while !left.is_empty() {
            match rustix::io::write(&ends.ours, left) {
                Ok(written) => left = left.get(written..).unwrap_or_default(),
                Err(rustix::io::Errno::INTR) => {}
                Err(rustix::io::Errno::AGAIN | rustix::io::Errno::IO) => return Ok(()),
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        self.unplug();
    }
}

/// Removes a symbolic link that an emulator may have left: one to a pseudo-terminal, or to nothing. All else stays.
fn remove_link(link: &Path) -> io::Result<()> {
    let there = |what: String| Err(io::Error::new(io::ErrorKind::AlreadyExists, what));
    match std::fs::read_link(link) {
        Ok(target) if target.starts_with("/dev/pts") || !link.exists() => std::fs::remove_file(link),
        Ok(target) => there(format!("it is a link to {}: name another", target.display())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => {
            there("it exists and is no symbolic link: name another".to_owned())
        }
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_link_that_an_emulator_left_is_replaced() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        for (name, target) in [("left", "/dev/pts/99999"), ("dangling", "nothing")] {
            std::os::unix::fs::symlink(target, at(name)).unwrap();
            drop(Pty::new(&at(name)).unwrap());
            assert!(at(name).symlink_metadata().is_err(), "it is removed in the end");
        }
        std::fs::write(at("file"), "mine").unwrap();
        std::os::unix::fs::symlink("file", at("port")).unwrap();
        for (name, told) in [("port", "it is a link to file"), ("file", "no symbolic link")] {
            let error = Pty::new(&at(name)).err().unwrap().to_string();
            assert!(error.contains(told), "{error}");
            assert!(at(name).exists());
        }
        assert!(at("port").symlink_metadata().unwrap().is_symlink());
    }
}
