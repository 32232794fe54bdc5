//! Power coming up and the calibration of the arm: an operator's long commands, in which it may move by itself.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use pschema_adept::arm::{Arm, Permissions, Phase};
use pschema_adept::arm_on;
use pschema_adept::line::record::RecordingLine;
use pschema_adept::line::recorder::LineRecorder;
use pschema_adept::line::serial::SerialLine;
use pschema_adept::line::{Line, LineError};
use pschema_adept::v_plus::sum;
use pschema_protocol::body::Outcome;
use pschema_vplus_emulator::{Dialect, EmulatorRecord};

use crate::meddled::MeddlingLine;
use crate::rig::{MONITOR, Rig, at, setup, until};

/// Each mode, and what the arm file says of it.
const MODES: [(Dialect, &[(&str, &str)]); 2] = [(Dialect::Program, &[]), (Dialect::Monitor, MONITOR)];

/// In both modes, an arm as slow as a real one: power takes 2 s to come up, a calibration 3 s.
fn both() -> [(Rig, Arm); 2] {
    MODES.map(|(speaks, mode)| {
        let rig = Rig::start(speaks, |args| args.fast = 1.0);
        let arm = rig.arm(&setup(mode), LineRecorder::default(), false);
        (rig, arm)
    })
}

/// Enables the arm, and does something as soon as the record says so; why it was not enabled.
fn disturbed(
    rig: &Rig,
    arm: &mut Arm,
    when: impl Fn(&EmulatorRecord) -> bool + Sync,
    disturb: impl FnOnce() + Send,
) -> String {
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            until("it is time", || {
                assert!(!ended.load(Ordering::SeqCst), "it ended before");
                when(&rig.emulator.record())
            });
            disturb();
        });
        let enabled = arm.enable();
        ended.store(true, Ordering::SeqCst);
        enabled.unwrap_err().to_string()
    })
}

#[test]
fn a_process_told_to_end_stops_a_calibration_and_takes_the_power_away() {
    for (rig, mut arm) in both() {
        let calibrates = |record: &EmulatorRecord| record.calibrations_begun == 1;
        let end = || rig.stop.store(true, Ordering::SeqCst);
        let why = disturbed(&rig, &mut arm, calibrates, end);
        assert!(why.contains("told to end"), "{why}");
        let record = rig.emulator.record();
        assert_eq!((record.calibrations, record.powered), (0, false));
        assert_eq!(*arm.phase(), Phase::Inactive);
        // It is not begun anew by a process that ends.
        assert!(arm.enable().is_err());
        assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
        let record = rig.emulator.record();
        assert_eq!((record.calibrations_begun, record.power_ups, record.motions), (1, 1, 0));
        // A person who asks again gets it.
        rig.stop.store(false, Ordering::SeqCst);
        arm.enable().unwrap();
        assert_eq!(rig.emulator.record().calibrations, 1);
        assert_eq!(arm.go(at(0.5, 0.1)), Outcome::Done);
    }
}

/// Braking may end one of a calibration's own motions alone: power goes first, whoever has turned it on.
#[test]
fn a_calibration_that_is_stopped_leaves_no_power_on_that_somebody_else_had_turned_on() {
    for (speaks, mode) in MODES {
        let rig = Rig::start(speaks, |args| args.fast = 1.0);
        let power = match speaks {
            Dialect::Program => format!("{}\n", sum::seal("POWER 999 1")),
            Dialect::Monitor => "ENABLE POWER\r\n".to_owned(),
        };
        let mut line = SerialLine::open(&rig.args.link, 9600).unwrap();
        line.send(power.as_bytes()).unwrap();
        until("somebody has turned power on", || rig.emulator.record().powered);
        drop(line);
        let recorder = LineRecorder::create(&rig.recording()).unwrap();
        let mut arm = rig.arm(&setup(mode), recorder, false);
        let calibrates = |record: &EmulatorRecord| record.calibrations_begun == 1;
        let why = disturbed(&rig, &mut arm, calibrates, || rig.stop.store(true, Ordering::SeqCst));
        assert!(why.contains("told to end"), "{why}");
        let record = rig.emulator.record();
        assert_eq!((record.power_ups, record.calibrations, record.powered), (1, 0, false), "{speaks:?}");
        if speaks == Dialect::Monitor {
            let said = std::fs::read_to_string(rig.recording()).unwrap();
            let (_, after) = said.split_once(r#"> "Y\r\n""#).unwrap();
            let at = |what: &str| after.find(what).unwrap_or_else(|| panic!("no {what} in {after}"));
            assert!(
                at(r#"> "DISABLE POWER\r\n""#) < at(r#"> "WHERE\r\n""#),
                "before it is seen to stand: {after}"
            );
        }
    }
}

/// One that may not be calibrated, for instance.
#[test]
fn an_arm_that_is_not_fit_to_move_loses_the_power_that_it_was_given() {
    for (speaks, mode) in MODES {
        let rig = Rig::start(speaks, |_| {});
        let link = rig.args.link.clone();
        let open = Box::new(move || Ok(Box::new(SerialLine::open(&link, 9600)?) as Box<dyn Line>));
        let may = Permissions { moves: true, home: false };
        let mut arm = arm_on(&setup(mode), open, LineRecorder::default(), may, Arc::default(), None).unwrap();
        let why = arm.enable().unwrap_err().to_string();
        assert!(why.contains("not calibrated"), "{why}");
        let record = rig.emulator.record();
        assert_eq!((record.power_ups, record.powered), (1, false), "{speaks:?}");
        assert_eq!(*arm.phase(), Phase::Inactive);
    }
}

#[test]
fn a_process_told_to_end_stops_power_from_coming_up() {
    for (rig, mut arm) in both() {
        let end = || rig.stop.store(true, Ordering::SeqCst);
        let why = disturbed(&rig, &mut arm, |record| record.power_ups == 1, end);
        assert!(why.contains("told to end"), "{why}");
        let record = rig.emulator.record();
        assert_eq!((record.powered, record.calibrations_begun), (false, 0));
        drop(arm);
        assert!(!rig.emulator.record().powered);
    }
}

#[test]
fn an_emergency_stop_while_the_arm_is_calibrated_needs_a_person() {
    for (rig, mut arm) in both() {
        let calibrates = |record: &EmulatorRecord| record.calibrations_begun == 1;
        disturbed(&rig, &mut arm, calibrates, || drop(rig.person("estop press")));
        let record = rig.emulator.record();
        assert_eq!((record.calibrations, record.powered), (0, false));
        assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
        rig.person("estop release");
        arm.enable().unwrap();
    }
}

/// Only the question that `CALIBRATE` asks is answered with yes.
#[test]
fn what_did_not_ask_whether_to_calibrate_is_not_agreed_to() {
    for no_echo in [true, false] {
        let rig = Rig::start(Dialect::Monitor, |args| args.no_echo = no_echo);
        let recorder = LineRecorder::create(&rig.recording()).unwrap();
        let (link, lines) = (rig.args.link.clone(), recorder.clone());
        let open = Box::new(move || -> Result<Box<dyn Line>, LineError> {
            let line = SerialLine::open(&link, 9600)?;
            let line = MeddlingLine::new(Box::new(line), &[("CALIBRATE", "ID")]);
            Ok(Box::new(RecordingLine::new(Box::new(line), lines.clone())))
        });
        let may = Permissions { moves: true, home: true };
        let mut arm = arm_on(&setup(MONITOR), open, recorder, may, Arc::default(), None).unwrap();
        assert!(arm.enable().is_err());
        drop(arm);
        let said = std::fs::read_to_string(rig.recording()).unwrap();
        assert!(said.contains(r#"> "CALIBRATE\r\n""#) && !said.contains(r#"> "Y\r\n""#), "{said}");
        let record = rig.emulator.record();
        assert_eq!((record.calibrations_begun, record.powered), (0, false));
    }
}
