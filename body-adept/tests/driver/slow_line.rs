//! A real line: 1.04 ms a character. A path takes longer to send than the driver may be silent.

use pschema_adept::line::recorder::LineRecorder;
use pschema_protocol::body::Outcome;
use pschema_vplus_emulator::Dialect;

use crate::rig::{MONITOR, Rig, at, setup, until};

const SLOW: (&str, &str) = ("baud = 38400", "baud = 9600");

#[test]
fn a_long_path_is_sent_in_its_time() {
    let rig = Rig::start(Dialect::Program, |args| args.baud = Some(9600));
    let setup = setup(&[SLOW]);
    let recorder = LineRecorder::create(&rig.recording()).unwrap();
    let mut arm = rig.arm(&setup, recorder, false);
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.2, 0.6)), Outcome::Done);
    let recorded = std::fs::read_to_string(rig.recording()).unwrap();
    let seconds = |line: &str| line.split(' ').next().unwrap().parse::<f64>().unwrap();
    let sent =
        |what: &str| recorded.lines().filter(|line| line.contains(what)).map(seconds).collect::<Vec<_>>();
    let (points, moves) = (sent("> \"VIA"), sent("> \"MOVE"));
    println!("{} points in {:.2} s", points.len(), moves[0] - points[0]);
    assert_eq!(moves.len(), 1, "at the first try");
    assert!(moves[0] - points[0] > 1.0, "longer than the longest silence, or this tests nothing");
}

#[test]
fn the_monitor_takes_it_a_short_way_over_a_slow_line() {
    let rig = Rig::start(Dialect::Monitor, |args| args.baud = Some(9600));
    let mut arm = rig.enabled(&setup(&[MONITOR, &[SLOW]].concat()));
    // Where this machine lets it wait, it is rightly stopped on the way.
    until("arrived", || arm.go(at(0.5, 0.0)) == Outcome::Done);
}

/// Positions that are read while the arm moves are never twice the same.
#[test]
fn the_monitor_is_asked_where_an_arm_passes_that_moves_slowly() {
    let rig = Rig::start(Dialect::Monitor, |args| args.fast = 1.0);
    let setup = setup(MONITOR);
    let recorder = LineRecorder::create(&rig.recording()).unwrap();
    let mut arm = rig.arm(&setup, recorder, false);
    until("enabled", || arm.enable().is_ok());
    assert_eq!(arm.go(at(0.5, 0.0)), Outcome::Done);
    let recorded = std::fs::read_to_string(rig.recording()).unwrap();
    let moving = recorded.split("> \"DO MOVE").nth(1).unwrap();
    assert!(moving.contains("> \"WHERE"), "it was asked on the way");
    drop(arm);
}
