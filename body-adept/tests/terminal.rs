//! The person at the terminal, whose every line counts. In a process of its own: the terminal is the process's.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::fs::File;
use std::io::{Read, Write};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use pschema_adept::operator::{Operator, OperatorPlace, Wish};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

const PATIENCE: Duration = Duration::from_secs(60);

/// The person: waits for a question to end, as all do, and types an answer. Who drops the terminal hangs up.
fn answers(mut terminal: File, lines: &[&str]) -> File {
    for line in lines {
        let mut shown = Vec::new();
        let mut byte = [0];
        while !shown.ends_with(b":\r\n") {
            terminal.read_exact(&mut byte).unwrap();
            shown.push(byte[0]);
        }
        writeln!(terminal, "{line}").unwrap();
        // The terminal echoes it.
        let echoed = format!("{line}\r\n");
        let mut back = vec![0; echoed.len()];
        terminal.read_exact(&mut back).unwrap();
        assert_eq!(String::from_utf8(back).unwrap(), echoed);
    }
    terminal
}

/// The arm is enabled by one part of the driver, and later asked for by another: neither takes the other's answer.
#[test]
fn every_line_answers_the_question_before_it_whoever_asks() {
    let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&ours).unwrap();
    unlockpt(&ours).unwrap();
    let name = ptsname(&ours, Vec::new()).unwrap();
    let theirs = rustix::fs::open(name.as_c_str(), OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap();
    rustix::stdio::dup2_stdin(&theirs).unwrap();
    rustix::stdio::dup2_stderr(&theirs).unwrap();
    let person = std::thread::spawn(move || answers(File::from(ours), &["enable", "reset", "no", ""]));
    let stop = AtomicBool::new(false);
    let first = Operator::new(OperatorPlace::Terminal);
    first.ask(&Wish::Enable("A learner will move the arm."), PATIENCE, &stop).unwrap();
    let second = Operator::new(OperatorPlace::Terminal);
    second.ask(&Wish::Reset("E-stop"), PATIENCE, &stop).unwrap();
    let refused = first.ask(&Wish::Reset("E-stop"), PATIENCE, &stop).unwrap_err();
    assert_eq!(refused.to_string(), "the operator refused: no");
    second.arrange(&Wish::Remove { object: "blue-block" }, &stop).unwrap();
    drop(person.join().unwrap());
}
