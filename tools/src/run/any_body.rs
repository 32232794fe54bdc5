//! The bodies that a run in one process can be carried out with.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pschema_adept::AdeptArgs;
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Description};
use pschema_sim::SimArgs;
use pschema_vplus_emulator::{Emulator, EmulatorArgs};
use tempfile::TempDir;

use crate::design::BodyKind;
use crate::failure::Failure;

use super::body::{Places, adept_arguments, check_adept, emulator_arguments};
use super::experiment::{Condition, read};
use super::pair::runtime_directory;

/// Any of them. Fields are dropped in this order: the body leaves the line before the line goes.
pub(super) struct AnyBody {
    body: Box<dyn Body>,
    _emulated: Option<(Emulator, TempDir)>,
}

impl AnyBody {
    /// The body of a run.
    pub(super) fn new(condition: &Condition, seed: u64) -> Result<Self, Failure> {
        match condition.body {
            BodyKind::Sim => {
                let arguments = read::<SimArgs>(condition.simulated(seed))?;
                Ok(Self {
                    body: Box::new(pschema_sim::build(&arguments).map_err(Failure::of)?),
                    _emulated: None,
                })
            }
            BodyKind::Adept => Self::adept(condition, seed),
        }
    }

    /// The arm's driver on a serial line, its controller emulated by a thread of this process.
    fn adept(condition: &Condition, seed: u64) -> Result<Self, Failure> {
        check_adept(condition)?;
        let directory = runtime_directory()?;
        let places = Places::within(directory.path());
        let emulator = read::<EmulatorArgs>(emulator_arguments(condition, seed, &places))?;
        let emulator = Emulator::start(emulator).map_err(Failure::of)?;
        let arguments = read::<AdeptArgs>(adept_arguments(&places))?;
        let stop = Arc::new(AtomicBool::new(false));
        let mut body = pschema_adept::build(&arguments, Arc::clone(&stop), None)?;
        pschema_adept::enable(&arguments, &mut body, &stop)?;
        Ok(Self { body: Box::new(body), _emulated: Some((emulator, directory)) })
    }
}

impl Body for AnyBody {
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
