//! The person beside the arm, who consents to moving it, looks after faults, and puts objects where a curriculum wants
//! them. The person is asked on the terminal, or through a socket on which somebody (or an emulator) answers line by
//! line.

use std::io::{self, BufRead, BufReader, IsTerminal, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use pschema_process::say;
use thiserror::Error;

/// Longest wait for objects to be put somewhere.
const ARRANGE_WAIT: Duration = Duration::from_secs(600);
/// Time between two looks of a wait whether the process is to end.
const SLICE: Duration = Duration::from_millis(100);
/// Longest answer, in bytes.
const ANSWER_BYTES_MAX: u64 = 1024;

/// The place where the person is asked.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum OperatorPlace {
    /// Nowhere: nobody can be asked.
    #[default]
    None,
    /// At the terminal of this process.
    Terminal,
    /// Behind a Unix stream socket.
    Socket(PathBuf),
}

impl FromStr for OperatorPlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.strip_prefix("socket:")) {
            ("none", _) => Ok(Self::None),
            ("terminal", _) => Ok(Self::Terminal),
            (_, Some(path)) if !path.is_empty() => Ok(Self::Socket(PathBuf::from(path))),
            _ => Err(format!("{text:?} is no operator: use terminal, socket:PATH or none")),
        }
    }
}

/// Why a person did not do what was asked.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OperatorError {
    /// There is nobody to ask.
    #[error(
        "nobody can be asked: run it in a terminal with --operator terminal, or with --operator socket:PATH"
    )]
    Nobody,
    /// The person said no.
    #[error("the operator refused: {0}")]
    Refused(String),
    /// The person did not answer.
    #[error("the operator did not answer within {} s", .0.as_secs())]
    Silent(Duration),
    /// The process is to end.
    #[error("ended while waiting for the operator")]
    Stopped,
    /// The socket failed.
    #[error("the operator's socket {path}: {source}")]
    Socket {
        /// Path of the socket.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
}

/// A request to a person.
#[derive(Clone, Debug, PartialEq)]
pub enum Wish<'a> {
    /// To agree that the arm may move.
    Enable(&'a str),
    /// To have seen to a fault, and agree that the arm may move again.
    Reset(&'a str),
    /// To put an object somewhere.
    Place {
        /// Name of the object.
        object: &'a str,
        /// The number of the place.
        position: usize,
        /// The place itself: x to the right and y outwards from the base's axis, in millimetres.
        at_mm: (f64, f64),
    },
    /// To take an object away.
    Remove {
        /// Name of the object.
        object: &'a str,
    },
}

impl Wish<'_> {
    /// The line that is sent through a socket.
    fn line(&self) -> String {
        match self {
            Self::Enable(why) => format!("enable {why}"),
            Self::Reset(why) => format!("reset {why}"),
            Self::Place { object, position, .. } => format!("place {object} {position}"),
            Self::Remove { object } => format!("remove {object}"),
        }
    }

    /// The text for a terminal, and the word that agrees. The empty word is the return key.
    fn said(&self) -> (String, &'static str) {
        match self {
            Self::Enable(why) => (
                format!(
                    "{why}\nThe arm will move. Stand clear, keep the emergency stop in reach, and type: enable"
                ),
                "enable",
            ),
            Self::Reset(why) => (
                format!(
                    "The arm has stopped: {why}\nSee to it, stand clear, and type: reset (anything else leaves it stopped)"
                ),
                "reset",
            ),
            Self::Place { object, position, at_mm: (x, y) } => (
                format!(
                    "Put {object} at place {position}: {x:.0} mm to the right of the base's axis, {y:.0} mm out. Press return \
                     when your hands are clear, or type why not"
                ),
                "",
            ),
            Self::Remove { object } => {
                (format!("Take {object} away. Press return when your hands are clear, or type why not"), "")
            }
        }
    }
}

/// A person to ask.
#[derive(Debug)]
pub struct Operator {
    place: OperatorPlace,
}

/// Lines typed at the terminal: one reader for the life of the process, whoever asks. A second one would take the
/// answer to the first one's next question.
static TYPED: OnceLock<Mutex<Receiver<String>>> = OnceLock::new();

impl Operator {
    /// A person who is asked at a place.
    #[must_use]
    pub fn new(place: OperatorPlace) -> Self {
        Self { place }
    }

    /// Whether there is anybody to ask.
    #[must_use]
    pub fn is_there(&self) -> bool {
        match &self.place {
            OperatorPlace::None => false,
            OperatorPlace::Terminal => io::stdin().is_terminal(),
            OperatorPlace::Socket(_) => true,
        }
    }

    /// Asks, and waits for the answer, at most `wait`, or until `stop` is set.
    ///
    /// # Errors
    /// When the person did not do it.
    pub fn ask(&self, wish: &Wish<'_>, wait: Duration, stop: &AtomicBool) -> Result<(), OperatorError> {
        match &self.place {
            OperatorPlace::None => Err(OperatorError::Nobody),
            OperatorPlace::Terminal => ask_terminal(wish, wait, stop),
            OperatorPlace::Socket(path) => {
                let failed = |source| OperatorError::Socket { path: path.clone(), source };
                match ask_socket(path, &wish.line(), wait, stop).map_err(failed)? {
                    Some(answer) if answer == "done" => Ok(()),
                    Some(answer) => {
                        Err(OperatorError::Refused(answer.trim_start_matches("refused").trim().to_owned()))
                    }
                    None if stop.load(Ordering::Relaxed) => Err(OperatorError::Stopped),
                    None => Err(OperatorError::Silent(wait)),
                }
            }
        }
    }

    /// Asks for an arrangement of objects, which takes a person a while.
    ///
    /// # Errors
    /// When the person did not do it.
    pub fn arrange(&self, wish: &Wish<'_>, stop: &AtomicBool) -> Result<(), OperatorError> {
        self.ask(wish, ARRANGE_WAIT, stop)
    }
}

fn ask_terminal(wish: &Wish<'_>, wait: Duration, stop: &AtomicBool) -> Result<(), OperatorError> {
    if !io::stdin().is_terminal() {
        return Err(OperatorError::Nobody);
    }
    let typed = TYPED.get_or_init(|| Mutex::new(read_terminal()));
    let typed = typed.lock().unwrap_or_else(PoisonError::into_inner);
    // Lines typed before the question are no answer to it.
    while typed.try_recv().is_ok() {}
    let (said, word) = wish.said();
    // A terminal that cannot be written to cannot be read from either, and no answer comes.
    say(&format!("{said}:"));
    let end = Instant::now() + wait;
    while Instant::now() < end {
        match typed.recv_timeout(SLICE) {
            Ok(line) if line.trim() == word => return Ok(()),
            Ok(line) => return Err(OperatorError::Refused(line.trim().to_owned())),
            Err(RecvTimeoutError::Timeout) if stop.load(Ordering::Relaxed) => {
                return Err(OperatorError::Stopped);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Err(OperatorError::Nobody),
        }
    }
    Err(OperatorError::Silent(wait))
}

/// Lines typed at the terminal. The thread that reads them waits in the system until the process ends.
fn read_terminal() -> Receiver<String> {
    let (sender, receiver) = mpsc::channel();
    let reader = std::thread::Builder::new().name("terminal".into()).spawn(move || {
        for line in io::stdin().lock().lines() {
            let Ok(line) = line else { break };
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    if let Err(error) = reader {
        tracing::error!(%error, "the terminal cannot be read");
    }
    receiver
}

/// Sends one line and reads one. None when no line came in time, or `stop` was set.
fn ask_socket(path: &PathBuf, line: &str, wait: Duration, stop: &AtomicBool) -> io::Result<Option<String>> {
    let mut stream = UnixStream::connect(path)?;
    stream.set_write_timeout(Some(wait.min(Duration::from_secs(5))))?;
    stream.set_read_timeout(Some(SLICE))?;
    stream.write_all(line.as_bytes())?;
    stream.write_all(b"\n")?;
    let end = Instant::now() + wait;
    let mut reader = io::Read::take(BufReader::new(stream), ANSWER_BYTES_MAX);
    let mut answer = Vec::new();
    while Instant::now() < end && !stop.load(Ordering::Relaxed) {
        match reader.read_until(b'\n', &mut answer) {
            Ok(_) if answer.last() == Some(&b'\n') => {
                return Ok(Some(String::from_utf8_lossy(&answer).trim().to_owned()));
            }
            Ok(_) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use std::os::unix::net::UnixListener;

    use super::*;

    #[test]
    fn places_are_read() {
        assert_eq!("terminal".parse(), Ok(OperatorPlace::Terminal));
        assert_eq!("socket:/run/x".parse(), Ok(OperatorPlace::Socket("/run/x".into())));
        assert!("socket:".parse::<OperatorPlace>().unwrap_err().contains("socket:PATH"));
    }

    #[test]
    fn somebody_behind_a_socket_does_it_or_says_why_not() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("operator");
        let listener = UnixListener::bind(&path).unwrap();
        let person = std::thread::spawn(move || {
            let answers = ["done\n", "refused the block is lost\n", ""];
            answers.map(|answer| {
                let (stream, _) = listener.accept().unwrap();
                let mut line = String::new();
                BufReader::new(&stream).read_line(&mut line).unwrap();
                (&stream).write_all(answer.as_bytes()).unwrap();
                line
            })
        });
        let operator = Operator::new(OperatorPlace::Socket(path.clone()));
        let stop = AtomicBool::new(false);
        let place = Wish::Place { object: "blue-block", position: 12, at_mm: (1.0, 2.0) };
        operator.arrange(&place, &stop).unwrap();
        let refused = operator.arrange(&Wish::Remove { object: "blue-block" }, &stop).unwrap_err();
        assert_eq!(refused.to_string(), "the operator refused: the block is lost");
        let hung_up = operator.ask(&Wish::Reset("E-stop"), Duration::from_secs(5), &stop).unwrap_err();
        assert!(matches!(hung_up, OperatorError::Socket { .. }), "{hung_up}");
        let asked = person.join().unwrap();
        assert_eq!(asked, ["place blue-block 12\n", "remove blue-block\n", "reset E-stop\n"]);
        assert!(matches!(
            Operator::new(OperatorPlace::None).arrange(&place, &stop),
            Err(OperatorError::Nobody)
        ));
    }
}
