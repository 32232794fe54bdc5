//! Recording every exchange with the controller, and replaying it: a test of the driver without an arm.
//!
//! A recording is text, one event a line: seconds since its beginning, then `order TEXT` and `outcome TEXT` for an
//! order to the driver and its outcome, `> "BYTES"` and `< "BYTES"` for bytes sent and received, `stop "BYTES"` for
//! bytes sent to stop the arm, and `gone TEXT` when the line was lost. Bytes are written as Rust writes them.

use std::collections::VecDeque;
use std::io::{self, BufRead};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use pschema_process::input;

use super::recorder::LineRecorder;
use super::{Line, LineError, Stopper};

/// Longest recording replayed, in lines.
const LINES_MAX: usize = 10_000_000;

/// A line whose exchanges are recorded.
pub struct RecordingLine {
    line: Box<dyn Line>,
    recorder: LineRecorder,
}

impl RecordingLine {
    /// Records a line.
    #[must_use]
    pub fn new(line: Box<dyn Line>, recorder: LineRecorder) -> Self {
        Self { line, recorder }
    }

    fn noted<T>(&self, result: Result<T, LineError>) -> Result<T, LineError> {
        result.inspect_err(|error| self.recorder.event("gone", &error.to_string()))
    }
}

impl Line for RecordingLine {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        // Sent before it is recorded: a slow disk may not delay an order until after the stop that should follow it.
        let sent = self.line.send(bytes);
        self.recorder.bytes(">", bytes);
        self.noted(sent)
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize, LineError> {
        let received = self.line.receive(buffer, wait);
        let received = self.noted(received)?;
        if let Some(bytes) = buffer.get(..received).filter(|bytes| !bytes.is_empty()) {
            self.recorder.bytes("<", bytes);
        }
        Ok(received)
    }

    fn discard(&mut self) -> Result<(), LineError> {
        self.line.discard()
    }

    fn stopper(&self) -> Result<Box<dyn Stopper>, LineError> {
        // The switch records the bytes that stop the arm, once they are sent.
        self.line.stopper()
    }
}

/// An event of a recording.
#[derive(Clone, Debug, PartialEq)]
pub enum LineEvent {
    /// The driver got an order.
    Order(String),
    /// The outcome of the order.
    Outcome(String),
    /// The driver sent bytes.
    Sent(Vec<u8>),
    /// The driver received bytes.
    Received(Vec<u8>),
    /// The line was lost.
    Gone(String),
}

/// A recording that was read back: its events with their line numbers.
#[derive(Clone, Default)]
pub struct LineRecording(Arc<Mutex<VecDeque<(usize, LineEvent)>>>);

impl LineRecording {
    /// Reads a recording.
    ///
    /// # Errors
    /// When the file cannot be read, or a line is not an event.
    pub fn read(path: &Path) -> io::Result<Self> {
        let mut events = VecDeque::new();
        for (index, line) in input(path)?.lines().enumerate().take(LINES_MAX) {
            let line = line?;
            let event = event(&line).ok_or_else(|| {
                let problem = format!("line {} is no event of a recording: {line:?}", index + 1);
                io::Error::new(io::ErrorKind::InvalidData, problem)
            })?;
            events.extend(event.map(|event| (index + 1, event)));
        }
        Ok(Self(Arc::new(Mutex::new(events))))
    }

    /// The next order, if that is the next event.
    #[must_use]
    pub fn next_order(&self) -> Option<(usize, String)> {
        self.next_if(|event| if let LineEvent::Order(text) = event { Some(text.clone()) } else { None })
    }

    /// The next outcome, if that is the next event.
    #[must_use]
    pub fn next_outcome(&self) -> Option<(usize, String)> {
        self.next_if(|event| if let LineEvent::Outcome(text) = event { Some(text.clone()) } else { None })
    }

    /// The next event and its line number. The event stays the next one.
    #[must_use]
    pub fn peek(&self) -> Option<(usize, LineEvent)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).front().cloned()
    }

    fn next_if<T>(&self, wanted: impl Fn(&LineEvent) -> Option<T>) -> Option<(usize, T)> {
        let mut events = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let (line, event) = events.front()?;
        let found = (*line, wanted(event)?);
        events.pop_front();
        Some(found)
    }
}

/// Reads a line. The outer None: the line is no event. The inner None: the event is not replayed.
fn event(line: &str) -> Option<Option<LineEvent>> {
    let mut parts = line.splitn(3, ' ');
    let (seconds, what, text) = (parts.next()?, parts.next()?, parts.next()?);
    seconds.parse::<f64>().ok()?;
    Some(match what {
        "order" => Some(LineEvent::Order(text.to_owned())),
        "outcome" => Some(LineEvent::Outcome(text.to_owned())),
        ">" => Some(LineEvent::Sent(unescaped(text)?)),
        "<" => Some(LineEvent::Received(unescaped(text)?)),
        "gone" => Some(LineEvent::Gone(text.to_owned())),
        // Another thread pressed the switch, in its own time.
        "stop" => None,
        _ => return None,
    })
}

/// The bytes of a text in quotes that `escape_ascii` wrote.
fn unescaped(text: &str) -> Option<Vec<u8>> {
    let inner = text.strip_prefix('"')?.strip_suffix('"')?;
    let (mut bytes, mut rest) = (Vec::new(), inner.bytes());
    while let Some(byte) = rest.next() {
        if byte != b'\\' {
            bytes.push(byte);
            continue;
        }
        bytes.push(match rest.next()? {
            b'n' => b'\n',
            b'r' => b'\r',
            b't' => b'\t',
            b'x' => {
                let digit = |byte: u8| char::from(byte).to_digit(16);
                u8::try_from(digit(rest.next()?)? * 16 + digit(rest.next()?)?).ok()?
            }
            other => other,
        });
    }
    Some(bytes)
}

/// A line that answers as in a recording, and checks that the driver sends the same bytes as then.
pub struct ReplayLine {
    recording: LineRecording,
    held: VecDeque<u8>,
}

impl ReplayLine {
    /// A line that replays a recording.
    #[must_use]
    pub fn new(recording: LineRecording) -> Self {
        Self { recording, held: VecDeque::new() }
    }
}

impl Line for ReplayLine {
    fn send(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        // An event of the recording that must come before these bytes is an error.
        let sent = self.recording.next_if(|event| match event {
            LineEvent::Sent(sent) => Some(Ok(sent.clone())),
            LineEvent::Gone(why) => Some(Err(why.clone())),
            _ => None,
        });
        match sent {
            Some((_, Ok(sent))) if sent == bytes => Ok(()),
            Some((_, Err(why))) => Err(LineError::Gone(io::Error::other(why))),
            Some((line, Ok(sent))) => Err(LineError::Replay {
                line,
                problem: format!(
                    "the driver sent \"{}\" where it had sent \"{}\"",
                    bytes.escape_ascii(),
                    sent.escape_ascii()
                ),
            }),
            None => {
                let (line, next) = self.recording.peek().unwrap_or((0, LineEvent::Gone("the end".into())));
                let problem =
                    format!("the driver sent \"{}\" where there was {next:?}", bytes.escape_ascii());
                Err(LineError::Replay { line, problem })
            }
        }
    }

    fn receive(&mut self, buffer: &mut [u8], wait: Duration) -> Result<usize, LineError> {
        if self.held.is_empty() {
            let received = self.recording.next_if(|event| match event {
                LineEvent::Received(bytes) => Some(Ok(bytes.clone())),
                LineEvent::Gone(why) => Some(Err(why.clone())),
                _ => None,
            });
            match received {
                Some((_, Ok(bytes))) => self.held.extend(bytes),
                Some((_, Err(why))) => return Err(LineError::Gone(io::Error::other(why))),
                // No bytes came then, so none come now, and the driver waits in vain.
                None => std::thread::sleep(wait),
            }
        }
        let count = buffer.len().min(self.held.len());
        for (to, byte) in buffer.iter_mut().zip(self.held.drain(..count)) {
            *to = byte;
        }
        Ok(count)
    }

    fn discard(&mut self) -> Result<(), LineError> {
        self.held.clear();
        Ok(())
    }

    fn stopper(&self) -> Result<Box<dyn Stopper>, LineError> {
        Ok(Box::new(NoStopper))
    }
}

/// Stops nothing, because in a replay nothing moves.
struct NoStopper;

impl Stopper for NoStopper {
    fn stop(&mut self, _: &[u8]) -> Result<(), LineError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Says `pong` to everything.
    struct Pong(bool);

    impl Line for Pong {
        fn send(&mut self, _: &[u8]) -> Result<(), LineError> {
            self.0 = true;
            Ok(())
        }

        fn receive(&mut self, buffer: &mut [u8], _: Duration) -> Result<usize, LineError> {
            let answer = if std::mem::take(&mut self.0) { &b"pong\x07\"\\\r\n"[..] } else { b"" };
            buffer[..answer.len()].copy_from_slice(answer);
            Ok(answer.len())
        }

        fn discard(&mut self) -> Result<(), LineError> {
            Ok(())
        }

        fn stopper(&self) -> Result<Box<dyn Stopper>, LineError> {
            Ok(Box::new(NoStopper))
        }
    }

    fn exchange(line: &mut dyn Line, question: &[u8]) -> Result<Vec<u8>, LineError> {
        line.send(question)?;
        let mut buffer = [0; 64];
        let count = line.receive(&mut buffer, Duration::ZERO)?;
        Ok(buffer[..count].to_vec())
    }

    #[test]
    fn what_was_recorded_is_replayed_and_a_difference_is_told_with_its_line() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("recording");
        let recorder = LineRecorder::create(&path).unwrap();
        let mut line = RecordingLine::new(Box::new(Pong(false)), recorder.clone());
        recorder.event("order", "where");
        let answer = exchange(&mut line, b"WHERE\r\n").unwrap();
        let mut stopper = line.stopper().unwrap();
        stopper.stop(b"STOP\n").unwrap();
        recorder.stopped(b"STOP\n");
        recorder.event("outcome", "fine");
        assert_eq!(exchange(&mut line, b"ID\r\n").unwrap(), answer);

        let recording = LineRecording::read(&path).unwrap();
        let mut replayed = ReplayLine::new(recording.clone());
        assert_eq!(recording.next_order(), Some((1, "where".to_owned())));
        assert_eq!(exchange(&mut replayed, b"WHERE\r\n").unwrap(), answer);
        assert_eq!(recording.next_outcome(), Some((5, "fine".to_owned())));
        let error = exchange(&mut replayed, b"SPEED 100\r\n").unwrap_err().to_string();
        assert!(error.contains("line 6") && error.contains("SPEED 100") && error.contains("ID"), "{error}");
    }

    #[test]
    fn a_damaged_recording_is_refused_with_its_line() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("recording");
        for text in ["0.1 > \"a\"\nx > \"a\"\n", "0.1 > \"a\"\n0.2 > a\n", "0.1 > \"a\"\n0.2 < \"\\x4\"\n"] {
            std::fs::write(&path, text).unwrap();
            let error = LineRecording::read(&path).err().unwrap().to_string();
            assert!(error.contains("line 2"), "{error}");
        }
    }
}
