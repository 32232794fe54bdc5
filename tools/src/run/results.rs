//! The figures of a run, as `experiment --json` prints them.

use pschema_inspect::{Report, StageSummary};
use serde::Serialize;

use crate::design::{Design, Published};

use super::experiment::Condition;
use super::readings::{Reading, first_generalisation, placements};

/// One run of an experiment, and everything it is judged by.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Results {
    /// The experiment's name.
    pub(crate) experiment: String,
    /// The variant; none where the experiment has none.
    pub(crate) variant: Option<String>,
    /// What a swept value was set to; none where nothing is swept.
    pub(crate) swept: Option<f64>,
    /// The world it was run in.
    pub(crate) world: String,
    /// The body it was run with.
    pub(crate) body: &'static str,
    /// The seed of learner and body.
    pub(crate) seed: u64,
    /// Schemas after learning.
    pub(crate) schemas_total: u32,
    /// Those with constants only.
    pub(crate) schemas_concrete: u32,
    /// Those with variables.
    pub(crate) schemas_generalised: u32,
    /// Learning placements until there was a generalised schema; all of them if there never was one; none where nothing was
    /// placed to learn from.
    pub(crate) placements: Option<u32>,
    /// The number of the placement after which there was a generalised schema; none if there never was.
    pub(crate) generalised_after_placement: Option<u32>,
    /// Counter-examples made.
    pub(crate) counter_examples: u32,
    /// Actions carried out, the probe's included.
    pub(crate) actions_total: u64,
    /// Its stages, in the order in which they were entered.
    pub(crate) stages: Vec<StageSummary>,
    /// What was measured with learning frozen; none where nothing was.
    pub(crate) probe: Option<Probe>,
    /// What the curriculum's `[[experiment.measure]]` tables ask to be read off the run.
    pub(crate) measures: Vec<Reading>,
    /// How long the run took, from starting the processes to the last report.
    pub(crate) wall_s: f64,
    /// Median time of a step in the daemon, from the frame decoded to the reply sent.
    pub(crate) step_latency_us_p50: f64,
    /// 99th percentile of it.
    pub(crate) step_latency_us_p99: f64,
    /// Digest of everything learnt: equal digests are equal memories.
    pub(crate) memory_digest: String,
    /// The paper's figures for this set-up; none for another world and for variants.
    pub(crate) published: Option<Published>,
}

/// Touching at positions never used in training, learning frozen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct Probe {
    /// Positions tried.
    pub(crate) placements_tried: u32,
    /// Touched with the first action.
    pub(crate) touched_first_try: u32,
    /// Touched at all.
    pub(crate) touched: u32,
}

impl Results {
    /// The figures in a run's last report.
    pub(crate) fn new(
        design: &Design,
        condition: &Condition,
        report: &Report,
        measures: Vec<Reading>,
        wall_s: f64,
    ) -> Self {
        let published = design.published.as_ref().filter(|_| condition.is_as_published(design));
        Self {
            experiment: design.name.clone(),
            variant: condition.name.clone(),
            swept: condition.swept,
            world: condition.world.clone(),
            body: condition.body.name(),
            seed: report.seed,
            schemas_total: report.schemas_total,
            schemas_concrete: report.schemas_concrete,
            schemas_generalised: report.schemas_generalised,
            placements: placements(&report.stages),
            generalised_after_placement: first_generalisation(&report.stages),
            counter_examples: report.stages.iter().map(|stage| stage.counter_examples_new).sum(),
            actions_total: report.actions_total,
            stages: report.stages.clone(),
            probe: probe(&report.stages),
            measures,
            wall_s,
            step_latency_us_p50: report.step_latency_us_p50,
            step_latency_us_p99: report.step_latency_us_p99,
            memory_digest: report.memory_digest.clone().unwrap_or_default(),
            published: published.cloned(),
        }
    }
}

/// All stages in which nothing was learnt are measurements.
fn probe(stages: &[StageSummary]) -> Option<Probe> {
    let measured = stages.iter().filter(|stage| !stage.learning);
    let probe = measured.fold(Probe::default(), |probe, stage| Probe {
        placements_tried: probe.placements_tried + stage.trials,
        touched_first_try: probe.touched_first_try + stage.trials_met_first,
        touched: probe.touched + stage.trials_met,
    });
    (probe.placements_tried > 0).then_some(probe)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::run::experiment::{Experiment, Overrides};

    pub(crate) fn stage(name: &str, learning: bool, met: &[bool], generalised: &[u32]) -> StageSummary {
        let trials = u32::try_from(met.len()).unwrap();
        let trials_met = u32::try_from(met.iter().filter(|met| **met).count()).unwrap();
        StageSummary {
            name: name.to_owned(),
            learning,
            actions: u64::from(trials),
            schemas_new: 0,
            generalised_new: 0,
            counter_examples_new: 0,
            trials,
            trials_met,
            trials_met_first: trials_met,
            generalised_after_trial: generalised.to_vec(),
            actions_of_trial: vec![1; met.len()],
            drawn: Vec::new(),
            saturated: false,
            ended: true,
        }
    }

    pub(crate) fn report(stages: Vec<StageSummary>) -> Report {
        Report {
            curriculum: "exp1-s1".to_owned(),
            seed: 7,
            stage: "probe".to_owned(),
            stage_state: pschema_inspect::StageState::Finished,
            finished: true,
            stuck: None,
            step: 330,
            schemas_total: 228,
            schemas_concrete: 227,
            schemas_generalised: 1,
            actions_total: stages.iter().map(|stage| stage.actions).sum(),
            step_latency_us_p50: 55.0,
            step_latency_us_p99: 180.0,
            memory_digest: Some("00ff".to_owned()),
            stages,
        }
    }

    /// The results of exp1-s1 in `world`, had it given this report.
    pub(crate) fn results(world: &str, report: &Report) -> Results {
        let asked = Overrides { world: Some(world), ..Overrides::default() };
        let experiment = Experiment::new("exp1-s1", asked).unwrap();
        Results::new(&experiment.design, &experiment.conditions[0], report, Vec::new(), 4.25)
    }

    #[test]
    fn generalisation_is_counted_in_learning_placements_over_all_stages() {
        let stages = vec![
            stage("babbling", true, &[], &[]),
            stage("first", true, &[true], &[0]),
            stage("second", true, &[true, true], &[1, 1]),
            stage("probe", false, &[true, false], &[1, 1]),
        ];
        let results = results("wide", &report(stages));
        assert_eq!(results.placements, Some(2));
        assert_eq!(results.probe, Some(Probe { placements_tried: 2, touched_first_try: 1, touched: 1 }));
        assert_eq!(results.published.unwrap().schemas_total, Some(227));
    }

    #[test]
    fn a_probe_alone_never_counts_as_learning_and_no_generalisation_is_none() {
        let stages = vec![stage("first", true, &[true], &[0]), stage("probe", false, &[true], &[1])];
        let results = results("my-world.toml", &report(stages));
        assert_eq!(
            (results.placements, results.generalised_after_placement, results.published),
            (Some(1), None, None)
        );
    }

    /// Experiment 2 once told 0 placements tried and 0 touched, as if it had tried.
    #[test]
    fn what_a_run_did_not_measure_is_none() {
        let results = results("wide", &report(vec![stage("babbling", true, &[], &[])]));
        assert_eq!((results.placements, results.probe), (None, None));
        let printed = serde_json::to_value(&results).unwrap();
        assert!(printed["placements"].is_null() && printed["probe"].is_null(), "{printed}");
    }
}
