//! A camera whose program writes raw pictures to its standard output, one after the other, for as long as it runs. A program
//! that ends is started again, as a serial line is opened again.

use std::io::{self, Read};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use pschema_process::relay;
use pschema_vision::image::RgbImage;

use super::source::{FrameSource, PICTURE_WAIT, SightError};

/// First and longest pause before the command is started again; each is twice the one before. A command that ran for longer
/// than the longest begins with the first.
const PAUSE_FIRST: Duration = Duration::from_millis(100);
const PAUSE_LAST: Duration = Duration::from_secs(3);
/// A command that ended so often in a row without a whole picture is not waited for.
const FAILURES_MAX: u32 = 3;

/// The newest picture, how many pictures came so far, and the command that they come from.
#[derive(Default)]
struct Camera {
    count: u64,
    bytes: Vec<u8>,
    /// None while the command does not run.
    child: Option<Child>,
    /// How the command ended last. None after a whole picture.
    ended: Option<String>,
    /// How often in a row it ended without a whole picture.
    failures: u32,
    /// Nobody wants pictures any more.
    is_dropped: bool,
}

#[derive(Default)]
struct Shared {
    camera: Mutex<Camera>,
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Camera> {
        self.camera.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

pub(super) struct Exec {
    command: String,
    size_px: (usize, usize),
    shared: Arc<Shared>,
}

impl Exec {
    /// Starts the command, which a shell splits into words.
    pub(super) fn start(command: &str, size_px: (usize, usize)) -> Result<Self, SightError> {
        let exec = Self { command: command.to_owned(), size_px, shared: Arc::default() };
        let failed = |source| SightError::Io { place: exec.place(), source };
        let stdout = run(command, &mut exec.shared.lock()).map_err(failed)?;
        let (shared, command) = (exec.shared.clone(), command.to_owned());
        let keep = move || keep_running(&command, stdout, size_px, &shared);
        std::thread::Builder::new().name("camera".into()).spawn(keep).map_err(failed)?;
        Ok(exec)
    }

    fn place(&self) -> String {
        format!("exec:{}", self.command)
    }
}

/// Starts the command.
fn run(command: &str, camera: &mut Camera) -> io::Result<ChildStdout> {
    // `exec` makes the command replace the shell, so that ending the child ends the command.
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("exec {command}")]).stdin(Stdio::null());
    let mut child = shell.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    camera.child = Some(child);
    stderr.map_or(Ok(()), relay)?;
    stdout.ok_or_else(|| io::Error::other("it has no standard output"))
}

/// Reads pictures from the command, and starts it again whenever it ends, until nobody wants pictures any more.
fn keep_running(command: &str, first: ChildStdout, size_px: (usize, usize), shared: &Shared) {
    let mut started = Ok::<_, io::Error>(first);
    let mut pause = PAUSE_FIRST;
    loop {
        let begun = Instant::now();
        let ended = match started {
            Ok(mut stdout) => {
                read_on(&mut stdout, size_px, shared);
                let child = shared.lock().child.take();
                child.map(end).unwrap_or_default()
            }
            Err(error) => error.to_string(),
        };
        if begun.elapsed() > PAUSE_LAST {
            pause = PAUSE_FIRST;
        }
        let mut camera = shared.lock();
        if camera.is_dropped {
            return;
        }
        if pause == PAUSE_FIRST {
            tracing::warn!(%command, ended, "the camera's command has ended; it is started again");
        }
        camera.ended = Some(ended);
        camera.failures += 1;
        shared.changed.notify_all();
        let wanted = |camera: &mut Camera| !camera.is_dropped;
        camera = shared
            .changed
            .wait_timeout_while(camera, pause, wanted)
            .unwrap_or_else(PoisonError::into_inner)
            .0;
        if camera.is_dropped {
            return;
        }
        started = run(command, &mut camera);
        pause = (pause * 2).min(PAUSE_LAST);
    }
}

/// Reads picture after picture and keeps the newest, so that the command is never held up. Returns when it ends.
fn read_on(stdout: &mut ChildStdout, (width, height): (usize, usize), shared: &Shared) {
    let mut bytes = vec![0; width * height * 3];
    while stdout.read_exact(&mut bytes).is_ok() {
        let mut camera = shared.lock();
        camera.count += 1;
        camera.bytes.clone_from(&bytes);
        (camera.ended, camera.failures) = (None, 0);
        shared.changed.notify_all();
    }
}

/// Ends a command that sends no pictures any more. Returns how it ended.
fn end(mut child: Child) -> String {
    // One that only closed its output is of no use either; one that has ended by itself keeps its own status.
    child.kill().ok();
    child.wait().map_or_else(|error| error.to_string(), |status| status.to_string())
}

impl FrameSource for Exec {
    fn frame(&mut self) -> Result<RgbImage, SightError> {
        let mut camera = self.shared.lock();
        // The next picture may have been taken already and be on its way; the one after that was not.
        let wanted = camera.count + 2;
        let since = Instant::now();
        while camera.count < wanted {
            let left = PICTURE_WAIT.checked_sub(since.elapsed());
            if let Some(ended) = &camera.ended
                && (left.is_none() || camera.failures >= FAILURES_MAX)
            {
                let problem = format!(
                    "the command has ended ({ended}), and is started again and again; run it by hand to see why"
                );
                return Err(SightError::NoPicture { place: self.place(), problem });
            }
            let Some(left) = left else { return Err(SightError::Stale { place: self.place() }) };
            let changed = self.shared.changed.wait_timeout(camera, left);
            camera = changed.unwrap_or_else(PoisonError::into_inner).0;
        }
        Ok(RgbImage::from_rgb_bytes(self.size_px.0, self.size_px.1, &camera.bytes)?)
    }
}

impl Drop for Exec {
    fn drop(&mut self) {
        let mut camera = self.shared.lock();
        camera.is_dropped = true;
        self.shared.changed.notify_all();
        if let Some(child) = camera.child.take() {
            tracing::debug!(ended = end(child), "the camera's command is ended");
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
        let count = exec.shared.lock().count;
        exec.frame().unwrap();
        assert!(exec.shared.lock().count >= count + 2);
    }

    #[test]
    fn a_command_that_only_ends_is_told() {
        let mut exec = Exec::start("sh -c 'exit 3'", (2, 1)).unwrap();
        let error = exec.frame().unwrap_err().to_string();
        assert!(error.contains("exec:sh -c") && error.contains("has ended (exit status: 3)"), "{error}");
    }

    #[test]
    fn a_command_that_dies_is_started_again_and_half_a_picture_is_none() {
        let directory = tempfile::tempdir().unwrap();
        let lives = directory.path().join("lives");
        // Each life has one whole picture of its number, and dies in the middle of another.
        let command = format!(
            "sh -c 'echo >> {0}; i=$(grep -c ^ {0}); printf $i$i$i$i$i$i; printf $i$i$i; kill -KILL $$'",
            lives.display()
        );
        let mut exec = Exec::start(&command, (2, 1)).unwrap();
        let mut seen = Vec::new();
        for _ in 0..2 {
            let image = exec.frame().unwrap();
            let bytes = image.as_rgb_bytes();
            assert!(bytes.iter().all(|byte| *byte == bytes[0]), "whole: {image:?}");
            seen.push(bytes[0]);
        }
        assert!(seen[1] >= seen[0] + 2, "each of another life: {seen:?}");
        // Nobody starts it any more.
        drop(exec);
        let counted = std::fs::read_to_string(&lives).unwrap().lines().count();
        assert!(counted >= usize::from(seen[1] - b'0'));
    }
}
