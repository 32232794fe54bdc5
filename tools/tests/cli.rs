//! What can be typed: help, usage and exit codes, on the real binary.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod described;

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// A runtime directory of the test's own, short enough for sockets.
fn runtime() -> TempDir {
    let private = std::fs::Permissions::from_mode(0o700);
    tempfile::Builder::new().prefix("pschema-").permissions(private).tempdir_in("/tmp").unwrap()
}

fn pschema(runtime: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
    command.args(arguments).env("PSCHEMA_RUNTIME_DIR", runtime).env_remove("RUST_LOG").stdin(Stdio::null());
    command.output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

const COMMANDS: [&str; 21] = [
    "demo",
    "server",
    "sim",
    "status",
    "schemas",
    "show",
    "claims",
    "explain",
    "say",
    "stage",
    "view",
    "journal",
    "verify",
    "repair",
    "replay",
    "export",
    "import",
    "experiment",
    "conformance",
    "doctor",
    "completions",
];

#[test]
fn every_command_has_help_with_an_example() {
    let runtime = runtime();
    let all = pschema(runtime.path(), &["--help"]);
    for command in COMMANDS {
        assert!(text(&all.stdout).contains(&format!("  {command} ")), "{command} is not in `pschema --help`");
        let help = pschema(runtime.path(), &[command, "--help"]);
        assert_eq!(help.status.code(), Some(0), "{command}");
        let help = text(&help.stdout);
        assert!(help.contains("Example:\n  pschema "), "{command} has no example:\n{help}");
        let on_disk = ["journal", "verify", "repair", "replay", "import"].contains(&command);
        assert!(!on_disk || help.contains("--data"), "{command} has no --data:\n{help}");
        let alone = ["demo", "experiment", "doctor", "completions"].contains(&command);
        assert!(on_disk || alone || help.contains("--name"), "{command} has no --name:\n{help}");
    }
    for order in ["show", "next", "hold", "resume", "set"] {
        let help = text(&pschema(runtime.path(), &["stage", order, "--help"]).stdout);
        assert!(help.contains("Example:\n  pschema stage "), "stage {order}:\n{help}");
    }
}

#[test]
fn a_name_is_taken_before_and_after_the_command() {
    let runtime = runtime();
    for arguments in [["--name", "robot-1", "status"], ["status", "--name", "robot-1"]] {
        let output = pschema(runtime.path(), &arguments);
        assert_eq!(output.status.code(), Some(3), "{arguments:?}");
        assert!(text(&output.stderr).contains("robot-1"), "{}", text(&output.stderr));
    }
}

#[test]
fn without_a_daemon_asking_exits_3_and_says_how_to_start_one() {
    let runtime = runtime();
    let questions: [&[&str]; 7] = [
        &["status"],
        &["status", "--json"],
        &["schemas", "--generalised"],
        &["show", "1"],
        &["explain"],
        &["say", "touch"],
        &["stage", "next"],
    ];
    for question in questions {
        let output = pschema(runtime.path(), question);
        assert_eq!(output.status.code(), Some(3), "{question:?}: {}", text(&output.stderr));
        assert!(output.stdout.is_empty(), "{question:?} has no result");
        let said = text(&output.stderr);
        assert!(said.contains("no daemon") && said.contains("start one"), "{question:?}: {said}");
    }
}

#[test]
fn wrong_usage_exits_2_and_points_at_it() {
    let runtime = runtime();
    let slips: [(&[&str], &str); 9] = [
        (&["demo", "--sead", "1"], "--seed"),
        (&["no-such-command"], "no-such-command"),
        (&["show"], "<ID>"),
        (&["show", "first"], "first"),
        (&["--name", "No Good", "status"], "a-z"),
        (&["experiment", "exp9"], "exp1-s1"),
        (&["experiment", "exp1-s1", "--seeds", "9..1"], "above"),
        (&["schemas", "--limit", "0"], "0"),
        (&["say"], "<WORD>"),
    ];
    for (arguments, says) in slips {
        let output = pschema(runtime.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(text(&output.stderr).contains(says), "{arguments:?}: {}", text(&output.stderr));
    }
}

/// Where an option stood before an order and behind it as well, the second was obeyed and the first forgotten.
#[test]
fn no_argument_is_obeyed_in_part() {
    let runtime = runtime();
    let cases: [&[&str]; 12] = [
        &["stage", "--name", "a", "step", "--name", "b"],
        &["--name", "a", "stage", "step", "--name", "b"],
        &["stage", "--data", "life", "--until", "3", "show", "--until", "5"],
        &["stage", "next", "first touches"],
        &["stage", "set"],
        &["explain", "--data", "life", "--step", "10", "--until", "5"],
        &["explain", "--data", "life", "--why-not", "3", "--step", "10", "--until", "5"],
        &["adept", "--port", "/dev/ttyS0", "calibrate", "--port", "/dev/ttyS1"],
        &["adept", "--replay", "line.txt", "calibrate"],
        // The default is a name as any other.
        &["--name", "a", "server", "--name", "default"],
        &["--name", "a", "sim", "--name", "default", "--exit-with-daemon"],
        &["--name", "a", "adept", "--name", "default", "--port", "/dev/ttyS0"],
    ];
    for arguments in cases {
        let output = pschema(runtime.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
    }
    let later = text(&pschema(runtime.path(), cases[5]).stderr);
    assert!(later.contains("before step 10: leave out --until"), "{later}");
    // Each place will do.
    for arguments in [["stage", "--name", "robot-1", "step"], ["stage", "step", "--name", "robot-1"]] {
        let output = pschema(runtime.path(), &arguments);
        assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    }
}

/// `-` was looked for as a file of that name.
#[test]
fn the_input_that_is_named_by_a_dash_is_stdin() {
    let runtime = runtime();
    let given = |input: &str, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", runtime.path()).env_remove("RUST_LOG");
        command.current_dir(runtime.path()).stdin(Stdio::piped()).stderr(Stdio::piped());
        let mut process = command.spawn().unwrap();
        // Whoever refuses its arguments has gone before it reads.
        drop(std::io::Write::write_all(&mut process.stdin.take().unwrap(), input.as_bytes()));
        let output = process.wait_with_output().unwrap();
        (output.status.code(), text(&output.stderr))
    };
    let small = std::fs::read_to_string(SMALL).unwrap();
    // All of it is read before a setting is found to be of no value of it.
    let (code, said) = given(&small, &["server", "--curriculum", "-", "--set", "values.noise=1"]);
    assert!(code == Some(1) && said.contains("its values are: silence"), "{said}");
    let (code, said) = given("attention = 3", &["server", "--config", "-"]);
    assert!(code == Some(1) && said.contains("-:1:"), "{said}");
    let (code, said) = given(&small, &["server", "--config", "-", "--curriculum", "-"]);
    assert!(code == Some(1) && said.contains("stdin can be read once"), "{said}");
    for arguments in [&["experiment", "-"][..], &["experiment", SMALL, "--world", "-"]] {
        let (code, said) = given(&small, arguments);
        assert!(code == Some(1) && said.contains("- can't be read again and again"), "{arguments:?}: {said}");
    }
    let narrow = pschema_sim::config::NARROW;
    let (code, said) = given(narrow, &["sim", "--world", "-", "--snapshot", "seen.png"]);
    assert!(code == Some(0) && runtime.path().join("seen.png").exists(), "{said}");
    let (code, said) = given("table = 1", &["sim", "--world", "-"]);
    assert!(code == Some(1) && said.contains("world file -: "), "{said}");
    let (code, said) = given("no event", &["adept", "--replay", "-"]);
    assert!(code == Some(1) && said.contains("line 1 is no event"), "{said}");
    assert!(!runtime.path().join("-").exists());
}

/// A message once repeated all of what was typed, ten thousand bytes of it, and numbers of 320 digits.
#[test]
fn long_input_is_quoted_in_part() {
    let runtime = runtime();
    let (word, words, digits) = ("é".repeat(10_000), "a word ".repeat(2_000), "9".repeat(320));
    let noise = format!("move_error_mm={digits}");
    let slips: [&[&str]; 9] = [
        &["show", &word],
        &["show", &words],
        &["--name", &word, "status"],
        &["schemas", "--limit", &digits],
        &["experiment", &words],
        &["server", "--curriculum", &word],
        &["import", &word, "--data", "never-made"],
        &["sim", "--noise", &noise],
        &["emulator", "--link", &word],
    ];
    for arguments in slips {
        let output = pschema(runtime.path(), arguments);
        assert_ne!(output.status.code(), Some(0), "{}", arguments[0]);
        let said = text(&output.stderr);
        assert!((10..3_000).contains(&said.len()) && !said.contains(&digits), "{}: {said}", arguments[0]);
    }
}

#[test]
fn completions_know_the_commands() {
    let runtime = runtime();
    for shell in ["bash", "zsh", "fish"] {
        let output = pschema(runtime.path(), &["completions", shell]);
        assert_eq!(output.status.code(), Some(0), "{shell}");
        let script = text(&output.stdout);
        assert!(COMMANDS.iter().all(|command| script.contains(command)), "{shell}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let runtime = runtime();
    for arguments in [&["completions", "bash"][..], &["sim", "--snapshot", "-"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", runtime.path());
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(process.stdout.take());
        let output = process.wait_with_output().unwrap();
        assert_eq!(text(&output.stderr), "", "{arguments:?}");
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
    }
}

#[test]
fn doctor_finds_a_runtime_directory_that_is_open_to_others() {
    let runtime = runtime();
    let well = pschema(runtime.path(), &["doctor", "--json"]);
    let findings: serde_json::Value = serde_json::from_slice(&well.stdout).unwrap();
    described::assert_described("doctor", &findings);
    let checks = findings["checks"].as_array().unwrap();
    let found = checks.iter().find(|check| check["name"] == "runtime directory").unwrap();
    assert_eq!(found["ok"], true, "{findings}");

    std::fs::set_permissions(runtime.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
    let ill = pschema(runtime.path(), &["doctor"]);
    assert_eq!(ill.status.code(), Some(1));
    assert!(text(&ill.stdout).contains("chmod 700"), "{}", text(&ill.stdout));
}

/// An experiment of one's own, with variants.
const SMALL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/curricula/small.toml");

/// The runs that `experiment --json` printed, each as its JSON Schema says.
fn lines(output: &Output) -> Vec<serde_json::Value> {
    let lines: Vec<_> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    lines.iter().for_each(|line| described::assert_described("experiment", line));
    lines
}

#[test]
fn an_experiment_of_ones_own_runs_from_its_file_with_its_variants() {
    let runtime = runtime();
    let out = runtime.path().join("report");
    let arguments =
        ["experiment", SMALL, "--seeds", "1..2", "--jobs", "2", "--in-process", "--json", "--out"];
    let output = pschema(runtime.path(), &[&arguments[..], &[out.to_str().unwrap()]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("index.html"), "says where the page is: {}", text(&output.stderr));
    let runs = lines(&output);
    let told: Vec<_> = runs.iter().map(|run| (run["variant"].as_str(), run["seed"].as_u64())).collect();
    let names = ["whole", "without generalisation", "a finger that is seen elsewhere"];
    let expected: Vec<_> =
        names.iter().flat_map(|name| [1, 2].map(|seed| (Some(*name), Some(seed)))).collect();
    assert_eq!(told, expected, "in order, whichever ended first");
    let value = |run: &serde_json::Value, field: &str| run[field].as_u64().unwrap();
    for seed in [0, 1] {
        let (whole, without) = (&runs[seed], &runs[2 + seed]);
        assert_eq!(value(whole, "schemas_generalised"), 1, "{whole}");
        assert_eq!(value(without, "schemas_generalised"), 0, "{without}");
        // What the paper reports is about the run as it stands.
        assert_eq!(whole["published"]["schemas_total"], 115);
        assert!(without["published"].is_null(), "{without}");
        let touching = whole["measures"].as_array().unwrap().iter();
        let touching: Vec<_> = touching.filter(|m| m["name"] == "schemas of touching").collect();
        assert_eq!(touching[0]["value"], 3.0, "two touches and their generalisation");
        assert_eq!(whole["stages"][2]["actions_of_trial"].as_array().unwrap().len(), 3, "{whole}");
        assert_ne!(whole["memory_digest"], runs[4 + seed]["memory_digest"], "noise is felt");
    }
    let page = std::fs::read_to_string(out.join("index.html")).unwrap();
    assert!(names.iter().all(|name| page.contains(name)));
    let steps = std::fs::read_to_string(out.join("small.steps.csv")).unwrap();
    assert!(steps.lines().count() > 6 * 100, "every step of six runs");
}

#[test]
fn two_processes_leave_the_same_steps_as_one_but_for_their_times() {
    let runtime = runtime();
    let steps = |folder: &str, more: &[&str]| {
        let out = runtime.path().join(folder);
        let arguments = ["experiment", SMALL, "--variant", "whole", "--seed", "5", "--json", "--out"];
        let output = pschema(runtime.path(), &[&arguments[..], &[out.to_str().unwrap()], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let steps = std::fs::read_to_string(out.join("small.steps.csv")).unwrap();
        // The time is the last column.
        steps.lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned()).collect::<Vec<_>>()
    };
    let (one, two) = (steps("one", &["--in-process"]), steps("two", &[]));
    assert!(one.len() > 100 && one[1..].iter().all(|line| line.starts_with("whole,5,")), "{}", one[1]);
    assert_eq!(one, two);
}

#[test]
fn one_variant_can_be_run_alone_and_an_unknown_one_is_answered_with_those_there_are() {
    let runtime = runtime();
    let alone = ["experiment", SMALL, "--variant", "without generalisation", "--in-process", "--json"];
    let output = pschema(runtime.path(), &alone);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let run: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(run["variant"], "without generalisation");
    let output = pschema(runtime.path(), &["experiment", SMALL, "--variant", "with luck"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("whole, without generalisation"), "{}", text(&output.stderr));
}

#[test]
fn a_value_is_swept_and_a_mistake_is_located() {
    let runtime = runtime();
    let small = std::fs::read_to_string(SMALL).unwrap();
    let (before, _) = small.split_once("[[experiment.variant]]").unwrap();
    let file = runtime.path().join("swept.toml");
    let swept = |line: &str| {
        std::fs::write(&file, format!("{before}[experiment.sweep]\n{line}\n")).unwrap();
        pschema(runtime.path(), &["experiment", file.to_str().unwrap(), "--in-process", "--json"])
    };
    let output = swept("silence = [0.0, 1.0]");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let runs = lines(&output);
    assert_eq!(runs.iter().map(|run| run["swept"].as_f64()).collect::<Vec<_>>(), [Some(0.0), Some(1.0)]);
    let output = swept("silense = [0.0, 1.0]");
    assert_eq!(output.status.code(), Some(1));
    let line = before.lines().count() + 2;
    let said = text(&output.stderr);
    assert!(said.contains(&format!("swept.toml:{line}:1: ")) && said.contains("silence"), "{said}");
}

/// `touching = "tuch"` gave a share of 0 % and exit code 0, as a finding would.
#[test]
fn a_misspelt_name_in_the_table_of_an_experiment_is_no_finding() {
    let runtime = runtime();
    let small = std::fs::read_to_string(SMALL).unwrap();
    let file = runtime.path().join("mine.toml");
    let map = |object: &str, place: &str| {
        let map = format!(r#"map = {{ object = "{object}", effector = "finger", place = "{place}" }}"#);
        format!("touching = \"touch\"\n{map}")
    };
    let sound = r#"touching = "touch""#;
    let cases = [
        (sound, r#"touching = "tuch""#, "touching: no observation type is named \"tuch\"; there are "),
        (sound, &map("objekt", "field"), "map.object: no observation type is named \"objekt\""),
        (sound, &map("object", "feild"), "map.object: object has no property \"feild\"; it has "),
        (
            r#"post = "touch{}""#,
            r#"post = "tuch{}""#,
            "measure \"schemas of touching\", post: no observation type is named \"tuch\"",
        ),
        (
            r#"post = "touch{}""#,
            r#"post = "finger{colour=grene}""#,
            "measure \"schemas of touching\": post-condition pattern: colour=grene: no such symbol was ever met",
        ),
    ];
    for (said, meant, complaint) in cases {
        assert!(small.contains(said), "{said}");
        std::fs::write(&file, small.replace(said, meant)).unwrap();
        let arguments = ["experiment", file.to_str().unwrap(), "--variant", "whole"];
        for more in [&["--in-process"][..], &[]] {
            let output = pschema(runtime.path(), &[&arguments[..], more].concat());
            let told = text(&output.stderr);
            assert_eq!(output.status.code(), Some(1), "{meant}: {told}");
            let expected = format!("mine.toml: [experiment] {complaint}");
            assert!(told.contains(&expected), "{meant}\nwanted {expected}\nin {told}");
        }
    }
}

#[test]
fn all_experiments_are_run_as_their_files_say() {
    let runtime = runtime();
    for more in [["--world", "narrow"], ["--variant", "whole"]] {
        let output = pschema(runtime.path(), &[&["experiment", "all"][..], &more].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    }
}

/// What stands in the place of a directory was told as `File exists (os error 17)`, without what to do.
#[test]
fn a_file_in_the_place_of_a_directory_is_told_as_one() {
    let runtime = runtime();
    let at = |name: &str| runtime.path().join(name).display().to_string();
    std::fs::write(at("file"), "").unwrap();
    std::os::unix::fs::symlink("none", at("link")).unwrap();
    let told = |arguments: &[&str], problem: &str| {
        let output = pschema(runtime.path(), arguments);
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(1) && said.contains(problem), "{arguments:?}: {said}");
    };
    let is_file = format!("{} is a file and no directory; name a directory", at("file"));
    let leads_nowhere = format!("{} is a link to none, which is not there; make that directory", at("link"));
    for (name, problem) in [("file", &is_file), ("file/below", &is_file), ("link", &leads_nowhere)] {
        let path = at(name);
        for command in [
            &["server", "--data", &path][..],
            &["experiment", SMALL, "--in-process", "--out", &path],
            &["status", "--data", &path],
            &["export", "--data", &path],
            &["verify", "--data", &path],
        ] {
            told(command, problem);
        }
    }
}
