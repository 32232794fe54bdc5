//! Figures of this machine, each beside a baseline that was measured in the same run. One file a figure.

mod body;
mod decision;
mod durability;
mod inspect;
mod ipc;
mod memory;
mod restart;
mod sim;
mod vision;
mod worlds;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::de::DeserializeOwned;
use tempfile::TempDir;

use crate::cli::BenchCommand;
use crate::failure::Failure;
use worlds::Mix;

/// Measures what was asked for.
pub(crate) fn run(what: &BenchCommand, quiet: bool) -> Result<(), Failure> {
    match what {
        BenchCommand::Decision(args) => decision::run(args, quiet),
        BenchCommand::Memory(args) => memory::run(args, quiet),
        BenchCommand::Durability(args) => durability::run(args, quiet),
        BenchCommand::Restart(args) => restart::run(args, quiet),
        BenchCommand::Inspect(args) => inspect::run(args, quiet),
        BenchCommand::Ipc(args) => ipc::run(args, quiet),
        BenchCommand::IpcPeer(args) => ipc::serve(args),
        BenchCommand::Sim(args) => sim::run(args, quiet),
        BenchCommand::Vision(args) => vision::run(args, quiet),
    }
}

/// A directory on the disk that is to be measured; removed when dropped.
fn on_disk(of: Option<&Path>) -> Result<TempDir, Failure> {
    let place = of.map_or_else(|| PathBuf::from("."), Path::to_path_buf);
    let made = tempfile::Builder::new().prefix(".pschema-bench-").tempdir_in(&place);
    made.map_err(|error| {
        Failure::Failed(format!("cannot create a directory in {}: {error}", place.display()))
    })
}

/// What `bench WHAT` comes to for one mix, in a process of its own.
fn alone<T: DeserializeOwned>(
    what: &str,
    mix: Mix,
    sizes: &[usize],
    seed: u64,
    quiet: bool,
) -> Result<T, Failure> {
    let failed = |error: &dyn std::fmt::Display| {
        Failure::Failed(format!("bench {what} --mix {} in a process of its own: {error}", mix.name()))
    };
    let binary = std::env::current_exe().map_err(|error| failed(&error))?;
    let sizes: Vec<_> = sizes.iter().map(ToString::to_string).collect();
    let mut command = Command::new(binary);
    command.args(["bench", what, "--json", "--mix", mix.name(), "--schemas", &sizes.join(",")]);
    command.args(["--seed", &seed.to_string()]).args(quiet.then_some("-q"));
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let output = output.map_err(|error| failed(&error))?;
    if !output.status.success() {
        return Err(failed(&output.status));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| failed(&error))
}

/// Times in microseconds.
#[derive(Clone, Debug, Default)]
struct Times(Vec<f64>);

impl Times {
    fn push(&mut self, time: std::time::Duration) {
        self.0.push(time.as_secs_f64() * 1e6);
    }

    /// The time that the share `of` of them did not exceed.
    fn at(&self, of: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        crate::render::statistics::percentile(&sorted, of).unwrap_or(0.0)
    }
}

/// Numbers drawn by lot.
#[derive(Debug)]
struct Draw(pschema_learner::random::Random);

impl Draw {
    fn new(seed: u64) -> Self {
        Self(pschema_learner::random::Random::from_seed(seed))
    }

    /// A number below `of`; 0 when that is 0.
    fn below(&mut self, of: usize) -> usize {
        self.0.below(of.max(1))
    }
}
