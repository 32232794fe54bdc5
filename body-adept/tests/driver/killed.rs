//! The body's process ends in the middle of a motion: told to, or killed.

use std::process::{Child, Command, Stdio};

use pschema_adept::config::EMULATED;
use pschema_vplus_emulator::{Dialect, EmulatorArgs, EmulatorRecord};
use rustix::process::{Pid, Signal, kill_process};

use crate::rig::{Rig, until};

/// Longer than a busy machine keeps a process from its watchdog.
const WATCHDOG_MS: u64 = 2_000;

/// What ends a process: told by a person, by a system that shuts down or loses its power, by a terminal that is closed, or by a
/// service manager's watchdog (SIGABRT); and the signals of faults, as far as they can be handled when someone sends them. The
/// last two only halt others (Ctrl-Z, and a terminal that is read in the background), and would leave nobody at the arm.
const ENDING: [Signal; 11] = [
    Signal::TERM,
    Signal::INT,
    Signal::HUP,
    Signal::QUIT,
    Signal::POWER,
    Signal::ABORT,
    Signal::TRAP,
    Signal::SYS,
    Signal::BUS,
    Signal::TSTP,
    Signal::TTIN,
];

/// A signal of real time: the last one, which is the same for every C library.
const OF_REAL_TIME: &str = "64";

/// Ends its process, should a test end before that.
struct Process(Child);

impl Process {
    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.0), signal).unwrap();
    }

    /// Sends a signal that has a number alone.
    fn signal_by_number(&self, number: &str) {
        let sent = Command::new("kill").args([&format!("-{number}"), &self.0.id().to_string()]).status();
        assert!(sent.unwrap().success());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It has usually ended by now.
        self.0.kill().ok();
        self.0.wait().unwrap();
    }
}

/// A body that moves the arm by itself: it calibrates its camera. Returns once the record says so.
fn calibrating(
    when: impl Fn(&EmulatorRecord) -> bool,
    change: impl FnOnce(&mut EmulatorArgs),
) -> (Rig, Process) {
    calibrating_in(Dialect::Program, when, change)
}

fn calibrating_in(
    dialect: Dialect,
    when: impl Fn(&EmulatorRecord) -> bool,
    change: impl FnOnce(&mut EmulatorArgs),
) -> (Rig, Process) {
    let rig = Rig::start(dialect, |args| {
        args.fast = 1.0;
        change(args);
    });
    let file = rig.directory.path().join("arm.toml");
    let text = match dialect {
        Dialect::Monitor => EMULATED.replace("mode = \"server\"", "mode = \"monitor\""),
        _ => EMULATED.to_owned(),
    };
    std::fs::write(&file, text).unwrap();
    // A signal that is ignored here, as under `nohup`, would be ignored there too.
    let child = Command::new("env")
        .args(["--default-signal", env!("CARGO_BIN_EXE_pschema-adept")])
        .args([
            "--port",
            rig.args.link.to_str().unwrap(),
            "--arm",
            file.to_str().unwrap(),
            "--enable",
            "--home",
        ])
        .args(["--camera", &format!("socket:{}", rig.args.camera.as_ref().unwrap().display())])
        .arg("calibrate")
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let process = Process(child);
    until("it is time", || when(&rig.emulator.record()));
    (rig, process)
}

fn moves(record: &EmulatorRecord) -> bool {
    record.motions > 0
}

/// Brought into its home position, an arm moves in ways that no limits here hold.
fn homes(record: &EmulatorRecord) -> bool {
    record.calibrations_begun > 0
}

#[test]
fn a_process_that_is_killed_while_it_homes_the_arm_leaves_it_to_the_watchdog() {
    let (rig, process) = calibrating(homes, |args| args.watchdog_ms = WATCHDOG_MS);
    process.signal(Signal::KILL);
    until("the watchdog stops the arm", || rig.emulator.record().watchdog_stops > 0);
    let record = rig.emulator.record();
    assert_eq!((record.calibrations, record.powered, record.motions), (0, false, 0));
}

#[test]
fn a_process_told_to_end_while_it_homes_the_arm_stops_it_and_takes_its_power_away() {
    for signal in [Some(Signal::TERM), Some(Signal::HUP), Some(Signal::TTOU), None] {
        let (rig, mut process) = calibrating(homes, |_| {});
        match signal {
            Some(signal) => process.signal(signal),
            None => process.signal_by_number(OF_REAL_TIME),
        }
        assert!(!process.0.wait().unwrap().success(), "it did not calibrate");
        let record = rig.emulator.record();
        assert_eq!((record.calibrations, record.powered, record.motions), (0, false, 0));
    }
}

#[test]
fn a_killed_process_leaves_the_arm_to_the_watchdog() {
    let (rig, process) = calibrating(moves, |args| args.watchdog_ms = WATCHDOG_MS);
    process.signal(Signal::KILL);
    until("the watchdog stops the arm", || rig.emulator.record().watchdog_stops > 0);
    assert_eq!(rig.emulator.record().motions, 1);
}

#[test]
fn a_process_told_to_end_stops_the_arm_and_takes_its_power_away() {
    let by_program = ENDING.map(|signal| (Dialect::Program, signal));
    for (dialect, signal) in
        by_program.into_iter().chain([Signal::HUP, Signal::ABORT].map(|signal| (Dialect::Monitor, signal)))
    {
        let (rig, mut process) = calibrating_in(dialect, moves, |_| {});
        process.signal(signal);
        let ended = process.0.wait().unwrap();
        assert!(!ended.success(), "{dialect:?}, {signal:?}: it did not calibrate");
        let record = rig.emulator.record();
        assert!(
            record.stops > 0 && record.motions == 1,
            "{dialect:?}, {signal:?}: {} {}",
            record.stops,
            record.motions
        );
        if dialect == Dialect::Program {
            // Nobody may have it without enabling it anew.
            let mut arm = rig.arm(&crate::rig::setup(&[]), Default::default(), false);
            arm.connect().unwrap();
            assert_eq!(*arm.phase(), pschema_adept::arm::Phase::Inactive);
        } else {
            assert!(!record.powered, "{signal:?}: power stayed on");
        }
    }
}
