//! A life on disk, told and mended by the real command: served by a real daemon, with a real body, and killed.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod described;

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use described::{assert_all_described, assert_described};
use pschema_inspect::{LiveQuery, Request, TraceQuery, ask};
use pschema_protocol::client::Client;
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use serde_json::Value;
use tempfile::TempDir;

/// What any wait may take; a machine under load takes its time.
const PATIENCE: Duration = Duration::from_secs(60);

struct House(TempDir);

/// A process; dropped, it is killed.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

impl Process {
    /// Ends it as it wants to be ended.
    fn end(mut self) {
        let pid = rustix::process::Pid::from_raw(i32::try_from(self.0.id()).unwrap()).unwrap();
        rustix::process::kill_process(pid, rustix::process::Signal::TERM).unwrap();
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

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pschema"));
        command.args(arguments).env("PSCHEMA_RUNTIME_DIR", self.path("run")).env_remove("RUST_LOG");
        command.env("NO_COLOR", "1").stdin(Stdio::null()).current_dir(self.0.path());
        command
    }

    fn start(&self, arguments: &[&str]) -> Process {
        let mut command = self.command(arguments);
        Process(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// What it prints when all is well.
    fn text(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", text(&output.stderr));
        text(&output.stdout)
    }

    /// What it prints as JSON, which is as its JSON Schema says.
    fn json(&self, arguments: &[&str]) -> Value {
        let printed = self.text(&[arguments, &["--json"]].concat());
        let printed = serde_json::from_str(&printed).unwrap_or_else(|error| panic!("{arguments:?}: {error}"));
        let schema = match arguments {
            ["status", rest @ ..] if rest.contains(&"--data") => "status-data",
            ["explain", rest @ ..] if rest.contains(&"--why-not") => "why-not",
            _ => arguments[0],
        };
        assert_described(schema, &printed);
        printed
    }

    /// Checks each of some lines of JSON.
    fn assert_lines_described(&self, schema: &str, lines: &str) {
        let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert!(!lines.is_empty(), "{schema}");
        assert_all_described(schema, &lines);
    }

    /// Why it can't be done, and with which exit code.
    fn refusal(&self, arguments: &[&str]) -> (Option<i32>, String) {
        let output = self.run(arguments);
        (output.status.code(), text(&output.stderr))
    }

    /// Asks for the status until it is as wanted.
    fn until(&self, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let output = self.run(&["status", "--json"]);
            let status: Option<Value> = serde_json::from_slice(&output.stdout).ok();
            match status {
                Some(status) if wanted(&status) => return status,
                status => assert!(start.elapsed() < PATIENCE, "{status:?}: {}", text(&output.stderr)),
            }
            std::thread::yield_now();
        }
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn is_attached(status: &Value) -> bool {
    status["bodies"].as_array().unwrap().iter().any(|body| body["state"] == "attached")
}

/// Every file but the lock, which says who had the directory last.
fn files(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else if !path.ends_with("LOCK") {
            found.push((path.clone(), std::fs::read(path).unwrap()));
        }
    }
    found.sort();
    found
}

#[test]
fn a_life_that_was_killed_is_told_as_the_daemon_told_it() {
    let house = House::new();
    let serve = ["server", "--data", "life", "--seed", "7", "--snapshot-every", "16KiB"];
    let daemon = house.start(&serve);
    let body = house.start(&["sim", "--seed", "7"]);
    house.until(|status| status["step"].as_u64() >= Some(200));
    body.end();
    // Without a body nothing is stepped: what is asked now is about one moment.
    let then = house.until(|status| !is_attached(status));
    let step = then["step"].to_string();
    let questions: [&[&str]; 5] = [
        &["schemas", "--limit", "10000"],
        &["schemas", "--sort", "excitation", "--limit", "5"],
        &["show", "3"],
        &["explain"],
        &["stage"],
    ];
    let answers: Vec<_> = questions.iter().map(|question| house.json(question)).collect();
    let body = house.start(&["sim", "--seed", "7"]);
    let later = then["step"].as_u64().unwrap() + 100;
    house.until(|status| status["step"].as_u64() >= Some(later));
    answers_are_as_their_schemas_say(&house);
    // Beside the daemon that goes on, and after it was killed.
    let beside = house.json(&["status", "--data", "life", "--until", &step]);
    drop(daemon);
    drop(body);
    let kept = files(&house.path("life"));
    for told in [&beside, &house.json(&["status", "--data", "life", "--until", &step])] {
        for field in ["step", "memory_digest", "schemas_total", "stage", "curriculum", "excitation_top"] {
            assert_eq!(told[field], then[field], "{field}");
        }
    }
    for (question, answer) in questions.iter().zip(&answers) {
        let past = house.json(&[*question, &["--data", "life", "--until", &step]].concat());
        let timeless = |answer: &Value| {
            let mut answer = answer.clone();
            if let Some(fields) = answer.as_object_mut() {
                // A stage is told with how long steps took, and with what a body is doing now.
                fields.retain(|name, _| !name.starts_with("step_latency") && name != "stage_state");
            }
            answer
        };
        assert_eq!(timeless(&past), timeless(answer), "{question:?}");
    }
    assert!(house.text(&["status", "--data", "life", "--until", &step]).contains("read from disk"));
    let here =
        house.json(&["predict", answers[3]["action"].as_str().unwrap(), "--data", "life", "--until", &step]);
    assert!(!here["world"].as_array().unwrap().is_empty(), "what was perceived then: {here}");
    assert!(house.json(&["plan", "finger{}", "--data", "life"])["state"].is_string());
    let nowhere = house.run(&["plan", "object{field=-1}", "--data", "life"]);
    assert_eq!(nowhere.status.code(), Some(1), "{}", text(&nowhere.stderr));
    assert!(text(&nowhere.stdout).contains("Nothing known leads from here"));
    assert!(
        text(&nowhere.stderr).contains("there is no plan for object{field=-1}"),
        "{}",
        text(&nowhere.stderr)
    );
    let last = house.json(&["status", "--data", "life"])["step"].as_u64().unwrap();
    let (code, said) = house.refusal(&["explain", "--data", "life", "--step", &(last + 1).to_string()]);
    assert!(code == Some(1) && said.contains(&format!("step {} has not been taken yet", last + 1)), "{said}");
    // An empty journal looked like a finding.
    for more in [&[][..], &["--json"], &["--to", "1000000"]] {
        let from = (last + 1).to_string();
        let (code, said) = house.refusal(&[&["journal", "--data", "life", "--from", &from], more].concat());
        assert!(code == Some(1) && said.contains(&format!("step {from} has not been taken yet")), "{said}");
    }

    let checked = house.json(&["verify", "--data", "life", "--relearn"]);
    assert_eq!(
        (&checked["sound"], &checked["relearnt"]),
        (&Value::Bool(true), &checked["last_step"]),
        "{checked}"
    );
    assert!(checked["last_step"].as_u64() >= Some(later), "nothing that was acted on is lost");
    let journal = house.text(&["journal", "--data", "life", "--limit", "50", "--effects", "--json"]);
    house.assert_lines_described("journal", &journal);
    let replayed = house.json(&["replay", "--data", "life", "--until", &step]);
    assert_eq!(replayed["memory_digest"], then["memory_digest"]);
    assert!(files(&house.path("life")) == kept, "looking changes nothing");
}

/// What a daemon with a body answers, of all that is not asked elsewhere here.
fn answers_are_as_their_schemas_say(house: &House) {
    house.json(&["explain", "--why-not", "3"]);
    let graph = house.text(&["graph", "--limit", "20", "--format", "json"]);
    assert_described("graph", &serde_json::from_str(&graph).unwrap());
    house.json(&["say", "touch"]);
    house.json(&["achieve", "finger{}"]);
    assert_eq!(house.json(&["record", "--jsonl", "steps.jsonl", "--steps", "20"])["steps"], 20);
    let recorded = std::fs::read_to_string(house.path("steps.jsonl")).unwrap();
    house.assert_lines_described("record-jsonl", &recorded);

    let place = Place::new(RuntimeDir::at(&house.path("run")).unwrap(), LearnerName::new("default").unwrap());
    let mut client = Client::connect(&place, PATIENCE).unwrap();
    let query = LiveQuery { candidates_max: 5, terms_max: 5, newest_max: 5, ..LiveQuery::default() };
    assert_described("request", &serde_json::to_value(Request::from(query.clone())).unwrap());
    let live = ask(query, |request| client.request(request)).unwrap();
    assert_described("live", &serde_json::to_value(live).unwrap());
    let trace = ask(TraceQuery { from: 0 }, |request| client.request(request)).unwrap();
    assert_described("trace", &serde_json::to_value(trace).unwrap());
}

/// A life of some hundred steps in `life`, whose daemon was killed.
fn killed(house: &House, arguments: &[&str]) -> Value {
    let daemon = house.start(&[&["server", "--data", "life", "--seed", "3"], arguments].concat());
    let body = house.start(&["sim", "--seed", "3"]);
    house.until(|status| status["step"].as_u64() >= Some(300));
    drop(daemon);
    drop(body);
    house.json(&["status", "--data", "life"])
}

#[test]
fn memory_goes_out_and_comes_back_and_branches_off() {
    let house = House::new();
    let now = killed(&house, &[]);
    house.text(&["export", "--data", "life", "-o", "life.jsonl"]);
    let printed = house.text(&["export", "--data", "life"]);
    assert_eq!(printed, std::fs::read_to_string(house.path("life.jsonl")).unwrap());
    house.assert_lines_described("export", &printed);
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../server/store/tests/golden/export-1.jsonl");
    house.assert_lines_described("export", &std::fs::read_to_string(golden).unwrap());
    for stdout in ["-", "/dev/stdout"] {
        assert!(house.text(&["export", "--data", "life", "-o", stdout]) == printed, "{stdout} is no file");
        assert!(house.text(&["graph", "--data", "life", "--out", stdout]).starts_with("<svg"), "{stdout}");
    }
    assert!(!house.path("-").exists());
    let mode = std::fs::metadata(house.path("life.jsonl")).unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o600, "what a learner knows is its owner's");
    let (code, said) = house.refusal(&["export", "--data", "life", "-o", "life.jsonl"]);
    assert!(code == Some(1) && said.contains("there already"), "{said}");
    for full in [&["export", "--data", "life", "-o", "/dev/full"][..], &["sim", "--snapshot", "/dev/full"]] {
        let (code, said) = house.refusal(full);
        assert!(code == Some(1) && said.contains("cannot write /dev/full: No space left"), "{said}");
    }
    let made = house.json(&["import", "life.jsonl", "--data", "again"]);
    assert_eq!(made["memory_digest"], now["memory_digest"]);
    let (code, said) = house.refusal(&["import", "life.jsonl", "--data", "again"]);
    assert!(code == Some(1) && said.contains("not empty"), "{said}");
    std::fs::write(house.path("cut.jsonl"), &printed[..printed.len() / 2]).unwrap();
    let (code, said) = house.refusal(&["import", "cut.jsonl", "--data", "cut"]);
    assert!(code == Some(1) && said.contains("cut.jsonl: line "), "{said}");
    assert!(!house.path("cut").exists(), "what can't be imported leaves nothing");

    let branch = house.json(&["replay", "--data", "life", "--until", "120", "--out", "branch"]);
    for (directory, digest) in [("again", &now["memory_digest"]), ("branch", &branch["memory_digest"])] {
        let daemon = house.start(&["server", "--data", directory]);
        let served = house.until(|_| true);
        assert_eq!(served["memory_digest"], *digest, "a daemon goes on from {directory}");
        let exported = house.text(&["export", "--name", "default"]);
        assert!(exported.contains(digest.as_str().unwrap()), "a running learner is exported, too");
        daemon.end();
        assert_eq!(house.json(&["verify", "--data", directory])["sound"], true);
    }
    let (code, said) = house.refusal(&["status", "--data", "again", "--until", "5"]);
    assert!(code == Some(1) && said.contains("goes back to step"), "{said}");
}

#[test]
fn damage_is_found_told_and_mended() {
    let house = House::new();
    let now = killed(&house, &[]);
    let segment = house.path("life/journal/00000000000000000001.journal");
    let mut bytes = std::fs::read(&segment).unwrap();
    bytes[20_000] ^= 8;
    std::fs::write(&segment, bytes).unwrap();
    let damaged = files(&house.path("life"));

    let output = house.run(&["verify", "--data", "life", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let checked: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_described("verify", &checked);
    let finding = &checked["findings"][0];
    assert_eq!((&checked["sound"], finding["file"].as_str()), (&Value::Bool(false), segment.to_str()));
    let lost = finding["lost_from"].as_u64().unwrap();
    assert_eq!(
        (finding["lost_to"].as_u64(), checked["last_step"].as_u64()),
        (now["step"].as_u64(), Some(lost - 1))
    );
    assert!(finding["offset"].as_u64() <= Some(20_000), "{finding}");
    assert_eq!(house.run(&["server", "--data", "life"]).status.code(), Some(1), "no daemon starts on it");
    assert!(house.text(&["journal", "--data", "life"]).contains("DAMAGED"));
    assert_eq!(
        house.json(&["status", "--data", "life", "--until", "10"])["step"],
        10,
        "before it, all is well"
    );

    let planned = house.json(&["repair", "--data", "life", "--dry-run"]);
    assert_eq!(
        (planned["saved_step"].as_u64(), planned["last_step"].as_u64()),
        (Some(lost - 1), now["step"].as_u64())
    );
    assert!(house.text(&["repair", "--data", "life", "--to", "saved"]).contains("left as it is"));
    assert_eq!(house.json(&["status", "--data", "saved"])["memory_digest"], planned["memory_digest"]);
    assert!(files(&house.path("life")) == damaged, "so far nothing was changed");

    let daemon = house.start(&["server", "--data", "saved"]);
    house.until(|_| true);
    let (code, said) = house.refusal(&["repair", "--data", "saved"]);
    assert!(code == Some(0) || said.contains("in use"), "{said}");
    daemon.end();

    let said = house.text(&["repair", "--data", "life"]);
    assert!(said.contains("life.before-repair-1"), "{said}");
    let aside: Vec<_> =
        files(&house.path("life.before-repair-1")).into_iter().map(|(_, bytes)| bytes).collect();
    let before: Vec<_> = damaged.into_iter().map(|(_, bytes)| bytes).collect();
    assert!(aside == before, "all of it is beside it, byte for byte");
    assert_eq!(house.json(&["verify", "--data", "life", "--relearn"])["sound"], true);
    assert!(house.text(&["repair", "--data", "life"]).contains("Nothing is damaged"));
    let daemon = house.start(&["server", "--data", "life"]);
    assert_eq!(house.until(|_| true)["memory_digest"], planned["memory_digest"]);
    daemon.end();
}

#[test]
fn orders_and_slips_are_answered_with_what_to_do() {
    let house = House::new();
    std::fs::create_dir(house.path("empty")).unwrap();
    let orders: [&[&str]; 6] = [
        &["say", "touch", "--data", "life"],
        &["stage", "step", "--data", "life"],
        &["stage", "next", "--data", "life"],
        &["stage", "--data", "life", "set", "free"],
        &["achieve", "touch{}", "--data", "life"],
        &["status", "--until", "5"],
    ];
    for order in orders {
        let (code, said) = house.refusal(order);
        assert_eq!(code, Some(2), "{order:?}: {said}");
        assert!(said.contains("pschema server --data life") || said.contains("--data"), "{order:?}: {said}");
    }
    for question in [&["status"][..], &["verify"], &["repair"], &["journal"], &["replay"], &["explain"]] {
        let (code, said) = house.refusal(&[question, &["--data", "empty"]].concat());
        assert!(code == Some(1) && said.contains("there is no memory in"), "{question:?}: {said}");
        let (code, said) = house.refusal(&[question, &["--data", "nowhere"]].concat());
        assert!(code == Some(1) && said.contains("nowhere"), "{question:?}: {said}");
    }
    assert_eq!(house.refusal(&["journal", "--data", "life", "--from", "9", "--to", "3"]).0, Some(2));
    what_cannot_be_obeyed_together_is_refused(&house);
    let (code, said) = house.refusal(&["export"]);
    assert!(code == Some(3) && said.contains("no daemon"), "{said}");
}

/// Options that contradict each other, wherever they stand. clap lets an option that needs another pass where that other one
/// conflicts with a third that is given; so `schemas --until 3 --name x` once told how things are now.
fn what_cannot_be_obeyed_together_is_refused(house: &House) {
    let asking: [&[&str]; 10] = [
        &["status"],
        &["schemas"],
        &["show", "3"],
        &["explain"],
        &["graph"],
        &["predict", "move()"],
        &["plan", "touch{}"],
        &["stage"],
        &["stage", "show"],
        &["export"],
    ];
    for command in asking {
        let [before, behind] = [&["--name", "x"][..], &[]];
        for (before, behind) in [(before, behind), (behind, before)] {
            let (code, said) = house.refusal(&[before, command, &["--until", "3"], behind].concat());
            assert!(code == Some(2) && said.contains("--data DIR"), "{command:?} {before:?}: {said}");
            let (code, said) = house.refusal(&[before, command, &["--data", "life"], behind].concat());
            assert!(
                code == Some(2) && said.contains("each say which memory"),
                "{command:?} {before:?}: {said}"
            );
        }
        let (code, said) = house.refusal(&[&["--name", "x"], command, &["--name", "y"]].concat());
        assert!(code == Some(2) && said.contains("two learners"), "{command:?}: {said}");
    }
    let others: [&[&str]; 13] = [
        &["sim", "--snapshot", "scene.png", "--realtime"],
        &["status", "--metrics", "--until", "3"],
        &["stage", "--until", "3", "show"],
        &["stage", "--data", "life", "show", "--name", "x"],
        &["graph", "--goal", "touch{}", "--depth", "3"],
        &["watch", "--width", "100", "--rate", "5"],
        &["watch", "--height", "50", "--rate", "5"],
        &["--name", "x", "view", "--data", "life"],
        &["--name", "x", "journal", "--data", "life"],
        &["--name", "x", "doctor"],
        &["--name", "x", "sim", "--name", "y"],
        &["-q", "status", "-v"],
        &["record", "--jsonl", "-", "--json"],
    ];
    for arguments in others {
        let (code, said) = house.refusal(arguments);
        assert_eq!(code, Some(2), "{arguments:?}: {said}");
    }
    // Behind an order the name means what it means before it.
    for arguments in [
        &["stage", "step", "--name", "x"][..],
        &["stage", "--name", "x", "step"],
        &["--name", "x", "stage", "step"],
    ] {
        let (code, said) = house.refusal(arguments);
        assert!(code == Some(3) && said.contains("learner x"), "{arguments:?}: {said}");
    }
}

#[test]
fn memory_in_ram_is_measured_and_not_exported() {
    let house = House::new();
    let down = house.run(&["status", "--metrics"]);
    assert_eq!(down.status.code(), Some(3));
    assert!(text(&down.stdout).ends_with("pschema_up{learner=\"default\"} 0\n"));
    let daemon = house.start(&["server"]);
    house.until(|_| true);
    let (code, said) = house.refusal(&["export"]);
    assert!(code == Some(1) && said.contains("in RAM only") && said.contains("--data"), "{said}");
    let page = house.text(&["status", "--metrics"]);
    for sample in
        ["pschema_up{learner=\"default\"} 1\n", "pschema_durability_strict{learner=\"default\"} 0\n"]
    {
        assert!(page.contains(sample), "{page}");
    }
    daemon.end();
}

/// What is printed of the data directory of format 1 that every release must read, compared with files in `tests/golden`.
#[test]
fn what_is_printed_of_an_old_directory() {
    let house = House::new();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../server/store/tests/golden/v1");
    for name in ["manifest", "journal", "snapshot"] {
        let copied = |from: &Path, to: &Path| assert!(std::fs::copy(from, to).unwrap() > 0);
        let (from, to) = (source.join(name), house.path("old").join(name));
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        if from.is_dir() {
            std::fs::create_dir_all(&to).unwrap();
            for file in std::fs::read_dir(&from).unwrap() {
                let file = file.unwrap();
                copied(&file.path(), &to.join(file.file_name()));
            }
        } else {
            copied(&from, &to);
        }
    }
    let check = |name: &str, arguments: &[&str]| {
        let printed = text(&house.run(arguments).stdout);
        // The directory's name differs each time, and is always as long.
        let printed = printed.replace(house.0.path().to_str().unwrap(), "/tmp/pst-000000");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
        expect_test::expect_file![path].assert_eq(&printed);
        let too_wide = |line: &&str| name.ends_with(".txt") && line.chars().count() > 80;
        assert!(!printed.lines().any(|line| too_wide(&line)), "{name} fits 80 columns:\n{printed}");
    };
    check("past-status.txt", &["status", "--data", "old"]);
    check("past-journal.txt", &["journal", "--data", "old", "--limit", "5"]);
    check("past-effects.txt", &["journal", "--data", "old", "--from", "60", "--limit", "3", "--effects"]);
    check(
        "past-journal.json",
        &["journal", "--data", "old", "--from", "60", "--limit", "1", "--effects", "--json"],
    );
    check("past-verify.txt", &["verify", "--data", "old", "--relearn"]);
    check("past-verify.json", &["verify", "--data", "old", "--json"]);
    check("past-explain.txt", &["explain", "--data", "old", "--step", "60", "--candidates", "2"]);
    let segment = house.path("old/journal/00000000000000000840.journal");
    let mut bytes = std::fs::read(&segment).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&segment, bytes).unwrap();
    check("past-damaged.txt", &["verify", "--data", "old"]);
    check("past-repair.txt", &["repair", "--data", "old", "--dry-run"]);
    check("past-repair.json", &["repair", "--data", "old", "--dry-run", "--json"]);
    check("past-repaired.txt", &["repair", "--data", "old"]);
}
