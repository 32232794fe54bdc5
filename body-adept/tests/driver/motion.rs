//! The driver moves the emulated arm, in both modes, and knows where it is.

use pschema_adept::arm::{Permissions, Phase};
use pschema_adept::arm_on;
use pschema_adept::line::recorder::LineRecorder;
use pschema_adept::line::serial::SerialLine;
use pschema_adept::replay::replay;
use pschema_arm::route::Waypoint;
use pschema_protocol::body::Outcome;
use pschema_vplus_emulator::Dialect;

use crate::rig::{MONITOR, Rig, at, setup, until};

fn goes_where_it_is_sent(rig: &Rig, changes: &[(&str, &str)], postures: usize) {
    let setup = setup(changes);
    let mut arm = rig.enabled(&setup);
    for to in setup.repertoire.iter().step_by(setup.repertoire.len() / postures) {
        assert_eq!(arm.go(*to), Outcome::Done, "{to:?}");
        let wanted = setup.gate.taught().at(Waypoint { joints: *to, lift_m: 0.0 }).unwrap();
        let joints = arm.joints().unwrap();
        assert!(setup.gate.is_at(&wanted, &joints), "{joints:?} instead of {wanted:?}");
    }
    assert_eq!(arm.park(), Outcome::Done);
    drop(arm);
    let record = rig.emulator.record();
    assert_eq!(record.envelope_errors, 0);
    assert!(record.tip_m_min > 0.008, "the finger's ball stays off the table: {} m", record.tip_m_min);
}

#[test]
fn the_server_program_takes_it_where_it_is_sent() {
    goes_where_it_is_sent(&Rig::start(Dialect::Program, |_| {}), &[], 12);
}

#[test]
fn the_monitor_takes_it_where_it_is_sent() {
    goes_where_it_is_sent(&Rig::start(Dialect::Monitor, |_| {}), MONITOR, 2);
}

#[test]
fn a_monitor_that_does_not_echo_takes_it_where_it_is_sent() {
    goes_where_it_is_sent(&Rig::start(Dialect::Monitor, |args| args.no_echo = true), MONITOR, 1);
}

/// Goes to blocks; none of them may be pushed through.
fn touches(speaks: Dialect, mode: &[(&str, &str)], inverted: bool, positions: &[usize]) {
    let rig = Rig::start(speaks, |args| args.touch_inverted = inverted);
    let on_when_untouched = ("inverted = false", "inverted = true");
    let changes = if inverted { &[mode, &[on_when_untouched]].concat() } else { mode };
    let setup = setup(changes);
    let untouched = if inverted { 0b1111 } else { 0 };
    let mut arm = rig.enabled(&setup);
    for position in positions {
        assert_eq!(rig.person(&format!("place blue-block {position}")), "done");
        let [x, y] = setup.file.places.at_mm[*position].map(|mm| mm.get());
        let (across, outwards) = (setup.file.plane.across_mm.get(), setup.file.plane.outwards_mm.get());
        let place = at(x / across + 0.5, (y - setup.file.plane.nearest_mm.get()) / outwards);
        assert_eq!(arm.signals().unwrap(), untouched, "before");
        assert_eq!(arm.go(place), Outcome::Done);
        assert_ne!(arm.signals().unwrap(), untouched, "at {position}");
        // A way that was carried on with to the block's middle would push it along.
        let stopped = arm.joints().unwrap();
        let middle = setup.gate.taught().at(Waypoint { joints: place, lift_m: 0.0 }).unwrap();
        assert!(!setup.gate.is_at(&middle, &stopped), "it went on through what it touched");
        assert_eq!(arm.park(), Outcome::Done);
    }
}

#[test]
fn a_block_in_the_way_is_touched_and_felt() {
    touches(Dialect::Program, &[], false, &[3, 20, 50, 77]);
}

#[test]
fn a_block_in_the_way_is_touched_and_felt_through_the_monitor() {
    touches(Dialect::Monitor, MONITOR, false, &[3]);
}

/// Inputs that are on when nothing is touched: the guard looks for one that goes off.
#[test]
fn a_touch_that_switches_an_input_off_is_felt_as_well() {
    touches(Dialect::Program, &[], true, &[3, 50]);
    touches(Dialect::Monitor, MONITOR, true, &[3]);
}

#[test]
fn what_was_recorded_is_replayed_without_an_arm() {
    // Slow enough for the driver to ask and measure again and again on the way.
    let rig = Rig::start(Dialect::Program, |args| args.fast = 10.0);
    let setup = setup(&[]);
    let recorder = LineRecorder::create(&rig.recording()).unwrap();
    let mut arm = rig.arm(&setup, recorder, false);
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.5, 0.5)), Outcome::Done);
    assert!(matches!(arm.go(at(2.0, 0.5)), Outcome::Refused(_)));
    arm.signals().unwrap();
    assert_eq!(arm.park(), Outcome::Done);
    drop(arm);
    assert!(replay(&setup, &rig.recording()).unwrap() >= 6);

    // Another posture in the order is other bytes on the line.
    let text = std::fs::read_to_string(rig.recording()).unwrap();
    std::fs::write(rig.recording(), text.replacen("go 0.5 0.5", "go 0.5 0.51", 1)).unwrap();
    let error = replay(&setup, &rig.recording()).unwrap_err().to_string();
    assert!(error.contains("line "), "{error}");
}

#[test]
fn nothing_moves_before_a_person_enables_it() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let mut arm = rig.arm(&setup(&[]), LineRecorder::default(), false);
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
    assert_eq!(*arm.phase(), Phase::Inactive);
    assert_eq!(arm.signals().unwrap(), 0, "it senses");
    assert_eq!(rig.emulator.record().motions, 0);
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.5, 0.5)), Outcome::Done);
}

#[test]
fn a_dry_run_checks_and_moves_nothing() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let open = {
        let link = rig.args.link.clone();
        Box::new(move || Ok(Box::new(SerialLine::open(&link, 9600)?) as Box<dyn pschema_adept::line::Line>))
    };
    let may = Permissions { moves: false, home: false };
    let mut arm = arm_on(&setup(&[]), open, LineRecorder::default(), may, rig.stop.clone(), None).unwrap();
    arm.enable().unwrap();
    assert!(matches!(arm.go(at(0.5, 0.5)), Outcome::Refused(_)));
    assert_eq!(arm.signals().unwrap(), 0, "it senses");
    let record = rig.emulator.record();
    assert_eq!((record.motions, record.targets.len()), (0, 0));
    assert_eq!(*arm.phase(), Phase::Active, "without power, which it has not turned on");
}
