//! What an experiment is made of.

use clap::{Args, Parser};
use pschema_protocol::body::Body;
use pschema_sim::SimArgs;

use crate::cli::ExperimentName;
use crate::failure::Failure;

use super::published::{Published, SCENARIO_1_PHYSICAL, SCENARIO_1_SIMULATED, SCENARIO_2};

/// A repeatable run: which curriculum, in which world, and what the paper reports of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Experiment {
    /// Its name, as reported.
    pub(crate) name: &'static str,
    /// The daemon's curriculum.
    pub(crate) curriculum: &'static str,
    /// The body's world: a built-in one or a file.
    pub(crate) world: String,
    /// What is put before the robot.
    pub(crate) object: &'static str,
    /// The published figures; none for a world of one's own.
    pub(crate) published: Option<Published>,
}

impl Experiment {
    /// `name` in `world`: `wide`, `narrow` or a world file.
    pub(crate) fn new(name: ExperimentName, world: &str) -> Self {
        // The paper's figures are for its own set-ups: scenario 2 was run in simulation only.
        let (name, published) = match (name, world) {
            (ExperimentName::Exp1S1, "wide") => ("exp1-s1", Some(SCENARIO_1_SIMULATED)),
            (ExperimentName::Exp1S1, "narrow") => ("exp1-s1-narrow", Some(SCENARIO_1_PHYSICAL)),
            (ExperimentName::Exp1S1, _) => ("exp1-s1", None),
            (ExperimentName::Exp1S2, "wide") => ("exp1-s2", Some(SCENARIO_2)),
            (ExperimentName::Exp1S2, _) => ("exp1-s2", None),
        };
        Self { name, curriculum: name, world: world.to_owned(), object: "blue block", published }
    }

    /// How the daemon is started: the same for a process of its own and for a run in one process.
    pub(crate) fn daemon(&self, seed: u64) -> Vec<String> {
        ["--curriculum", self.curriculum, "--seed", &seed.to_string()].map(str::to_owned).into()
    }

    /// How the body is started.
    pub(crate) fn body(&self, seed: u64) -> Vec<String> {
        ["--world", &self.world, "--seed", &seed.to_string()].map(str::to_owned).into()
    }

    /// How much there is to do.
    pub(crate) fn size(&self) -> Size {
        let curriculum = pschema_server::config::curriculum(self.curriculum).ok();
        let trials =
            curriculum.map_or_else(Vec::new, |c| c.stages.iter().map(|stage| stage.trials).collect());
        let body = read::<SimArgs>(self.body(1)).ok().and_then(|args| pschema_sim::build(&args).ok());
        Size { postures: body.map(|body| body.describe().repertoire.len() as u64), trials }
    }
}

/// How much there is to do in an experiment, to show how far it is. What cannot be known (a file that cannot be
/// read, say) is left open: the processes will say better what is wrong.
#[derive(Clone, Debug, Default)]
pub(crate) struct Size {
    /// Postures in the body's repertoire.
    pub(crate) postures: Option<u64>,
    /// Trials of each stage of the curriculum.
    pub(crate) trials: Vec<u32>,
}

/// Arguments as a process would read them, so that runs in one process and in two have the same defaults.
pub(super) fn read<A: Args>(arguments: Vec<String>) -> Result<A, Failure> {
    #[derive(Parser)]
    #[command(no_binary_name = true)]
    struct Read<A: Args> {
        #[command(flatten)]
        args: A,
    }
    let read = Read::try_parse_from(arguments);
    read.map(|read| read.args)
        .map_err(|error| Failure::Failed(format!("arguments of the experiment: {error}")))
}
