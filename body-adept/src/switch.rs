//! The switch that stops the arm. Any thread can press it at any time, it needs no answer, and it lets no order to move
//! pass until a new motion is begun on purpose.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::{Duration, Instant};

use crate::line::recorder::LineRecorder;
use crate::line::{LineError, Stopper};

/// Longest time that pressing waits for an order that is just being written.
const ORDER_WAIT: Duration = Duration::from_millis(5);

/// The cause why the switch was pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopCause {
    /// The daemon was silent for too long.
    DaemonSilent,
    /// This process's own loop was silent for too long.
    DriverSilent,
    /// The process was told to end.
    Asked,
    /// The motion took too long.
    OutOfTime,
    /// The arm was measured beyond its limits.
    OutOfPlace,
    /// Any other trouble in the driver.
    Trouble,
}

impl fmt::Display for StopCause {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(match self {
            Self::DaemonSilent => "the daemon is silent",
            Self::DriverSilent => "the driver is stuck",
            Self::Asked => "the body was told to end",
            Self::OutOfTime => "the motion took too long",
            Self::OutOfPlace => "the arm was measured beyond its limits",
            Self::Trouble => "the driver is in trouble",
        })
    }
}

/// A way to the arm, the bytes that stop the arm there, and the recorder of what is sent.
struct Wire {
    stopper: Box<dyn Stopper>,
    bytes: &'static [u8],
    recorder: LineRecorder,
}

struct Shared {
    pressed: AtomicBool,
    by: Mutex<Option<StopCause>>,
    /// Held while an order to move is written.
    orders: Mutex<()>,
    wire: Mutex<Option<Wire>>,
}

/// The switch. Clones are the same switch.
#[derive(Clone)]
pub struct StopSwitch(Arc<Shared>);

impl fmt::Debug for StopSwitch {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.debug_struct("StopSwitch").field("pressed", &self.is_pressed()).finish_non_exhaustive()
    }
}

impl Default for StopSwitch {
    fn default() -> Self {
        Self(Arc::new(Shared {
            pressed: AtomicBool::new(false),
            by: Mutex::new(None),
            orders: Mutex::new(()),
            wire: Mutex::new(None),
        }))
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // The values behind these locks are whole, whatever a thread that panicked was doing.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl StopSwitch {
    /// Connects the switch to a line, on which `bytes` stop the arm. `recorder` records that they were sent.
    pub fn connect(&self, stopper: Box<dyn Stopper>, bytes: &'static [u8], recorder: LineRecorder) {
        *locked(&self.0.wire) = Some(Wire { stopper, bytes, recorder });
    }

    /// Lets go of the line, so that it can be opened again.
    pub fn disconnect(&self) {
        *locked(&self.0.wire) = None;
    }

    /// Stops the arm now. No order to move passes any more until [`Self::release`].
    pub fn press(&self, by: StopCause) {
        // The flag comes first, so that no order is begun after it. Then an order that is being written may end.
        self.0.pressed.store(true, Ordering::SeqCst);
        let since = Instant::now();
        let first = {
            let mut pressed = locked(&self.0.by);
            let first = pressed.is_none();
            pressed.get_or_insert(by);
            first
        };
        let order = loop {
            match self.0.orders.try_lock() {
                Ok(guard) => break Some(guard),
                Err(TryLockError::Poisoned(poisoned)) => break Some(poisoned.into_inner()),
                // An order that is stuck on its way is overtaken.
                Err(TryLockError::WouldBlock) if since.elapsed() > ORDER_WAIT => break None,
                Err(TryLockError::WouldBlock) => std::thread::sleep(Duration::from_micros(200)),
            }
        };
        let sent = self.send_unrecorded();
        drop(order);
        record(sent);
        if first {
            tracing::warn!(%by, "stop");
        }
    }

    /// Sends the bytes that stop the arm once more.
    pub fn send(&self) {
        record(self.send_unrecorded());
    }

    /// Sends the bytes that stop the arm. Returns them with their recorder, to be recorded when no lock is held any
    /// more: a disk that is slow or full may delay no stop, and no repetition of one.
    fn send_unrecorded(&self) -> Option<(LineRecorder, &'static [u8])> {
        let mut wire = locked(&self.0.wire);
        let Wire { stopper, bytes, recorder } = wire.as_mut()?;
        if let Err(error) = stopper.stop(bytes) {
            tracing::error!(%error, "the order to stop could not be sent: press the emergency stop");
        }
        Some((recorder.clone(), bytes))
    }

    /// Whether the switch is pressed.
    #[must_use]
    pub fn is_pressed(&self) -> bool {
        self.0.pressed.load(Ordering::SeqCst)
    }

    /// The cause why it was pressed first. None while it is not pressed.
    #[must_use]
    pub fn pressed_by(&self) -> Option<StopCause> {
        *locked(&self.0.by)
    }

    /// Lets orders pass again, at the beginning of a new motion. An old motion is never resumed.
    pub fn release(&self) {
        *locked(&self.0.by) = None;
        self.0.pressed.store(false, Ordering::SeqCst);
    }

    /// Writes an order to move, unless the switch is pressed. `write` is not called then.
    ///
    /// # Errors
    /// None when the switch was pressed before or meanwhile, otherwise the error of `write`.
    pub fn order(&self, write: impl FnOnce() -> Result<(), LineError>) -> Result<(), Option<LineError>> {
        let order = locked(&self.0.orders);
        if self.is_pressed() {
            return Err(None);
        }
        let written = write();
        drop(order);
        if self.is_pressed() {
            // The stop may have overtaken this order. It is sent once more, to come after the order.
            self.send();
            return Err(None);
        }
        written.map_err(Some)
    }
}

fn record(sent: Option<(LineRecorder, &'static [u8])>) {
    if let Some((recorder, bytes)) = sent {
        recorder.stopped(bytes);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;

    struct SentStops(mpsc::Sender<Vec<u8>>);

    impl Stopper for SentStops {
        fn stop(&mut self, bytes: &[u8]) -> Result<(), LineError> {
            self.0.send(bytes.to_vec()).unwrap();
            Ok(())
        }
    }

    fn switch() -> (StopSwitch, mpsc::Receiver<Vec<u8>>) {
        let (switch, (sender, receiver)) = (StopSwitch::default(), mpsc::channel());
        switch.connect(Box::new(SentStops(sender)), b"STOP\n", LineRecorder::default());
        (switch, receiver)
    }

    #[test]
    fn no_order_passes_a_pressed_switch() {
        let (switch, wire) = switch();
        assert!(switch.order(|| Ok(())).is_ok());
        switch.press(StopCause::Asked);
        switch.press(StopCause::DaemonSilent);
        assert_eq!(wire.try_iter().count(), 2, "every press sends");
        assert_eq!(switch.pressed_by(), Some(StopCause::Asked), "the first counts");
        assert!(matches!(switch.order(|| unreachable!("written")), Err(None)));
        switch.release();
        assert!(switch.order(|| Ok(())).is_ok() && switch.pressed_by().is_none());
    }

    /// An order that is just being written ends before the order to stop; one that is stuck does not delay it.
    #[test]
    fn stop_comes_after_an_order_under_way_and_overtakes_one_that_is_stuck() {
        let (switch, wire) = switch();
        let (begun, has_begun) = mpsc::channel();
        let (go_on, may_go_on) = mpsc::channel::<()>();
        let stuck = switch.clone();
        let writer = std::thread::spawn(move || {
            stuck.order(|| {
                begun.send(()).unwrap();
                may_go_on.recv().unwrap();
                Ok(())
            })
        });
        has_begun.recv().unwrap();
        switch.press(StopCause::DriverSilent);
        assert_eq!(wire.recv().unwrap(), b"STOP\n", "sent although the order hangs");
        go_on.send(()).unwrap();
        assert!(matches!(writer.join().unwrap(), Err(None)));
        assert_eq!(wire.recv().unwrap(), b"STOP\n", "and once more, behind the order that it overtook");
        assert!(matches!(switch.order(|| Ok(())), Err(None)), "and nothing follows it");
    }

    #[test]
    fn without_a_line_it_is_pressed_all_the_same() {
        let switch = StopSwitch::default();
        switch.press(StopCause::OutOfTime);
        assert!(switch.is_pressed());
    }

    /// A recording hangs, as on a disk that is full or gone.
    #[test]
    fn a_recording_that_hangs_delays_no_stop() {
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("recording");
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0)
            .unwrap();
        // A pipe that nobody empties takes 64 KiB, and then no more.
        let reader = std::fs::OpenOptions::new().read(true).write(true).open(&pipe).unwrap();
        let recorder = LineRecorder::create(&pipe).unwrap();
        let (sender, wire) = mpsc::channel();
        let switch = StopSwitch::default();
        switch.connect(Box::new(SentStops(sender)), b"STOP\n", recorder.clone());
        let full = std::thread::spawn(move || recorder.event("order", &"x".repeat(1 << 20)));
        let pressed = switch.clone();
        let first = std::thread::spawn(move || pressed.press(StopCause::Asked));
        assert_eq!(wire.recv_timeout(Duration::from_secs(60)).unwrap(), b"STOP\n");
        let pressed = switch.clone();
        let second = std::thread::spawn(move || pressed.press(StopCause::Asked));
        assert_eq!(wire.recv_timeout(Duration::from_secs(60)).unwrap(), b"STOP\n", "also the next one");
        // Emptied, all of them end.
        let emptied = std::thread::spawn(move || {
            let mut reader = reader;
            let mut bytes = [0; 4096];
            let mut read = 0;
            while read < 1 << 20 {
                read += std::io::Read::read(&mut reader, &mut bytes).unwrap();
            }
            reader
        });
        let reader = emptied.join().unwrap();
        for thread in [full, first, second] {
            thread.join().unwrap();
        }
        drop(reader);
    }
}
