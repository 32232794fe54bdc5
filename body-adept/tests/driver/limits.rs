//! Whatever is asked for, nothing beyond the limits reaches the port.

use std::sync::Arc;

use pschema_adept::arm::{Arm, Permissions, Phase};
use pschema_adept::arm_on;
use pschema_adept::config::ArmSetup;
use pschema_adept::line::recorder::LineRecorder;
use pschema_arm::JointPositions;
use pschema_arm::SplitMix;
use pschema_arm::route::Waypoint;
use pschema_protocol::body::Outcome;

use crate::fake::FakeLine;
use crate::rig::setup;

/// Commands in one run; `PSCHEMA_ADEPT_COMMANDS` sets another number.
const COMMANDS: u64 = 2_000;

fn arm_on_port(setup: &Arc<ArmSetup>) -> (Arm, FakeLine) {
    let rest = Waypoint { joints: setup.rest, lift_m: 0.0 };
    let line = FakeLine::at(&setup.gate.taught().at(rest).unwrap());
    let port = line.clone();
    let open = Box::new(move || Ok(Box::new(port.clone()) as Box<dyn pschema_adept::line::Line>));
    let may = Permissions { moves: true, home: false };
    let mut arm = arm_on(setup, open, LineRecorder::default(), may, Arc::default(), None).unwrap();
    arm.enable().unwrap();
    (arm, line)
}

/// Anything a learner, or something that pretends to be one, could ask for.
fn hostile(random: &mut SplitMix) -> JointPositions {
    let odd = [
        0.0,
        -0.0,
        1.0,
        -1e-12,
        1.0 + 1e-12,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e300,
        -1e300,
        5e-324,
    ];
    let mut one = || match random.one_of(&[0, 1, 2, 3, 4, 5]) {
        Some(0) => random.one_of(&odd).unwrap(),
        Some(1) => random.within_one() * 1e6,
        Some(2) => random.within_one() * 2.0,
        _ => (random.within_one() + 1.0) / 2.0,
    };
    JointPositions { j1: one(), j2: one() }
}

#[test]
fn no_motion_leaves_the_limits() {
    let commands =
        std::env::var("PSCHEMA_ADEPT_COMMANDS").ok().and_then(|n| n.parse().ok()).unwrap_or(COMMANDS);
    let seed = 11;
    let setup = setup(&[]);
    let (mut arm, line) = arm_on_port(&setup);
    let mut random = SplitMix::new(seed);
    let (mut done, mut refused) = (0_u64, 0_u64);
    for _ in 0..commands {
        match arm.go(hostile(&mut random)) {
            Outcome::Done => done += 1,
            Outcome::Refused(_) => refused += 1,
            other => panic!("seed {seed}: {other:?}"),
        }
    }
    let port = line.0.lock().unwrap();
    println!(
        "seed {seed}: {commands} commands, {done} done, {refused} refused, {} points",
        port.targets.len()
    );
    assert_eq!(*arm.phase(), Phase::Active, "after {} motions", port.motions);
    assert!(done > commands / 10 && refused > commands / 10, "both must have happened");
    assert_eq!(port.motions, done);
    // Read from the file's text, not through the driver's own checks.
    let limits = [(-95.0, 95.0), (-160.0, 10.0), (0.0, 138.0), (-78.0, 5.0)];
    for (speed, joints) in &port.targets {
        assert!((1..=20).contains(speed), "{speed} %");
        assert_eq!(joints.len(), limits.len());
        for (value, (min, max)) in joints.iter().zip(limits) {
            assert!((min..=max).contains(value), "{joints:?}");
        }
    }
}

#[test]
fn narrower_limits_refuse_what_wider_ones_let_pass() {
    let wide = setup(&[]);
    let far_left = JointPositions { j1: 0.15, j2: 0.3 };
    let (mut arm, _) = arm_on_port(&wide);
    assert_eq!(arm.go(far_left), Outcome::Done);
    // A file whose taught points lie outside its limits is refused when it is read.
    let error =
        ArmSetup::parse("test", &pschema_adept::config::EMULATED.replacen("min = -95.0", "min = -30.0", 1))
            .unwrap_err();
    let error = error.to_string();
    assert!(error.contains("line ") && error.contains("within the limits"), "{error}");
}
