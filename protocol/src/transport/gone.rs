//! Whether a daemon has gone.

/// Whether the daemon has gone without a reply. A daemon lets go of a request the moment it has replied, and may itself end
/// then; so neither of the first two says that no reply will come, and `has_reply` must be asked after them.
pub(super) fn has_gone(
    is_connected: impl FnOnce() -> bool,
    is_current: impl FnOnce() -> bool,
    has_reply: impl FnOnce() -> bool,
) -> bool {
    let seems_gone = !is_connected() || !is_current();
    seems_gone && !has_reply()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    #[test]
    fn a_daemon_that_replies_while_it_is_looked_for_has_not_gone() {
        let replied = Cell::new(false);
        let lets_go = || {
            replied.set(true);
            false
        };
        assert!(!has_gone(lets_go, || true, || replied.get()), "it let go of the request");
        replied.set(false);
        assert!(!has_gone(|| true, lets_go, || replied.get()), "it ended");
        assert!(!has_gone(|| true, || true, || false), "it takes its time");
        assert!(has_gone(|| false, || true, || false), "it dropped the request");
        assert!(has_gone(|| true, || false, || false), "it died");
    }
}
