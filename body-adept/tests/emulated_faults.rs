//! A line with faults: bytes lost, flipped and made up, answers cut, late, lost, doubled, text that nobody asked for,
//! the plug pulled out. The arm may refuse, give up and need a person; it may not hang, believe to be where it is not,
//! or move as nobody asked.
//!
//! `PSCHEMA_LINE_FAULTS=1000` for as many faults in each mode; fewer unless asked for.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

#[path = "driver/rig.rs"]
#[allow(dead_code, reason = "other tests use the rest")]
mod rig;

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use pschema_adept::arm::{Arm, Phase};
use pschema_adept::config::ArmSetup;
use pschema_adept::line::recorder::LineRecorder;
use pschema_arm::SplitMix;
use pschema_arm::route::Waypoint;
use pschema_protocol::body::Outcome;
use pschema_vplus_emulator::{Dialect, Joints};
use rig::{Rig, setup};

/// Longest that one order may take, whatever the line does.
const ORDER_MAX: Duration = Duration::from_secs(60);
/// Longest that it may take until an order gets through, where the machine delays answers as well.
const ORDERS_MAX: Duration = Duration::from_secs(180);
/// Farthest that the arm may be from where it says it is, in degrees: the digits that it says it with.
const DIGITS_DEG: f64 = 0.001;

fn faults_wanted() -> u64 {
    std::env::var("PSCHEMA_LINE_FAULTS").map_or(80, |text| text.parse().expect("a number of faults"))
}

/// Every precision point that was ever sent, as text.
fn points_sent(recording: &str) -> BTreeSet<String> {
    let mut points = BTreeSet::new();
    for line in recording.lines() {
        let Some((_, sent)) = line.split_once(" > ") else { continue };
        let words: Vec<&str> =
            sent.trim_matches('"').split("\\r").next().unwrap_or_default().split(' ').collect();
        let values = match words.as_slice() {
            [verb, _, _, rest @ ..] if verb.ends_with("VIA") => rest,
            [verb, _, _, _, rest @ ..] if verb.ends_with("MOVE") => rest,
            _ => match sent.split_once("#PPOINT(").and_then(|(_, rest)| rest.split_once(')')) {
                Some((inner, _)) => {
                    points.insert(named(inner.split(',')));
                    continue;
                }
                None => continue,
            },
        };
        points.insert(named(values.iter().take(4).copied()));
    }
    points
}

/// A point by its values, however they were written.
fn named<'a>(values: impl Iterator<Item = &'a str>) -> String {
    values
        .map(|value| format!("{:.4}", value.trim().parse::<f64>().expect("a number")))
        .collect::<Vec<_>>()
        .join(" ")
}

fn point(joints: &Joints) -> String {
    joints.map(|value| format!("{value:.4}")).join(" ")
}

fn truth(rig: &Rig) -> Joints {
    rig.emulator.record().joints
}

/// Gets the arm going again as a person does, who tries once, then sees to the line.
fn attended(rig: &Rig, arm: &mut Arm) {
    let since = Instant::now();
    let motions = rig.emulator.record().motions;
    for attempt in 0.. {
        if *arm.phase() == Phase::Active {
            break;
        }
        if attempt == 1 {
            assert_eq!(rig.person("faults off"), "done");
        }
        assert!(since.elapsed() < ORDER_MAX, "it never gets going: {:?}", arm.phase());
        drop(arm.enable());
    }
    assert_eq!(rig.emulator.record().motions, motions, "nothing moves because somebody connects");
    assert_eq!(rig.person("faults on"), "done");
}

fn lives_with_faults(speaks: Dialect, mode: &[(&str, &str)], seed: u64) {
    let wanted = faults_wanted();
    println!("{speaks:?}, seed {seed}, {wanted} faults");
    let rig = Rig::start(speaks, |args| {
        // The monitor is told and asked ten times as much for each motion, and any doubt ends it.
        let rates = match speaks {
            Dialect::Program => {
                "lose=0.0005 flip=0.0005 noise=0.0005 cut=0.005 mute=0.005 late=0.01 chatter=0.005 twice=0.005 unplug=0.002"
            }
            Dialect::Monitor => {
                "lose=0.0001 flip=0.0001 noise=0.0001 cut=0.001 mute=0.001 late=0.002 chatter=0.001 twice=0.001 unplug=0.0005"
            }
        };
        args.fault = rates.split(' ').map(|rate| rate.parse().unwrap()).collect();
        (args.fault_seed, args.faults_max, args.fast) = (seed, wanted, 2000.0);
    });
    let quick = [mode, &[("answer_ms = 500", "answer_ms = 120")]].concat();
    let setup = setup(&quick);
    let recorder = LineRecorder::create(&rig.recording()).unwrap();
    let mut arm = rig.arm(&setup, recorder, false);
    let mut random = SplitMix::new(seed);
    let (mut orders, mut done, mut slowest) = (0_u32, 0_u32, Duration::ZERO);
    let began = Instant::now();
    // A busy machine delays answers by more than the time that they are given here, so that it can take some orders more until one
    // gets through.
    let goes_on = |done| rig.emulator.record().faults < wanted || (done == 0 && began.elapsed() < ORDERS_MAX);
    while goes_on(done) {
        attended(&rig, &mut arm);
        let to = random.one_of(&setup.repertoire).unwrap();
        let since = Instant::now();
        let motions = rig.emulator.record().motions;
        let outcome = arm.go(to);
        slowest = slowest.max(since.elapsed());
        assert!(since.elapsed() < ORDER_MAX, "an order took {:?}", since.elapsed());
        orders += 1;
        if outcome == Outcome::Done {
            done += 1;
            is_at(&setup, to, &truth(&rig));
        }
        assert!(
            !matches!(outcome, Outcome::Refused(_)) || rig.emulator.record().motions == motions,
            "refused, and yet it moved"
        );
        let before = truth(&rig);
        if let Ok(believed) = arm.joints() {
            let after = truth(&rig);
            let near = |believed: &f64, truth: &f64| (believed - truth).abs() <= DIGITS_DEG;
            let right =
                |truth: &Joints| believed.iter().zip(truth).all(|(believed, truth)| near(believed, truth));
            // A motion that was given up may still be coming to rest.
            assert!(
                right(&before) || right(&after),
                "believed {believed:?}, was {before:?} and is {after:?}"
            );
        }
    }
    println!("{orders} orders, {done} done, the slowest in {slowest:?}");
    assert!(done > 0, "some get through");
    drop(arm);
    only_what_was_sent(&rig, &setup);
}

/// Whether the arm is where a posture was taught.
fn is_at(setup: &ArmSetup, to: pschema_arm::JointPositions, at: &Joints) {
    let taught = setup.gate.taught().at(Waypoint { joints: to, lift_m: 0.0 }).unwrap();
    let off = taught.iter().zip(at).map(|(taught, at)| (taught - at).abs()).fold(0.0, f64::max);
    assert!(off < 0.5, "said to be done, but off by {off} degrees: {at:?} instead of {taught:?}");
}

/// Every motion that was begun went to points that were sent, within the limits and not faster than the cap.
fn only_what_was_sent(rig: &Rig, setup: &ArmSetup) {
    let sent = points_sent(&std::fs::read_to_string(rig.recording()).unwrap());
    let record = rig.emulator.record();
    assert!(!sent.is_empty() && !record.targets.is_empty());
    for target in &record.targets {
        assert!(sent.contains(&point(target)), "nobody sent the arm to {target:?}");
        for (value, joint) in target.iter().zip(&setup.file.joints) {
            let joint = joint.get_ref();
            assert!((joint.min.get()..=joint.max.get()).contains(value), "{}: {value}", joint.name);
        }
    }
    assert!(record.speed_max <= 0.2 + 1e-9, "at {} of full speed", record.speed_max);
    assert_eq!(record.envelope_errors, 0, "it met what does not give way");
}

#[test]
fn on_the_line_of_the_server_program() {
    for seed in 1..=2 {
        lives_with_faults(Dialect::Program, &[], seed);
    }
}

#[test]
fn on_the_line_of_the_monitor() {
    lives_with_faults(Dialect::Monitor, &[("mode = \"server\"", "mode = \"monitor\"")], 3);
}
