//! A camera whose program writes raw pictures to its standard output, one after the other, for as long as it runs.

use std::io::{self, Read};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Instant;

use pschema_vision::image::RgbImage;

use super::source::{FrameSource, PICTURE_WAIT, SightError};

/// The newest picture, and how many pictures came so far.
#[derive(Default)]
struct LatestPicture {
    count: u64,
    bytes: Vec<u8>,
    ended: bool,
}

type Shared = Arc<(Mutex<LatestPicture>, Condvar)>;

pub(super) struct Exec {
    command: String,
    size_px: (usize, usize),
    child: Child,
    newest: Shared,
}

impl Exec {
    /// Starts the command, which a shell splits into words.
    pub(super) fn start(command: &str, size_px: (usize, usize)) -> Result<Self, SightError> {
        let failed = |source| SightError::Io { place: format!("exec:{command}"), source };
        // `exec` makes the command replace the shell, so that ending the child ends the command.
        let mut child = Command::new("sh")
            .args(["-c", &format!("exec {command}")])
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let newest = Shared::default();
        let started = match child.stdout.take() {
            Some(stdout) => read_on(stdout, size_px, newest.clone()),
            None => Err(io::Error::other("it has no standard output")),
        };
        let exec = Self { command: command.to_owned(), size_px, child, newest };
        started.map_err(failed)?;
        Ok(exec)
    }

    fn place(&self) -> String {
        format!("exec:{}", self.command)
    }
}

/// Reads picture after picture and keeps the newest, so that the command is never held up.
fn read_on(mut stdout: ChildStdout, (width, height): (usize, usize), newest: Shared) -> io::Result<()> {
    std::thread::Builder::new().name("camera".into()).spawn(move || {
        let mut bytes = vec![0; width * height * 3];
        let (lock, changed) = &*newest;
        loop {
            let whole = stdout.read_exact(&mut bytes).is_ok();
            let mut newest = lock.lock().unwrap_or_else(PoisonError::into_inner);
            if whole {
                newest.count += 1;
                newest.bytes.clone_from(&bytes);
            } else {
                newest.ended = true;
            }
            changed.notify_all();
            if newest.ended {
                return;
            }
        }
    })?;
    Ok(())
}

impl FrameSource for Exec {
    fn frame(&mut self) -> Result<RgbImage, SightError> {
        let (lock, changed) = &*self.newest;
        let mut newest = lock.lock().unwrap_or_else(PoisonError::into_inner);
        // The next picture may have been taken already and be on its way; the one after that was not.
        let wanted = newest.count + 2;
        let since = Instant::now();
        while newest.count < wanted {
            let Some(left) = PICTURE_WAIT.checked_sub(since.elapsed()) else {
                return Err(SightError::Stale { place: self.place() });
            };
            if newest.ended {
                let problem = "the command has ended; run it by hand to see why".to_owned();
                return Err(SightError::NoPicture { place: self.place(), problem });
            }
            newest = changed.wait_timeout(newest, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        Ok(RgbImage::from_rgb_bytes(self.size_px.0, self.size_px.1, &newest.bytes)?)
    }
}

impl Drop for Exec {
    fn drop(&mut self) {
        if let Err(error) = self.child.kill().and_then(|()| self.child.wait().map(|_| ())) {
            tracing::debug!(%error, "the camera's command could not be ended");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_one_taken_after_it_was_asked_for() {
        // Six bytes a picture, all the same, counting up.
        let command = "sh -c 'i=0; while :; do i=$(( (i + 1) % 10 )); printf $i$i$i$i$i$i; sleep 0.01; done'";
        let mut exec = Exec::start(command, (2, 1)).unwrap();
        let image = exec.frame().unwrap();
        let first = image.pixels()[0][0];
        assert!(image.as_rgb_bytes().iter().all(|byte| *byte == first), "whole: {image:?}");
        let count = exec.newest.0.lock().unwrap().count;
        exec.frame().unwrap();
        assert!(exec.newest.0.lock().unwrap().count >= count + 2);
    }

    #[test]
    fn a_command_that_ends_is_told() {
        let mut exec = Exec::start("true", (2, 1)).unwrap();
        let error = exec.frame().unwrap_err().to_string();
        assert!(error.contains("exec:true") && error.contains("has ended"), "{error}");
    }
}
