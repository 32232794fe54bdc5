//! An arm on an emulated controller.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use pschema_adept::arm::{Arm, Permissions};
use pschema_adept::arm_on;
use pschema_adept::config::{ArmSetup, EMULATED};
use pschema_adept::line::record::RecordingLine;
use pschema_adept::line::recorder::LineRecorder;
use pschema_adept::line::serial::SerialLine;
use pschema_adept::watch::Beat;
use pschema_arm::JointPositions;
use pschema_vplus_emulator::{Dialect, Emulator, EmulatorArgs};

/// Longest wait for anything in these tests.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// The change that makes it the arm on a monitor.
pub(crate) const MONITOR: &[(&str, &str)] = &[("mode = \"server\"", "mode = \"monitor\"")];

pub(crate) fn at(j1: f64, j2: f64) -> JointPositions {
    JointPositions { j1, j2 }
}

/// The emulated arm as shipped, with one thing replaced by another.
pub(crate) fn setup(changes: &[(&str, &str)]) -> Arc<ArmSetup> {
    let mut text = EMULATED.to_owned();
    for (from, to) in changes {
        assert!(text.contains(from), "the shipped arm file has no {from:?} any more");
        text = text.replacen(from, to, 1);
    }
    Arc::new(ArmSetup::parse("test", &text).unwrap())
}

pub(crate) struct Rig {
    pub(crate) emulator: Emulator,
    pub(crate) args: EmulatorArgs,
    pub(crate) daemon: Beat,
    pub(crate) stop: Arc<AtomicBool>,
    pub(crate) directory: tempfile::TempDir,
}

impl Rig {
    /// An emulated controller, changed as `change` does.
    pub(crate) fn start(speaks: Dialect, change: impl FnOnce(&mut EmulatorArgs)) -> Self {
        let filter = tracing_subscriber::EnvFilter::from_default_env();
        // Another test of this process may have done it.
        drop(tracing_subscriber::fmt().with_env_filter(filter).with_test_writer().try_init());
        let directory = tempfile::Builder::new().prefix("adept").tempdir_in("/tmp").unwrap();
        let mut args = EmulatorArgs::at(&directory.path().join("line"));
        args.speaks = speaks;
        args.operator = Some(directory.path().join("operator"));
        args.camera = Some(directory.path().join("camera"));
        args.fast = 200.0;
        args.watchdog_ms = 60_000;
        change(&mut args);
        let emulator = Emulator::start(args.clone()).unwrap();
        Self { emulator, args, daemon: Beat::default(), stop: Arc::default(), directory }
    }

    pub(crate) fn recording(&self) -> PathBuf {
        self.directory.path().join("recording")
    }

    /// An arm on its line; with `daemon`, one that depends on a daemon's sign of life.
    pub(crate) fn arm(&self, setup: &Arc<ArmSetup>, recorder: LineRecorder, daemon: bool) -> Arm {
        let (link, baud) = (self.args.link.clone(), setup.file.line.baud.count() as u32);
        let lines = recorder.clone();
        let open = Box::new(move || {
            let line = SerialLine::open(&link, baud)?;
            Ok(Box::new(RecordingLine::new(Box::new(line), lines.clone()))
                as Box<dyn pschema_adept::line::Line>)
        });
        let may = Permissions { moves: true, home: true };
        let daemon = daemon.then(|| self.daemon.clone());
        arm_on(setup, open, recorder, may, self.stop.clone(), daemon).unwrap()
    }

    /// An arm that is enabled.
    pub(crate) fn enabled(&self, setup: &Arc<ArmSetup>) -> Arm {
        let mut arm = self.arm(setup, LineRecorder::default(), false);
        until("the arm is enabled", || arm.enable().is_ok());
        arm
    }

    /// Does what a person in the room would do.
    pub(crate) fn person(&self, line: &str) -> String {
        let mut stream = UnixStream::connect(self.args.operator.as_ref().unwrap()).unwrap();
        stream.write_all(format!("{line}\n").as_bytes()).unwrap();
        let mut answer = String::new();
        BufReader::new(stream).read_line(&mut answer).unwrap();
        answer.trim().to_owned()
    }
}

/// Waits until something is so.
pub(crate) fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < PATIENCE, "waited in vain until {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
