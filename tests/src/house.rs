//! A place of its own for a test: a runtime directory, and the command in it.

use std::cell::RefCell;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

use crate::process::{Finished, Running};
use crate::traces::Traces;
use crate::until;

/// A runtime directory that only one test uses.
#[derive(Debug)]
pub struct House {
    binary: &'static str,
    runtime: TempDir,
    traces: RefCell<Traces>,
}

impl House {
    /// With the command built as `binary`.
    ///
    /// # Panics
    /// When no directory can be made.
    #[must_use]
    pub fn new(binary: &'static str) -> Self {
        let private = Permissions::from_mode(0o700);
        // In /tmp whatever TMPDIR is: sockets need short paths.
        let runtime = tempfile::Builder::new().prefix("pst-").permissions(private).tempdir_in("/tmp");
        let runtime = runtime.unwrap_or_else(|error| panic!("a directory in /tmp: {error}"));
        let traces = RefCell::new(Traces::of(runtime.path()));
        Self { binary, runtime, traces }
    }

    /// Its runtime directory.
    #[must_use]
    pub fn runtime(&self) -> &Path {
        self.runtime.path()
    }

    /// Starts `pschema` with `arguments`.
    #[must_use]
    pub fn start(&self, arguments: &[&str]) -> Running {
        let mut command = Command::new(self.binary);
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", self.runtime.path()).env_remove("RUST_LOG");
        Running::start(&mut command)
    }

    /// Starts another program with `arguments` in this house.
    #[must_use]
    pub fn start_program(&self, program: &str, arguments: &[&str]) -> Running {
        let mut command = Command::new(program);
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", self.runtime.path()).env_remove("RUST_LOG");
        Running::start(&mut command)
    }

    /// Runs `pschema` with `arguments` to its end.
    #[must_use]
    pub fn run(&self, arguments: &[&str]) -> Finished {
        self.start(arguments).finished()
    }

    /// Starts the daemon of `name` and waits until it answers.
    #[must_use]
    pub fn daemon(&self, name: &str, arguments: &[&str]) -> Running {
        let daemon = self.start(&[&["server", "--name", name], arguments].concat());
        // A daemon that serves under this name already would answer as well.
        until(&format!("daemon {name} answers"), || {
            let answer = self.run(&["status", "--name", name, "--json"]);
            (answer.code() == Some(0) && answer.json()["pid"] == daemon.pid()).then_some(())
        });
        self.traces.borrow_mut().note();
        daemon
    }

    /// Starts a simulated body of `name`.
    #[must_use]
    pub fn body(&self, name: &str, arguments: &[&str]) -> Running {
        self.start(&[&["sim", "--name", name], arguments].concat())
    }

    /// What `pschema status --json` says of `name`.
    #[must_use]
    pub fn status(&self, name: &str) -> Value {
        self.run(&["status", "--name", name, "--json"]).json()
    }

    /// Waits until the learner `name` has taken more than `step` steps; returns how many it has.
    #[must_use]
    pub fn past(&self, name: &str, step: u64) -> u64 {
        until(&format!("learner {name} is past step {step}"), || {
            self.status(name)["step"].as_u64().filter(|now| *now > step)
        })
    }

    /// Waits until the curriculum of `name` is over.
    pub fn curriculum_over(&self, name: &str) {
        until(&format!("the curriculum of {name} is over"), || {
            (self.status(name)["stage_state"] == "finished").then_some(())
        });
    }

    /// Everything that daemons here left, in this directory and in shared memory. Their processes must have ended.
    #[must_use]
    pub fn left(&self) -> Vec<String> {
        self.traces.borrow().left()
    }
}

impl Drop for House {
    /// A test that fails leaves nothing either: its processes are killed by then, and what is in shared memory would
    /// stay for good.
    fn drop(&mut self) {
        self.traces.borrow_mut().note();
        for name in self.traces.borrow().left() {
            // Directories are not in shared memory and go with the house.
            drop(std::fs::remove_file(Path::new("/dev/shm").join(name)));
        }
    }
}
