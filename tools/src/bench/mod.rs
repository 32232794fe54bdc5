//! Figures of this machine, each beside a baseline that was measured in the same run. One file a figure.

mod body;
mod decision;
mod durability;
mod restart;
mod worlds;

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::cli::BenchCommand;
use crate::failure::Failure;

/// Measures what was asked for.
pub(crate) fn run(what: &BenchCommand, quiet: bool) -> Result<(), Failure> {
    match what {
        BenchCommand::Decision(args) => decision::run(args, quiet),
        BenchCommand::Durability(args) => durability::run(args, quiet),
        BenchCommand::Restart(args) => restart::run(args, quiet),
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
