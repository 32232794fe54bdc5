//! The wish that a process ends, as a flag to look at.

use std::io;
use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::Signal;
use signal_hook::consts::{
    SIGABRT, SIGALRM, SIGBUS, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGSYS, SIGTERM, SIGTRAP, SIGTSTP,
    SIGTTIN, SIGTTOU, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
};
use signal_hook::iterator::Signals;
use signal_hook::{flag, low_level};

/// All signals that end or halt a process unless it handles them, but for those of real time, and those that can't be handled:
/// SIGKILL and SIGSTOP by anyone; SIGSEGV, SIGILL and SIGFPE by no handler that returns, for the fault would come again. Of the
/// other signals of a fault in the program itself, those that someone sends are handled. Those of a real fault still end the process:
/// `abort` does so when the handler of SIGABRT has returned, and Rust's own handler of SIGBUS, which comes first, removes itself.
const ENDING: [i32; 20] = [
    SIGINT,
    SIGTERM,
    SIGHUP,
    SIGQUIT,
    SIGTSTP,
    SIGTTIN,
    SIGTTOU,
    SIGUSR1,
    SIGUSR2,
    SIGALRM,
    SIGVTALRM,
    SIGPROF,
    SIGIO,
    SIGXCPU,
    SIGABRT,
    SIGBUS,
    SIGSYS,
    SIGTRAP,
    Signal::POWER.as_raw(),
    Signal::STKFLT.as_raw(),
];
/// The signals by which a person or another program asks a process to end.
const TO_END: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];
/// The signals of real time, which end a process as well. The C library keeps the first few to itself.
const OF_REAL_TIME: RangeInclusive<i32> = 32..=64;
/// Signals that come one after another within this time were sent together.
const HASTE: Duration = Duration::from_millis(500);

/// Raised by the first signal that asks this process to end, for those who have no [`Stop`] at hand.
static ASKED_TO_END: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

/// A flag that is raised with any [`Stop`] that listens to signals.
pub(crate) fn asked_to_end() -> Arc<AtomicBool> {
    Arc::clone(&ASKED_TO_END)
}

/// A flag that is raised when this process is asked to end. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    raised: Arc<AtomicBool>,
    /// Raised by [`Stop::cancel`], for those who share this flag alone.
    cancelled: Arc<AtomicBool>,
}

/// Work was given up because the process, or the group that the work belongs to, was asked to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("stopped before the end")]
pub struct Interrupted;

/// The system refused to handle a signal.
#[derive(Debug, thiserror::Error)]
#[error("cannot handle signals: {0}")]
pub struct SignalError(#[from] io::Error);

impl Stop {
    /// From now on SIGINT, SIGTERM and SIGHUP raise the flag: the last comes when the terminal is closed, or when the process
    /// that started this one dies. A second of these signals ends the process at once, for a person who does not want to wait, or
    /// should the work never look at the flag; not when it comes within half a second, for `timeout` and its like send two.
    ///
    /// A signal that this process was started to ignore stays ignored, as `nohup` wants it.
    ///
    /// # Errors
    /// When the system refuses to handle a signal.
    pub fn on_signals() -> Result<Self, SignalError> {
        Self::on_the_first_of(&TO_END)
    }

    /// As [`Stop::on_signals`], for every other signal too that ends a process and can be handled: for a program that must bring
    /// something to rest first. So do those that would only halt the process: SIGTSTP (Ctrl-Z), and SIGTTIN and SIGTTOU, by which a
    /// terminal halts a process in the background; and SIGABRT, by which a service manager's watchdog ends a process.
    ///
    /// # Errors
    /// When the system refuses to handle a signal.
    pub fn on_every_signal() -> Result<Self, SignalError> {
        let stop = Self::on_the_first_of(&ENDING)?;
        for signal in heeded(&OF_REAL_TIME.collect::<Vec<i32>>()) {
            match flag::register(signal, Arc::clone(&stop.raised)) {
                Err(error) if error.kind() != io::ErrorKind::InvalidInput => return Err(error.into()),
                // Refused as no signal: one that the C library keeps to itself.
                _ => {}
            }
        }
        Ok(stop)
    }

    fn on_the_first_of(signals: &[i32]) -> Result<Self, SignalError> {
        let stop = Self::on(signals)?;
        let mut signals = Signals::new(heeded(&TO_END))?;
        let wait = move || {
            let mut first: Option<Instant> = None;
            for _ in signals.forever() {
                if first.get_or_insert_with(Instant::now).elapsed() > HASTE {
                    low_level::exit(1);
                }
            }
        };
        thread::Builder::new().name("signals".to_owned()).spawn(wait)?;
        Ok(stop)
    }

    /// SIGINT, SIGTERM and SIGHUP raise the flag, and no number of them ends the process at once: for a program that must
    /// put its terminal in order first.
    ///
    /// # Errors
    /// When the system refuses to handle a signal.
    pub fn on_signals_without_haste() -> Result<Self, SignalError> {
        Self::on(&TO_END)
    }

    fn on(signals: &[i32]) -> Result<Self, SignalError> {
        let stop = Self::default();
        for signal in heeded(signals) {
            flag::register(signal, Arc::clone(&stop.raised))?;
            flag::register(signal, asked_to_end())?;
        }
        // A file that may not grow further (`ulimit -f`) shall be an error to report; the signal would end the process
        // without a word.
        flag::register(SIGXFSZ, Arc::default())?;
        Ok(stop)
    }

    /// Whether the process was asked to end.
    #[must_use]
    pub fn is_raised(&self) -> bool {
        self.raised.load(Ordering::Relaxed)
    }

    /// The flag itself, for code that looks at it while it works.
    #[must_use]
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.raised)
    }

    /// A flag that is raised together with this one, and that a group of threads can also raise for themselves alone, with
    /// [`Stop::cancel`].
    #[must_use]
    pub fn cancellable(&self) -> Self {
        Self { raised: Arc::clone(&self.raised), cancelled: Arc::default() }
    }

    /// Stops the group that shares this flag.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Nothing while the work may go on.
    ///
    /// # Errors
    /// [`Interrupted`] once the process was asked to end, or the group was cancelled.
    pub fn check(&self) -> Result<(), Interrupted> {
        if self.is_raised() || self.cancelled.load(Ordering::Relaxed) { Err(Interrupted) } else { Ok(()) }
    }
}

/// Those of `signals` that this process was not started to ignore.
fn heeded(signals: &[i32]) -> Vec<i32> {
    // Linux tells them as a hexadecimal mask, with the first signal as its lowest bit.
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let ignored = ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    signals.iter().copied().filter(|signal| ignored >> (signal - 1) & 1 == 0).collect()
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    use rustix::process::{Pid, kill_process};

    use super::*;

    #[test]
    fn a_signal_raises_the_flag_and_every_clone_sees_it() {
        let stop = Stop::on_signals().expect("signals can be handled");
        let group = stop.cancellable();
        assert_eq!((stop.check(), group.check()), (Ok(()), Ok(())));
        signal_hook::low_level::raise(SIGHUP).expect("a signal can be raised");
        assert!(stop.is_raised() && group.is_raised() && stop.flag().load(Ordering::Relaxed));
        assert_eq!(group.check(), Err(Interrupted));
    }

    #[test]
    fn every_signal_that_ends_or_halts_a_process_raises_the_flag() {
        // Twice these end the process of this test.
        for signal in ENDING.into_iter().chain(34..=64).filter(|signal| !TO_END.contains(signal)) {
            // What the process was started to ignore stays ignored.
            if heeded(&[signal]).is_empty() {
                continue;
            }
            let stop = Stop::on_every_signal().expect("signals can be handled");
            signal_hook::low_level::raise(signal).expect("a signal can be raised");
            assert!(stop.is_raised(), "signal {signal}");
        }
    }

    /// The name of a variable that makes the test below the process that is to be ended.
    const WAITS: &str = "PSCHEMA_TEST_WAITS";

    /// However many a SIGHUP came, they ended nothing, and the SIGTERM after them counted as the first.
    #[test]
    fn a_second_signal_ends_the_process_at_once_whichever_they_are() {
        if std::env::var_os(WAITS).is_some() {
            let _stop = Stop::on_signals().expect("signals can be handled");
            println!("waits");
            thread::sleep(Duration::from_secs(60));
            return;
        }
        let name = "stop::tests::a_second_signal_ends_the_process_at_once_whichever_they_are";
        for (first, second) in [(SIGHUP, SIGHUP), (SIGHUP, SIGTERM), (SIGINT, SIGHUP)] {
            if heeded(&[first, second]).len() < 2 {
                continue;
            }
            let mut process = Command::new(std::env::current_exe().expect("this test is a program"))
                .args([name, "--exact", "--nocapture"])
                .env(WAITS, "")
                .stdout(Stdio::piped())
                .spawn()
                .expect("it can be started");
            let stdout = process.stdout.take().expect("its stdout is a pipe");
            let mut lines = BufReader::new(stdout).lines();
            lines
                .find(|line| line.as_ref().is_ok_and(|line| line.ends_with("waits")))
                .expect("it waits")
                .expect("text");
            let pid = Pid::from_child(&process);
            let send = |signal| {
                let signal = Signal::from_named_raw(signal).expect("a signal");
                kill_process(pid, signal).expect("the process is there");
            };
            let begun = Instant::now();
            send(first);
            let ended = loop {
                // What comes within half a second was sent together with the first.
                thread::sleep(HASTE / 5);
                match process.try_wait().expect("it is ours") {
                    Some(ended) => break ended,
                    None => send(second),
                }
                assert!(begun.elapsed() < Duration::from_secs(20), "{first} and {second} end it");
            };
            assert_eq!(ended.code(), Some(1), "{first} and {second}");
        }
    }

    #[test]
    fn a_group_that_is_cancelled_stops_alone() {
        let stop = Stop::default();
        let (one, other) = (stop.cancellable(), stop.cancellable());
        one.cancel();
        assert_eq!((one.clone().check(), other.check(), stop.check()), (Err(Interrupted), Ok(()), Ok(())));
    }
}
