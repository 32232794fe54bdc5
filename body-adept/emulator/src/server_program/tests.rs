//! The emulated program between its lines.

use super::*;

const WATCHDOG: Duration = Duration::from_millis(100);

/// The program with an arm, and the clock on the wall in its own hands.
struct Bench {
    program: ServerProgram,
    machine: Machine,
    now: Instant,
}

impl Bench {
    fn new() -> Self {
        let now = Instant::now();
        Self { program: ServerProgram::new(WATCHDOG, now), machine: Machine::new("narrow", 1).unwrap(), now }
    }

    /// With power, calibrated.
    fn ready() -> Self {
        let mut bench = Self::new();
        assert_eq!(bench.ask("POWER 1 1"), Vec::<String>::new());
        assert_eq!(bench.wait(3.0), ["OK 1"]);
        assert_eq!(bench.ask("CAL 2"), Vec::<String>::new());
        assert_eq!(bench.wait(4.0), ["OK 2"]);
        bench
    }

    fn raw(&mut self, bytes: &[u8]) -> Vec<String> {
        self.program.take(bytes, &mut self.machine, self.now);
        self.said()
    }

    fn ask(&mut self, line: &str) -> Vec<String> {
        self.raw(format!("{}\n", sum::summed(line)).as_bytes())
    }

    fn watch(&mut self) -> Vec<String> {
        self.raw(b"")
    }

    /// Lets the arm's time pass, not that on the wall.
    fn wait(&mut self, time_s: f64) -> Vec<String> {
        for _ in 0..(time_s / 0.01) as usize {
            self.machine.advance(0.01);
            for event in self.machine.events() {
                self.program.tell(event, &mut self.machine);
            }
        }
        self.said()
    }

    /// The lines said since this was asked last, without their sums.
    fn said(&mut self) -> Vec<String> {
        let unsealed = |line: String| sum::checked(line.trim_end()).expect("a right sum").to_owned();
        self.program.said().into_iter().map(unsealed).collect()
    }
}

#[test]
fn nothing_moves_before_power_and_calibration() {
    let mut bench = Bench::new();
    let here = bench.ask("WHERE 1");
    assert!(here[0].starts_with("OK 1 0.000 "), "{here:?}");
    assert_eq!(bench.ask("MOVE 2 0 5 0 -114.4 117.2 -57.8"), ["ERR 2 -604 Robot power off"]);
    bench.ask("POWER 3 1");
    assert_eq!(bench.wait(3.0), ["OK 3"]);
    assert_eq!(bench.ask("MOVE 4 0 5 0 -114.4 117.2 -57.8"), ["ERR 4 -605 Robot not calibrated"]);
    assert_eq!(bench.ask("WHERE 5")[0][5..], here[0][5..]);
    assert_eq!(bench.machine.record().motions, 0);
}

#[test]
fn a_motion_is_acknowledged_ends_where_it_should_and_is_told_of_once() {
    let mut bench = Bench::ready();
    assert_eq!(bench.ask("HELLO 3"), ["OK 3 PSCHEMA 1 4 100"]);
    assert_eq!(bench.ask("VIA 4 50 10 -114.4 117.2 -57.8"), ["OK 4 1"]);
    assert_eq!(bench.ask("MOVE 5 0 50 20 -114.4 117.2 -57.8"), ["OK 5"]);
    assert_eq!(bench.ask("MOVE 6 0 50 0 -114.4 117.2 -57.8"), ["ERR 6 10 busy"]);
    assert_eq!(bench.ask("STAT 7"), ["OK 7 1 1 0 1 0 0 0 0"]);
    assert_eq!(bench.wait(5.0), ["END 5 0"]);
    assert_eq!(bench.ask("WHERE 8"), ["OK 8 20.000 -114.400 117.200 -57.800"]);
    assert_eq!(bench.ask("STAT 9"), ["OK 9 1 1 0 0 0 0 5 0"]);
    // The same line once more moves nothing.
    assert_eq!(bench.ask("MOVE 5 0 50 0 -114.4 117.2 -57.8"), ["ERR 5 17 repeated"]);
    assert_eq!(bench.machine.record().motions, 1);
}

#[test]
fn what_is_not_a_motion_within_the_softstops_moves_nothing() {
    let mut bench = Bench::ready();
    for (line, why) in [
        ("MOVE 3 0 5 121 -114.4 117.2 -57.8", "-610"),
        ("MOVE 3 0 5 0 -114.4 117.2 11", "-610"),
        ("MOVE 3 0 5 nan -114.4 117.2 -57.8", "12"),
        ("MOVE 3 0 5 inf -114.4 117.2 -57.8", "12"),
        ("MOVE 3 0 5 1e1 -114.4 117.2 -57.8", "12"),
        ("MOVE 3 0 5 0 -114.4 117.2", "12"),
        ("MOVE 3 0 5 0 -114.4 117.2 -57.8 0", "12"),
        ("MOVE 3 0 0 0 -114.4 117.2 -57.8", "12"),
        ("MOVE 3 0 101 0 -114.4 117.2 -57.8", "12"),
        ("MOVE 3 3 5 0 -114.4 117.2 -57.8", "12"),
        ("MOVE 3", "12"),
        ("GO 3", "15"),
    ] {
        let answer = bench.ask(line);
        assert!(answer.len() == 1 && answer[0].starts_with(&format!("ERR 3 {why} ")), "{line}: {answer:?}");
    }
    for bytes in [
        &b"MOVE 3 0 5 0 -114.4 117.2 -57.8\n"[..],
        b"MOVE 3 0 5 0 -114.4 117.2 -57.8 *1\n",
        &[0xff, b'\n'],
        &[b'x'; 500],
    ] {
        bench.raw(bytes);
    }
    assert_eq!(bench.raw(b"\n"), ["ERR 0 16 checksum"], "what was too long is thrown away to its end");
    assert_eq!(bench.machine.record().motions, 0);
}

#[test]
fn a_stop_needs_no_proof_and_is_obeyed_in_every_state() {
    for stop in [&b"STOP\n"[..], b"\x03", b"garbage STO\x03"] {
        let mut bench = Bench::ready();
        bench.raw(stop);
        bench.raw(b"\n");
        bench.ask("MOVE 3 0 20 60 -114.4 117.2 -57.8");
        bench.wait(0.5);
        bench.raw(stop);
        let ended = bench.wait(0.2);
        assert_eq!(ended, ["END 3 2"]);
        let here = bench.machine.joints();
        bench.wait(1.0);
        assert_eq!(bench.machine.joints(), here);
    }
}

#[test]
fn a_silent_line_stops_the_motion_and_moves_are_refused_until_a_reset() {
    let mut bench = Bench::ready();
    bench.ask("MOVE 3 0 20 60 -114.4 117.2 -57.8");
    bench.now += WATCHDOG;
    bench.watch();
    assert_eq!(bench.machine.record().watchdog_stops, 0, "not yet");
    bench.now += Duration::from_millis(1);
    bench.watch();
    assert_eq!(bench.wait(0.3), ["END 3 3"]);
    assert_eq!(bench.ask("MOVE 4 0 20 60 -114.4 117.2 -57.8"), ["ERR 4 11 latched"]);
    assert_eq!(bench.ask("RESET 5"), ["OK 5"]);
    assert_eq!(bench.ask("MOVE 6 0 20 60 -114.4 117.2 -57.8"), ["OK 6"]);
    // Standing still, silence harms nobody.
    bench.wait(5.0);
    bench.now += WATCHDOG * 10;
    bench.watch();
    assert_eq!(bench.machine.record().watchdog_stops, 1);
}

#[test]
fn an_emergency_stop_takes_power_away_and_nothing_moves_by_itself_afterwards() {
    let mut bench = Bench::ready();
    bench.ask("MOVE 3 0 20 60 -114.4 117.2 -57.8");
    bench.wait(0.5);
    bench.machine.press(true);
    assert_eq!(bench.wait(0.5), ["END 3 -645"]);
    assert_eq!(bench.ask("STAT 4"), ["OK 4 0 0 1 0 1 0 3 -645"]);
    assert_eq!(bench.ask("RESET 5"), ["ERR 5 -645 E-STOP from user E-STOP button"]);
    bench.machine.press(false);
    assert_eq!(bench.ask("RESET 6"), ["OK 6"]);
    assert_eq!(bench.ask("MOVE 7 0 20 60 -114.4 117.2 -57.8"), ["ERR 7 -604 Robot power off"]);
    let here = bench.machine.joints();
    bench.wait(5.0);
    assert_eq!(bench.machine.joints(), here);
}

/// Power that comes up and a calibration end by the byte that stops and when nobody feeds the watchdog: without power.
#[test]
fn a_calibration_is_stopped_like_a_motion() {
    for stopped_by_the_host in [true, false] {
        let mut bench = Bench::new();
        bench.ask("POWER 1 1");
        assert_eq!(bench.raw(b"\x03\n"), ["ERR 1 18 stopped", "ERR 0 16 checksum"]);
        assert_eq!(bench.wait(3.0), Vec::<String>::new());
        assert!(!bench.machine.has_power());
        bench.ask("POWER 2 1");
        assert_eq!(bench.ask("STAT 3"), ["OK 3 0 0 0 1 0 0 0 0"], "busy");
        assert_eq!(bench.wait(3.0), ["OK 2"]);
        bench.ask("CAL 4");
        assert_eq!(bench.ask("MOVE 5 0 20 60 -114.4 117.2 -57.8"), ["ERR 5 10 busy"]);
        bench.wait(1.0);
        let said = if stopped_by_the_host {
            bench.raw(b"\x03")
        } else {
            bench.now += WATCHDOG * 2;
            bench.watch()
        };
        assert_eq!(said, ["ERR 4 18 stopped"]);
        bench.raw(b"\n");
        assert_eq!(bench.wait(10.0), Vec::<String>::new());
        let latched = u8::from(!stopped_by_the_host);
        assert_eq!(bench.ask("STAT 6"), [format!("OK 6 0 0 0 0 {latched} 0 0 0")]);
        assert_eq!(bench.machine.record().calibrations, 0);
    }
}

#[test]
fn an_error_in_the_program_stops_the_arm_and_is_told() {
    let mut bench = Bench::ready();
    bench.ask("MOVE 3 0 20 60 -114.4 117.2 -57.8");
    bench.wait(0.5);
    bench.program.trip(&mut bench.machine).unwrap();
    assert_eq!(bench.said(), ["ERR 0 -524 Communications overrun"]);
    assert_eq!(bench.wait(0.3), ["END 3 3"]);
    assert_eq!(bench.ask("MOVE 4 0 20 60 -114.4 117.2 -57.8"), ["ERR 4 11 latched"]);
}

#[test]
fn the_arm_driven_into_the_table_loses_power_instead() {
    let mut bench = Bench::ready();
    bench.ask("MOVE 3 0 20 0 -86.4 66.1 -34.6");
    assert_eq!(bench.wait(10.0), ["END 3 -1006"]);
    assert!(!bench.machine.has_power());
    assert_eq!(bench.machine.record().envelope_errors, 1);
}

/// A driver that drops what it has not sent yet may have sent an order but for its line end, which the bytes that stop
/// then bring.
#[test]
fn a_stop_is_not_the_end_of_the_order_that_it_cuts_short() {
    let order = sum::summed("MOVE 3 0 20 60 -114.4 117.2 -57.8");
    let mut bench = Bench::ready();
    let here = bench.machine.joints();
    assert_eq!(bench.raw(order.as_bytes()), Vec::<String>::new());
    assert_eq!(bench.raw(b"\x03\nSTOP\n"), ["ERR 0 16 checksum", "OK 0"]);
    assert_eq!(bench.wait(1.0), Vec::<String>::new());
    assert_eq!((bench.machine.record().motions, bench.machine.joints()), (0, here));
    // The same line is an order where nothing stops it.
    assert_eq!(bench.raw(format!("{order}\n").as_bytes()), ["OK 3"]);
}

#[test]
fn noise_does_not_keep_a_motion_alive() {
    let mut bench = Bench::ready();
    bench.ask("MOVE 3 0 20 60 -114.4 117.2 -57.8");
    let step = WATCHDOG * 2 / 3;
    // Lines of the host do.
    for _ in 0..3 {
        bench.now += step;
        bench.watch();
        bench.ask("PING 4");
    }
    assert_eq!(bench.machine.record().watchdog_stops, 0);
    for noise in [&b"\n"[..], b"PING 5 *1\n"] {
        bench.now += step;
        assert_eq!(bench.raw(noise), ["ERR 0 16 checksum"]);
        bench.watch();
    }
    assert_eq!(bench.machine.record().watchdog_stops, 1);
    assert_eq!(bench.wait(0.3), ["END 3 3"]);
}

#[test]
fn what_is_latched_gets_no_power_and_is_not_calibrated_before_a_reset() {
    for powered in [false, true] {
        let mut bench = Bench::new();
        if powered {
            bench.ask("POWER 1 1");
            assert_eq!(bench.wait(3.0), ["OK 1"]);
        }
        bench.program.trip(&mut bench.machine).unwrap();
        bench.said();
        assert_eq!(bench.ask("POWER 2 1"), ["ERR 2 11 latched"]);
        assert_eq!(bench.ask("CAL 3"), ["ERR 3 11 latched"]);
        assert_eq!(bench.machine.record().calibrations_begun, 0);
        assert_eq!(bench.machine.record().power_ups, u64::from(powered));
        assert_eq!(bench.ask("POWER 4 0"), ["OK 4"], "taking it away is always allowed");
        assert_eq!(bench.ask("RESET 5"), ["OK 5"]);
        bench.ask("POWER 6 1");
        assert_eq!(bench.wait(3.0), ["OK 6"]);
    }
}
