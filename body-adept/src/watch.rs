//! The watch over motions, on a thread of its own: when the daemon or the driver falls silent while the arm moves, or
//! the process is told to end, it presses the [switch](crate::switch). It parses nothing and waits for nobody.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use pschema_process::Worker;

use crate::switch::{StopCause, StopSwitch};

/// Longest time between two looks while the arm moves.
const LOOK_EVERY: Duration = Duration::from_millis(4);
/// Shortest time between two looks.
const LOOK_AGAIN: Duration = Duration::from_micros(200);
/// Time between two looks whether there is something to watch over.
const REST: Duration = Duration::from_secs(1);
/// Time between two orders to stop, for an arm whose driver is silent.
const REPEAT_EVERY: Duration = Duration::from_millis(100);
/// The kinds of guards: the remainder of a guard's number when it is divided by four. Numbers of guards count up in
/// fours, so that no guard is taken for the one before.
const NOTHING: u64 = 0;
const COMMAND: u64 = 1;
const MOTION: u64 = 2;
const KINDS: u64 = 4;

/// The time of the last sign of life. The thread that lives renews it; clones are the same sign.
#[derive(Clone, Debug)]
pub struct Beat(Arc<(Instant, AtomicU64)>);

impl Default for Beat {
    fn default() -> Self {
        Self(Arc::new((Instant::now(), AtomicU64::new(0))))
    }
}

impl Beat {
    /// Gives a sign of life now.
    pub fn renew(&self) {
        self.0.1.store(self.micros(), Ordering::SeqCst);
    }

    /// Time since the last sign of life.
    #[must_use]
    pub fn age(&self) -> Duration {
        Duration::from_micros(self.micros().saturating_sub(self.0.1.load(Ordering::SeqCst)))
    }

    fn micros(&self) -> u64 {
        u64::try_from(self.0.0.elapsed().as_micros()).unwrap_or(u64::MAX)
    }
}

/// The signs of life without which the arm is stopped.
#[derive(Clone, Debug)]
pub struct Signs {
    /// That of the loop that follows a motion.
    pub driver: Beat,
    /// That of the daemon. None when no daemon orders the motions.
    pub daemon: Option<Beat>,
    /// The flag that is set when the process is to end.
    pub stop: Arc<AtomicBool>,
    /// Longest silence.
    pub silence_max: Duration,
}

/// The watch.
#[derive(Debug)]
pub struct Watch {
    signs: Signs,
    watching: Arc<AtomicU64>,
    thread: Worker,
}

impl Watch {
    /// Begins to watch, with nothing moving.
    ///
    /// # Errors
    /// When no thread can be started.
    pub fn begin(signs: Signs, switch: StopSwitch) -> std::io::Result<Self> {
        let watching = Arc::new(AtomicU64::new(NOTHING));
        let (watched, over) = (signs.clone(), watching.clone());
        let thread = Worker::start("watch", move |stop| {
            if let Err(error) = crate::priority::be_on_time() {
                tracing::debug!(%error, "the watch has no higher priority than the rest");
            }
            while !stop.load(Ordering::SeqCst) {
                let guard = over.load(Ordering::SeqCst);
                if guard % KINDS == NOTHING {
                    std::thread::park_timeout(REST);
                } else {
                    watch(&watched, &over, guard, &switch);
                }
            }
        })?;
        Ok(Self { signs, watching, thread })
    }

    /// The signs of life that it watches.
    #[must_use]
    pub fn signs(&self) -> &Signs {
        &self.signs
    }

    /// Watches over a motion from now on, until the returned guard is dropped.
    #[must_use]
    pub fn motion(&self) -> WatchGuard {
        self.guard(MOTION)
    }

    /// Watches over a long command of an operator, until the returned guard is dropped. No daemon ordered it, and the
    /// driver waits for it, so that only the end of the process stops it.
    #[must_use]
    pub fn command(&self) -> WatchGuard {
        self.guard(COMMAND)
    }

    fn guard(&self, kind: u64) -> WatchGuard {
        self.signs.driver.renew();
        let before = self.watching.load(Ordering::SeqCst);
        self.watching.store(before / KINDS * KINDS + KINDS + kind, Ordering::SeqCst);
        self.thread.wake();
        WatchGuard(self.watching.clone())
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        // The thread, which ends when it is dropped after this, has nothing to watch over any more.
        drop(WatchGuard(self.watching.clone()));
    }
}

/// Keeps the watch over one motion or command, until it is dropped. There is one guard at a time.
#[derive(Debug)]
pub struct WatchGuard(Arc<AtomicU64>);

impl Drop for WatchGuard {
    fn drop(&mut self) {
        let guard = self.0.load(Ordering::SeqCst);
        self.0.store(guard / KINDS * KINDS + NOTHING, Ordering::SeqCst);
    }
}

/// Watches over the motion or command of one guard.
fn watch(signs: &Signs, watching: &AtomicU64, guard: u64, switch: &StopSwitch) {
    let mut sent: Option<Instant> = None;
    while watching.load(Ordering::SeqCst) == guard {
        let by = if guard % KINDS == COMMAND { ended(signs) } else { silent(signs) };
        if let Some(by) = by {
            // A driver that lives repeats the order itself, at times that do not cut short its question whether the arm
            // stands.
            let due = |sent: Instant| sent.elapsed() >= REPEAT_EVERY && signs.driver.age() >= REPEAT_EVERY;
            if sent.is_none_or(due) {
                switch.press(by);
                sent = Some(Instant::now());
            }
        } else {
            sent = None;
        }
        std::thread::sleep(next_look(signs));
    }
}

/// Time to the next look: until the first sign of life would be too old, but not long, as the process may be told to
/// end.
fn next_look(signs: &Signs) -> Duration {
    let left = |beat: &Beat| signs.silence_max.saturating_sub(beat.age());
    let left = signs.daemon.as_ref().map_or(Duration::MAX, left).min(left(&signs.driver));
    left.clamp(LOOK_AGAIN, LOOK_EVERY)
}

fn ended(signs: &Signs) -> Option<StopCause> {
    signs.stop.load(Ordering::SeqCst).then_some(StopCause::Asked)
}

fn silent(signs: &Signs) -> Option<StopCause> {
    let ended = ended(signs);
    if ended.is_some() {
        ended
    } else if signs.daemon.as_ref().is_some_and(|daemon| daemon.age() > signs.silence_max) {
        Some(StopCause::DaemonSilent)
    } else if signs.driver.age() > signs.silence_max {
        Some(StopCause::DriverSilent)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use super::*;
    use crate::line::recorder::LineRecorder;
    use crate::line::{LineError, Stopper};

    struct Wire(mpsc::Sender<Instant>);

    impl Stopper for Wire {
        fn stop(&mut self, _: &[u8]) -> Result<(), LineError> {
            // A test that has seen enough is gone by now.
            self.0.send(Instant::now()).ok();
            Ok(())
        }
    }

    fn watched(daemon: bool, silence_max: Duration) -> (Watch, StopSwitch, mpsc::Receiver<Instant>) {
        let (switch, (sender, wire)) = (StopSwitch::default(), mpsc::channel());
        switch.connect(Box::new(Wire(sender)), b"STOP\n", LineRecorder::default());
        let signs = Signs {
            driver: Beat::default(),
            daemon: daemon.then(Beat::default),
            stop: Arc::new(AtomicBool::new(false)),
            silence_max,
        };
        (Watch::begin(signs, switch.clone()).unwrap(), switch, wire)
    }

    #[test]
    fn a_silent_daemon_stops_a_motion_and_nothing_is_done_without_one() {
        let (watch, switch, wire) = watched(true, Duration::from_millis(60));
        let daemon = watch.signs().daemon.clone().unwrap();
        while daemon.age() < Duration::from_millis(80) {
            std::thread::yield_now();
        }
        assert!(!switch.is_pressed(), "nothing moves, so nothing is stopped");
        daemon.renew();
        let _motion = watch.motion();
        let silent_from = Instant::now();
        let sent = loop {
            watch.signs().driver.renew();
            if let Ok(sent) = wire.try_recv() {
                break sent;
            }
            assert!(silent_from.elapsed() < Duration::from_secs(10), "never stopped");
        };
        assert_eq!(switch.pressed_by(), Some(StopCause::DaemonSilent));
        assert!(sent - silent_from >= Duration::from_millis(50), "not before its time");
    }

    #[test]
    fn a_driver_that_is_stuck_and_a_process_told_to_end_stop_it_again_and_again() {
        let (watch, switch, wire) = watched(false, Duration::from_millis(40));
        let motion = watch.motion();
        assert!(wire.recv_timeout(Duration::from_secs(10)).is_ok());
        assert!(wire.recv_timeout(Duration::from_secs(10)).is_ok(), "repeated while nobody attends");
        assert_eq!(switch.pressed_by(), Some(StopCause::DriverSilent));
        drop(motion);
        let (watch, switch, wire) = watched(false, Duration::from_secs(3600));
        let _motion = watch.motion();
        watch.signs().stop.store(true, Ordering::SeqCst);
        assert!(wire.recv_timeout(Duration::from_secs(10)).is_ok());
        assert_eq!(switch.pressed_by(), Some(StopCause::Asked));
    }

    #[test]
    fn a_command_is_stopped_by_the_end_of_the_process_alone() {
        let (watch, switch, wire) = watched(true, Duration::from_millis(20));
        let command = watch.command();
        while watch.signs().driver.age() < Duration::from_millis(60) {
            std::thread::yield_now();
        }
        assert!(!switch.is_pressed(), "no daemon ordered it, and it takes its time");
        watch.signs().stop.store(true, Ordering::SeqCst);
        assert!(wire.recv_timeout(Duration::from_secs(10)).is_ok());
        assert_eq!(switch.pressed_by(), Some(StopCause::Asked));
        drop(command);
    }

    /// A stop that was sent for one motion is none for the next, however soon that follows.
    #[test]
    fn each_motion_is_stopped_anew_and_a_driver_that_lives_is_left_to_its_own_questions() {
        let (watch, switch, wire) = watched(false, Duration::from_secs(3600));
        watch.signs().stop.store(true, Ordering::SeqCst);
        for _ in 0..3 {
            switch.release();
            let _motion = watch.motion();
            let begun = Instant::now();
            while !switch.is_pressed() {
                watch.signs().driver.renew();
                assert!(begun.elapsed() < Duration::from_secs(10), "never stopped");
            }
            assert!(wire.recv_timeout(Duration::from_secs(10)).is_ok());
        }
        let _motion = watch.motion();
        assert!(wire.recv_timeout(Duration::from_secs(10)).is_ok());
        let sent = Instant::now();
        while sent.elapsed() < 3 * REPEAT_EVERY {
            watch.signs().driver.renew();
        }
        assert!(wire.try_recv().is_err(), "the driver lives, and was not disturbed");
        assert!(wire.recv_timeout(Duration::from_secs(10)).is_ok(), "it died, and the arm was stopped again");
    }
}
