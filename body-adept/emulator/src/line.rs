//! The traffic of the line: answers wait here until they may leave, at the pace of the line and with its faults.

use std::collections::VecDeque;
use std::io;
use std::time::{Duration, Instant};

use crate::faults::LineFaults;
use crate::pty::Pty;

/// Bytes that may wait to leave. Further ones are lost.
const WAITING_MAX: usize = 64 * 1024;
/// Bits of a character on the line: start, eight, stop.
const BITS: u32 = 10;

/// The line, with the answers that wait to leave on it.
pub(crate) struct Line {
    pty: Pty,
    pub(crate) faults: LineFaults,
    pub(crate) faulty: bool,
    baud: Option<u32>,
    waiting: VecDeque<QueuedBytes>,
    waiting_bytes: usize,
    /// When the last character that left has gone, if the line is paced.
    free_at: Instant,
    /// When the last character that came in has come, if the line is paced.
    heard_until: Instant,
    plug_at: Option<Instant>,
}

struct QueuedBytes {
    at: Instant,
    bytes: Vec<u8>,
    unplug: Option<Duration>,
}

impl Line {
    pub(crate) fn new(pty: Pty, faults: LineFaults, baud: Option<u32>, now: Instant) -> Self {
        Self {
            pty,
            faults,
            faulty: true,
            baud,
            waiting: VecDeque::new(),
            waiting_bytes: 0,
            free_at: now,
            heard_until: now,
            plug_at: None,
        }
    }

    pub(crate) fn pty(&self) -> &Pty {
        &self.pty
    }

    fn takes(&self, bytes: usize) -> Duration {
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
        self.baud.map_or(Duration::ZERO, |baud| Duration::from_secs(1) * BITS * bytes / baud)
    }

    /// Takes an answer that is to leave.
    pub(crate) fn say(&mut self, text: &str, now: Instant) {
        let sent = if self.faulty {
            self.faults.answer(text)
        } else {
            crate::faults::Transmission { bytes: text.as_bytes().to_vec(), ..Default::default() }
        };
        if self.waiting_bytes + sent.bytes.len() > WAITING_MAX {
            tracing::warn!("what the controller says is lost: nobody reads");
            return;
        }
        // No answer overtakes another.
        let at = (now + sent.late).max(self.waiting.back().map_or(now, |last| last.at));
        self.waiting_bytes += sent.bytes.len();
        self.waiting.push_back(QueuedBytes { at, bytes: sent.bytes, unplug: sent.unplug });
    }

    /// Pulls the plug, for a time.
    pub(crate) fn unplug(&mut self, time: Duration, now: Instant) {
        self.pty.unplug();
        self.waiting.clear();
        self.waiting_bytes = 0;
        self.plug_at = Some(now + time);
    }

    /// The time of the next thing to do. None while nothing waits.
    pub(crate) fn due(&self) -> Option<Instant> {
        let next = self.waiting.front().map(|next| next.at.max(self.free_at));
        [next, self.plug_at].into_iter().flatten().min()
    }

    /// Lets the answers leave that may.
    pub(crate) fn flush(&mut self, now: Instant) -> io::Result<()> {
        if self.plug_at.is_some_and(|at| at <= now) {
            self.plug_at = None;
            self.pty.plug()?;
        }
        while self.waiting.front().is_some_and(|next| next.at.max(self.free_at) <= now) {
            let Some(mut next) = self.waiting.pop_front() else { return Ok(()) };
            if let Some(time) = next.unplug {
                self.unplug(time, now);
                return Ok(());
            }
            // A paced line takes a few characters at a time.
            let chunk = if self.baud.is_some() { next.bytes.len().min(8) } else { next.bytes.len() };
            let rest = next.bytes.split_off(chunk);
            self.waiting_bytes = self.waiting_bytes.saturating_sub(chunk);
            self.free_at = now + self.takes(chunk);
            self.pty.write(&next.bytes)?;
            if !rest.is_empty() {
                self.waiting.push_front(QueuedBytes { at: next.at, bytes: rest, unplug: None });
            }
        }
        Ok(())
    }

    /// The bytes that have come in, with the faults of the line. On a paced line they come a few at a time.
    pub(crate) fn hear(&mut self, now: Instant) -> io::Result<Vec<u8>> {
        if self.heard_until > now {
            return Ok(Vec::new());
        }
        let mut bytes = [0; 512];
        let wanted = if self.baud.is_some() { 8 } else { bytes.len() };
        let read = self.pty.read(bytes.get_mut(..wanted).unwrap_or_default())?;
        let heard = bytes.get(..read).unwrap_or_default();
        self.heard_until = now + self.takes(read);
        Ok(if self.faulty { self.faults.bytes(heard) } else { heard.to_vec() })
    }
}
