//! The program for the controller, as text: nothing here can run it, but what its safety rests on can be read.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::collections::{BTreeMap, BTreeSet};

const SOURCE: &str = include_str!("../vplus/pschema.v2");

/// The lines of each program, without comments.
fn programs() -> BTreeMap<String, Vec<String>> {
    let mut programs = BTreeMap::new();
    let mut under_way: Option<(String, Vec<String>)> = None;
    for line in SOURCE.lines() {
        let code = line.split(';').next().unwrap().trim();
        if let Some(head) = code.strip_prefix(".PROGRAM ") {
            assert!(under_way.is_none(), "{head} begins within another");
            under_way = Some((head.split('(').next().unwrap().to_owned(), Vec::new()));
        } else if code == ".END" {
            let (name, lines) = under_way.take().unwrap();
            assert!(programs.insert(name, lines).is_none());
        } else if !code.is_empty() {
            under_way.as_mut().unwrap_or_else(|| panic!("outside a program: {code}")).1.push(code.to_owned());
        }
    }
    assert!(under_way.is_none());
    programs
}

/// The programs that lines name after a word.
fn named(lines: &[String], word: &str) -> Vec<String> {
    let name = |line: &String| {
        let rest = line.strip_prefix(word)?.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ');
        Some(rest.split('(').next()?.trim().to_owned())
    };
    lines.iter().filter_map(name).collect()
}

/// All lines that run as a part of a program.
fn all_lines(programs: &BTreeMap<String, Vec<String>>, root: &str) -> Vec<String> {
    let (mut seen, mut left, mut lines) = (BTreeSet::new(), vec![root.to_owned()], Vec::new());
    while let Some(name) = left.pop() {
        if seen.insert(name.clone()) {
            let own = &programs[&name];
            left.extend(named(own, "CALL "));
            left.extend(named(own, "REACTE "));
            lines.extend(own.iter().cloned());
        }
    }
    lines
}

#[test]
fn blocks_are_closed_and_what_is_called_is_there() {
    let programs = programs();
    for (name, lines) in &programs {
        let opened = lines.iter().filter(|line| {
            let (is, ends) = (|word: &str| line.starts_with(word), |word: &str| line.ends_with(word));
            (is("IF ") && ends("THEN"))
                || (is("WHILE ") && ends("DO"))
                || is("FOR ")
                || (is("CASE ") && ends("OF"))
        });
        let closed = lines.iter().filter(|line| *line == "END").count();
        assert_eq!(opened.count(), closed, "{name}");
        for word in ["CALL ", "REACTE ", "EXECUTE "] {
            for called in named(lines, word) {
                assert!(programs.contains_key(&called), "{name}: {word}{called}");
            }
        }
        for line in lines {
            assert_eq!(line.matches('(').count(), line.matches(')').count(), "{name}: {line}");
            assert_eq!(line.matches('"').count() % 2, 0, "{name}: {line}");
        }
    }
}

/// A variable that was never set is an error of V+.
#[test]
fn every_variable_is_set_somewhere() {
    let programs = programs();
    let lines: Vec<&String> = programs.values().flatten().collect();
    let set = |name: &str| {
        lines.iter().any(|line| {
            let assigned = line.strip_prefix(name).is_some_and(|rest| {
                let rest = if rest.starts_with('[') { rest.split_once(']').unwrap().1 } else { rest };
                rest.trim_start().starts_with('=')
            });
            // Set by what is called, or by the instruction.
            assigned
                || line.contains(&format!("ATTACH ({name},"))
                || line.contains(&format!("DECOMPOSE {name}["))
                || (line.starts_with("CALL ") && line.ends_with(&format!("{name})")))
        })
    };
    for line in &lines {
        for word in line.split(|c: char| !(c.is_ascii_alphanumeric() || "._$#".contains(c))) {
            let name = word.trim_start_matches('#');
            if !name.trim_start_matches('$').starts_with("ps.")
                || programs.contains_key(name)
                || word.starts_with('#')
            {
                continue;
            }
            assert!(set(name), "{name} in {line:?}");
        }
    }
}

/// A `WRITE` that flow control holds up, or a line that fails, must not hold up what stops the arm.
#[test]
fn what_watches_and_what_moves_neither_reads_nor_writes() {
    let programs = programs();
    for root in ["ps.watch", "ps.robot", "ps.stop"] {
        for line in all_lines(&programs, root) {
            for blocking in ["READ", "WRITE", "GETC", "TYPE", "PROMPT", "ATTACH", "DETACH", "FOPEN", "IOSTAT"]
            {
                assert!(!line.contains(blocking), "{root} comes to {line:?}");
            }
        }
    }
    let watching = all_lines(&programs, "ps.watch").join("\n");
    for duty in ["TIMER(1) > ps.watchdog", "CALL ps.felt", "BRAKE"] {
        assert!(watching.contains(duty), "{duty}");
    }
    assert!(programs["pschema"].iter().any(|line| line == "EXECUTE 2 ps.watch()"), "in a task of its own");
}

/// Each task traps its errors: the arm stops and is latched, and the task ends. To `RETURN` would resume, or repeat,
/// what failed: the motion, perhaps, as soon as there is power again.
#[test]
fn an_error_in_any_task_stops_the_arm_and_resumes_nothing() {
    let programs = programs();
    for (task, reaction) in [("ps.robot", "ps.failed"), ("ps.serve", "ps.tripped"), ("ps.watch", "ps.blind")]
    {
        assert_eq!(named(&programs[task], "REACTE "), [reaction]);
        let lines = &programs[reaction];
        assert!(lines.iter().any(|line| line == "ps.latched = TRUE"), "{reaction}");
        assert!(lines.iter().any(|line| line == "ps.halt = TRUE" || line == "CALL ps.stop(3)"), "{reaction}");
        assert_eq!(lines.last().map(String::as_str), Some("HALT"), "{reaction}");
        assert!(!lines.iter().any(|line| line.starts_with("RETURN")), "{reaction}");
    }
    assert!(programs["ps.tell"].iter().any(|line| line.contains("ERR 0 ")), "the host is told");
}

#[test]
fn values_are_counted_before_they_are_read() {
    let programs = programs();
    let lines = &programs["ps.line"];
    let at =
        |what: &str| lines.iter().position(|line| line.contains(what)).unwrap_or_else(|| panic!("{what}"));
    assert!(at("IF ps.values < 1 THEN") < at("n = ps.value[1]"));
    assert!(at("IF ps.values <> 2 THEN") < at("ps.value[2]"));
    assert!(at("IF ps.values >= 9 THEN") < at("ps.value[ps.values] ="));
    for line in lines.iter().filter(|line| line.contains("ps.values <")) {
        assert!(!line.contains(" OR "), "both sides are looked at: {line}");
    }
}

/// The lines from one that is so to the next that is another.
fn between<'a>(lines: &'a [String], from: &str, to: &str) -> Vec<&'a str> {
    let at = lines.iter().position(|line| line == from).unwrap_or_else(|| panic!("{from}"));
    lines[at + 1..].iter().map(String::as_str).take_while(|line| *line != to).collect()
}

/// The byte that stops is followed by a line end: it may be all that was missing of the order that was cut short.
#[test]
fn the_byte_that_stops_spoils_the_line_that_it_comes_in() {
    let programs = programs();
    let stop = between(&programs["ps.serve"], "VALUE 3:", "VALUE 10:");
    assert_eq!(stop, ["CALL ps.stop(2)", "$line = \"?\""]);
}

#[test]
fn only_a_line_whose_sum_is_right_feeds_the_watchdog() {
    let programs = programs();
    let feeds = |name: &str| programs[name].iter().filter(|line| *line == "TIMER 1 = 0").count();
    let fed: Vec<&String> = programs.keys().filter(|name| feeds(name) > 0).collect();
    assert_eq!(fed, ["ps.line", "ps.setup"]);
    assert_eq!(feeds("ps.line"), 1);
    let lines = &programs["ps.line"];
    let feeding = lines.iter().position(|line| line == "TIMER 1 = 0").unwrap();
    let refusal =
        ["CALL ps.unseal($t, s)", "IF NOT s THEN", "CALL ps.say(\"ERR 0 16 checksum\")", "RETURN", "END"];
    assert_eq!(lines[feeding - refusal.len()..feeding], refusal);
}

/// A stop may come after an order was taken and before task 0 carries it out.
#[test]
fn what_was_stopped_before_it_was_begun_brings_no_power_up_and_calibrates_nothing() {
    let programs = programs();
    let robot = &programs["ps.robot"];
    let power = between(robot, "VALUE 2:", "VALUE 3:");
    assert_eq!(
        power,
        [
            "IF NOT ps.halt THEN",
            "ENABLE POWER",
            "WAIT (STATE(1) >= 4) OR ps.halt",
            "IF ps.halt THEN",
            "DISABLE POWER",
            "END",
            "END"
        ]
    );
    assert_eq!(between(robot, "VALUE 3:", "END"), ["IF NOT ps.halt THEN", "CALIBRATE"]);
}

#[test]
fn nothing_that_moves_or_gives_power_is_begun_while_latched() {
    let programs = programs();
    let order = &programs["ps.order"];
    let refused = order.iter().position(|line| line.starts_with("IF ps.latched OR ")).unwrap();
    assert!(order[refused + 1].contains(" 11 latched"), "{}", order[refused + 1]);
    assert_eq!(order[refused + 2], "RETURN");
    assert!(refused < order.iter().position(|line| line == "ps.go = TRUE").unwrap());
    // There is no other way to task 0.
    for (name, lines) in &programs {
        assert!(name == "ps.order" || !lines.iter().any(|line| line == "ps.go = TRUE"), "{name}");
    }
}
