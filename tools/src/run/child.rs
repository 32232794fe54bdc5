//! A process of this same binary, started by it, which never outlives it.

use std::collections::VecDeque;
use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Child as Process, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use pschema_protocol::domain::Place;
use rustix::process::{Pid, Signal, getppid, kill_process, set_parent_process_death_signal};

use crate::failure::Failure;

/// Lines of a child's stderr kept for when it fails.
const TAIL_LINES: usize = 20;
/// Bytes of each such line.
const TAIL_LINE_BYTES: u64 = 2000;
/// How long a child may take to end cleanly before it is killed.
const END_WITHIN: Duration = Duration::from_secs(5);
/// How often to look whether it has.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// A running child. Dropping it ends it.
#[derive(Debug)]
pub struct Child {
    /// What it is, for people: `daemon`, `body`.
    what: &'static str,
    process: Process,
    tail: Arc<Mutex<VecDeque<String>>>,
    reader: Option<JoinHandle<()>>,
}

impl Child {
    /// Starts this binary with `arguments` and `runtime` as its runtime directory. Call it from the main
    /// thread: the kernel ends the child when the thread that started it ends.
    ///
    /// # Errors
    /// When it can't be started.
    pub fn start<S: AsRef<OsStr>>(
        what: &'static str,
        runtime: &Path,
        arguments: impl IntoIterator<Item = S>,
    ) -> Result<Self, Failure> {
        let failed = |error: std::io::Error| Failure::Failed(format!("cannot start the {what}: {error}"));
        let binary = std::env::current_exe().map_err(failed)?;
        let mut command = Command::new(binary);
        command.args(arguments).arg("--parent").arg(std::process::id().to_string());
        command.env("PSCHEMA_RUNTIME_DIR", runtime).env("NO_COLOR", "1");
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        // A group of its own: Ctrl-C reaches this process alone, which then ends its children in order.
        command.process_group(0);
        let mut process = command.spawn().map_err(failed)?;
        let tail = Arc::new(Mutex::new(VecDeque::new()));
        let stderr = process.stderr.take();
        let reader = stderr.map(|stderr| {
            let tail = Arc::clone(&tail);
            thread::spawn(move || keep_tail(stderr, what, &tail))
        });
        Ok(Self { what, process, tail, reader })
    }

    /// A failure, with the last that it said, when the child has ended; all is well while it runs.
    ///
    /// # Errors
    /// That the child has ended.
    pub fn check(&mut self) -> Result<(), Failure> {
        match self.process.try_wait() {
            Ok(None) => Ok(()),
            Ok(Some(status)) => Err(self.ended(status)),
            Err(error) => Err(Failure::Failed(format!("cannot watch the {}: {error}", self.what))),
        }
    }

    fn ended(&mut self, status: ExitStatus) -> Failure {
        // Its stderr is closed now; what it said last is only complete once read to the end.
        if let Some(reader) = self.reader.take() {
            drop(reader.join());
        }
        let tail = self.tail.lock().unwrap_or_else(PoisonError::into_inner);
        let said: String = tail.iter().map(|line| format!("\n  {line}")).collect();
        let said = if said.is_empty() { "\n  (nothing)".to_owned() } else { said };
        Failure::Failed(format!("the {} ended too early ({status}). The last it said:{said}", self.what))
    }

    /// Ends the child: SIGTERM, and SIGKILL if that does not do within [`END_WITHIN`].
    pub(crate) fn end(&mut self) {
        if matches!(self.process.try_wait(), Ok(Some(_))) {
            return;
        }
        if let Some(pid) = Pid::from_raw(i32::try_from(self.process.id()).unwrap_or(0)) {
            // Not yet waited for, so the number is still its own.
            if let Err(error) = kill_process(pid, Signal::TERM) {
                tracing::warn!(%error, "cannot ask the {} to end", self.what);
            }
        }
        if let Ok(Some(_)) = retry(END_WITHIN, || Ok(self.process.try_wait().ok().flatten())) {
            return;
        }
        tracing::warn!("the {} did not end within {END_WITHIN:?} and was killed", self.what);
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.end();
    }
}

fn keep_tail(stderr: impl Read, what: &'static str, tail: &Mutex<VecDeque<String>>) {
    let mut stderr = BufReader::new(stderr);
    loop {
        let mut line = Vec::new();
        match stderr.by_ref().take(TAIL_LINE_BYTES).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let line = crate::render::words::plain(String::from_utf8_lossy(&line).trim_end());
        tracing::info!("{what}: {line}");
        let mut tail = tail.lock().unwrap_or_else(PoisonError::into_inner);
        if tail.len() == TAIL_LINES {
            tail.pop_front();
        }
        tail.push_back(line);
    }
}

/// Tries again and again until it succeeds, fails, or the time is up: then it is none.
pub(super) fn retry<T>(
    within: Duration,
    mut attempt: impl FnMut() -> Result<Option<T>, Failure>,
) -> Result<Option<T>, Failure> {
    let start = Instant::now();
    loop {
        let made = attempt()?;
        if made.is_some() || start.elapsed() > within {
            return Ok(made);
        }
        thread::sleep(LOOK_EVERY);
    }
}

/// In a child: ends it with SIGHUP when the process `parent` dies, however it dies. Not with SIGTERM: the kernel may
/// send the signal more than once, for each thread of the parent that dies, and a second SIGTERM means "at once".
///
/// # Errors
/// When the system refuses, or `parent` is no longer the parent of this process.
pub fn follow_parent(parent: Option<u32>) -> Result<(), Failure> {
    let Some(parent) = parent else { return Ok(()) };
    set_parent_process_death_signal(Some(Signal::HUP))
        .map_err(|error| Failure::Failed(format!("cannot follow process {parent}: {error}")))?;
    // It may have died before the line above.
    if is_orphan(Some(parent)) {
        return Err(Failure::Failed(format!(
            "process {parent}, to be followed, is not the parent of this one"
        )));
    }
    Ok(())
}

/// Whether this process was to follow `parent`, which is no longer its parent.
pub(crate) fn is_orphan(parent: Option<u32>) -> bool {
    let now = getppid().and_then(|pid| u32::try_from(pid.as_raw_nonzero().get()).ok());
    parent.is_some() && now != parent
}

/// The name of the learner in a pair's private runtime directory, for the process that started it.
pub(super) fn private_name(owner: u32) -> String {
    format!("demo-{owner}")
}

/// Removes the private runtime directory of a pair whose owner died without a chance to, once the daemon in it has
/// ended cleanly. Any other directory is left alone.
pub(crate) fn remove_orphaned(place: &Place, owner: Option<u32>) {
    if owner.map(private_name).as_deref() != Some(place.learner().as_str()) {
        return;
    }
    if let Err(error) = fs::remove_dir_all(place.runtime().path()) {
        tracing::warn!(%error, path = %place.runtime().path().display(), "cannot remove the runtime directory");
    }
}
