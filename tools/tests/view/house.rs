//! A learner of the test's own, with a page to look into it.

use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

/// What any wait may take; a machine under load takes its time.
pub(crate) const PATIENCE: Duration = Duration::from_secs(90);

/// A place for a learner; dropped, what is left of it is cleared away.
pub(crate) struct House(TempDir);

/// A process; dropped, it is killed.
pub(crate) struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

impl Process {
    /// Processor time that it has used, in seconds.
    pub(crate) fn cpu_s(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.0.id())).unwrap();
        let fields: Vec<f64> = stat
            .rsplit_once(')')
            .unwrap()
            .1
            .split_whitespace()
            .filter_map(|field| field.parse().ok())
            .collect();
        // The first field, a letter, is no number; utime and stime are in ticks of a hundredth of a second.
        (fields[10] + fields[11]) / 100.0
    }

    /// Ends it as it wants to be ended.
    pub(crate) fn end(mut self) {
        let pid = rustix::process::Pid::from_raw(i32::try_from(self.0.id()).unwrap()).unwrap();
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).unwrap();
        assert_eq!(self.0.wait().unwrap().code(), Some(0), "it ends cleanly");
    }
}

impl Drop for House {
    fn drop(&mut self) {
        drop(self.command(&["doctor", "--clean"]).output());
    }
}

impl House {
    pub(crate) fn new() -> Self {
        let private = std::fs::Permissions::from_mode(0o700);
        let mut builder = tempfile::Builder::new();
        Self(builder.prefix("psv-").permissions(private).tempdir_in("/tmp").unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn runtime(&self) -> PathBuf {
        self.path("run")
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", self.runtime()).env_remove("RUST_LOG");
        command.env("NO_COLOR", "1").stdin(Stdio::null()).current_dir(self.0.path());
        command
    }

    pub(crate) fn start(&self, arguments: &[&str]) -> Process {
        let mut command = self.command(arguments);
        Process(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
    }

    pub(crate) fn json(&self, arguments: &[&str]) -> Option<Value> {
        let output = self.command(&[arguments, &["--json"]].concat()).output().unwrap();
        serde_json::from_slice(&output.stdout).ok()
    }

    /// Why it can't be done, and with which exit code.
    pub(crate) fn refusal(&self, arguments: &[&str]) -> (Option<i32>, String) {
        let output = self.command(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    }

    /// A page, and its address.
    pub(crate) fn view(&self, more: &[&str]) -> (Process, Address) {
        let mut command = self.command(&[&["view", "--no-open"], more].concat());
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        (Process(child), Address::read(line.trim_end()))
    }

    /// Asks for the status until it is as wanted.
    pub(crate) fn until(&self, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let status = self.json(&["status"]);
            match status {
                Some(status) if wanted(&status) => return status,
                status => assert!(start.elapsed() < PATIENCE, "{status:?}"),
            }
            std::thread::yield_now();
        }
    }

    /// A life of some steps on disk, ended.
    pub(crate) fn life(&self, steps: u64) -> PathBuf {
        let data = self.path("life");
        let daemon = self.serve(&data);
        let body = self.start(&["sim", "--seed", "7"]);
        self.until(|status| status["step"].as_u64().unwrap() >= steps);
        body.end();
        daemon.end();
        data
    }

    /// A life whose curriculum is over: its last step, which is given too, decided nothing.
    pub(crate) fn finished(&self) -> (PathBuf, u64) {
        let data = self.path("finished");
        let arguments =
            ["server", "--seed", "7", "--curriculum", "exp1-s1", "--data", data.to_str().unwrap()];
        let daemon = self.start(&arguments);
        let body = self.start(&["sim", "--seed", "7"]);
        let ended = self.until(|status| status["stage_state"] == "finished");
        body.end();
        daemon.end();
        (data, ended["step"].as_u64().unwrap())
    }

    pub(crate) fn serve(&self, data: &Path) -> Process {
        self.start(&["server", "--seed", "7", "--data", data.to_str().unwrap()])
    }
}

/// Where a page is.
#[derive(Clone, Debug)]
pub(crate) struct Address {
    pub(crate) url: String,
    pub(crate) port: u16,
    pub(crate) token: String,
}

impl Address {
    fn read(url: &str) -> Self {
        let rest = url.strip_prefix("http://127.0.0.1:").expect(url);
        let (port, rest) = rest.split_once('/').expect(url);
        let token = rest.strip_suffix('/').expect(url);
        assert!(token.len() == 32 && token.chars().all(|c| c.is_ascii_hexdigit()), "{url}");
        Self { url: url.to_owned(), port: port.parse().unwrap(), token: token.to_owned() }
    }
}
