//! The numbers of requests, which begin anew after 999,999, and those of motions, which the program takes in ascending
//! order alone.

use std::time::{Duration, Instant};

use pschema_adept::line::Line;
use pschema_adept::line::recorder::LineRecorder;
use pschema_adept::line::serial::SerialLine;
use pschema_adept::v_plus::sum;
use pschema_protocol::body::Outcome;
use pschema_vplus_emulator::Dialect;

use crate::rig::{PATIENCE, Rig, at, setup};

/// The highest number that the host of before gave to a motion.
const BEFORE: u32 = 998_900;
/// Questions about its state: enough to begin the numbers anew, too few to come to that number again.
const QUESTIONS: u32 = 1_200;

/// Says a line with its sum, and waits for one that begins so.
fn said(line: &mut SerialLine, text: &str, wanted: &str) -> String {
    line.send(format!("{}\n", sum::seal(text)).as_bytes()).unwrap();
    let begun = Instant::now();
    let (mut heard, mut buffer) = (String::new(), [0; 256]);
    loop {
        assert!(begun.elapsed() < PATIENCE, "no {wanted:?} in {heard:?}");
        let count = line.receive(&mut buffer, Duration::from_millis(20)).unwrap();
        heard.push_str(&String::from_utf8_lossy(&buffer[..count]));
        let whole = heard.rsplit_once('\n').map_or("", |(whole, _)| whole);
        if let Some(found) = whole.lines().filter_map(sum::unseal).find(|line| line.starts_with(wanted)) {
            return found.to_owned();
        }
    }
}

#[test]
fn numbers_that_begin_anew_between_two_motions_refuse_neither() {
    let rig = Rig::start(Dialect::Program, |_| {});
    {
        let mut line = SerialLine::open(&rig.args.link, 9600).unwrap();
        said(&mut line, "POWER 1 1", "OK 1");
        said(&mut line, "CAL 2", "OK 2");
        let here = said(&mut line, "WHERE 3", "OK 3 ");
        let joints = here.strip_prefix("OK 3 ").unwrap();
        said(&mut line, &format!("MOVE {BEFORE} 0 5 {joints}"), &format!("END {BEFORE} 0"));
    }
    let recorder = LineRecorder::create(&rig.recording()).unwrap();
    let mut arm = rig.arm(&setup(&[]), recorder, false);
    arm.enable().unwrap();
    assert_eq!(arm.go(at(0.5, 0.3)), Outcome::Done);
    for _ in 0..QUESTIONS {
        assert_eq!(arm.signals().unwrap(), 0);
    }
    let motions = rig.emulator.record().motions;
    assert_eq!(arm.go(at(0.5, 0.2)), Outcome::Done);
    assert!(rig.emulator.record().motions > motions);
    drop(arm);
    // It was as it was meant to be: above the number of before, and begun anew by a question.
    let recording = std::fs::read_to_string(rig.recording()).unwrap();
    let numbers = |verb: &str| -> Vec<u32> {
        let of = |line: &str| line.split_once(&format!("> \"{verb} "))?.1.split(' ').next()?.parse().ok();
        recording.lines().filter_map(of).collect()
    };
    let (motions, questions) = (numbers("MOVE"), numbers("STAT"));
    assert!(motions.first().is_some_and(|first| *first > BEFORE), "{motions:?}");
    assert!(motions.last().is_some_and(|last| *last < QUESTIONS), "{motions:?}");
    assert!(questions.iter().any(|number| *number > 999_900) && questions.contains(&50), "{questions:?}");
}
