//! An experiment as it is carried out: the runs that a curriculum's `[experiment]` table asks for.

use std::collections::BTreeMap;

use clap::{Args, Parser};
use pschema_protocol::body::Body;
use pschema_server::config::{self, ConfigError};
use pschema_sim::SimArgs;

use crate::design::{self, BodyKind, Design, DesignError, Variant};
use crate::failure::Failure;

/// An experiment, and the conditions it is run under.
#[derive(Clone, Debug)]
pub(crate) struct Experiment {
    /// What the curriculum's file says.
    pub(crate) design: Design,
    /// The run as it stands, or its variants, or one for each value swept.
    pub(crate) conditions: Vec<Condition>,
}

/// Everything that decides a run but its seed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Condition {
    /// What it is called beside the others; none when there are no others.
    pub(crate) name: Option<String>,
    /// The daemon's curriculum: a built-in one or a file.
    pub(crate) curriculum: String,
    /// The body's world: a built-in one or a file.
    pub(crate) world: String,
    /// The body.
    pub(crate) body: BodyKind,
    /// The run whose memory this one goes on from.
    pub(crate) after: Option<Box<Condition>>,
    /// Settings of the daemon.
    pub(crate) settings: Vec<String>,
    /// Noise of the body, by name.
    pub(crate) noise: BTreeMap<String, f64>,
    /// What a swept value is set to.
    pub(crate) swept: Option<f64>,
}

/// What is asked of an experiment beyond what its file says.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Overrides<'a> {
    /// Another world.
    pub(crate) world: Option<&'a str>,
    /// Another body.
    pub(crate) body: Option<BodyKind>,
    /// Only this variant.
    pub(crate) variant: Option<&'a str>,
}

impl Experiment {
    /// The experiment that the curriculum `name` (built in, or a file) is.
    pub(crate) fn new(name: &str, asked: Overrides<'_>) -> Result<Self, Failure> {
        let design = design::design(name).map_err(|error| match error {
            DesignError::Config(ConfigError::NoCurriculum { .. }) => Failure::Usage(format!(
                "no experiment {name:?}: it is none of the built-in ones ({}), and there is no such file",
                built_in()
            )),
            DesignError::NoExperiment { .. } => Failure::Usage(format!("{error}; there are: {}", built_in())),
            error => Failure::of(error),
        })?;
        Self::of(design, asked)
    }

    /// All that come with this binary, the quickest first.
    pub(crate) fn all() -> Result<Vec<Self>, Failure> {
        let all = design::designs().map_err(Failure::of)?;
        all.into_iter().map(|design| Self::of(design, Overrides::default())).collect()
    }

    fn of(mut design: Design, asked: Overrides<'_>) -> Result<Self, Failure> {
        if let Some(world) = asked.world.filter(|world| *world != design.world) {
            // The paper's figures are for its own set-ups.
            world.clone_into(&mut design.world);
            design.published = None;
            design.why = None;
            design.measures.iter_mut().for_each(|measure| (measure.published, measure.why) = (None, None));
        }
        if let Some(body) = asked.body {
            design.body = body;
        }
        let mut conditions = conditions(&design, asked.world);
        conditions.iter().try_for_each(|one| design::read_again(&one.world)).map_err(Failure::of)?;
        if let Some(name) = asked.variant {
            conditions.retain(|condition| condition.name.as_deref() == Some(name));
            if conditions.is_empty() {
                let known: Vec<_> =
                    self::conditions(&design, None).into_iter().filter_map(|c| c.name).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                return Err(Failure::Usage(format!(
                    "{} has no variant {name:?}; there are: {known}",
                    design.name
                )));
            }
        }
        Ok(Self { design, conditions })
    }
}

/// The run as it stands and its variants, each for every value swept.
fn conditions(design: &Design, world: Option<&str>) -> Vec<Condition> {
    let alone = design.variants.is_empty();
    let base = Variant { name: design.base.clone(), ..Variant::default() };
    let variants = [&base].into_iter().chain(&design.variants);
    let condition = |variant: &Variant| {
        let world = world.or(variant.world.as_deref()).unwrap_or(&design.world).to_owned();
        // What was learnt before is learnt in the same world, whatever is changed afterwards.
        let after = design.after.as_ref().map(|earlier| {
            let (curriculum, world) = (earlier.curriculum.clone(), world.clone());
            Box::new(Condition { curriculum, world, body: earlier.body, ..Condition::default() })
        });
        Condition {
            name: (!alone).then(|| variant.name.clone()),
            curriculum: variant.curriculum.as_ref().unwrap_or(&design.curriculum).clone(),
            world,
            body: design.body,
            after,
            settings: variant.settings(),
            noise: variant.noise.clone(),
            swept: None,
        }
    };
    let Some((name, values)) = design.sweep.first_key_value() else {
        return variants.map(condition).collect();
    };
    let swept = |variant: &Variant| {
        let condition = condition(variant);
        let at = |value: &f64| {
            let mut condition = condition.clone();
            let set = format!("{name} = {value}");
            condition.name =
                Some(condition.name.map_or_else(|| set.clone(), |name| format!("{name}, {set}")));
            condition.settings.push(format!("values.{name}={value:?}"));
            condition.swept = Some(*value);
            condition
        };
        values.iter().map(at).collect::<Vec<_>>()
    };
    variants.flat_map(swept).collect()
}

/// The names there are.
fn built_in() -> String {
    let names = config::BUILT_IN.iter().map(|(name, _)| *name);
    names.filter(|name| design::design(name).is_ok()).collect::<Vec<_>>().join(", ")
}

impl Condition {
    /// Whether the paper's figures are about this: nothing is changed that the experiment's file does not say itself.
    pub(crate) fn is_as_published(&self, design: &Design) -> bool {
        let own = self.world == design.world && self.curriculum == design.curriculum;
        own && self.settings.is_empty() && self.noise.is_empty()
    }

    /// How the daemon is started: the same for a process of its own and for a run in one process.
    pub(crate) fn daemon(&self, seed: u64) -> Vec<String> {
        let seed = seed.to_string();
        let own = ["--curriculum", &self.curriculum, "--seed", &seed].map(str::to_owned);
        let settings = self.settings.iter().flat_map(|setting| ["--set".to_owned(), setting.clone()]);
        own.into_iter().chain(settings).collect()
    }

    /// How the simulated body is started.
    pub(crate) fn simulated(&self, seed: u64) -> Vec<String> {
        let own = ["--world", &self.world, "--seed", &seed.to_string()].map(str::to_owned);
        let noise =
            self.noise.iter().flat_map(|(name, value)| ["--noise".to_owned(), format!("{name}={value}")]);
        own.into_iter().chain(noise).collect()
    }

    /// How much there is to do.
    pub(crate) fn size(&self) -> Workload {
        let curriculum = config::curriculum(&self.curriculum).ok();
        let trials =
            curriculum.map_or_else(Vec::new, |c| c.stages.iter().map(|stage| stage.trials).collect());
        let body = read::<SimArgs>(self.simulated(1)).ok().and_then(|args| pschema_sim::build(&args).ok());
        Workload { postures: body.map(|body| body.describe().repertoire.len() as u64), trials }
    }
}

/// How much there is to do in an experiment, to show how far it is. What cannot be known (a file that cannot be
/// read, say) is left open: the processes will say better what is wrong.
#[derive(Clone, Debug, Default)]
pub(crate) struct Workload {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_alone_has_no_name_and_starts_as_its_file_says() {
        let experiment = Experiment::new("exp1-s1", Overrides::default()).unwrap();
        let [only] = experiment.conditions.as_slice() else { panic!("{:?}", experiment.conditions) };
        assert_eq!(only.name, None);
        assert_eq!(only.daemon(7), ["--curriculum", "exp1-s1", "--seed", "7"]);
        assert_eq!(only.simulated(7), ["--world", "wide", "--seed", "7"]);
    }

    #[test]
    fn another_world_is_not_what_the_paper_reports_of() {
        let asked = Overrides { world: Some("narrow"), ..Overrides::default() };
        let experiment = Experiment::new("exp1-s1", asked).unwrap();
        assert_eq!(experiment.design.published, None);
        assert!(experiment.design.measures.iter().all(|measure| measure.published.is_none()));
        assert_eq!(experiment.conditions[0].world, "narrow");
    }

    #[test]
    fn variants_and_values_are_conditions_of_their_own() {
        let mut design = Experiment::new("exp1-s1", Overrides::default()).unwrap().design;
        design.base = "whole".to_owned();
        design.variants.push(Variant {
            name: "deaf".to_owned(),
            learner: [("attention".to_owned(), false.into())].into_iter().collect(),
            noise: BTreeMap::from([("finger_misplaced".to_owned(), 0.1)]),
            ..Variant::default()
        });
        let names = |design: &Design| -> Vec<_> {
            conditions(design, None).into_iter().map(|condition| condition.name.unwrap_or_default()).collect()
        };
        assert_eq!(names(&design), ["whole", "deaf"]);
        let deaf = &conditions(&design, None)[1];
        assert_eq!(deaf.daemon(1)[4..], ["--set", "learner.attention=false"]);
        assert_eq!(deaf.simulated(1)[4..], ["--noise", "finger_misplaced=0.1"]);
        design.sweep = BTreeMap::from([("rate".to_owned(), vec![0.0, 0.5])]);
        assert_eq!(
            names(&design),
            ["whole, rate = 0", "whole, rate = 0.5", "deaf, rate = 0", "deaf, rate = 0.5"]
        );
        assert_eq!(conditions(&design, None)[1].settings, ["values.rate=0.5"]);
        let asked = Overrides { variant: Some("mute"), ..Overrides::default() };
        let refused = Experiment::of(design, asked).unwrap_err().to_string();
        assert!(refused.contains("whole, rate = 0"), "{refused}");
    }

    #[test]
    fn an_unknown_experiment_is_answered_with_those_there_are() {
        for name in ["exp9", "free"] {
            let error = Experiment::new(name, Overrides::default()).unwrap_err();
            assert!(matches!(&error, Failure::Usage(said) if said.contains("exp1-s2")), "{error}");
        }
    }
}
