//! When, how and with what a report was made.

use std::time::{SystemTime, UNIX_EPOCH};

use crate::render::time::time;

/// What a reader needs to make the report again.
#[derive(Clone, Debug)]
pub(crate) struct Provenance {
    /// When it was made, as `2026-11-22 07:05 UTC`.
    pub(super) date: String,
    /// What was typed.
    pub(super) command: String,
    /// This program's version.
    pub(super) version: String,
    /// The machine, as far as it matters to figures of time.
    pub(super) machine: String,
}

impl Provenance {
    /// As it is.
    pub(crate) fn now(now: SystemTime) -> Self {
        let seconds = now.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let build = if cfg!(debug_assertions) { "debug" } else { "release" };
        let typed: Vec<String> = std::env::args().skip(1).map(|argument| quoted(&argument)).collect();
        Self {
            date: date(seconds),
            command: format!("pschema {}", typed.join(" ")),
            version: format!("{} ({build} build)", env!("CARGO_PKG_VERSION")),
            machine: format!("{} {}, {cores} cores", std::env::consts::OS, std::env::consts::ARCH),
        }
    }
}

/// An argument as a shell would take it.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,@+".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        return argument.to_owned();
    }
    format!("'{}'", argument.replace('\'', "'\\''"))
}

/// Seconds since 1970 as `2026-11-22 07:05 UTC`.
fn date(seconds: u64) -> String {
    let time = time(seconds);
    let minutes = time.rsplit_once(':').map_or(time.as_str(), |(minutes, _)| minutes);
    format!("{minutes} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_the_calendars() {
        assert_eq!(date(0), "1970-01-01 00:00 UTC");
        assert_eq!(date(951_782_400 + 3_661), "2000-02-29 01:01 UTC");
        assert_eq!(date(1_795_330_800), "2026-11-22 07:00 UTC");
    }

    #[test]
    fn arguments_can_be_typed_again() {
        assert_eq!(quoted("exp1-s1"), "exp1-s1");
        assert_eq!(quoted("no attention"), "'no attention'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }
}
