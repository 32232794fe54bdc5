//! The log of a process, on stderr.

use std::io::{self, BufRead, BufReader, IsTerminal, Read, Write};
use std::thread;

use tracing::dispatcher;
use tracing_subscriber::EnvFilter;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::lines::Lines;
use crate::readable::readable;

pub use tracing_subscriber::filter::LevelFilter;

/// The longest line of another process that is said as one, in bytes.
const RELAYED_BYTES_MAX: u64 = 64 * 1024;

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

    /// Begins to log on stderr. A process that has a log already keeps that one. Logging never waits for who reads stderr:
    /// see [`lost_lines`].
    pub fn begin(self) {
        let filter = EnvFilter::builder().with_default_directive(self.level.into()).from_env_lossy();
        let coloured = io::stderr().is_terminal() && colour_is_wanted();
        let lines = Lines::to(io::stderr(), |lines| {
            tracing::warn!(lines, "these lines of the log are lost: stderr was not read for too long");
        });
        let lines = match lines {
            Ok(lines) => lines,
            Err(error) => return say(&format!("there is no log: cannot start its thread: {error}")),
        };
        let writer = lines.clone();
        let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(move || writer.clone());
        let log = log.with_ansi(coloured).log_internal_errors(false);
        let begun = if self.json {
            log.json().finish().with(lines).try_init()
        } else {
            log.with_target(false).finish().with(lines).try_init()
        };
        if let Err(error) = begun {
            tracing::debug!(%error, "this process has a log already");
        }
    }
}

/// Writes one line to stderr, behind those of the log and by the same thread, without what nobody would read of it ([`readable`]).
/// While nobody reads stderr the line waits, as those of the log do, and the process goes on. When nobody reads it any more, the
/// line is lost and the process goes on as well; `eprintln!` would panic. A process that has no log waits until the line is written.
pub fn say(line: &str) {
    let line = format!("{}\n", readable(line));
    if with_lines(|lines| lines.say(line.as_bytes())).is_none() {
        drop(io::stderr().write_all(line.as_bytes()));
    }
}

/// Says what another process writes to `stderr`, line by line, from a thread of its own that ends with that process. A shell that
/// can't start a command repeats it, however long it is.
///
/// # Errors
/// When the thread can't be started.
pub fn relay(stderr: impl Read + Send + 'static) -> io::Result<()> {
    let run = move || {
        let mut stderr = BufReader::new(stderr);
        let mut line = Vec::new();
        while stderr.by_ref().take(RELAYED_BYTES_MAX).read_until(b'\n', &mut line).is_ok_and(|read| read > 0)
        {
            say(String::from_utf8_lossy(&line).trim_end());
            line.clear();
        }
    };
    thread::Builder::new().name("stderr".to_owned()).spawn(run).map(drop)
}

/// How many lines of this process's log were lost so far, because nobody read them from stderr.
#[must_use]
pub fn lost_lines() -> u64 {
    with_lines(Lines::lost).unwrap_or(0)
}

/// Waits until all lines logged and said so far are written, for a second at most: at the end of a process.
pub fn flush() {
    with_lines(Lines::flush);
}

fn with_lines<T>(look: impl FnOnce(&Lines) -> T) -> Option<T> {
    dispatcher::get_default(|log| log.downcast_ref::<Lines>().cloned()).map(|lines| look(&lines))
}

/// Whether the environment allows colours: neither <https://no-color.org> nor a terminal that has none forbids them.
#[must_use]
pub fn colour_is_wanted() -> bool {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty());
    set("NO_COLOR").is_none() && set("TERM").is_none_or(|term| term != "dumb")
}
