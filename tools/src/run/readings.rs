//! The figures that a curriculum's `[[experiment.measure]]` tables ask for, read off a run.

use pschema_inspect::{Report, SchemaQuery, StageSummary};
use serde::Serialize;

use crate::design::{Design, Measure, Quantity};
use crate::failure::Failure;
use crate::learner::Asks;

use super::names;
use super::trace::{Trace, Trial};

/// One figure read off a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Reading {
    /// What it is, for people.
    pub(crate) name: String,
    /// Its value, of a share 0 to 1; none where there is nothing to read it off.
    pub(crate) value: Option<f64>,
    /// What the paper says of it.
    pub(crate) published: Option<String>,
    /// How it is shown.
    #[serde(skip)]
    pub(crate) unit: Unit,
    /// Why ours differs from what the paper says.
    #[serde(skip)]
    pub(crate) why: Option<String>,
}

/// How a figure is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Unit {
    /// A whole number, or half of one.
    #[default]
    Count,
    /// A share, shown in percent.
    Share,
    /// A number as it comes, or a mean of such.
    Value,
    /// Microseconds.
    Microseconds,
}

/// Everything that measures are read off.
pub(crate) struct Reader<'a> {
    pub(crate) design: &'a Design,
    pub(crate) report: &'a Report,
    pub(crate) trace: &'a Trace,
}

impl Reader<'_> {
    /// All that the experiment asks for.
    pub(crate) fn readings(&self, asked: &mut impl Asks) -> Result<Vec<Reading>, Failure> {
        let read = |measure: &Measure| {
            let key = || format!("measure {:?}", measure.name);
            self.reading(measure, asked).map_err(|failure| names::at(self.design, &key(), failure))
        };
        self.design.measures.iter().map(read).collect()
    }

    fn reading(&self, wanted: &Measure, asked: &mut impl Asks) -> Result<Reading, Failure> {
        let report = self.report;
        let count = |n: u32| Some(f64::from(n));
        let (value, unit) = match wanted.of {
            Quantity::SchemasTotal => (count(report.schemas_total), Unit::Count),
            Quantity::SchemasGeneralised => (count(report.schemas_generalised), Unit::Count),
            Quantity::CounterExamples => {
                (self.sum(&wanted.stages, |stage| stage.counter_examples_new.into()), Unit::Count)
            }
            Quantity::Placements => (placements(&report.stages).and_then(count), Unit::Count),
            Quantity::PlacementsAll => (all_placements(&report.stages).and_then(count), Unit::Count),
            Quantity::Actions => (self.sum(&wanted.stages, |stage| stage.actions), Unit::Count),
            Quantity::SchemasNew => (self.sum(&wanted.stages, |stage| stage.schemas_new.into()), Unit::Count),
            Quantity::MetShare => (self.share(&wanted.stages, |stage| stage.trials_met), Unit::Share),
            Quantity::FirstTryShare => {
                (self.share(&wanted.stages, |stage| stage.trials_met_first), Unit::Share)
            }
            Quantity::ActionsToMet => (self.actions_to_met(&wanted.stages), Unit::Count),
            Quantity::TouchingShare => (self.touching_share(&wanted.stages), Unit::Share),
            Quantity::Precision => {
                let met = |names: &[String]| self.total(names, |stage| stage.trials_met);
                let (right, wrong) = (met(&wanted.stages), met(&wanted.against));
                (ratio(right, right + wrong), Unit::Share)
            }
            Quantity::Schemas => (Some(schemas(wanted, asked)?), Unit::Count),
            Quantity::ValueSum => (self.came(wanted).map(|(sum, _)| sum), Unit::Value),
            Quantity::ValueMean => {
                let mean = |(sum, actions)| if actions > 0.0 { Some(sum / actions) } else { None };
                (self.came(wanted).and_then(mean), Unit::Value)
            }
            Quantity::StepUsP99 => (Some(report.step_latency_us_p99), Unit::Microseconds),
        };
        let (name, published, why) = (wanted.name.clone(), wanted.published.clone(), wanted.why.clone());
        Ok(Reading { name, value, published, unit, why })
    }

    /// The stages of these names; those that only measure when none is named.
    fn measuring<'a>(&'a self, names: &'a [String]) -> impl Iterator<Item = &'a StageSummary> {
        let stages = self.report.stages.iter();
        stages
            .filter(move |stage| if names.is_empty() { !stage.learning } else { names.contains(&stage.name) })
    }

    fn total(&self, names: &[String], of: fn(&StageSummary) -> u32) -> u32 {
        self.measuring(names).map(of).sum()
    }

    fn share(&self, names: &[String], of: fn(&StageSummary) -> u32) -> Option<f64> {
        ratio(self.total(names, of), self.total(names, |stage| stage.trials))
    }

    /// Over the stages of these names, or all when none is named; none when there is none of them.
    fn sum(&self, names: &[String], of: fn(&StageSummary) -> u64) -> Option<f64> {
        let stages = self.report.stages.iter();
        let mut asked = stages.filter(|stage| names.is_empty() || names.contains(&stage.name)).peekable();
        asked.peek()?;
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2^52")]
        Some(asked.map(of).sum::<u64>() as f64)
    }

    /// The median.
    fn actions_to_met(&self, names: &[String]) -> Option<f64> {
        let is_asked = |trial: &Trial| names.iter().any(|name| name == self.trace.stage(trial.stage));
        let met = self.trace.trials().into_iter().filter(|trial| trial.met == Some(true) && is_asked(trial));
        #[expect(clippy::cast_precision_loss, reason = "counts far below 2^52")]
        let actions = met.map(|trial| trial.actions as f64).collect();
        crate::render::statistics::median(actions)
    }

    /// The sum of what came of a measure's value in the stages that it names, or in all when it names none, and the number of decisions in
    /// them; none where nothing was decided.
    fn came(&self, wanted: &Measure) -> Option<(f64, f64)> {
        let with_value = self.design.measures.iter().filter(|one| one.value.is_some());
        let at = with_value.into_iter().position(|one| std::ptr::eq(one, wanted))?;
        let is_asked = |stage: u32| {
            wanted.stages.is_empty() || wanted.stages.iter().any(|name| name == self.trace.stage(stage))
        };
        let asked = self.trace.steps.iter().filter(|step| is_asked(step.record.stage));
        let (sum, actions) = asked.fold((0.0, 0.0), |(sum, actions), step| {
            let acts = if step.record.decision.is_some() { 1.0 } else { 0.0 };
            (sum + step.came.get(at).copied().unwrap_or_default(), actions + acts)
        });
        (actions > 0.0).then_some((sum, actions))
    }

    fn touching_share(&self, names: &[String]) -> Option<f64> {
        let is_asked =
            |stage: u32| names.is_empty() || names.iter().any(|name| name == self.trace.stage(stage));
        let decided = self.trace.steps.iter().filter(|step| step.record.decision.is_some());
        let asked = decided.filter(|step| is_asked(step.record.stage));
        let (touching, all) = asked.fold((0_u32, 0_u32), |(touching, all), step| {
            (touching + u32::from(step.touching), all.saturating_add(1))
        });
        ratio(touching, all)
    }
}

/// Learning placements until there was a generalised schema; all of them if there never was one.
pub(super) fn placements(stages: &[StageSummary]) -> Option<u32> {
    first_generalisation(stages).or_else(|| all_placements(stages))
}

/// All learning placements; none where nothing was placed.
fn all_placements(stages: &[StageSummary]) -> Option<u32> {
    let placed = stages.iter().filter(|stage| stage.learning).map(|stage| stage.trials).sum();
    (placed > 0).then_some(placed)
}

/// The number of the learning placement, from 1, at whose end there was a generalised schema.
pub(super) fn first_generalisation(stages: &[StageSummary]) -> Option<u32> {
    let learning = stages.iter().filter(|stage| stage.learning);
    let after = learning.flat_map(|stage| stage.generalised_after_trial.iter());
    let at = after.copied().position(|generalised| generalised > 0)?;
    u32::try_from(at + 1).ok()
}

fn ratio(part: u32, whole: u32) -> Option<f64> {
    (whole > 0).then(|| f64::from(part) / f64::from(whole))
}

/// How many schemas there are with these conditions.
fn schemas(wanted: &Measure, asked: &mut impl Asks) -> Result<f64, Failure> {
    let mut matching = |post: Option<&String>| {
        let query =
            SchemaQuery { pre: wanted.pre.clone(), post: post.cloned(), limit: 1, ..SchemaQuery::default() };
        asked.ask(query).map(|list| list.matching)
    };
    let all = matching(wanted.post.as_ref())?;
    let except = match &wanted.except_post {
        Some(post) => matching(Some(post))?,
        None => 0,
    };
    Ok(f64::from(all.saturating_sub(except)))
}
