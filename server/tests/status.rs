//! How near a stage is to its end, as `status` tells it: compared with what memory holds, step by step.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use common::{Row, curriculum, setup};
use pschema_inspect::{StageState, Status, StatusQuery};
use pschema_learner::curriculum::{Curriculum, Habituation};
use pschema_server::in_process::{InProcess, RunState};

const EXECUTIONS_MIN: u32 = 4;

fn habituating() -> Curriculum {
    let mut curriculum = curriculum();
    curriculum.stages[0].habituation =
        Some(Habituation { executions_min: EXECUTIONS_MIN, interval_max: 0.25 });
    curriculum
}

fn status(run: &InProcess<Row>) -> Status {
    run.ask(&StatusQuery {}).unwrap()
}

/// Babbled schemas have no pre-conditions: each can be executed anywhere.
fn too_rarely_executed(run: &InProcess<Row>) -> u32 {
    let schemas = &run.learner().memory().content().schemas;
    let rare = schemas.iter().filter(|schema| schema.executions.trials < EXECUTIONS_MIN);
    u32::try_from(rare.count()).unwrap()
}

#[test]
fn saturation_and_habituation_are_told_as_they_come() {
    let mut run = InProcess::new(Row::new("row"), setup(3, habituating())).unwrap();
    let (mut quiet, mut left) = (Vec::new(), Vec::new());
    while run.advance().unwrap() == RunState::Running {
        let told = status(&run);
        if told.stage != "babbling" {
            break;
        }
        assert_eq!(told.trial, None);
        let saturation = told.saturation.unwrap();
        assert_eq!(saturation.quiet_actions_wanted, 3);
        assert!((saturation.saturation_below - 1.0).abs() < f64::EPSILON);
        quiet.push(saturation.quiet_actions);
        let habituation = told.habituation.unwrap();
        assert_eq!(habituation.executions_min, EXECUTIONS_MIN);
        assert!((habituation.interval_max - 0.25).abs() < f64::EPSILON);
        assert_eq!(habituation.habituation_left.is_some(), told.stage_state == StageState::Habituating);
        if let Some(schemas) = habituation.habituation_left {
            assert_eq!(schemas, too_rarely_executed(&run));
            assert_eq!(saturation.quiet_actions, 3, "saturation is what led here");
            left.push(schemas);
        }
    }
    assert_eq!(too_rarely_executed(&run), 0, "the stage was left when nothing was left");
    assert!(quiet.contains(&0) && quiet.windows(2).all(|two| two[1] <= two[0] + 1), "{quiet:?}");
    assert!(left.len() > 3 && left.last() == Some(&1), "{left:?}");
    assert!(left.windows(2).all(|two| two[1] <= two[0]), "{left:?}");
}

#[test]
fn trials_are_told_and_nothing_once_the_curriculum_is_over() {
    let mut run = InProcess::new(Row::new("row"), setup(3, habituating())).unwrap();
    let mut seen = Vec::new();
    while run.advance().unwrap() == RunState::Running {
        let told = status(&run);
        if told.stage != "touching" {
            continue;
        }
        assert_eq!((&told.saturation, &told.habituation), (&None, &None), "its trials end it");
        let trial = told.trial.unwrap();
        assert_eq!((trial.trials_wanted, trial.actions_max), (2, Some(20)));
        if trial.open && !seen.contains(&trial.trial) {
            assert_eq!(trial.actions, 0, "it has just begun");
            seen.push(trial.trial);
        }
    }
    assert_eq!(seen, [1, 2]);
    let over = status(&run);
    assert_eq!(over.stage_state, StageState::Finished);
    assert_eq!((over.saturation, over.habituation, over.trial), (None, None, None));
}
