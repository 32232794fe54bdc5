//! The duties of every body, written once. A new body is a [`Subject`] and a line in [`conform`] below. Its duties are in
//! `conformance/wire.rs` (the messages of a body, and its obedience) and `conformance/life.rs` (the start and the end of its process).

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod conformance {
    pub(crate) mod life;
    pub(crate) mod wire;

    pub(crate) use super::{Any, BINARY, StartedBody, Subject};
}
#[path = "../../protocol/examples/grid_world.rs"]
#[expect(dead_code, reason = "as a program it is started elsewhere")]
mod grid_world;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use pschema_adept::AdeptArgs;
use pschema_adept::body::AdeptBody;
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Description};
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;
use pschema_tests::{ChildProcess, Sandbox, until};
use pschema_vplus_emulator::{Emulator, EmulatorArgs};
use tempfile::TempDir;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

/// A body to be examined.
pub(crate) trait Subject {
    /// The body's name in messages of the test.
    fn name(&self) -> &'static str;
    /// The body itself; equal seeds give equal bodies.
    fn body(&self, seed: u64) -> Any;
    /// The body as a process that attaches to the learner `name`.
    fn start(&self, sandbox: &Sandbox, name: &str) -> StartedBody;
}

/// Any body.
pub(crate) struct Any(Box<dyn Body>);

impl Any {
    fn new(body: impl Body + 'static) -> Self {
        Self(Box::new(body))
    }
}

impl Body for Any {
    fn describe(&self) -> Description {
        self.0.describe()
    }

    fn sense(&mut self, frame: &mut Senses) {
        self.0.sense(frame);
    }

    fn act(&mut self, action: &Action) -> Outcome {
        self.0.act(action)
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        self.0.arrange(command)
    }
}

/// A body's process, and the processes that it needs beside it.
pub(crate) struct StartedBody {
    pub(crate) process: ChildProcess,
    /// Ends after the body.
    _beside: Vec<ChildProcess>,
}

/// The simulated arm.
struct Simulated;

impl Subject for Simulated {
    fn name(&self) -> &'static str {
        "the simulated arm"
    }

    fn body(&self, seed: u64) -> Any {
        let file = WorldFile::load("narrow").unwrap();
        Any::new(SimBody::new("arm", file, "narrow", seed, false).unwrap())
    }

    fn start(&self, sandbox: &Sandbox, name: &str) -> StartedBody {
        StartedBody { process: sandbox.body(name, &["--world", "narrow"]), _beside: Vec::new() }
    }
}

/// The example of how to write a body.
struct GridWorld;

impl Subject for GridWorld {
    fn name(&self) -> &'static str {
        "the grid world"
    }

    fn body(&self, _: u64) -> Any {
        Any::new(grid_world::GridWorld::new())
    }

    fn start(&self, sandbox: &Sandbox, name: &str) -> StartedBody {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pschema-grid-world"));
        command.args(["--name", name]).env("PSCHEMA_RUNTIME_DIR", sandbox.runtime()).env_remove("RUST_LOG");
        StartedBody { process: ChildProcess::start(&mut command), _beside: Vec::new() }
    }
}

/// The Adept arm, its controller emulated: text on a serial line, pictures from a socket.
struct Adept;

/// Where the emulated controller's line and sockets are.
struct Room {
    line: PathBuf,
    camera: PathBuf,
    operator: PathBuf,
}

impl Room {
    fn within(directory: &Path) -> Self {
        let at = |name: &str| directory.join(name);
        Self { line: at("line"), camera: at("camera"), operator: at("operator") }
    }

    fn body_arguments(&self) -> Vec<String> {
        let (line, camera, operator) = (self.line.display(), self.camera.display(), self.operator.display());
        let places = format!("--port {line} --camera socket:{camera} --operator socket:{operator}");
        format!("{places} --arm emulated --enable --home").split(' ').map(str::to_owned).collect()
    }
}

/// The body with the emulator that it talks to, which ends after it.
struct AdeptOnEmulator {
    body: AdeptBody,
    _emulator: Emulator,
    _directory: TempDir,
}

impl Body for AdeptOnEmulator {
    fn describe(&self) -> Description {
        self.body.describe()
    }

    fn sense(&mut self, frame: &mut Senses) {
        self.body.sense(frame);
    }

    fn act(&mut self, action: &Action) -> Outcome {
        self.body.act(action)
    }

    fn arrange(&mut self, command: &Action) -> Outcome {
        self.body.arrange(command)
    }
}

#[derive(Parser)]
struct AdeptCli {
    #[command(flatten)]
    args: AdeptArgs,
}

impl Subject for Adept {
    fn name(&self) -> &'static str {
        "the Adept arm on the emulator"
    }

    fn body(&self, seed: u64) -> Any {
        let directory = tempfile::tempdir().unwrap();
        let room = Room::within(directory.path());
        let mut args = EmulatorArgs::at(&room.line);
        (args.camera, args.operator) = (Some(room.camera.clone()), Some(room.operator.clone()));
        (args.seed, args.fast, args.consent) = (seed, 100_000.0, true);
        // A machine under load is silent for longer than a robot's should be.
        args.watchdog_ms = 60_000;
        let emulator = Emulator::start(args).unwrap();
        let arguments = std::iter::once("adept".to_owned()).chain(room.body_arguments());
        let args = AdeptCli::parse_from(arguments).args;
        let stop = Arc::new(AtomicBool::new(false));
        let mut body = pschema_adept::build(&args, Arc::clone(&stop), None).unwrap();
        pschema_adept::enable(&args, &mut body, &stop).unwrap();
        Any::new(AdeptOnEmulator { body, _emulator: emulator, _directory: directory })
    }

    fn start(&self, sandbox: &Sandbox, name: &str) -> StartedBody {
        let room = Room::within(sandbox.runtime());
        let (line, camera, operator) = (room.line.display(), room.camera.display(), room.operator.display());
        let places = format!("--link {line} --camera {camera} --operator {operator}");
        let emulator = format!("emulator {places} --fast 100000 --consent");
        let emulator = sandbox.start(&emulator.split(' ').collect::<Vec<_>>());
        until("the emulated controller is ready", || room.line.exists().then_some(()));
        let arguments =
            [["adept", "--name", name].map(str::to_owned).to_vec(), room.body_arguments()].concat();
        let process = sandbox.start(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        StartedBody { process, _beside: vec![emulator] }
    }
}

/// Makes the tests of each body.
macro_rules! conform {
    ($($body:ident: $subject:expr;)*) => { $(
        mod $body {
            use super::conformance::{life, wire};
            use super::*;

            conform!(@ $subject, wire: it_describes_itself it_refuses_what_it_never_declared
                one_action_one_frame_one_report a_new_session_begins_anew values_stay_within_what_is_declared
                scene_commands_are_obeyed_or_refused the_same_seed_gives_the_same_life);
            conform!(@ $subject, life: it_lives_with_a_daemon it_goes_on_after_the_daemon_is_restarted
                it_ends_when_it_is_sent_away it_ends_on_ctrl_c it_ends_on_ctrl_c_without_a_daemon);
        }
    )* };
    (@ $subject:expr, $part:ident: $($test:ident)*) => { $(
        #[test]
        fn $test() {
            $part::$test(&$subject);
        }
    )* };
}

conform! {
    simulated: Simulated;
    grid_world_example: GridWorld;
    adept_on_emulator: Adept;
}

/// What the command that examines bodies of any language says of the body that `command` starts.
fn examined(command: &str) -> (Option<i32>, serde_json::Value) {
    let sandbox = Sandbox::new(BINARY);
    let examined = sandbox.run(&["conformance", "--command", command, "--json"]);
    let found: serde_json::Value =
        serde_json::from_str(&examined.stdout).unwrap_or_else(|_| panic!("{examined:?}"));
    (examined.code(), found)
}

#[test]
fn the_command_passes_the_bodies_of_this_repository() {
    for command in [
        format!("{BINARY} sim --world narrow"),
        format!("{} --name default", env!("CARGO_BIN_EXE_pschema-grid-world")),
    ] {
        let (code, found) = examined(&command);
        assert_eq!((code, &found["ok"]), (Some(0), &serde_json::json!(true)), "{found:#}");
        let checks = found["checks"].as_array().unwrap();
        assert!(checks.len() >= 14 && checks.iter().all(|check| check["verdict"] == "passed"), "{found:#}");
    }
}

#[test]
fn the_command_says_what_a_broken_body_does_wrong() {
    let (code, found) = examined(&format!("{} broken default b", env!("CARGO_BIN_EXE_pschema-test-peer")));
    assert_eq!((code, &found["ok"]), (Some(1), &serde_json::json!(false)), "{found:#}");
    let check = |name: &str| {
        let checks = found["checks"].as_array().unwrap();
        checks.iter().find(|check| check["name"] == name).unwrap_or_else(|| panic!("no {name} in {found:#}"))
    };
    for name in ["hello", "sequence", "pause"] {
        assert_eq!(check(name)["verdict"], "passed", "{found:#}");
    }
    for (name, problem) in [
        ("rest", "it sent its next frame after"),
        ("actions", "refusal 7"),
        ("refused-frame", "refusal 7"),
        ("session", "where a hello was due"),
        ("restart", "the body ended"),
        ("sent-away", "frame"),
    ] {
        let check = check(name);
        let told = check["problem"].as_str().unwrap_or_default();
        assert!(check["verdict"] == "failed" && told.contains(problem), "{name}: {found:#}");
    }
    // The protocol demands neither a farewell nor an exit code.
    let told = check("sigterm")["problem"].as_str().unwrap_or_default();
    assert!(check("sigterm")["verdict"] == "advised" && told.contains("signal: 15"), "{found:#}");
}

/// The shell that could not start it repeated ten thousand bytes of it.
#[test]
fn a_command_that_can_not_be_started_is_not_repeated_whole() {
    let sandbox = Sandbox::new(BINARY);
    let output = sandbox.run(&["conformance", "--command", &"x".repeat(10_000)]);
    assert_eq!(output.code(), Some(1), "{output:?}");
    assert!(output.stderr.len() < 1_000 && output.stderr.contains("characters) …"), "{output:?}");
}

#[test]
fn of_a_command_that_is_no_body_nothing_else_is_tried() {
    let (code, found) = examined("sh -c 'exit 5'");
    assert_eq!(code, Some(1), "{found:#}");
    let checks = found["checks"].as_array().unwrap();
    assert!(checks[0]["problem"].as_str().unwrap().contains("the body ended (exit status: 5)"), "{found:#}");
    assert!(checks[1..].iter().all(|check| check["verdict"] == "not_tried"), "{found:#}");
}
