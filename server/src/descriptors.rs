//! The files that the process may have open. Peers take some of them, and a daemon that has none left could not go on to another
//! file of the journal.

use rustix::process::{Resource, getrlimit, setrlimit};

use crate::error::ServerError;

/// The files that a daemon with all its bodies and tools has open, generously rounded up.
pub(crate) const DESCRIPTORS_NEEDED: u64 = 1024;

/// Makes sure that the process may open as many files as it needs: raises its own limit to that, as far as the system allows.
///
/// # Errors
/// [`ServerError::Descriptors`] when the system allows fewer.
pub(crate) fn require() -> Result<(), ServerError> {
    let mut limit = getrlimit(Resource::Nofile);
    // None: no limit.
    if limit.current.is_none_or(|soft| soft >= DESCRIPTORS_NEEDED) {
        return Ok(());
    }
    let allowed = limit.maximum.unwrap_or(DESCRIPTORS_NEEDED).min(DESCRIPTORS_NEEDED);
    limit.current = Some(allowed);
    if allowed < DESCRIPTORS_NEEDED || setrlimit(Resource::Nofile, limit).is_err() {
        return Err(ServerError::Descriptors { allowed, needed: DESCRIPTORS_NEEDED });
    }
    tracing::debug!(allowed, "raised the number of files that the process may open");
    Ok(())
}
