//! Calibrating the emulated camera with the emulated arm.

use pschema_adept::calibration::calibrate;
use pschema_adept::config::{ArmSetup, EMULATED};
use pschema_adept::operator::OperatorPlace;
use pschema_adept::sight::CameraSource;
use pschema_adept::{AdeptArgs, build, enable};
use pschema_vplus_emulator::Dialect;

use crate::rig::Rig;

fn args(rig: &Rig, arm: &str) -> AdeptArgs {
    AdeptArgs {
        name: "none".to_owned(),
        body: "arm".to_owned(),
        port: Some(rig.args.link.clone()),
        arm: arm.to_owned(),
        camera: rig.args.camera.clone().map(CameraSource::Socket),
        operator: OperatorPlace::None,
        enable: true,
        home: true,
        dry_run: false,
        record: None,
        replay: None,
        exit_with_daemon: true,
        task: None,
    }
}

#[test]
fn the_map_fits_and_is_kept_in_the_arm_file() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let file = rig.directory.path().join("arm.toml");
    std::fs::write(&file, EMULATED).unwrap();
    let args = args(&rig, file.to_str().unwrap());
    let mut body = build(&args, rig.stop.clone(), None).unwrap();
    enable(&args, &mut body, &rig.stop).unwrap();
    let calibration = calibrate(&mut body, &args.arm, &rig.stop).unwrap();
    println!("{calibration:?}");
    // The ball is 16 mm wide; its blob's centre is not quite its own.
    assert!(calibration.points >= 10 && calibration.residual_mm < 3.0, "{calibration:?}");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.starts_with(EMULATED.trim_end()), "all else is as it was");
    assert_eq!(ArmSetup::load(&args.arm).unwrap().file.calibration, Some(calibration));
}

#[test]
fn without_an_arm_file_of_its_own_nothing_is_calibrated() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let args = args(&rig, "emulated");
    let mut body = build(&args, rig.stop.clone(), None).unwrap();
    let refused = calibrate(&mut body, &args.arm, &rig.stop).unwrap_err().to_string();
    assert!(refused.contains("--arm FILE"), "{refused}");
    assert_eq!(rig.emulator.record().motions, 0);
}
