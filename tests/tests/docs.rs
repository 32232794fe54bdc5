//! The documentation, followed literally: its commands are run, page by page, each in a directory of its own, and must do
//! what the page says they do; the others are at least commands that exist.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::fmt::Write as _;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

use pschema_protocol::description::{ActionType, Description, ObservationType, Property, Value};
use pschema_protocol::wire::decode::{self, SessionChecks};
use pschema_protocol::wire::{FrameHeader, encode};
use pschema_tests::{Block, ChildProcess, Page, Sandbox};
use rustix::process::{Pid, Signal, kill_process};

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");
const GRID_WORLD: &str = env!("CARGO_BIN_EXE_pschema-grid-world");
const LAMP: &str = env!("CARGO_BIN_EXE_pschema-lamp");

/// Commands that need a build of their own, Python, a person, an arm, or half an hour, which a test does not have.
const NOT_RUN: [&str; 10] = [
    "cargo ",
    "pip install ",
    "python ",
    "export PATH=",
    "pschema watch ",
    "pschema view ",
    "pschema adept ",
    "pschema server --data ~/arm &",
    "pschema experiment all",
    "pschema experiment exp1-s1 --seeds 1..10",
];

/// The ways in which pages call the program that measures.
const BENCH: [&str; 2] = ["cargo run --release -p pschema-bench -- ", "target/release/pschema-bench "];

/// The shell in which a page's commands run: it stops at the first command that fails, and leaves no process.
const PROLOGUE: &str = r#"
set -euo pipefail
set -m
trap 'jobs -p | while read -r pid; do kill -9 "$pid" 2>/dev/null || true; done' EXIT
name_of() { sed -n 's/.*--name[ =]\([a-z0-9_-]*\).*/\1/p' <<<"$1" | grep . || echo default; }
# A person who types is slower than a daemon that starts.
answers() { until pschema --name "$1" status >/dev/null 2>&1; do kill -0 "$2"; sleep 0.02; done; }
# And plays with the next thing only after some seconds.
plays() {
  until pschema --name "$1" status --json | tr -d '\n ' |
    grep -Eq '"stage_state":"finished"|"step":([2-9][0-9][0-9]|[0-9]{4})'; do kill -0 "$2"; sleep 0.05; done
}
"#;

/// Stands in for cargo: starts the program that cargo would build, which has been built already.
const CARGO: &str = r#"#!/usr/bin/env bash
set -eu
arguments="$*"
case "$arguments" in
  "new "*) mkdir -p "$2/src" ;;
  "add --manifest-path "*) test -d "$(dirname "$3")/src" ;;
  "test --workspace") ;; # this is it
  "run --release -- "*) shift 3; exec pschema "$@" ;;
  "run --release --manifest-path ../lamp/"*) while [ "$1" != -- ]; do shift; done; shift; exec LAMP "$@" ;;
  "run --release -p pschema-protocol --example grid_world -- "*) while [ "$1" != -- ]; do shift; done; shift; exec GRID "$@" ;;
  *) echo "the test knows no cargo $arguments" >&2; exit 96 ;;
esac
"#;

#[test]
fn the_readme_does_what_it_says() {
    follow("README.md");
}

#[test]
fn the_tutorial_ends_with_a_body_of_ones_own() {
    follow("docs/TUTORIAL.md");
}

#[test]
fn a_body_can_be_written_as_its_page_says() {
    follow("docs/howto/own-body.md");
}

#[test]
fn a_curriculum_can_be_written_as_its_page_says() {
    follow("docs/howto/own-curriculum.md");
}

#[test]
fn a_word_is_taught_as_its_page_says() {
    let said = follow("docs/howto/teach-a-word.md");
    assert!(said.contains("word{text=touch}"), "the word is in no explanation:\n{said}");
}

#[test]
fn a_damaged_journal_is_recovered_as_its_page_says() {
    follow("docs/howto/recover-a-journal.md");
}

#[test]
fn the_page_about_the_arm_works_without_one() {
    follow("docs/howto/on-the-arm.md");
}

#[test]
fn every_page_that_has_commands_to_follow_is_followed_here() {
    let followed = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/docs.rs")).unwrap();
    // What is shown alone needs what is not here, and is excused below: the Python of a page is run by the tests of the package.
    let howto = |page: &&Page| page.path.starts_with("docs/howto") && page.commands(false).next().is_some();
    for page in Page::all().iter().filter(howto) {
        let path = page.path.display().to_string();
        assert!(followed.contains(&format!("follow(\"{path}\")")), "{path} is not followed");
    }
}

#[test]
fn commands_that_are_only_shown_exist() {
    let mut seen = 0;
    for page in Page::all() {
        for block in page.commands(true) {
            for (line, command) in commands(block) {
                let bench = BENCH.iter().find_map(|start| command.split_once(start));
                let checked = match bench {
                    Some((_, arguments)) => {
                        pschema_bench::check_usage(&words(&format!("pschema-bench {arguments}")))
                    }
                    None if command.starts_with("pschema") => pschema_tools::check_usage(&words(&command)),
                    None => continue,
                };
                let place = format!("{}:{line}: {command}", page.path.display());
                checked.unwrap_or_else(|problem| panic!("{place}\n{problem}"));
                seen += 1;
            }
        }
    }
    assert!(seen > 50, "only {seen} commands were found");
}

#[test]
fn what_is_not_run_could_not_be() {
    for page in Page::all() {
        let is_followed = page.path.ends_with("README.md")
            || page.path.ends_with("TUTORIAL.md")
            || page.path.starts_with("docs/howto");
        for block in page.blocks.iter().filter(|block| is_followed && block.info.starts_with("sh ")) {
            for (line, command) in commands(block) {
                let place = format!("{}:{line}", page.path.display());
                let excused = NOT_RUN.iter().any(|start| format!("{command} ").starts_with(start));
                assert!(excused, "{place}: this can be run: {command}");
            }
        }
    }
}

/// The commands of a block with their lines; comments left out, those that go on over several lines joined.
fn commands(block: &Block) -> Vec<(usize, String)> {
    let mut commands = Vec::new();
    let mut begun: Option<(usize, String)> = None;
    for (at, line) in block.text.lines().enumerate() {
        let (number, mut command) = begun.take().unwrap_or((block.line + at, String::new()));
        let line = line.split(" #").next().unwrap_or_default().trim();
        match line.strip_suffix('\\') {
            Some(part) => begun = Some((number, command + part)),
            None => {
                command.push_str(line);
                if !command.is_empty() && !command.starts_with('#') {
                    commands.push((number, command));
                }
            }
        }
    }
    commands
}

/// The words of the first command of a line, as a shell would split them.
fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    let (mut word, mut quote, mut begun) = (String::new(), None, false);
    // A shell puts one word in place of `$(…)`.
    let mut substituted = false;
    for letter in command.chars() {
        match (quote, letter) {
            (Some(open), _) if open == letter => quote = None,
            (None, '$') => substituted = true,
            (None, ')') if substituted => substituted = false,
            (None, _) if substituted => (),
            (Some(_), _) => word.push(letter),
            (None, '\'' | '"') => (quote, begun) = (Some(letter), true),
            (None, ' ') => {
                if begun {
                    words.push(std::mem::take(&mut word));
                }
                begun = false;
            }
            (None, '|' | '&' | '>' | ';' | '<') => break,
            (None, _) => {
                word.push(letter);
                begun = true;
            }
        }
    }
    if begun {
        words.push(word);
    }
    words
}

/// Runs a page's commands in order. Returns the text that they printed.
fn follow(path: &str) -> String {
    let page = Page::read(Path::new(path));
    let sandbox = Sandbox::new(BINARY);
    let home = tempfile::Builder::new().prefix("psd-").tempdir_in("/tmp").unwrap();
    let (bin, work) = (home.path().join("bin"), home.path().join("pschema"));
    fs::create_dir(&bin).unwrap();
    fs::create_dir(&work).unwrap();
    symlink(BINARY, bin.join("pschema")).unwrap();
    let cargo = bin.join("cargo");
    fs::write(&cargo, CARGO.replace("LAMP", LAMP).replace("GRID", GRID_WORLD)).unwrap();
    fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).unwrap();
    let script = script(&page);
    let mut command = Command::new("bash");
    let path_variable = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    command.arg("-c").arg(&script).current_dir(&work).env("PATH", path_variable).env("HOME", home.path());
    command.env("PSCHEMA_RUNTIME_DIR", sandbox.runtime()).env_remove("RUST_LOG").env("NO_COLOR", "1");
    let _sweep = Sweep(work.display().to_string());
    let finished = ChildProcess::start(&mut command).finished();
    assert!(
        finished.status.success(),
        "{path}: {}\n--- what it printed\n{}\n--- what it said\n{}",
        finished.status,
        finished.stdout,
        finished.stderr
    );
    assert!(!script.contains(" &\n") || sandbox.left().is_empty(), "{path} leaves {:?}", sandbox.left());
    finished.stdout
}

/// Ends the processes that a failed page left running in its directory: a shell that is killed does not end them.
struct Sweep(String);

impl Drop for Sweep {
    fn drop(&mut self) {
        for entry in fs::read_dir("/proc").into_iter().flatten().filter_map(Result::ok) {
            let pid = entry.file_name().to_string_lossy().parse::<i32>().ok().and_then(Pid::from_raw);
            let there = fs::read_link(entry.path().join("cwd")).is_ok_and(|cwd| cwd.starts_with(&self.0));
            if let (Some(pid), true) = (pid, there) {
                // One that has just ended by itself is no matter.
                kill_process(pid, Signal::KILL).ok();
            }
        }
    }
}

/// A page as a script: files are saved and commands run in the order in which they stand.
fn script(page: &Page) -> String {
    let mut script = PROLOGUE.to_owned();
    for block in &page.blocks {
        if let Some(file) = &block.file {
            if file.ends_with(".rs") {
                let built = include_str!("../src/bin/pschema_lamp.rs");
                assert_eq!(block.text, built, "{}: not what the test has built", page.path.display());
            }
            writeln!(script, "cat > '{file}' <<'END_OF_FILE'\n{}END_OF_FILE", block.text).unwrap();
        }
        if block.info == "sh" {
            for (line, command) in commands(block) {
                script.push_str(&step(page, line, &command));
            }
        }
    }
    script
}

fn step(page: &Page, line: usize, command: &str) -> String {
    let quoted = command.replace('\'', "'\\''");
    let place = format!("{}:{line}", page.path.display());
    let mut step = format!("printf '\\n>>> %s: %s\\n' '{place}' '{quoted}' | tee /dev/stderr\n");
    if let Some(failing) = command.strip_prefix("! ") {
        writeln!(step, "if {failing}; then echo 'this was to fail' >&2; exit 97; fi").unwrap();
    } else {
        writeln!(step, "{command}").unwrap();
    }
    if command.ends_with('&') {
        let waits = if command.contains(" server") { "answers" } else { "plays" };
        writeln!(step, "{waits} \"$(name_of '{quoted}')\" $!").unwrap();
    }
    step
}

/// The bytes of a message of the protocol, as an author of a body in another language sees them.
fn bytes_of<T: Copy>(message: &T) -> Vec<u8> {
    let bytes = std::ptr::from_ref(message).cast::<u8>();
    // SAFETY: the messages are made of integers and of arrays of integers, without padding (`protocol/src/wire/layout.rs` asserts it).
    #[expect(unsafe_code, reason = "a message is shown as it lies in shared memory")]
    unsafe { std::slice::from_raw_parts(bytes, size_of::<T>()) }.to_vec()
}

/// Rows of 16 bytes with their offsets, without those that are all zero.
fn rows(bytes: &[u8]) -> String {
    let mut text = String::new();
    for (row, bytes) in bytes.chunks(16).enumerate().filter(|(_, bytes)| bytes.iter().any(|byte| *byte != 0))
    {
        let shown: Vec<_> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        writeln!(text, "{:06x}  {}", row * 16, shown.join(" ")).unwrap();
    }
    text
}

#[test]
fn the_smallest_messages_are_these_bytes() {
    let mut description = Description::new("b", "k");
    let at = Property::integer("at", 0..=9);
    let x = description.observation(ObservationType::state("x").own().property(at));
    let go = description.action(ActionType::new("go"));
    description.primitive(go, ());
    let hello = encode::hello(&description, 4711, 0x1122_3344_5566_7788).unwrap();
    // The repertoire follows the head.
    let mut hello_bytes = bytes_of(&*hello.head);
    hello.primitives.iter().for_each(|one| hello_bytes.extend(bytes_of(one)));
    assert_eq!(x.index(), 0);
    let wake = 0x1122_3344_5566_7788;
    let header =
        FrameHeader { session: 7, sequence: 1, wake, observation_count: 1, ..FrameHeader::default() };
    let frame = encode::frame(header, None, vec![encode::record(0, &[Value::Integer(3)])]);
    assert!(SessionChecks::new(7, decode::hello(&hello).unwrap().description).check(&frame).is_ok());
    let page = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/PROTOCOL.md")).unwrap();
    let expected = [
        ("hello", rows(&hello_bytes)),
        ("header", rows(&bytes_of(&frame.header))),
        ("frame", rows(&bytes_of(&frame.records[0]))),
    ];
    for (name, rows) in expected {
        let block = format!("```{name}\n{rows}```\n");
        assert!(page.contains(&block), "docs/PROTOCOL.md should have this:\n{block}");
    }
}

/// A table of faults is worth as much as its tests: each file that it names is there, and has the tests that it names.
#[test]
fn the_tests_in_the_table_of_faults_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let page = fs::read_to_string(root.join("docs/RELIABILITY.md")).unwrap();
    let rows = page.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| kind |"));
    let mut files = 0;
    for row in rows {
        let tests = row.trim_end_matches('|').rsplit(" | ").next().unwrap();
        for one in tests.split(';') {
            let (file, names) = one.trim().strip_prefix('`').unwrap().split_once('`').unwrap();
            let path = root.join(file);
            assert!(path.exists(), "{file} is named in {row}");
            files += 1;
            let Some(names) = names.strip_prefix(": ").filter(|_| path.is_file()) else { continue };
            let source = fs::read_to_string(&path).unwrap();
            for name in names.split(", ").filter(|name| name.contains('_') && !name.starts_with('`')) {
                let name = name.split_whitespace().next().unwrap();
                assert!(source.contains(&format!("fn {name}")), "{file} has no test {name}: {row}");
            }
        }
    }
    assert!(files > 40, "{files}");
}
