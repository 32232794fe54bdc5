//! Runs as a report shows them: by experiment, and by condition.

use pschema_learner::mechanisms::Mechanisms;
use pschema_server::{LearnerSettings, config};

use crate::design::Design;
use crate::render::statistics::{Summary, summary};
use crate::run::{Condition, Outcome, Reading, Results};

/// One experiment with its runs.
#[derive(Clone, Debug)]
pub(crate) struct Section<'a> {
    pub(crate) design: &'a Design,
    /// The runs by condition; those of the experiment as it stands are the first.
    pub(crate) groups: Vec<Group<'a>>,
}

/// Runs under one condition, with different seeds.
#[derive(Clone, Debug)]
pub(crate) struct Group<'a> {
    pub(crate) condition: &'a Condition,
    pub(crate) outcomes: &'a [Outcome],
    /// The learner's parameters and the body's noise, as text.
    pub(crate) parameters: String,
}

impl<'a> Group<'a> {
    /// The runs under a condition.
    pub(crate) fn new(condition: &'a Condition, outcomes: &'a [Outcome]) -> Self {
        Self { condition, outcomes, parameters: parameters(condition) }
    }

    /// What each run is judged by.
    pub(crate) fn results(&self) -> impl Iterator<Item = &'a Results> {
        self.outcomes.iter().map(|outcome| &outcome.results)
    }

    /// A figure of all runs that have it.
    pub(crate) fn over(&self, figure: impl Fn(&Results) -> Option<f64>) -> Option<Summary> {
        summary(self.results().filter_map(figure).collect())
    }

    /// The measure at this place in the list of the experiment's measures, over all runs.
    pub(crate) fn measured(&self, at: usize) -> Option<Summary> {
        self.over(|results| results.measures.get(at)?.value)
    }

    /// The condition's name beside the others.
    pub(crate) fn name(&self) -> &'a str {
        self.condition.name.as_deref().unwrap_or("as it is")
    }
}

fn parameters(condition: &Condition) -> String {
    let lesson = config::lesson(&condition.curriculum, Default::default(), &condition.settings);
    let learner = lesson.map_or_else(|error| error.to_string(), |(_, learner)| told(&learner));
    let noise = condition.noise.iter().map(|(name, value)| format!("\nnoise of the body: {name} = {value}"));
    learner + &noise.collect::<String>()
}

/// The parameters, and the mechanisms where the learner does more than the paper's.
fn told(LearnerSettings { parameters, mechanisms, .. }: &LearnerSettings) -> String {
    let beyond = (*mechanisms != Mechanisms::PAPER).then(|| format!("\n{mechanisms:#?}"));
    format!("{parameters:#?}") + &beyond.unwrap_or_default()
}

impl<'a> Section<'a> {
    /// What each run is judged by, under all conditions.
    pub(crate) fn results(&self) -> impl Iterator<Item = &'a Results> {
        self.groups.iter().flat_map(Group::results)
    }

    /// The measures of the first run, which are those of every run.
    pub(crate) fn measures(&self) -> &'a [Reading] {
        self.results().next().map_or(&[], |results| &results.measures)
    }

    /// The first run of the experiment as it stands.
    pub(crate) fn first(&self) -> Option<&'a Outcome> {
        self.groups.first()?.outcomes.first()
    }

    /// How many seeds there are, of the condition that has the most.
    pub(crate) fn seeds(&self) -> usize {
        self.groups.iter().map(|group| group.outcomes.len()).max().unwrap_or(0)
    }
}
