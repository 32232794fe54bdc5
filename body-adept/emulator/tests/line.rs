//! The emulated controller from outside: text on a line, pictures and a person's deeds, and nothing else. No code of
//! the driver is used here.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

use pschema_vplus_emulator::{Dialect, Emulator, EmulatorArgs};
use serialport::SerialPort;

const DEADLINE: Duration = Duration::from_secs(30);

/// A place for the line and the sockets, gone when the test is.
struct Room {
    _directory: tempfile::TempDir,
    args: EmulatorArgs,
}

impl Room {
    fn new() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        let mut args = EmulatorArgs::at(&at("line"));
        (args.camera, args.operator) = (Some(at("camera")), Some(at("operator")));
        args.fast = 20.0;
        // Nobody pings here, and the machine may be busy.
        args.watchdog_ms = 60_000;
        Self { _directory: directory, args }
    }
}

fn open(path: &Path) -> Box<dyn SerialPort> {
    let port = serialport::new(path.to_str().unwrap(), 9600).timeout(Duration::from_millis(50)).open();
    port.unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Fletcher's sum, a third time.
fn summed(line: &str) -> String {
    let (mut a, mut b) = (0_u32, 0_u32);
    for byte in line.bytes() {
        a = (a + u32::from(byte)) % 255;
        b = (b + a) % 255;
    }
    format!("{line} *{}\n", b * 256 + a)
}

/// The next line that begins with `wanted`, without its sum.
fn next(port: &mut Box<dyn SerialPort>, wanted: &str) -> String {
    let start = Instant::now();
    let mut line = Vec::new();
    let mut byte = [0];
    while start.elapsed() < DEADLINE {
        match port.read(&mut byte) {
            Ok(1) if byte == [b'\n'] => {
                let text = String::from_utf8(std::mem::take(&mut line)).unwrap();
                if text.starts_with(wanted) {
                    return text.rsplit_once(" *").expect("a sum").0.to_owned();
                }
            }
            Ok(_) if byte != [b'\r'] => line.push(byte[0]),
            _ => {}
        }
    }
    panic!("no {wanted:?}, only {:?}", String::from_utf8_lossy(&line));
}

fn ask(port: &mut Box<dyn SerialPort>, line: &str) -> String {
    port.write_all(summed(line).as_bytes()).unwrap();
    let number = line.split(' ').nth(1).unwrap();
    let answer = next(port, "");
    assert!(answer.split(' ').nth(1) == Some(number), "{line} is answered {answer}");
    answer
}

fn told(socket: &Path, line: &str) -> String {
    let mut stream = UnixStream::connect(socket).unwrap();
    writeln!(stream, "{line}").unwrap();
    let mut answer = String::new();
    BufReader::new(stream).read_line(&mut answer).unwrap();
    answer.trim().to_owned()
}

/// A picture: its size and its pixels.
fn picture(socket: &Path) -> (usize, usize, Vec<u8>) {
    let mut stream = UnixStream::connect(socket).unwrap();
    stream.write_all(b"\n").unwrap();
    let mut reader = BufReader::new(stream);
    let mut lines = [String::new(), String::new(), String::new()];
    for line in &mut lines {
        reader.read_line(line).unwrap();
    }
    assert_eq!((lines[0].as_str(), lines[2].as_str()), ("P6\n", "255\n"));
    let (width, height) = lines[1].trim().split_once(' ').unwrap();
    let (width, height): (usize, usize) = (width.parse().unwrap(), height.parse().unwrap());
    let mut pixels = vec![0; width * height * 3];
    reader.read_exact(&mut pixels).unwrap();
    (width, height, pixels)
}

fn blue(pixels: &[u8]) -> usize {
    pixels.chunks(3).filter(|p| p[2] > 80 && p[2] / 2 > p[0] && p[2] - 30 > p[1]).count()
}

#[test]
fn the_arm_moves_on_the_line_and_is_seen_by_the_camera() {
    let room = Room::new();
    let emulator = Emulator::start(room.args.clone()).unwrap();
    let mut port = open(&room.args.link);
    assert_eq!(ask(&mut port, "HELLO 1"), "OK 1 PSCHEMA 1 4 60000");
    assert_eq!(ask(&mut port, "POWER 2 1"), "OK 2");
    assert_eq!(ask(&mut port, "CAL 3"), "OK 3");
    let (camera, operator) = (room.args.camera.unwrap(), room.args.operator.unwrap());
    let (width, height, empty) = picture(&camera);
    assert_eq!((width, height), (780, 580));
    assert_eq!(ask(&mut port, "MOVE 4 1 40 10 -114.4 117.2 -57.8"), "OK 4");
    assert_eq!(next(&mut port, "END"), "END 4 0");
    assert_eq!(ask(&mut port, "WHERE 5"), "OK 5 10.000 -114.400 117.200 -57.800");
    assert_ne!(picture(&camera).2, empty, "the arm is in the picture");
    assert_eq!(blue(&empty), 0);
    assert_eq!(told(&operator, "place blue-block 7"), "done");
    assert!(blue(&picture(&camera).2) > 100);
    assert!(told(&operator, "place blue-block 999").starts_with("refused there is no position 999"));
    assert!(told(&operator, "place red-ball 1").contains("only blue-block, red-block, yellow-block"));
    assert!(told(&operator, "enable please").starts_with("refused"));
    let record = emulator.record();
    assert_eq!((record.motions, record.envelope_errors, record.pictures), (1, 0, 3));
    drop(emulator);
    assert!(!room.args.link.exists() && !camera.exists() && !operator.exists(), "it leaves nothing");
}

#[test]
fn a_guarded_motion_ends_at_the_first_touch_and_the_block_stays() {
    let room = Room::new();
    let emulator = Emulator::start(room.args.clone()).unwrap();
    let mut port = open(&room.args.link);
    ask(&mut port, "POWER 1 1");
    ask(&mut port, "CAL 2");
    // Straight along the table, at finger height, through where a block stands.
    let workspace = pschema_sim::workspace::Workspace::new(
        "narrow",
        pschema_sim::config::WorldFile::load("narrow").unwrap(),
    )
    .unwrap();
    let position = (0..100).min_by(|a, b| {
        let off = |at: &usize| (workspace.places[*at].centre_m.0.abs() * 1e6) as u64;
        off(a).cmp(&off(b))
    });
    let position = position.unwrap();
    let (x, y) = workspace.places[position].centre_m;
    let degrees = |out_m: f64, lift_m: f64| {
        let at = pschema_sim::manifold::OnManifold { bearing_rad: x.atan2(y), arc_m: out_m };
        let posture = workspace.arm.posture_above(&workspace.manifold, at, lift_m).unwrap();
        posture.angles_rad.map(|angle| format!("{:.3}", angle.to_degrees())).join(" ")
    };
    let distance_m = x.hypot(y);
    assert_eq!(told(room.args.operator.as_ref().unwrap(), &format!("place blue-block {position}")), "done");
    ask(&mut port, &format!("VIA 3 20 {}", degrees(0.1, 0.1)));
    ask(&mut port, &format!("MOVE 3 1 20 {}", degrees(distance_m - 0.05, 0.06)));
    assert_eq!(next(&mut port, "END"), "END 3 0");
    ask(&mut port, &format!("MOVE 4 1 10 {}", degrees(distance_m - 0.04, 0.0)));
    assert_eq!(next(&mut port, "END"), "END 4 0");
    assert_eq!(ask(&mut port, "STAT 5"), "OK 5 1 1 0 0 0 0 4 0");
    ask(&mut port, &format!("MOVE 6 1 4 {}", degrees(distance_m + 0.03, 0.0)));
    assert_eq!(next(&mut port, "END"), "END 6 1");
    // The far side of the finger feels it: signal 1004.
    assert_eq!(ask(&mut port, "STAT 7"), "OK 7 1 1 0 0 0 8 6 1");
    // On through it without the guard: pushed, not passed through.
    ask(&mut port, &format!("MOVE 8 0 4 {}", degrees(distance_m + 0.03, 0.0)));
    assert_eq!(next(&mut port, "END"), "END 8 0");
    assert_eq!(emulator.record().envelope_errors, 0);
}

#[test]
fn a_line_pulled_out_hangs_up_and_comes_back_under_its_name() {
    let room = Room::new();
    let _emulator = Emulator::start(room.args.clone()).unwrap();
    let mut port = open(&room.args.link);
    assert_eq!(ask(&mut port, "PING 1"), "OK 1");
    assert_eq!(told(room.args.operator.as_ref().unwrap(), "unplug 50"), "done");
    let start = Instant::now();
    while port.write_all(b"\n").and_then(|()| port.read(&mut [0])).is_ok_and(|read| read > 0) {
        assert!(start.elapsed() < DEADLINE, "it never hangs up");
    }
    drop(port);
    while !room.args.link.exists() {
        assert!(start.elapsed() < DEADLINE, "it never comes back");
        std::thread::yield_now();
    }
    assert_eq!(ask(&mut open(&room.args.link), "PING 2"), "OK 2");
}

#[test]
fn a_paced_line_takes_as_long_as_its_characters_do() {
    let mut room = Room::new();
    room.args.baud = Some(9600);
    let _emulator = Emulator::start(room.args.clone()).unwrap();
    let mut port = open(&room.args.link);
    let start = Instant::now();
    let answer = ask(&mut port, "WHERE 1");
    let characters = summed("WHERE 1").len() + answer.len();
    let least = Duration::from_micros(1042) * u32::try_from(characters).unwrap();
    assert!(start.elapsed() > least.mul_f64(0.8), "{characters} characters in {:?}", start.elapsed());
}

#[test]
fn the_monitor_prompts_echoes_and_asks() {
    let mut room = Room::new();
    room.args.speaks = Dialect::Monitor;
    let _emulator = Emulator::start(room.args.clone()).unwrap();
    let mut port = open(&room.args.link);
    let mut until = |typed: &str, wanted: &str| {
        port.write_all(typed.as_bytes()).unwrap();
        let start = Instant::now();
        let mut heard = String::new();
        while !heard.contains(wanted) {
            assert!(start.elapsed() < DEADLINE, "no {wanted:?} in {heard:?}");
            let mut bytes = [0; 64];
            if let Ok(read) = port.read(&mut bytes) {
                heard.push_str(&String::from_utf8_lossy(&bytes[..read]));
            }
        }
        heard
    };
    until("", "Adept V+");
    until("", "\r\n.");
    until("ENABLE POWER\r\n", "\r\n.");
    until("CALIBRATE\r\n", "(Y/N)? ");
    until("Y\r\n", "\r\n.");
    until("DO SET #P=#PPOINT(20,-114.4,117.2,-57.8)\r\n", "\r\n.");
    until("DO MOVE #P\r\n", "\r\n.");
    until("DO BREAK\r\n", "\r\n.");
    let where_ = until("WHERE\r\n", "\r\n.");
    assert!(where_.starts_with("WHERE\r\n") && where_.contains("-114.400"), "{where_:?}");
}
