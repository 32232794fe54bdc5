//! A runtime directory for one test, and the `pschema` command in it.

use std::cell::RefCell;
use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use tempfile::TempDir;

use crate::leftovers::Leftovers;
use crate::process::{ChildProcess, ProcessOutput};
use crate::until;

/// A runtime directory that only one test uses.
#[derive(Debug)]
pub struct Sandbox {
    binary: &'static str,
    runtime: TempDir,
    leftovers: RefCell<Leftovers>,
}

impl Sandbox {
    /// A sandbox in which `pschema` is the program `binary`.
    ///
    /// # Panics
    /// When no directory can be made.
    #[must_use]
    pub fn new(binary: &'static str) -> Self {
        let private = Permissions::from_mode(0o700);
        // In /tmp whatever TMPDIR is: sockets need short paths.
        let runtime = tempfile::Builder::new().prefix("pst-").permissions(private).tempdir_in("/tmp");
        let runtime = runtime.unwrap_or_else(|error| panic!("a directory in /tmp: {error}"));
        let leftovers = RefCell::new(Leftovers::of(runtime.path()));
        Self { binary, runtime, leftovers }
    }

    /// The runtime directory.
    #[must_use]
    pub fn runtime(&self) -> &Path {
        self.runtime.path()
    }

    /// Starts `pschema` with `arguments`.
    #[must_use]
    pub fn start(&self, arguments: &[&str]) -> ChildProcess {
        let mut command = Command::new(self.binary);
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", self.runtime.path()).env_remove("RUST_LOG");
        ChildProcess::start(&mut command)
    }

    /// Starts another program with `arguments` in this sandbox.
    #[must_use]
    pub fn start_program(&self, program: &str, arguments: &[&str]) -> ChildProcess {
        let mut command = Command::new(program);
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", self.runtime.path()).env_remove("RUST_LOG");
        ChildProcess::start(&mut command)
    }

    /// Runs `pschema` with `arguments` to its end.
    #[must_use]
    pub fn run(&self, arguments: &[&str]) -> ProcessOutput {
        self.start(arguments).finished()
    }

    /// Starts the daemon of `name` and waits until it answers.
    #[must_use]
    pub fn daemon(&self, name: &str, arguments: &[&str]) -> ChildProcess {
        let daemon = self.start(&[&["server", "--name", name], arguments].concat());
        // A daemon that serves under this name already would answer as well.
        until(&format!("daemon {name} answers"), || {
            let answer = self.run(&["status", "--name", name, "--json"]);
            (answer.code() == Some(0) && answer.json()["pid"] == daemon.pid()).then_some(())
        });
        self.leftovers.borrow_mut().note();
        daemon
    }

    /// Starts a simulated body of `name`.
    #[must_use]
    pub fn body(&self, name: &str, arguments: &[&str]) -> ChildProcess {
        self.start(&[&["sim", "--name", name], arguments].concat())
    }

    /// The status of the learner `name`, as `pschema status --json` prints it.
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

    /// The names of all files that the daemons of this sandbox left in its directory and in shared memory. The daemons must have
    /// ended.
    #[must_use]
    pub fn left(&self) -> Vec<String> {
        self.leftovers.borrow().left()
    }
}

impl Drop for Sandbox {
    /// Removes the files that a failed test left: its processes are killed by then, and files in shared memory would
    /// stay for good.
    fn drop(&mut self) {
        self.leftovers.borrow_mut().note();
        for name in self.leftovers.borrow().left() {
            // Directories are not in shared memory and go with the sandbox.
            drop(std::fs::remove_file(Path::new("/dev/shm").join(name)));
        }
    }
}
