//! Calibrating the emulated camera with the emulated arm.

use std::fs::File;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::sync::Arc;

use pschema_adept::calibration::{ArmFile, calibrate};
use pschema_adept::config::{ArmSetup, EMULATED};
use pschema_adept::operator::OperatorPlace;
use pschema_adept::sight::CameraSource;
use pschema_adept::{AdeptArgs, AdeptTask, build, enable, run};
use pschema_vplus_emulator::Dialect;

use crate::rig::Rig;

/// Arguments for the emulated arm of a rig, enabled at once.
pub(crate) fn args(rig: &Rig, arm: &str) -> AdeptArgs {
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
        overwrite: false,
        replay: None,
        exit_with_daemon: true,
        task: None,
    }
}

#[test]
fn the_map_fits_and_is_kept_in_the_arm_file() {
    let rig = Rig::start(Dialect::Program, |_| {});
    // The arm file of a group of people, behind a link.
    let file = rig.directory.path().join("shared.toml");
    std::fs::write(&file, EMULATED).unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o664)).unwrap();
    let link = rig.directory.path().join("arm.toml");
    symlink("shared.toml", &link).unwrap();
    let args = args(&rig, link.to_str().unwrap());
    let into = ArmFile::prepare(&args.arm, &Arc::default()).unwrap();
    let mut body = build(&args, rig.stop.clone(), None).unwrap();
    enable(&args, &mut body, &rig.stop).unwrap();
    let log = rig.directory.path().join("log");
    let written = tracing_subscriber::fmt()
        .with_ansi(false)
        .with_writer(Arc::new(File::create(&log).unwrap()))
        .finish();
    let calibration =
        tracing::subscriber::with_default(written, || calibrate(&mut body, into, &rig.stop)).unwrap();
    let log = std::fs::read_to_string(log).unwrap();
    assert!(log.contains("finger=None"), "some points are out of the camera's sight: {log}");
    // Each of them, seen after another, was told as a frozen camera.
    assert!(!log.contains("the same to the last pixel"), "{log}");
    assert!(link.symlink_metadata().unwrap().is_symlink(), "the link is one still");
    assert_eq!(file.metadata().unwrap().mode() & 0o777, 0o664);
    println!("{calibration:?}");
    // The ball is 16 mm wide; its blob's centre is not quite its own.
    assert!(calibration.points >= 10 && calibration.residual_mm < 3.0, "{calibration:?}");
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.starts_with(EMULATED.trim_end()), "all else is as it was");
    assert_eq!(ArmSetup::load(&args.arm).unwrap().file.calibration, Some(calibration));
}

#[test]
fn an_arm_file_that_cannot_be_written_is_found_out_before_the_arm_moves() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let nowhere = rig.directory.path().join("none/arm.toml");
    for (arm, problem) in [("emulated", "--arm FILE"), (nowhere.to_str().unwrap(), "cannot write")] {
        let mut args = args(&rig, arm);
        args.task = Some(AdeptTask::Calibrate);
        let refused = run(&args).unwrap_err().to_string();
        assert!(refused.contains(problem), "{refused}");
    }
    let record = rig.emulator.record();
    assert_eq!((record.motions, record.powered), (0, false));
}

#[test]
fn a_map_that_cannot_be_written_any_more_is_told() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let file = rig.directory.path().join("arm.toml");
    std::fs::write(&file, EMULATED).unwrap();
    let args = args(&rig, file.to_str().unwrap());
    let into = ArmFile::prepare(&args.arm, &Arc::default()).unwrap();
    let mut body = build(&args, rig.stop.clone(), None).unwrap();
    enable(&args, &mut body, &rig.stop).unwrap();
    std::fs::remove_file(&file).unwrap();
    let lost = calibrate(&mut body, into, &rig.stop).unwrap_err().to_string();
    assert!(lost.contains("The map is not lost") && lost.contains("\npx_from_mm = ["), "{lost}");
}

#[test]
fn a_recording_that_is_there_stays_unless_a_person_says_otherwise() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let recording = rig.recording();
    std::fs::write(&recording, "an hour of yesterday\n").unwrap();
    let mut args = args(&rig, "emulated");
    args.record = Some(recording.clone());
    let refused = build(&args, rig.stop.clone(), None).err().unwrap().to_string();
    assert!(refused.contains("it is there already") && refused.contains("--overwrite"), "{refused}");
    assert_eq!(std::fs::read_to_string(&recording).unwrap(), "an hour of yesterday\n");
    args.overwrite = true;
    let mut body = build(&args, rig.stop.clone(), None).unwrap();
    body.arm().ensure_connected().unwrap();
    assert!(!std::fs::read_to_string(&recording).unwrap().contains("yesterday"));
}
