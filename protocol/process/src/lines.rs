//! The lines of a log on their way to stderr.
//!
//! Who logs never waits for who reads: a terminal that is held (Ctrl-S) or a pipe that nobody empties blocks a write to
//! stderr for as long as it likes. A thread of its own writes; the lines that find no room meanwhile are lost and counted.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;

use tracing_subscriber::Layer;

/// How many bytes of lines may wait. Some thousand lines of the usual length.
const WAITING_BYTES_MAX: usize = 1 << 20;
/// How long a flush waits at most.
const FLUSH_MAX: Duration = Duration::from_secs(1);

/// The lines that wait, shared by those who log and the thread that writes.
#[derive(Clone, Debug)]
pub(crate) struct Lines {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    lines: VecDeque<Vec<u8>>,
    bytes: usize,
    /// Lines lost so far.
    lost: u64,
    /// Whether the thread is writing lines that it has taken from here.
    is_writing: bool,
    /// Whether a flush was in vain, and the thread has not come on since.
    is_stuck: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Lines {
    /// Starts the thread that writes to `out`. `on_loss` is told how many lines were lost each time after the thread could write
    /// again.
    pub(crate) fn to(
        mut out: impl Write + Send + 'static,
        on_loss: impl Fn(u64) + Send + 'static,
    ) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let lines = Self { shared: Arc::clone(&shared) };
        thread::Builder::new().name("log".to_owned()).spawn(move || {
            let mut told = 0;
            loop {
                let (taken, lost) = {
                    let waiting =
                        shared.changed.wait_while(shared.lock(), |waiting| waiting.lines.is_empty());
                    let mut waiting = waiting.unwrap_or_else(PoisonError::into_inner);
                    (waiting.is_writing, waiting.bytes) = (true, 0);
                    (std::mem::take(&mut waiting.lines), waiting.lost)
                };
                for line in taken {
                    // When the other end of the pipe has died there is nobody to tell.
                    drop(out.write_all(&line));
                }
                {
                    let mut waiting = shared.lock();
                    (waiting.is_writing, waiting.is_stuck) = (false, false);
                }
                shared.changed.notify_all();
                if lost > told {
                    on_loss(lost - told);
                    told = lost;
                }
            }
        })?;
        Ok(lines)
    }

    /// How many lines were lost so far.
    pub(crate) fn lost(&self) -> u64 {
        self.shared.lock().lost
    }

    /// Waits until the lines logged so far are written, for a second at most.
    pub(crate) fn flush(&self) {
        let is_busy = |waiting: &mut Waiting| waiting.is_writing || !waiting.lines.is_empty();
        let waited = self.shared.changed.wait_timeout_while(self.shared.lock(), FLUSH_MAX, is_busy);
        let (mut waiting, time) = waited.unwrap_or_else(PoisonError::into_inner);
        waiting.is_stuck |= time.timed_out();
    }

    /// Has a line written and waits for it, as [`Lines::flush`] does; not again and again while nobody reads.
    pub(crate) fn say(&self, line: &[u8]) {
        self.take(line);
        if !self.shared.lock().is_stuck {
            self.flush();
        }
    }

    /// Takes a whole line, or loses it whole.
    fn take(&self, line: &[u8]) {
        let mut waiting = self.shared.lock();
        if waiting.bytes + line.len() > WAITING_BYTES_MAX {
            waiting.lost += 1;
        } else {
            waiting.bytes += line.len();
            waiting.lines.push_back(line.to_owned());
            drop(waiting);
            self.shared.changed.notify_all();
        }
    }
}

impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        self.take(line);
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A layer of the log that does nothing with events: by it the process finds its lines again.
impl<S: tracing::Subscriber> Layer<S> for Lines {}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;
    use std::time::Instant;

    use super::*;

    /// A reader that reads nothing before it is told to.
    struct Held {
        go_on: mpsc::Receiver<()>,
        written: mpsc::Sender<Vec<u8>>,
    }

    impl Write for Held {
        fn write(&mut self, line: &[u8]) -> io::Result<usize> {
            self.go_on.recv().ok();
            self.written.send(line.to_owned()).ok();
            Ok(line.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    /// Each line that was said waited for the reader.
    #[test]
    fn who_says_something_waits_for_the_reader_once() {
        let (go_on, held) = mpsc::channel();
        let (written, lines_written) = mpsc::channel();
        let lines = Lines::to(Held { go_on: held, written }, |_| {}).unwrap();
        let began = Instant::now();
        (0..100).for_each(|_| lines.say(b"said\n"));
        assert!((FLUSH_MAX..50 * FLUSH_MAX).contains(&began.elapsed()), "{:?}", began.elapsed());
        drop(go_on);
        lines.flush();
        lines.say(b"again\n");
        assert_eq!(lines_written.try_iter().last().as_deref(), Some(&b"again\n"[..]));
    }

    #[test]
    fn who_logs_does_not_wait_for_who_reads_and_lost_lines_are_counted() {
        let (go_on, held) = mpsc::channel();
        let (written, lines_written) = mpsc::channel();
        let (tell, told) = mpsc::channel();
        let mut lines =
            Lines::to(Held { go_on: held, written }, move |lost| tell.send(lost).unwrap()).unwrap();
        let long = vec![b'x'; WAITING_BYTES_MAX / 8];
        for _ in 0..100 {
            lines.write_all(&long).unwrap();
        }
        // The thread holds one batch, which it took before there was more, and one megabyte waits.
        let lost = lines.lost();
        assert!((84..=92).contains(&lost), "{lost}");
        drop(go_on);
        lines.flush();
        assert_eq!(
            lines_written.iter().take(usize::try_from(100 - lost).unwrap()).map(|line| line.len()).max(),
            Some(long.len())
        );
        assert_eq!(told.recv(), Ok(lost));
        lines.write_all(b"again\n").unwrap();
        lines.flush();
        assert_eq!(lines_written.recv().unwrap(), b"again\n");
        assert_eq!(lines.lost(), lost);
    }
}
