//! `pschema watch` on real processes: a daemon, a simulated body, and a terminal that is one.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::fs::PermissionsExt;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pty_process::Size;
use pty_process::blocking::{Pts, Pty};
use rustix::process::{Pid, Signal, kill_process};
use rustix::termios::{Termios, tcgetattr};
use serde_json::Value;
use tempfile::TempDir;

/// What any wait may take; a machine under load takes its time.
const PATIENCE: Duration = Duration::from_secs(60);

/// A runtime directory of the test's own.
struct House(TempDir);

/// A process; dropped, it is killed.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn signal(process: &Child, signal: Signal) {
    let pid = Pid::from_raw(i32::try_from(process.id()).unwrap()).unwrap();
    kill_process(pid, signal).unwrap();
}

impl Process {
    /// Ends it as it wants to be ended.
    fn end(mut self) {
        signal(&self.0, Signal::TERM);
        self.0.wait().unwrap();
    }
}

impl Drop for House {
    fn drop(&mut self) {
        // What a killed daemon left in shared memory.
        drop(self.run(&["doctor", "--clean"]));
    }
}

impl House {
    fn new() -> Self {
        let private = std::fs::Permissions::from_mode(0o700);
        let mut builder = tempfile::Builder::new();
        Self(builder.prefix("pst-").permissions(private).tempdir_in("/tmp").unwrap())
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", self.0.path()).env_remove("RUST_LOG");
        command.env_remove("NO_COLOR").env("TERM", "xterm-256color").stdin(Stdio::null());
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn start(&self, arguments: &[&str]) -> Process {
        Process(self.command(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
    }

    /// A daemon that answers.
    fn daemon(&self) -> Process {
        let daemon = self.start(&["server", "--seed", "3"]);
        self.until("the daemon answers", |status| (status["pid"] == daemon.0.id()).then_some(()));
        daemon
    }

    fn status(&self) -> Option<Value> {
        serde_json::from_slice(&self.run(&["status", "--json"]).stdout).ok()
    }

    /// Asks for the status until there is something to see in it.
    fn until<T>(&self, what: &str, look: impl Fn(&Value) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            if let Some(seen) = self.status().as_ref().and_then(&look) {
                return seen;
            }
            assert!(start.elapsed() < PATIENCE, "{what}: not within {PATIENCE:?}: {:?}", self.status());
        }
    }

    fn until_step_past(&self, step: u64) -> u64 {
        self.until("it acts", |status| status["step"].as_u64().filter(|now| *now > step))
    }

    fn watch(&self, arguments: &[&str]) -> Terminal {
        Terminal::start(self.command(&[&["watch"], arguments].concat()), 80, 24)
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn size(cells: u16) -> NonZeroU16 {
    NonZeroU16::new(cells).unwrap()
}

/// What is on the terminal, and a bell for when that changes.
type Shown = Arc<(Mutex<vt100::Parser>, Condvar)>;

/// A terminal of 80 by 24 with a process on it.
struct Terminal {
    process: Child,
    /// As it was before the process began.
    before: Termios,
    keyboard: Pty,
    /// Kept open, so that what the process leaves behind can be looked at.
    line: Option<Pts>,
    shown: Shown,
    reader: Option<JoinHandle<()>>,
}

impl Terminal {
    fn start(command: Command, columns: u16, rows: u16) -> Self {
        let (keyboard, line) = pty_process::blocking::open().unwrap();
        keyboard.resize(Size::new(rows, columns)).unwrap();
        let before = tcgetattr(line.as_fd()).unwrap();
        let mut own: OwnedFd = keyboard.as_fd().try_clone_to_owned().unwrap();
        let shown: Shown =
            Arc::new((Mutex::new(vt100::Parser::new(size(rows), size(columns), 0)), Condvar::new()));
        let written = Arc::clone(&shown);
        let reader = std::thread::spawn(move || read(&mut own, &written));
        let mut command = pty_process::blocking::Command::from(command);
        let process = command.spawn_borrowed(&line).unwrap();
        Self { process, before, keyboard, line: Some(line), shown, reader: Some(reader) }
    }

    fn press(&mut self, keys: &str) {
        self.keyboard.write_all(keys.as_bytes()).unwrap();
    }

    fn resize(&self, columns: u16, rows: u16) {
        // As a terminal does it: its own screen first, then what it says of it.
        self.shown.0.lock().unwrap().screen_mut().set_size(size(rows), size(columns));
        self.keyboard.resize(Size::new(rows, columns)).unwrap();
    }

    /// Waits until there is something to see.
    fn until<T>(&self, what: &str, look: impl Fn(&str) -> Option<T>) -> T {
        let start = Instant::now();
        let mut parser = self.shown.0.lock().unwrap();
        loop {
            let text = parser.screen().contents();
            if let Some(seen) = look(&text) {
                return seen;
            }
            let left = PATIENCE.saturating_sub(start.elapsed());
            assert!(!left.is_zero(), "{what}: not within {PATIENCE:?}; on the screen:\n{text}");
            parser = self.shown.1.wait_timeout(parser, left).unwrap().0;
        }
    }

    fn shows(&self, what: &str) {
        self.until(&format!("{what:?} is shown"), |screen| screen.contains(what).then_some(()));
    }

    /// Waits for the end of the process, and checks that it left the terminal as it was.
    fn ended(mut self) -> ExitStatus {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.process.try_wait().unwrap() {
                break status;
            }
            assert!(start.elapsed() < PATIENCE, "it ends");
            std::thread::yield_now();
        };
        let after = tcgetattr(self.line.as_ref().unwrap().as_fd()).unwrap();
        let modes = |termios: &Termios| {
            (termios.input_modes, termios.output_modes, termios.control_modes, termios.local_modes)
        };
        assert_eq!(modes(&after), modes(&self.before), "keys are read as they were before");
        // All that it wrote is read once the line is closed.
        self.line = None;
        self.reader.take().unwrap().join().unwrap();
        let parser = self.shown.0.lock().unwrap();
        assert!(!parser.screen().alternate_screen(), "what was there before is shown again");
        assert!(!parser.screen().hide_cursor(), "the cursor is shown again");
        drop(parser);
        status
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

/// Reads what is written on a terminal until nobody can write there any more.
fn read(from: &mut OwnedFd, shown: &Shown) {
    let mut from = std::fs::File::from(from.try_clone().unwrap());
    let mut bytes = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut bytes) {
        shown.0.lock().unwrap().process(&bytes[..count]);
        shown.1.notify_all();
    }
}

/// The step in the line at the top.
fn step(screen: &str) -> Option<u64> {
    screen.lines().next()?.split("step ").nth(1)?.split(' ').next()?.parse().ok()
}

fn is_held(status: &Value) -> Option<u64> {
    (status["stage_state"] == "held").then(|| status["step"].as_u64().unwrap())
}

#[test]
fn a_learner_is_watched_held_stepped_and_spoken_to() {
    let house = House::new();
    let daemon = house.daemon();
    let body = house.start(&["sim", "--seed", "3"]);
    house.until_step_past(20);
    let mut watch = house.watch(&["--rate", "20"]);
    watch.until("the camera, the world and the trace", |screen| {
        let all = ["\u{b7} \u{b7} \u{b7}", "finger{colour=green", "excitation", "touching", "space hold"];
        all.iter().all(|part| screen.contains(part)).then_some(())
    });

    watch.press(" ");
    let held_at = house.until("it is held", is_held);
    watch.shows("(held)");
    watch.until("the step at which it is held", |screen| (step(screen)? == held_at).then_some(()));

    watch.press(".");
    let stepped = house.until("one action", |status| is_held(status).filter(|step| *step > held_at));
    watch.until("the step taken", |screen| (step(screen)? == stepped).then_some(()));
    watch.shows("(held)");
    assert_eq!(house.until("it is held", is_held), stepped, "one action, and no more");

    watch.press(&format!("w{}\r", "x".repeat(200)));
    watch.shows("is no word");
    watch.press(" ");
    house.until("it goes on", |status| (status["stage_state"] != "held").then_some(()));
    watch.press("/touch\r");
    watch.shows("said \"touch\"");
    // A word that was never met is no symbol to look for; this one is now.
    let start = Instant::now();
    while house.run(&["schemas", "--post", "word{text=touch}"]).status.code() != Some(0) {
        assert!(start.elapsed() < PATIENCE, "the word was heard");
    }

    watch.press("f0\r");
    watch.shows("since you look");
    watch.press("3");
    watch.shows("each E = sum of its terms");
    watch.press("4");
    watch.until("the most used schemas", |screen| screen.contains("most used of ").then_some(()));
    watch.press("1");
    watch.resize(160, 50);
    watch.until("everything at once", |screen| {
        ["camera", "why it did what it did last", "newest schemas", "99th percentile"]
            .iter()
            .all(|part| screen.contains(part))
            .then_some(())
    });
    watch.press("q");
    assert_eq!(watch.ended().code(), Some(0));
    body.end();
    daemon.end();
}

#[test]
fn a_daemon_that_goes_is_missed_and_found_again() {
    let house = House::new();
    let first = house.daemon();
    let mut watch = house.watch(&[]);
    watch.shows("no body is attached");
    first.end();
    watch.shows("NO DAEMON ANSWERS");
    watch.press(".");
    watch.shows("it was not done");
    watch.press("x");
    let second = house.daemon();
    watch.until("the new daemon", |screen| {
        (!screen.contains("NO DAEMON") && step(screen) == Some(0)).then_some(())
    });
    watch.press("\u{3}");
    assert_eq!(watch.ended().code(), Some(0), "Ctrl-C is a way out, and no failure");
    second.end();
}

#[test]
fn signals_leave_the_terminal_as_it_was() {
    let house = House::new();
    let daemon = house.daemon();
    for way in [Signal::TERM, Signal::HUP, Signal::INT] {
        let watch = house.watch(&[]);
        watch.shows("no body is attached");
        signal(&watch.process, way);
        assert_eq!(watch.ended().code(), Some(0), "{way:?}");
    }
    daemon.end();
}

#[test]
fn a_terminal_that_hangs_up_ends_it() {
    let house = House::new();
    let daemon = house.daemon();
    let (mut keyboard, line) = pty_process::blocking::open().unwrap();
    keyboard.resize(Size::new(24, 80)).unwrap();
    let command = pty_process::blocking::Command::from(house.command(&["watch"]));
    let mut watch = Process(command.spawn(line).unwrap());
    let mut shown = vt100::Parser::new(size(24), size(80), 0);
    let mut bytes = [0; 4096];
    while !shown.screen().contents().contains("no body is attached") {
        let count = keyboard.read(&mut bytes).unwrap();
        shown.process(&bytes[..count]);
    }
    // As when a connection breaks: nobody reads what is drawn, and no key comes any more.
    drop(keyboard);
    let start = Instant::now();
    while watch.0.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < PATIENCE, "it ends");
        std::thread::yield_now();
    }
    daemon.end();
}

#[test]
fn one_frame_is_plain_text() {
    let house = House::new();
    let daemon = house.daemon();
    let body = house.start(&["sim", "--seed", "3"]);
    house.until_step_past(20);
    for (page, says) in [
        ("now", "excitation"),
        ("excitation", "last steps"),
        ("choice", "> E "),
        ("schemas", "most used of "),
        ("learner", "sim"),
        ("follow", "made in step"),
    ] {
        let output = house.run(&["watch", "--once", "--page", page, "--follow", "0"]);
        assert_eq!(output.status.code(), Some(0), "{page}: {}", text(&output.stderr));
        let frame = text(&output.stdout);
        assert_eq!(frame.lines().count(), 24, "{frame}");
        assert!(frame.lines().all(|line| line.chars().count() <= 80), "{frame}");
        assert!(frame.contains(says) && !frame.contains('\u{1b}'), "{page}:\n{frame}");
        assert!(step(&frame).is_some_and(|step| step > 20), "{frame}");
    }
    let output = house.run(&["watch", "--once", "--width", "160", "--height", "50"]);
    let frame = text(&output.stdout);
    assert_eq!(frame.lines().count(), 50, "{frame}");
    assert!(frame.contains("camera") && frame.contains("most used of "), "{frame}");
    assert!(frame.contains("\u{b7} \u{b7} \u{b7}"), "the fields came with a picture:\n{frame}");
    body.end();
    daemon.end();
}

#[test]
fn what_cannot_be_watched_is_refused_with_what_to_do() {
    let house = House::new();
    let help = text(&house.run(&["watch", "--help"]).stdout);
    assert!(help.contains("Example:\n  pschema watch") && help.contains("--once"), "{help}");
    let nobody = house.run(&["watch", "--once"]);
    assert_eq!(nobody.status.code(), Some(3), "{nobody:?}");
    assert!(text(&nobody.stderr).contains("pschema server"), "{nobody:?}");
    let no_terminal = house.run(&["watch"]);
    assert_eq!(no_terminal.status.code(), Some(2), "{no_terminal:?}");
    assert!(text(&no_terminal.stderr).contains("--once"), "{no_terminal:?}");
    let past = house.run(&["watch", "--data", "robot"]);
    assert_eq!(past.status.code(), Some(2), "{past:?}");
    assert!(text(&past.stderr).contains("--until"), "{past:?}");
    let on_a_terminal = house.watch(&[]);
    on_a_terminal.shows("no daemon");
    assert_eq!(on_a_terminal.ended().code(), Some(3), "before anything is drawn");
}
