//! What a teacher says in a curriculum, and trials that end when something is not observed any more, on the abstract
//! table (paper, II-F: "speaking to it as it performs actions").

#![allow(clippy::unwrap_used)]
mod common;

use common::{Table, WORD, stage};
use pschema_learner::Frame;
use pschema_learner::curriculum::{
    Absence, Afterwards, Argument, Curriculum, NamedObservation, Pool, SceneCommand, Stage, Utterance,
};
use pschema_learner::digest::digest;
use pschema_learner::effect::Effect;
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::{StageCommand, StageEffect, StageReport};

/// More steps than any lesson takes.
const PATIENCE: usize = 1_000;

fn anything(kind: &str) -> NamedObservation {
    NamedObservation { kind: kind.into(), properties: Vec::new() }
}

fn says(text: &str) -> Utterance {
    let heard = NamedObservation {
        kind: "word".into(),
        properties: vec![("text".into(), Argument::Symbol(text.into()))],
    };
    Utterance { heard: vec![heard], when: None, unless: None, probability: 1.0, times_max: 1 }
}

/// Trials of ten actions on a table of four fields, with a block placed anew for each.
fn lesson(trials: u32, say: Vec<Utterance>) -> Stage {
    let position = ("position".into(), Argument::Draw("table".into()));
    Stage {
        trials,
        arrange: vec![SceneCommand { command: "place".into(), arguments: vec![position] }],
        trial_actions_max: 10,
        say,
        ..stage("lesson", &["finger", "object", "touch", "word"])
    }
}

/// One frame of a run: what was felt and said in it, whether it was the first of a trial, and what was then known.
#[derive(Debug)]
struct Moment {
    touching: bool,
    seen: bool,
    first: bool,
    said: Vec<usize>,
    heard: usize,
}

/// Goes through `stage`, and reports on it.
fn taught(stage: Stage) -> (Vec<Moment>, StageReport) {
    let curriculum = Curriculum {
        name: "lessons".into(),
        pools: vec![Pool { name: "table".into(), from: 0, to: 3 }],
        stages: vec![stage],
        afterwards: Afterwards::Hold,
    };
    let mut table = Table::new(5, 4, 4, curriculum, Parameters::default());
    let mut moments = Vec::new();
    let mut begun = false;
    for _ in 0..PATIENCE {
        let (touching, seen) = (table.touching, !table.blocks.is_empty());
        let goes_on = table.step();
        let step = table.steps.last().unwrap();
        let mut moment = Moment { touching, seen, first: begun, said: Vec::new(), heard: 0 };
        begun = false;
        for effect in &step.effects {
            match effect {
                Effect::Stage(StageEffect::Spoken { utterances, .. }) => moment.said.clone_from(utterances),
                Effect::Stage(StageEffect::TrialBegun { .. }) => begun = true,
                _ => (),
            }
        }
        let world = step.decision.iter().flat_map(|decision| decision.world.observations());
        moment.heard = world.filter(|observation| observation.kind() == WORD).count();
        if step.decision.is_some() {
            let heard = moment.heard > 0;
            assert_eq!(heard, !moment.said.is_empty(), "heard in the very frame that gives the occasion");
        }
        moments.push(moment);
        if !goes_on {
            let report = table.learner.memory().content().progress.reports[0].as_ref().clone();
            return (moments, report);
        }
    }
    panic!("the lesson has no end");
}

/// The frames of the open trials: those in which something may be said.
fn count_said(moments: &[Moment], utterance: usize) -> usize {
    moments.iter().filter(|moment| moment.said.contains(&utterance)).count()
}

#[test]
fn a_teacher_speaks_when_there_is_occasion_and_not_unless() {
    let always = |when: &str, unless: Option<&str>| Utterance {
        when: Some(anything(when)),
        unless: unless.map(anything),
        times_max: 100,
        ..says("so")
    };
    let say = vec![always("touch", None), always("object", Some("touch")), always("lamp", None)];
    let (moments, report) = taught(lesson(3, say));
    assert_eq!((report.trials, report.actions), (3, 30));
    // The first frame and each that ends a trial's arranging are of no trial, or are its first.
    for moment in moments.iter().skip(1) {
        assert_eq!(moment.said.contains(&0), moment.touching, "{moment:?}");
        assert_eq!(moment.said.contains(&1), moment.seen && !moment.touching, "{moment:?}");
    }
    assert!(count_said(&moments, 0) > 3 && count_said(&moments, 1) > 3, "both occasions came: {moments:?}");
    assert_eq!(count_said(&moments, 2), 0, "a sense that the body has not gives no occasion");
}

#[test]
fn a_teacher_speaks_as_probably_and_as_often_as_the_curriculum_says() {
    let likely = |probability, times_max| Utterance {
        when: Some(anything("object")),
        probability,
        times_max,
        ..says("so")
    };
    let (moments, _) =
        taught(lesson(3, vec![likely(0.0, 100), likely(1.0, 100), likely(1.0, 4), likely(0.5, 100)]));
    // 11 frames of each trial: after arranging, and after each of 10 actions.
    let counts: Vec<_> = (0..4).map(|utterance| count_said(&moments, utterance)).collect();
    assert_eq!(counts[..3], [0, 33, 12], "never, always, and four times in each of three trials");
    assert!((5..=28).contains(&counts[3]), "half of 33 times, about: {counts:?}");
}

#[test]
fn without_an_occasion_a_teacher_speaks_in_the_first_frame_of_a_trial() {
    let (moments, report) = taught(lesson(3, vec![says("look")]));
    assert_eq!(report.trials, 3);
    for moment in &moments {
        assert_eq!(moment.said == [0], moment.first, "{moment:?}");
    }
    assert_eq!(count_said(&moments, 0), 3);

    // A trial for which nothing is arranged begins with a decision; its first frame is the one after that.
    let (moments, report) = taught(Stage { arrange: Vec::new(), ..lesson(2, vec![says("look")]) });
    assert_eq!((report.trials, &report.actions_of_trial[..]), (2, &[10, 10][..]));
    let said: Vec<_> = moments.iter().map(|moment| !moment.said.is_empty()).collect();
    let expected: Vec<_> = (0..21).map(|frame| frame == 1 || frame == 11).collect();
    assert_eq!(said, expected);
}

#[test]
fn nobody_speaks_while_the_learner_is_held() {
    let utterance = Utterance { when: Some(anything("object")), times_max: 100, ..says("so") };
    let curriculum = Curriculum {
        name: "lessons".into(),
        pools: vec![Pool { name: "table".into(), from: 0, to: 3 }],
        stages: vec![lesson(1, vec![utterance])],
        afterwards: Afterwards::Hold,
    };
    let mut table = Table::new(5, 4, 4, curriculum, Parameters::default());
    let spoke = |table: &Table| {
        let effects = &table.steps.last().unwrap().effects;
        effects.iter().any(|effect| {
            matches!(effect, Effect::Stage(StageEffect::Spoken { utterances, .. }) if !utterances.is_empty())
        })
    };
    table.step();
    table.step();
    assert!(spoke(&table));
    table.learner.stage(&StageCommand::Hold).unwrap();
    for _ in 0..3 {
        assert!(!table.step() && !spoke(&table));
    }
    table.learner.stage(&StageCommand::Resume).unwrap();
    table.step();
    assert!(spoke(&table));
}

#[test]
fn a_trial_ends_when_something_was_not_observed_for_a_while() {
    let absence = Absence { observation: anything("touch"), actions: 3 };
    let (moments, report) =
        taught(Stage { trial_actions_max: 0, until_absent: Some(absence), ..lesson(3, Vec::new()) });
    assert_eq!((report.trials, report.trials_met), (3, 3));
    assert!(report.ended && !report.saturated);
    // Each trial again, from what was felt: it ended with the third action in a row without touch, and not before.
    let mut frames = moments.iter().skip(1);
    let mut touches = 0;
    for actions in &report.actions_of_trial {
        assert!(frames.next().unwrap().first, "the frame after arranging follows no action");
        let felt: Vec<_> = frames.by_ref().take(*actions as usize).map(|moment| moment.touching).collect();
        assert_eq!(felt.windows(3).position(|three| *three == [false; 3]), Some(felt.len() - 3), "{felt:?}");
        touches += felt.iter().filter(|touching| **touching).count();
    }
    assert!(touches > 0, "something was felt, so that waiting began anew");
    assert_eq!(frames.count(), 0);
}

#[test]
fn a_forged_effect_of_a_stage_is_refused_and_changes_nothing() {
    let stage = stage("one", &["finger"]);
    let pools = vec![Pool { name: "places".into(), from: 0, to: 3 }];
    let afterwards = Afterwards::Continue;
    let curriculum = Curriculum { name: "one".into(), pools, stages: vec![stage], afterwards };
    let mut table = Table::new(1, 4, 4, curriculum, Parameters::default());
    table.learner.step(&Frame { body: table.body, outcome: None, observations: Vec::new() });
    let mut memory = table.learner.memory().clone();
    let before = digest(memory.content());
    let next = *memory.content().progress.pools[0].last().unwrap();
    for forged in [
        StageEffect::Spoken { utterances: vec![usize::MAX], random: 7 },
        // The first number is right, the second never was there.
        StageEffect::TrialBegun { drawn: vec![(0, next), (0, 99)] },
        StageEffect::TrialBegun { drawn: vec![(usize::MAX, next)] },
    ] {
        assert!(memory.apply(&Effect::Stage(forged.clone())).is_err(), "{forged:?}");
        assert_eq!(digest(memory.content()), before, "{forged:?}");
    }
}
