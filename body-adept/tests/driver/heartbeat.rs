//! How soon the order to stop is on the line once the heartbeat is lost.

use std::io::Read;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use pschema_adept::line::recorder::LineRecorder;
use pschema_adept::line::serial::SerialLine;
use pschema_adept::line::{Line, LineError, Stopper};
use pschema_adept::switch::StopSwitch;
use pschema_adept::v_plus::program;
use pschema_adept::watch::{Beat, Signs, Watch};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// Measured once in so many trials; `PSCHEMA_ADEPT_TRIALS` sets another number.
const TRIALS: usize = 5;
const SILENCE_MAX: Duration = Duration::from_millis(50);

/// Notes when the bytes were written.
struct StampingStopper {
    stopper: Box<dyn Stopper>,
    sent: mpsc::Sender<Instant>,
}

impl Stopper for StampingStopper {
    fn stop(&mut self, bytes: &[u8]) -> Result<(), LineError> {
        let stopped = self.stopper.stop(bytes);
        // Nobody listens any more to a repetition.
        self.sent.send(Instant::now()).ok();
        stopped
    }
}

/// The bytes are the order to stop, they come after the silence was too long and not before, and they come. How soon
/// depends on what else this machine does, so it is printed, not judged.
#[test]
fn the_order_to_stop_follows_the_lost_heartbeat() {
    let trials = std::env::var("PSCHEMA_ADEPT_TRIALS").ok().and_then(|n| n.parse().ok()).unwrap_or(TRIALS);
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let path = ptsname(&master, Vec::new()).unwrap().into_string().unwrap();
    let line = SerialLine::open(std::path::Path::new(&path), 9600).unwrap();
    let mut master = std::fs::File::from(master);
    let mut late_ms: Vec<f64> = Vec::new();
    for _ in 0..trials {
        let switch = StopSwitch::default();
        let (sender, sent) = mpsc::channel();
        switch.connect(
            Box::new(StampingStopper { stopper: line.stopper().unwrap(), sent: sender }),
            program::STOP,
            LineRecorder::default(),
        );
        let daemon = Beat::default();
        let signs = Signs {
            driver: Beat::default(),
            daemon: Some(daemon.clone()),
            stop: Arc::new(AtomicBool::new(false)),
            silence_max: SILENCE_MAX,
        };
        let watch = Watch::begin(signs, switch).unwrap();
        daemon.renew();
        let last_beat = Instant::now();
        let motion = watch.motion();
        let mut bytes = vec![0; program::STOP.len()];
        master.read_exact(&mut bytes).unwrap();
        // Stamped when the bytes were on the line, not when this busy test got to read them.
        let waited = sent.recv().unwrap() - last_beat;
        drop(motion);
        assert_eq!(bytes, program::STOP);
        assert!(waited >= SILENCE_MAX, "{waited:?} after the last beat");
        late_ms.push((waited - SILENCE_MAX).as_secs_f64() * 1e3);
        drop(watch);
    }
    late_ms.sort_by(f64::total_cmp);
    let (median, late, worst) = (late_ms[trials / 2], late_ms[trials * 99 / 100], late_ms[trials - 1]);
    println!(
        "after the limit: median {median:.2} ms, 99 % within {late:.2} ms, worst {worst:.2} ms of {trials}"
    );
}
