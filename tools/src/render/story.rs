//! A run told to a person, stage by stage, as its reports come in. Stages are recognised by what they do
//! (nothing arranged: babbling; nothing learnt: measuring), not by their names.

use pschema_inspect::{Report, StageSummary};

use super::words::{count, plain};

/// How far the story of a run has been told.
#[derive(Debug)]
pub(crate) struct Story {
    /// The object that is put before the robot.
    object: String,
    /// Stages that have been told.
    told: usize,
    /// Learning placements that have been told.
    placements: u32,
    /// Whether the first generalisation has been told.
    generalised: bool,
    /// Postures in the body's repertoire.
    postures: Option<u64>,
}

impl Story {
    /// The story of a robot that knows so many postures, if known, and is given `object`.
    pub(crate) fn new(object: String, postures: Option<u64>) -> Self {
        Self { object, told: 0, placements: 0, generalised: false, postures }
    }

    /// A line for each stage that has ended since the last report.
    pub(crate) fn news(&mut self, report: &Report) -> Vec<String> {
        let ended: Vec<_> = report.stages.iter().skip(self.told).take_while(|stage| stage.ended).collect();
        self.told += ended.len();
        ended.into_iter().map(|stage| self.ended(stage)).collect()
    }

    fn ended(&mut self, stage: &StageSummary) -> String {
        let told = match (stage.learning, stage.trials) {
            (false, _) => probed(stage),
            (true, 0) => self.babbled(stage),
            (true, _) => self.placed(stage),
        };
        format!("{}: {told}", plain(&stage.name))
    }

    fn babbled(&self, stage: &StageSummary) -> String {
        let actions = count(stage.actions, "action");
        match self.postures {
            // A schema for each posture, made when it is first tried.
            Some(all) => format!(
                "tried {} of {all} postures and saw where they take its finger ({actions})",
                stage.schemas_new
            ),
            None => format!("{actions}, {} about its own body", count(stage.schemas_new, "schema")),
        }
    }

    fn placed(&mut self, stage: &StageSummary) -> String {
        let object = self.object.clone();
        let generalised = self.generalisation(stage);
        let given = match (stage.trials, self.placements) {
            (1, 0) => format!("given a {object}"),
            (1, _) => format!("the {object} elsewhere"),
            (n, 0) => format!("given a {object} in {n} places, one after the other"),
            (n, _) => format!("the {object} in {n} more places"),
        };
        self.placements += stage.trials;
        let actions = count(stage.actions, "action");
        let felt = match (stage.trials_met, stage.trials) {
            (0, _) if stage.counter_examples_new > 0 => {
                "it points at it, feels nothing, and remembers the exception".to_owned()
            }
            (0, _) => format!("it felt nothing ({actions})"),
            (1, 1) => format!("it reached and felt it ({actions})"),
            (met, trials) if met == trials => format!("it reached and felt it each time ({actions})"),
            (met, trials) => format!("it felt it in {met} of {trials} ({actions})"),
        };
        format!("{given}: {felt}{generalised}")
    }

    /// The placement that brought the first generalisation, if it is one of this stage's.
    fn generalisation(&mut self, stage: &StageSummary) -> String {
        let at = stage.generalised_after_trial.iter().position(|generalised| *generalised > 0);
        match at.and_then(|at| u32::try_from(at).ok()) {
            Some(at) if !self.generalised => {
                self.generalised = true;
                format!("; it generalised after placement {}", self.placements + at + 1)
            }
            _ => String::new(),
        }
    }
}

fn probed(stage: &StageSummary) -> String {
    format!(
        "learning frozen, touches at {} of {} places never seen, {} with the first action",
        stage.trials_met, stage.trials, stage.trials_met_first
    )
}

/// How far the present stage is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct StageProgress {
    /// The stage, for people.
    pub(crate) what: String,
    /// Postures or places that have been tried.
    pub(crate) done: u64,
    /// How many of them there are, if that is known.
    pub(crate) of: Option<u64>,
}

/// How far the present stage is; none before the first. `postures` is the size of the body's repertoire, `trials` what the curriculum plans for
/// each of its stages; either may be unknown.
pub(crate) fn doing(report: &Report, postures: Option<u64>, trials: &[u32]) -> Option<StageProgress> {
    let at = report.stages.len().checked_sub(1)?;
    let stage = report.stages.get(at)?;
    let planned = trials.get(at).copied().filter(|n| *n > 0);
    let name = plain(&stage.name);
    Some(match planned {
        None => StageProgress {
            what: format!("{name}: postures tried"),
            done: stage.schemas_new.into(),
            of: postures,
        },
        Some(n) => {
            let ended = stage.generalised_after_trial.len() as u64;
            let what = format!("{name}: touched {} of", stage.trials_met);
            StageProgress {
                what: format!("{what} {}", count(ended, "place")),
                done: ended,
                of: Some(n.into()),
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::tests::{report, stage};

    #[test]
    fn the_story_of_scenario_1() {
        let mut story = Story::new("blue block".to_owned(), Some(224));
        let mut babbling = stage("motor babbling", true, &[], &[]);
        (babbling.actions, babbling.schemas_new) = (229, 224);
        let mut first = stage("first touches", true, &[true, true], &[0, 1]);
        first.ended = false;
        assert_eq!(
            story.news(&report(vec![babbling.clone(), first.clone()])),
            ["motor babbling: tried 224 of 224 postures and saw where they take its finger (229 actions)"]
        );
        first.ended = true;
        let mut beyond = stage("out of reach", true, &[false], &[1]);
        beyond.counter_examples_new = 1;
        let probe = stage("probe", false, &[true; 97], &[1; 97]);
        let stages = vec![babbling, first, stage("a new place", true, &[true], &[1]), beyond, probe];
        assert_eq!(
            story.news(&report(stages.clone())),
            [
                "first touches: given a blue block in 2 places, one after the other: it reached and felt it each time \
                 (2 actions); it generalised after placement 2",
                "a new place: the blue block elsewhere: it reached and felt it (1 action)",
                "out of reach: the blue block elsewhere: it points at it, feels nothing, and remembers the exception",
                "probe: learning frozen, touches at 97 of 97 places never seen, 97 with the first action",
            ]
        );
        assert!(story.news(&report(stages)).is_empty(), "nothing is told twice");
    }

    #[test]
    fn progress_counts_postures_while_babbling_and_places_later() {
        let mut babbling = stage("motor babbling", true, &[], &[]);
        babbling.schemas_new = 100;
        let now = report(vec![babbling.clone()]);
        let doing_now = doing(&now, Some(224), &[0, 2]).unwrap();
        assert_eq!((doing_now.done, doing_now.of), (100, Some(224)));
        let later = report(vec![babbling, stage("first", true, &[true], &[0])]);
        let doing_later = doing(&later, Some(224), &[0, 2]).unwrap();
        assert_eq!((doing_later.done, doing_later.of), (1, Some(2)));
        assert_eq!(doing(&report(Vec::new()), None, &[]), None);
    }
}
