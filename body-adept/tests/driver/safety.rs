//! What stops the arm, and that it stays stopped.

use std::sync::atomic::{AtomicBool, Ordering};

use pschema_adept::arm::{Permissions, Phase};
use pschema_adept::arm_on;
use pschema_adept::line::recorder::LineRecorder;
use pschema_adept::line::serial::SerialLine;
use pschema_adept::line::{Line, LineError};
use pschema_protocol::body::Outcome;
use pschema_vplus_emulator::Dialect;

use crate::meddled::MeddlingLine;
use crate::rig::{MONITOR, Rig, at, setup, until};

/// Runs a long motion and, once it is under way, `disturb`; returns how the motion came out.
fn disturbed(rig: &Rig, arm: &mut pschema_adept::arm::Arm, disturb: impl FnOnce() + Send) -> Outcome {
    let motions = rig.emulator.record().motions;
    let ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            until("the arm moves", || {
                assert!(!ended.load(Ordering::SeqCst), "it ended before it moved");
                rig.emulator.record().motions > motions
            });
            disturb();
        });
        let outcome = arm.go(at(0.2, 0.6));
        ended.store(true, Ordering::SeqCst);
        outcome
    })
}

/// As fast as a real arm: motions last seconds.
fn slow() -> Rig {
    Rig::start(Dialect::Program, |args| args.fast = 1.0)
}

#[test]
fn a_silent_daemon_stops_the_arm_and_its_return_does_not_resume_the_motion() {
    let rig = slow();
    let setup = setup(&[("heartbeat_ms = 1000", "heartbeat_ms = 200")]);
    let mut arm = rig.arm(&setup, LineRecorder::default(), true);
    until("enabled", || arm.enable().is_ok());
    rig.daemon.renew();
    // Nobody renews the sign of life any more.
    assert!(matches!(disturbed(&rig, &mut arm, || {}), Outcome::Failed(_)), "it did not arrive");
    let stopped = rig.emulator.record();
    assert!(stopped.motions == 1 && stopped.stops > 0, "{} {}", stopped.motions, stopped.stops);
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)), "and nothing begins without a daemon");
    rig.daemon.renew();
    assert_eq!(arm.signals().unwrap(), 0);
    assert_eq!(rig.emulator.record().motions, 1, "its return resumes nothing");
    assert_eq!(*arm.phase(), Phase::Active);
}

#[test]
fn a_process_told_to_end_stops_the_arm() {
    let rig = slow();
    let mut arm = rig.enabled(&setup(&[]));
    let stop = rig.stop.clone();
    assert!(matches!(disturbed(&rig, &mut arm, || stop.store(true, Ordering::SeqCst)), Outcome::Failed(_)));
    assert!(rig.emulator.record().stops > 0);
}

#[test]
fn an_emergency_stop_is_latched_until_a_person_resets_it() {
    let rig = slow();
    let mut arm = rig.enabled(&setup(&[]));
    assert!(matches!(disturbed(&rig, &mut arm, || drop(rig.person("estop press"))), Outcome::Failed(_)));
    assert!(matches!(arm.phase(), Phase::Latched(_)), "{:?}", arm.phase());
    let motions = rig.emulator.record().motions;
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
    assert!(arm.enable().is_err(), "still pressed");
    rig.person("estop release");
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)), "released is not reset");
    assert_eq!(rig.emulator.record().motions, motions);
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.45, 0.5)), Outcome::Done);
}

#[test]
fn an_emergency_stop_at_rest_is_noticed_before_the_next_motion() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let mut arm = rig.enabled(&setup(&[]));
    rig.person("estop press");
    arm.signals().unwrap();
    assert_eq!(*arm.phase(), Phase::Latched("an emergency stop was pressed".to_owned()));
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
}

#[test]
fn a_controller_that_was_switched_off_and_on_needs_a_person() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let mut arm = rig.enabled(&setup(&[]));
    assert_eq!(arm.go(at(0.5, 0.5)), Outcome::Done);
    let motions = rig.emulator.record().motions;
    rig.person("power cycle");
    until("it is noticed", || arm.signals().is_ok() && matches!(arm.phase(), Phase::Latched(_)));
    assert!(matches!(arm.go(at(0.5, 0.4)), Outcome::Refused(_)));
    assert_eq!(rig.emulator.record().motions, motions);
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.5, 0.4)), Outcome::Done);
}

#[test]
fn a_line_that_is_unplugged_at_rest_is_opened_again_and_nothing_is_sent_twice() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let mut arm = rig.enabled(&setup(&[]));
    assert_eq!(arm.go(at(0.5, 0.5)), Outcome::Done);
    rig.person("unplug 100");
    until("it is missed", || arm.signals().is_err());
    let motions = rig.emulator.record().motions;
    until("it is back", || arm.signals().is_ok());
    assert_eq!(rig.emulator.record().motions, motions, "nothing was begun anew");
    assert_eq!(*arm.phase(), Phase::Active);
    assert_eq!(arm.go(at(0.55, 0.5)), Outcome::Done);
}

#[test]
fn a_line_that_is_unplugged_during_a_motion_leaves_it_to_the_watchdog() {
    let rig = Rig::start(Dialect::Program, |args| (args.fast, args.watchdog_ms) = (1.0, 500));
    let mut arm = rig.enabled(&setup(&[]));
    let before = rig.emulator.record().watchdog_stops;
    let outcome = disturbed(&rig, &mut arm, || drop(rig.person("unplug 1500")));
    assert!(matches!(outcome, Outcome::Failed(_)));
    until("the watchdog stops it", || rig.emulator.record().watchdog_stops == before + 1);
    until("it is back", || arm.signals().is_ok());
    assert!(matches!(arm.phase(), Phase::Latched(_)), "{:?}", arm.phase());
    assert_eq!(rig.emulator.record().motions, 1);
}

#[test]
fn two_drivers_do_not_share_a_line() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let setup = setup(&[]);
    let mut arm = rig.enabled(&setup);
    let mut other = rig.arm(&setup, LineRecorder::default(), false);
    let refused = other.enable().unwrap_err().to_string();
    assert!(refused.contains("end whatever else uses it"), "{refused}");
    assert_eq!(arm.go(at(0.5, 0.5)), Outcome::Done);
}

#[test]
fn a_person_who_stops_the_arm_at_the_monitor_is_not_overruled_by_the_next_part_of_the_path() {
    let rig = Rig::start(Dialect::Monitor, |args| args.fast = 4.0);
    let setup = setup(MONITOR);
    let mut arm = rig.enabled(&setup);
    let outcome = disturbed(&rig, &mut arm, || assert_eq!(rig.person("halt"), "done"));
    assert!(matches!(outcome, Outcome::Failed(_)));
    assert!(matches!(arm.phase(), Phase::Latched(why) if why.contains("short of")), "{:?}", arm.phase());
    assert_eq!(rig.emulator.record().motions, 1, "nothing follows");
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)), "until a person has seen to it");
    assert_eq!(rig.emulator.record().motions, 1);
}

/// The pendant, another task, an operator at the controller: whoever it was had a reason.
#[test]
fn a_person_who_stops_the_arm_beside_the_program_is_not_overruled_by_the_next_order() {
    let rig = slow();
    let mut arm = rig.enabled(&setup(&[]));
    let outcome = disturbed(&rig, &mut arm, || assert_eq!(rig.person("halt"), "done"));
    assert!(matches!(outcome, Outcome::Failed(_)));
    assert!(matches!(arm.phase(), Phase::Latched(why) if why.contains("not from here")), "{:?}", arm.phase());
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)), "until a person has seen to it");
    assert_eq!(rig.emulator.record().motions, 1);
}

#[test]
fn an_error_in_the_program_on_the_controller_needs_a_person() {
    let rig = slow();
    let mut arm = rig.enabled(&setup(&[]));
    let outcome = disturbed(&rig, &mut arm, || assert_eq!(rig.person("trip"), "done"));
    assert!(matches!(outcome, Outcome::Failed(_)));
    assert!(matches!(arm.phase(), Phase::Latched(_)), "{:?}", arm.phase());
    assert!(rig.emulator.record().stops > 0);
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.45, 0.5)), Outcome::Done);
}

/// A controller begins at a speed of its own when it is switched on.
#[test]
fn the_speed_is_set_anew_with_each_motion() {
    let rig = Rig::start(Dialect::Monitor, |_| {});
    let one_speed = ("percent = 20\n", "percent = 5\n");
    let mut arm = rig.enabled(&setup(&[MONITOR, &[one_speed]].concat()));
    assert_eq!(arm.go(at(0.5, 0.0)), Outcome::Done);
    rig.person("power cycle");
    until("it is noticed", || arm.signals().is_ok() && matches!(arm.phase(), Phase::Latched(_)));
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.5, 0.05)), Outcome::Done);
    let record = rig.emulator.record();
    assert!(record.speed_max <= 0.05 + 1e-9, "at {} of full speed", record.speed_max);
}

/// Without echo nothing but what is read back tells what has arrived.
#[test]
fn a_speed_that_arrived_as_another_moves_nothing() {
    for no_echo in [true, false] {
        let rig = Rig::start(Dialect::Monitor, |args| args.no_echo = no_echo);
        let setup = setup(MONITOR);
        // Enabled over a good line first.
        drop(rig.enabled(&setup));
        let link = rig.args.link.clone();
        let open = Box::new(move || -> Result<Box<dyn Line>, LineError> {
            let line = SerialLine::open(&link, 9600)?;
            Ok(Box::new(MeddlingLine::new(
                Box::new(line),
                &[("SPEED 20", "SPEED 90"), ("SPEED 5\r", "SPEED 50\r")],
            )))
        });
        let may = Permissions { moves: true, home: true };
        let mut arm = arm_on(&setup, open, LineRecorder::default(), may, rig.stop.clone(), None).unwrap();
        arm.enable().unwrap();
        assert_ne!(arm.go(at(0.5, 0.5)), Outcome::Done);
        let record = rig.emulator.record();
        assert_eq!((record.motions, record.speed_max), (0, 0.0));
    }
}

#[test]
fn an_arm_that_stood_down_waits_for_a_person() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let mut arm = rig.enabled(&setup(&[]));
    arm.stand_down();
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
    assert_eq!((arm.phase().clone(), rig.emulator.record().motions), (Phase::Inactive, 0));
    assert_eq!(arm.signals().unwrap(), 0, "it senses, and stays as it is");
    assert_eq!(*arm.phase(), Phase::Inactive);
    arm.enable().unwrap();
    assert_eq!(arm.go(at(0.5, 0.5)), Outcome::Done);
}
