//! The program `pschema-sim`, and that what the body says is within the protocol.

use std::process::{Command, Output};

use pschema_protocol::body::BodyLoop;
use pschema_protocol::wire::decode;
use pschema_sim::body::SimBody;
use pschema_sim::config::{BLOCK_AND_BALL, NARROW, WIDE, WorldFile};

fn sim(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pschema-sim")).args(arguments).output().expect("the program starts")
}

#[test]
fn a_snapshot_is_a_picture_twice_the_cameras_size() {
    let folder = tempfile::tempdir().unwrap();
    for world in ["wide", "narrow", "block-and-ball"] {
        let path = folder.path().join(format!("{world}.png"));
        let output = sim(&["--world", world, "--snapshot", path.to_str().unwrap()]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()));
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let frame = reader.next_frame(&mut pixels).unwrap();
        assert_eq!((frame.width, frame.height), (1560, 1160));
        let blue = pixels.chunks_exact(3).filter(|p| p[2] > 150 && p[0] < 80).count();
        assert!(blue > 300, "the blue block is in it: {blue} pixels");
    }
}

#[test]
fn a_faulty_world_file_is_told_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("world.toml");
    std::fs::write(&path, WIDE.replacen("friction = 0.9", "friction = 9", 1)).unwrap();
    let output = sim(&["--world", path.to_str().unwrap()]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        told.contains("world.toml") && told.contains("line ") && told.contains("must be 0 to 2"),
        "{told}"
    );
}

#[test]
fn exact_worlds_are_named_and_refused_with_the_good_names() {
    let told = |arguments: &[&str]| {
        let output = sim(arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let help = String::from_utf8_lossy(&sim(&["--help"]).stdout).into_owned();
    let unknown = told(&["--world", "flop"]);
    for name in pschema_exact::WORLDS.iter().map(|entry| entry.name) {
        assert!(help.contains(name) && unknown.contains(name), "{name} is missing in {help} or in {unknown}");
    }
    assert!(unknown.contains("block-and-ball"), "{unknown}");
    let number = told(&["--world", "gripper:blocks=70"]);
    assert!(number.contains("blocks") && number.contains("must be 1 to 9"), "{number}");
    let option = told(&["--world", "flip", "--realtime"]);
    assert!(option.contains("--realtime") && option.contains("flip"), "{option}");
}

#[test]
fn a_noise_that_makes_no_sense_is_told() {
    for (noise, told) in [("blob_missed=7", "must be 0 to 1"), ("hearing=0.1", "finger_misplaced")] {
        let output = sim(&["--noise", noise]);
        let error = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(noise) && error.contains(told), "{error}");
    }
}

#[test]
fn a_snapshot_that_cannot_be_written_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    std::fs::write(&path, "another's").unwrap();
    let output = sim(&["--snapshot", path.to_str().unwrap()]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && told.contains("--overwrite"), "{told}");
    assert_eq!(std::fs::read(&path).unwrap(), b"another's");
    let output = sim(&["--snapshot", path.to_str().unwrap(), "--overwrite"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(std::fs::read(&path).unwrap().starts_with(b"\x89PNG"));
    let output = sim(&["--snapshot", "/nonexistent/folder/picture.png"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("/nonexistent/folder/picture.png"));
}

#[test]
fn what_the_body_declares_and_senses_is_within_the_protocol() {
    for (name, text) in [("wide", WIDE), ("narrow", NARROW), ("block-and-ball", BLOCK_AND_BALL)] {
        let file = WorldFile::parse(name, text).unwrap();
        let mut body = BodyLoop::new(SimBody::new("arm", file, name, 1, false).unwrap());
        let hello = decode::hello(&body.hello().unwrap()).unwrap();
        assert_eq!(&hello.description, body.description());
        let mut session = decode::SessionChecks::new(7, hello.description);
        body.attached(7);
        session.check(body.next_frame()).unwrap();
    }
}

/// clap says what was typed, however long it is.
#[test]
fn long_input_is_quoted_in_part() {
    let output = sim(&["--noise", &"é".repeat(10_000)]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && (10..3_000).contains(&told.len()), "{told}");
}
