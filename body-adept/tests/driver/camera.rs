//! A camera that fails while the arm is enabled.

use std::fs::File;
use std::sync::Arc;

use pschema_adept::operator::OperatorPlace;
use pschema_adept::sight::CameraSource;
use pschema_adept::{build, enable};
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::Action;
use pschema_vplus_emulator::Dialect;

use crate::calibrate::args;
use crate::rig::{Rig, setup};

/// A command that prints black pictures of so many bytes: two in its first life, and any number in each later one.
fn black_pictures(rig: &Rig, bytes: usize) -> String {
    format!(
        "sh -c 'if mkdir {0} 2>/dev/null; then head -c {1} /dev/zero; \
         else while head -c {bytes} /dev/zero; do sleep 0.02; done; fi'",
        rig.directory.path().join("died").display(),
        2 * bytes
    )
}

#[test]
fn a_camera_that_died_is_started_again_nobody_is_asked_and_frozen_pictures_are_told() {
    let rig = Rig::start(Dialect::Program, |_| {});
    let setup = setup(&[]);
    let camera = &setup.file.camera;
    let bytes = camera.width_px.count() * camera.height_px.count() * 3;
    let mut args = args(&rig, "emulated");
    args.camera = Some(CameraSource::Exec(black_pictures(&rig, bytes)));
    // Whoever would be asked is not there.
    args.operator = OperatorPlace::None;
    let mut body = build(&args, rig.stop.clone(), None).unwrap();
    enable(&args, &mut body, &rig.stop).unwrap();
    let (_, ids) = setup.declaration("arm").declare();
    let log = rig.directory.path().join("log");
    let written = tracing_subscriber::fmt().with_writer(Arc::new(File::create(&log).unwrap())).finish();
    let told = || std::fs::read_to_string(&log).unwrap().matches("the same to the last pixel").count();
    tracing::subscriber::with_default(written, || {
        body.sense(&mut Senses::default());
        body.sense(&mut Senses::default());
        assert!(rig.directory.path().join("died").exists());
        assert_eq!(told(), 0, "the arm stood still");
        for to in [[0.45, 0.5], [0.5, 0.5]] {
            assert_eq!(body.act(&Action::new(ids.move_to, to)), Outcome::Done);
            body.sense(&mut Senses::default());
            assert_eq!(told(), 1, "once in a while");
        }
    });
}
