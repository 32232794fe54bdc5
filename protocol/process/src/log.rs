//! The log of a process, on stderr.

use std::borrow::Cow;
use std::io::{self, BufRead, BufReader, IsTerminal, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use serde_json::Value;
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
        // The thread of a log that nobody writes to would stay as long as the process.
        static HAS_BEGUN: AtomicBool = AtomicBool::new(false);
        if HAS_BEGUN.swap(true, Ordering::Relaxed) {
            return;
        }
        let filter = EnvFilter::builder().with_default_directive(self.level.into()).from_env_lossy();
        let coloured = io::stderr().is_terminal() && colour_is_wanted();
        let lines = Lines::to(io::stderr(), |lines| {
            tracing::warn!(lines, "these lines of the log are lost: stderr was not read for too long");
        });
        let lines = match lines {
            Ok(lines) => lines,
            Err(error) => return say(&format!("there is no log: cannot start its thread: {error}")),
        };
        let (writer, json) = (lines.clone(), self.json);
        let log = tracing_subscriber::fmt().with_env_filter(filter);
        let log = log.with_writer(move || LogWriter { lines: writer.clone(), json });
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

/// The lines of the log without what nobody would read of them ([`readable`]): they tell of what came from elsewhere, which may be
/// anything.
struct LogWriter {
    lines: Lines,
    json: bool,
}

impl Write for LogWriter {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        match str::from_utf8(line).map(|line| if self.json { readable_json(line) } else { readable(line) }) {
            Ok(Cow::Owned(cut)) => self.lines.write_all(cut.as_bytes())?,
            _ => self.lines.write_all(line)?,
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        // Who logs waits for nobody.
        Ok(())
    }
}

/// A line of JSON with each of its texts [`readable`].
fn readable_json(line: &str) -> Cow<'_, str> {
    let text = readable(line);
    if let (Cow::Owned(_), Ok(mut value)) = (&text, serde_json::from_str(line)) {
        shorten(&mut value);
        return Cow::Owned(format!("{value}\n"));
    }
    Cow::Borrowed(line)
}

fn shorten(value: &mut Value) {
    match value {
        Value::String(text) => {
            if let Cow::Owned(cut) = readable(text) {
                *text = cut;
            }
        }
        Value::Array(values) => values.iter_mut().for_each(shorten),
        Value::Object(fields) => fields.values_mut().for_each(shorten),
        _ => {}
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

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};

    use super::*;

    struct Out(Sender<Vec<u8>>);

    impl Write for Out {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.send(bytes.to_owned()).ok();
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// The log of an arm repeated ten thousand bytes of what its controller had sent.
    #[test]
    fn the_log_repeats_no_long_input() {
        let (written, line) = channel();
        let lines = Lines::to(Out(written), |_| {}).unwrap();
        let log = |json| LogWriter { lines: lines.clone(), json };
        let long = "x".repeat(10_000);
        log(false).write_all(format!("WARN refused fault=\"{long}\" silent_ms=3\n").as_bytes()).unwrap();
        let text = String::from_utf8(line.recv().unwrap()).unwrap();
        assert!(
            text.len() < 300 && text.starts_with("WARN refused") && text.ends_with("silent_ms=3\n"),
            "{text}"
        );

        // JSON stays JSON, and numbers stay numbers.
        let fields =
            serde_json::json!({"level": "WARN", "fields": {"fault": long, "many": [long], "bytes": 1e300}});
        log(true).write_all(format!("{fields}\n").as_bytes()).unwrap();
        let text = String::from_utf8(line.recv().unwrap()).unwrap();
        let read: Value = serde_json::from_str(&text).unwrap();
        assert!(text.len() < 600 && text.ends_with("}\n"), "{text}");
        assert_eq!(
            (&read["level"], &read["fields"]["bytes"]),
            (&fields["level"], &fields["fields"]["bytes"])
        );
        assert!(read["fields"]["fault"].as_str().unwrap().contains(" characters) …"), "{text}");

        for short in ["WARN stop by=\"a person\"\n", "{\"level\":\"WARN\"}\n"] {
            for json in [false, true] {
                log(json).write_all(short.as_bytes()).unwrap();
                assert_eq!(line.recv().unwrap(), short.as_bytes());
            }
        }
    }
}
