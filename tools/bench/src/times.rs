//! Times that were measured, and the disk that some of them are about.

use std::path::{Path, PathBuf};
use std::time::Duration;

use pschema_tools::kit::{Failure, percentile};
use tempfile::TempDir;

/// Times in microseconds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times(Vec<f64>);

impl Times {
    pub(crate) fn push(&mut self, time: Duration) {
        self.0.push(time.as_secs_f64() * 1e6);
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// The time that the share `of` of them did not exceed.
    pub(crate) fn at(&self, of: f64) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        percentile(&sorted, of).unwrap_or(0.0)
    }

    pub(crate) fn p50(&self) -> f64 {
        self.at(0.5)
    }

    pub(crate) fn p99(&self) -> f64 {
        self.at(0.99)
    }
}

/// A directory on the disk that is measured: in `parent`, or here. It is removed when dropped.
pub(crate) fn directory_on_disk(parent: Option<&Path>) -> Result<TempDir, Failure> {
    let parent = parent.map_or_else(|| PathBuf::from("."), Path::to_path_buf);
    let made = tempfile::Builder::new().prefix(".pschema-bench-").tempdir_in(&parent);
    made.map_err(|error| {
        Failure::Failed(format!("cannot create a directory in {}: {error}", parent.display()))
    })
}
