//! The log of a process, on stderr.

use std::io::{self, IsTerminal};

use tracing_subscriber::EnvFilter;

pub use tracing_subscriber::filter::LevelFilter;

/// How a process logs.
#[derive(Clone, Copy, Debug)]
pub struct Log {
    level: LevelFilter,
    json: bool,
}

impl Log {
    /// A log for people, with everything down to `level`. The environment variable `RUST_LOG` takes precedence.
    #[must_use]
    pub fn new(level: LevelFilter) -> Self {
        Self { level, json: false }
    }

    /// The same log as JSON, one object a line, when `json` is set.
    #[must_use]
    pub fn as_json(self, json: bool) -> Self {
        Self { json, ..self }
    }

    /// Begins to log on stderr. A process that has a log already keeps that one.
    pub fn begin(self) {
        let filter = EnvFilter::builder().with_default_directive(self.level.into()).from_env_lossy();
        let coloured = io::stderr().is_terminal() && colour_is_wanted();
        let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(io::stderr);
        // When the other end of the pipe has died, its failures to write must not end this process.
        let log = log.with_ansi(coloured).log_internal_errors(false);
        let begun = if self.json { log.json().try_init() } else { log.with_target(false).try_init() };
        if let Err(error) = begun {
            tracing::debug!(error, "this process has a log already");
        }
    }
}

/// Whether the environment allows colours: neither <https://no-color.org> nor a terminal that has none forbids them.
#[must_use]
pub fn colour_is_wanted() -> bool {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    set("NO_COLOR").is_none() && set("TERM").is_none_or(|term| term != "dumb")
}
