//! Processes that a test starts.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use rustix::process::{Pid, Signal, kill_process};

use crate::until;

/// The output and the exit status of a process that has ended.
#[derive(Debug)]
pub struct ProcessOutput {
    /// The exit status.
    pub status: ExitStatus,
    /// The text on its stdout.
    pub stdout: String,
    /// The text on its stderr.
    pub stderr: String,
}

impl ProcessOutput {
    /// The exit code; `None` when a signal ended it.
    #[must_use]
    pub fn code(&self) -> Option<i32> {
        self.status.code()
    }

    /// The text on its stdout as JSON.
    ///
    /// # Panics
    /// When the process failed, or printed something else.
    #[must_use]
    pub fn json(&self) -> serde_json::Value {
        assert_eq!(self.code(), Some(0), "{self:?}");
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }
}

/// A process that a test has started. Dropping this kills the process.
#[derive(Debug)]
pub struct ChildProcess {
    process: Child,
    stdout: OutputReader,
    stderr: OutputReader,
}

/// Reads the output of a process as it comes, so that the process never has to wait for a reader.
#[derive(Debug)]
struct OutputReader {
    text: Arc<Mutex<String>>,
    reader: Option<JoinHandle<()>>,
}

impl OutputReader {
    fn listen(stream: Option<impl Read + Send + 'static>) -> Self {
        let text = Arc::new(Mutex::new(String::new()));
        let reader = stream.map(|stream| {
            let text = Arc::clone(&text);
            thread::spawn(move || {
                let mut stream = BufReader::new(stream);
                let mut line = Vec::new();
                while stream.read_until(b'\n', &mut line).is_ok_and(|n| n > 0) {
                    let mut text = text.lock().unwrap_or_else(PoisonError::into_inner);
                    text.push_str(&String::from_utf8_lossy(&line));
                    line.clear();
                }
            })
        });
        Self { text, reader }
    }

    fn so_far(&self) -> String {
        self.text.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn finish(&mut self) -> String {
        if let Some(reader) = self.reader.take() {
            reader.join().unwrap_or_else(|_| panic!("the reader of a process's output failed"));
        }
        self.so_far()
    }
}

impl ChildProcess {
    /// Starts a process.
    ///
    /// # Panics
    /// When it cannot be started.
    #[must_use]
    pub fn start(command: &mut Command) -> Self {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().unwrap_or_else(|error| panic!("{command:?}: {error}"));
        let (stdout, stderr) =
            (OutputReader::listen(process.stdout.take()), OutputReader::listen(process.stderr.take()));
        Self { process, stdout, stderr }
    }

    /// The process id.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// The text on its stderr so far.
    #[must_use]
    pub fn stderr(&self) -> String {
        self.stderr.so_far()
    }

    /// The text on its stdout so far.
    #[must_use]
    pub fn stdout(&self) -> String {
        self.stdout.so_far()
    }

    /// Waits until the process has written `text`, to stdout or stderr.
    ///
    /// # Panics
    /// When the text does not come before the deadline.
    pub fn says(&self, text: &str) {
        until(&format!("process {} says {text:?}", self.pid()), || {
            (self.stdout().contains(text) || self.stderr().contains(text)).then_some(())
        });
    }

    /// Sends the process a signal.
    ///
    /// # Panics
    /// When the process has ended already.
    pub fn signal(&self, signal: Signal) {
        signal_process(self.pid(), signal);
    }

    /// Halts the process, and waits until it is halted: when the signal has been sent it may run on for a moment.
    ///
    /// # Panics
    /// When the process is not halted before the deadline.
    pub fn halt(&self) {
        self.signal(Signal::STOP);
        let path = format!("/proc/{}/stat", self.pid());
        until(&format!("process {} is halted", self.pid()), || {
            let stat = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
            // Behind the name, which may hold anything, stands the state.
            stat.rsplit_once(')').is_some_and(|(_, rest)| rest.starts_with(" T ")).then_some(())
        });
    }

    /// Waits for the end of the process.
    ///
    /// # Panics
    /// When the process does not end before the deadline.
    #[must_use]
    pub fn finished(mut self) -> ProcessOutput {
        let pid = self.pid();
        let status = until(&format!("process {pid} ends; it said {:?}", self.stderr()), || {
            self.process.try_wait().unwrap_or_else(|error| panic!("process {pid}: {error}"))
        });
        ProcessOutput { status, stdout: self.stdout.finish(), stderr: self.stderr.finish() }
    }

    /// Asks the process to end with SIGTERM, and waits for its end.
    ///
    /// # Panics
    /// As [`ChildProcess::finished`].
    #[must_use]
    pub fn ended(self) -> ProcessOutput {
        self.signal(Signal::TERM);
        self.finished()
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        // Both fail only for a process that has ended.
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

/// Sends a signal to a process that this one did not start itself.
///
/// # Panics
/// When there is no such process.
pub fn signal_process(pid: u32, signal: Signal) {
    let target =
        i32::try_from(pid).ok().and_then(Pid::from_raw).unwrap_or_else(|| panic!("{pid} is no process"));
    kill_process(target, signal).unwrap_or_else(|error| panic!("signal to process {pid}: {error}"));
}
