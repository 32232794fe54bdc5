//! Processes of this program, at most one for each core at a time.

use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;

use crate::failure::CountFailure;

/// Does `task` for each item, on as many threads as there are cores. The results are in no particular order.
pub(crate) fn each<I: Send, T: Send>(
    items: impl Iterator<Item = I> + Send,
    task: impl Fn(I) -> Result<T, CountFailure> + Sync,
) -> Result<Vec<T>, CountFailure> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let (items, results) = (Mutex::new(items), Mutex::new(Vec::new()));
    let next = || items.lock().unwrap_or_else(PoisonError::into_inner).next();
    thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                while let Some(item) = next() {
                    let result = task(item);
                    results.lock().unwrap_or_else(PoisonError::into_inner).push(result);
                }
            });
        }
    });
    results.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().collect()
}

/// Runs this program with `arguments` and the directory `lives`, by way of the command `through` when there is one. Returns what
/// the process printed.
pub(crate) fn own_process(
    arguments: &[&str],
    lives: &Path,
    through: &[String],
) -> Result<Vec<u8>, CountFailure> {
    let failed = |problem: String| CountFailure::Process { command: arguments.join(" "), problem };
    let this = std::env::current_exe().map_err(|error| failed(error.to_string()))?;
    let mut command = match through {
        [] => Command::new(this),
        [program, options @ ..] => {
            let mut command = Command::new(program);
            command.args(options).arg(this);
            command
        }
    };
    command.args(arguments).arg(lives).env_remove("RUST_LOG").stdin(Stdio::null());
    let output = command.output().map_err(|error| failed(error.to_string()))?;
    if output.status.success() {
        return Ok(output.stdout);
    }
    Err(failed(format!("{}\n{}", output.status, String::from_utf8_lossy(&output.stderr))))
}
