//! The bodies that a run can be carried out with, as processes of this binary: the simulated arm, or the Adept arm at
//! the end of a serial line whose other end is emulated.

use std::path::{Path, PathBuf};
use std::time::Duration;

use pschema_process::Stop;

use crate::design::BodyKind;
use crate::failure::Failure;

use super::child::{Child, retry};
use super::experiment::Condition;

/// How many times as fast as a real arm the emulated one moves in experiments.
const FAST: &str = "100000";
/// How long the emulated controller may take until its line is there.
const LINE_WITHIN: Duration = Duration::from_secs(20);

/// The world for which the emulated arm was taught.
const TAUGHT_WORLD: &str = "narrow";

/// A body's process with what it needs beside it. Fields are dropped in this order.
pub(crate) struct BodyProcess {
    body: Child,
    emulator: Option<Child>,
}

/// Where the emulated controller's line and sockets are in a directory.
pub(super) struct Places {
    line: PathBuf,
    camera: PathBuf,
    operator: PathBuf,
}

impl Places {
    pub(super) fn within(directory: &Path) -> Self {
        let at = |name: &str| directory.join(name);
        Self { line: at("adept.line"), camera: at("adept.camera"), operator: at("adept.operator") }
    }
}

impl BodyProcess {
    /// Starts the body of a run, to attach to the learner `name` in the runtime directory `runtime`.
    pub(crate) fn start(
        condition: &Condition,
        seed: u64,
        runtime: &Path,
        name: &str,
        stop: &Stop,
    ) -> Result<Self, Failure> {
        let named = |command: &str, own: Vec<String>| {
            let command = [command, "--name", name].map(str::to_owned);
            command.into_iter().chain(own).collect::<Vec<_>>()
        };
        match condition.body {
            BodyKind::Sim => {
                let body = Child::start("body", runtime, named("sim", condition.simulated(seed)))?;
                Ok(Self { body, emulator: None })
            }
            BodyKind::Adept => {
                check_adept(condition)?;
                let places = Places::within(runtime);
                let arguments = emulator_arguments(condition, seed, &places);
                let arguments = ["emulator".to_owned()].into_iter().chain(arguments);
                let mut emulator = Child::start("emulator", runtime, arguments)?;
                wait_for_line(&places.line, &mut emulator, stop)?;
                let body = Child::start("body", runtime, named("adept", adept_arguments(&places)))?;
                Ok(Self { body, emulator: Some(emulator) })
            }
        }
    }

    /// A failure when one of the processes has ended.
    pub(crate) fn check(&mut self) -> Result<(), Failure> {
        // Without the controller the body only says that its line is dead.
        self.emulator.as_mut().map_or(Ok(()), Child::check)?;
        self.body.check()
    }
}

/// What the emulated arm cannot be asked for.
pub(super) fn check_adept(condition: &Condition) -> Result<(), Failure> {
    if condition.world != TAUGHT_WORLD {
        return Err(Failure::Usage(format!(
            "the Adept arm was taught in the world {TAUGHT_WORLD}, not in {}: give --world {TAUGHT_WORLD}",
            condition.world
        )));
    }
    if !condition.noise.is_empty() {
        let problem = "noise is a property of the simulated arm: leave --noise out, or use --body sim";
        return Err(Failure::Usage(problem.to_owned()));
    }
    Ok(())
}

pub(super) fn emulator_arguments(condition: &Condition, seed: u64, places: &Places) -> Vec<String> {
    let (world, seed) = (condition.world.as_str(), seed.to_string());
    let [line, camera, operator] =
        [&places.line, &places.camera, &places.operator].map(|path| path.display().to_string());
    let places = ["--link", &line, "--camera", &camera, "--operator", &operator];
    let run = ["--world", world, "--seed", &seed, "--fast", FAST, "--consent"];
    places.into_iter().chain(run).map(str::to_owned).collect()
}

pub(super) fn adept_arguments(places: &Places) -> Vec<String> {
    let socket = |path: &Path| format!("socket:{}", path.display());
    let port = places.line.display().to_string();
    let (camera, operator) = (socket(&places.camera), socket(&places.operator));
    let ways = ["--port", &port, "--camera", &camera, "--operator", &operator];
    let arm = ["--arm", "emulated", "--enable", "--home"];
    ways.into_iter().chain(arm).map(str::to_owned).collect()
}

fn wait_for_line(line: &Path, emulator: &mut Child, stop: &Stop) -> Result<(), Failure> {
    let is_there = || {
        stop.check()?;
        emulator.check()?;
        Ok(line.exists().then_some(()))
    };
    retry(LINE_WITHIN, is_there)?.ok_or_else(|| {
        let seconds = LINE_WITHIN.as_secs();
        Failure::Failed(format!("the emulated controller was not ready after {seconds} s"))
    })
}
