//! The files that the process may have open. Shared memory and peers take some of them, and an iceoryx2 that has none left says
//! only that it failed.

use rustix::process::{Resource, getrlimit, setrlimit};

/// The process may open too few files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "this process may open {allowed} files, and {who} needs {needed}: run `ulimit -n {needed}` first, or set \
     LimitNOFILE={needed} in its unit"
)]
pub struct TooFewDescriptors {
    who: &'static str,
    allowed: u64,
    needed: u64,
}

/// Makes sure that the process, which is `who`, may open as many files as it needs: raises its own limit to that, as far as the
/// system allows.
///
/// # Errors
/// When the system allows fewer.
pub fn require_descriptors(who: &'static str, needed: u64) -> Result<(), TooFewDescriptors> {
    let mut limit = getrlimit(Resource::Nofile);
    // None: no limit.
    if limit.current.is_none_or(|soft| soft >= needed) {
        return Ok(());
    }
    let allowed = limit.maximum.unwrap_or(needed).min(needed);
    limit.current = Some(allowed);
    if allowed < needed || setrlimit(Resource::Nofile, limit).is_err() {
        return Err(TooFewDescriptors { who, allowed, needed });
    }
    tracing::debug!(allowed, "raised the number of files that the process may open");
    Ok(())
}
