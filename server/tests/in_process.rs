//! A body learns in one process, through the same checks, translation and wire encoding as over shared memory.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::sync::atomic::AtomicBool;

use common::{FIELDS, Row, curriculum, free, setup};
use pschema_inspect::{
    DetailQuery, ExplanationQuery, NamedValues, Report, ReportQuery, SchemaKind, SchemaQuery, SchemaSort,
    StageState, StatusQuery, ValueText,
};
use pschema_learner::curriculum::{Argument, Curriculum, Lift, NamedObservation, Stage, Utterance};
use pschema_learner::parameters::TypeOverride;
use pschema_learner::progress::StageCommand;
use pschema_server::in_process::{InProcess, RunState, run_in_process};

fn run(seed: u64) -> Report {
    run_in_process(Row::new("row"), setup(seed, curriculum()), &AtomicBool::new(false)).unwrap()
}

/// Runs to the end of the curriculum.
fn finished(seed: u64) -> InProcess<Row> {
    let mut run = InProcess::new(Row::new("row"), setup(seed, curriculum())).unwrap();
    while run.advance().unwrap() == RunState::Running {}
    run
}

#[test]
fn a_body_learns_to_touch_at_places_it_was_never_shown() {
    for seed in 1..=5 {
        let report = run(seed);
        assert!(report.finished, "seed {seed}: {report:?}");
        // One schema for each field, two touches, one generalisation: the structure of the paper's table.
        assert_eq!(report.schemas_total, u32::try_from(FIELDS).unwrap() + 3, "seed {seed}");
        let stages: Vec<_> = report.stages.iter().map(|stage| (stage.name.as_str(), stage.trials)).collect();
        assert_eq!(stages, [("babbling", 0), ("touching", 2), ("probe", 6)], "seed {seed}");
        assert_eq!(report.stages[1].generalised_after_trial.last(), Some(&1), "seed {seed}");
        let probe = &report.stages[2];
        assert_eq!((probe.trials_met_first, probe.schemas_new), (6, 0), "seed {seed}: {probe:?}");
    }
}

#[test]
fn the_seed_decides_everything() {
    assert_eq!(run(3).memory_digest, run(3).memory_digest);
    assert_ne!(run(3).memory_digest, run(4).memory_digest);
}

#[test]
fn a_finished_learner_does_not_change_however_often_it_is_asked() {
    let mut run = finished(1);
    let before = run.report();
    for _ in 0..10 {
        assert_eq!(run.advance().unwrap(), RunState::Waiting);
    }
    let after = run.report();
    assert_eq!((after.step, after.memory_digest), (before.step, before.memory_digest));
}

#[test]
fn holding_stops_the_steps_and_resuming_goes_on_to_the_same_end() {
    let mut held = InProcess::new(Row::new("row"), setup(2, curriculum())).unwrap();
    for _ in 0..5 {
        held.advance().unwrap();
    }
    held.stage(&StageCommand::Hold).unwrap();
    // The learner still learns from the outcome of the action that was asked for before.
    while held.advance().unwrap() == RunState::Running {}
    let step = held.learner().memory().content().step;
    for _ in 0..20 {
        assert_eq!(held.advance().unwrap(), RunState::Waiting);
    }
    assert_eq!(held.learner().memory().content().step, step);
    assert_eq!(held.report().stage_state, StageState::Held);
    held.stage(&StageCommand::Resume).unwrap();
    while held.advance().unwrap() == RunState::Running {}
    let report = held.report();
    assert!(report.finished);
    assert_eq!(report.schemas_total, run(2).schemas_total);
}

#[test]
fn stages_can_be_left_and_set_and_mistakes_are_answered() {
    let mut run = InProcess::new(Row::new("row"), setup(2, curriculum())).unwrap();
    run.advance().unwrap();
    run.stage(&StageCommand::Next).unwrap();
    assert_eq!(run.report().stage, "touching");
    run.stage(&StageCommand::Set("babbling".to_owned())).unwrap();
    assert_eq!(run.report().stage, "babbling");
    let digest = run.report().memory_digest;
    let error = run.stage(&StageCommand::Set("dancing".to_owned())).unwrap_err().to_string();
    assert!(error.contains("dancing") && error.contains("babbling"), "{error}");
    assert_eq!(run.report().memory_digest, digest);
    run.stage(&StageCommand::Set("probe".to_owned())).unwrap();
    assert!(run.stage(&StageCommand::Next).is_err());
}

/// Says "touch" while the block is reached for, and counts the schemas that are then associated with the word.
fn associated_with_the_word(lift: Lift) -> usize {
    let mut taught = curriculum();
    taught.stages[1].lift = lift;
    let mut run = InProcess::new(Row::new("row"), setup(1, taught)).unwrap();
    while run.report().stage != "touching" {
        assert_eq!(run.advance().unwrap(), RunState::Running);
    }
    while run.report().stage == "touching" {
        run.say(&["touch".to_owned()]).unwrap();
        run.advance().unwrap();
    }
    let word = NamedValues(vec![("text".to_owned(), ValueText::Symbol("touch".to_owned()))]);
    let is_associated = |id: u32| {
        let schema = run.ask(&DetailQuery { id }).unwrap();
        let mut associated = schema.associated.iter().map(|one| &one.observation);
        associated.any(|one| one.kind == "word" && one.properties == word)
    };
    (0..run.report().schemas_total).filter(|id| is_associated(*id)).count()
}

#[test]
fn a_word_said_during_a_touch_is_associated_with_it_if_hearing_is_lifted() {
    assert!(associated_with_the_word(Lift::All) >= 1);
    let deaf = ["finger", "object", "touch"].map(str::to_owned).to_vec();
    assert_eq!(associated_with_the_word(Lift::Types(deaf)), 0);
}

#[test]
fn words_that_cannot_be_heard_are_refused() {
    let mut run = InProcess::new(Row::new("row"), setup(1, free())).unwrap();
    let say = |run: &mut InProcess<Row>, words: &[&str]| {
        run.say(&words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>())
            .map_err(|error| error.to_string())
    };
    assert!(say(&mut run, &[]).unwrap_err().contains("at least one"));
    assert!(say(&mut run, &["two words"]).unwrap_err().contains("two words"));
    assert!(say(&mut run, &[&"x".repeat(65)]).unwrap_err().contains("64 bytes"));
    assert!(say(&mut run, &["a"; 65]).unwrap_err().contains("65 words"));
    say(&mut run, &["a"; 64]).unwrap();
    assert!(say(&mut run, &["b"]).unwrap_err().contains("65 words"));
    run.advance().unwrap();
    say(&mut run, &["b"]).unwrap();
    let mut over = finished(1);
    assert!(say(&mut over, &["touch"]).unwrap_err().contains("finished"));
}

#[test]
fn a_curriculum_that_the_body_cannot_follow_gets_stuck_and_says_why() {
    let cases: [(&str, Argument, &str); 2] =
        [("green-block", Argument::Integer(1), "green-block"), ("red-block", Argument::Integer(99), "99")];
    for (object, position, complaint) in cases {
        let mut wrong = curriculum();
        wrong.stages[1] = Stage { arrange: vec![common::place(object, position)], ..wrong.stages[1].clone() };
        let report = run_in_process(Row::new("row"), setup(1, wrong), &AtomicBool::new(false)).unwrap();
        let stuck = report.stuck.unwrap();
        assert!(stuck.contains(complaint) && !report.finished, "{stuck}");
    }
}

/// A sense that nobody has lifts nothing, and an observation that nobody makes ends no trial: the run would look like a finding.
#[test]
fn a_name_in_a_curriculum_that_stands_for_nothing_is_told_before_the_first_action() {
    let named = |kind: &str, properties: &[(&str, Argument)]| NamedObservation {
        kind: kind.to_owned(),
        properties: properties.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect(),
    };
    let symbol = |text: &str| Argument::Symbol(text.to_owned());
    let with = |change: &dyn Fn(&mut Stage)| {
        let mut wrong = curriculum();
        change(&mut wrong.stages[1]);
        wrong
    };
    let until = |observation: NamedObservation| with(&|stage| stage.until = Some(observation.clone()));
    let utterance = Utterance {
        heard: vec![named("word", &[("text", symbol("touch"))])],
        when: Some(named("tuoch", &[])),
        unless: None,
        probability: 1.0,
        times_max: 1,
    };
    let cases: [(Curriculum, &str); 8] = [
        (
            with(&|stage| stage.lift = Lift::Types(vec!["fingr".to_owned()])),
            "lift: no observation type is named \"fingr\"; there are: finger, object, touch",
        ),
        (until(named("touc", &[])), "until: no observation type is named \"touc\""),
        (
            until(named("object", &[("color", symbol("blue"))])),
            "object has no property \"color\"; it has: colour, field",
        ),
        (until(named("object", &[("colour", symbol("mauve"))])), "object{colour} is never mauve; it has:"),
        (
            until(named("object", &[("field", Argument::Integer(99))])),
            "object{field} is never 99; it has: whole numbers from 0 to",
        ),
        (until(named("word", &[("txt", symbol("touch"))])), "word has no property \"txt\"; it has: text"),
        (
            with(&|stage| stage.say = vec![utterance.clone()]),
            "say: when: no observation type is named \"tuoch\"",
        ),
        (
            with(&|stage| stage.arrange[0].command = "palce".to_owned()),
            "arrange: the body has no scene command palce; it has: place",
        ),
    ];
    for (wrong, complaint) in cases {
        let mut run = InProcess::new(Row::new("row"), setup(1, wrong)).unwrap();
        for _ in 0..3 {
            assert_eq!(run.advance().unwrap(), RunState::Waiting);
        }
        let report = run.report();
        let stuck = report.stuck.clone().unwrap();
        assert!(
            stuck.contains("stage \"touching\"") && stuck.contains(complaint),
            "wanted {complaint:?}: {stuck}"
        );
        assert_eq!((report.actions_total, report.schemas_total), (0, 0));
        // To enter the stage again mends nothing.
        run.stage(&StageCommand::Set("touching".to_owned())).unwrap();
        assert!(run.report().stuck.is_some_and(|again| again == stuck));
    }
    let any_word = named("word", &[("text", symbol("never heard"))]);
    let mut run = InProcess::new(Row::new("row"), setup(1, until(any_word))).unwrap();
    assert_eq!(run.advance().unwrap(), RunState::Running);
    let mut overridden = setup(1, curriculum());
    let override_of =
        |name: &str| TypeOverride { name: name.to_owned(), precondition: Some(true), postcondition: None };
    overridden.learner.parameters.type_overrides = vec![override_of("finger"), override_of("thumb")];
    let stuck = InProcess::new(Row::new("row"), overridden).unwrap().report().stuck.unwrap();
    assert!(stuck.contains("\"thumb\""), "{stuck}");
}

#[test]
fn tools_are_answered_from_what_was_learnt() {
    let run = finished(1);
    let list = |query: SchemaQuery| run.ask(&query).unwrap();
    let all = list(SchemaQuery::default());
    assert_eq!(all.matching, 11);
    assert_eq!(list(SchemaQuery { limit: 3, ..SchemaQuery::default() }).schemas.len(), 3);
    let touching = list(SchemaQuery { post: Some("touch{}".to_owned()), ..SchemaQuery::default() });
    assert_eq!(touching.matching, 3);
    let general = list(SchemaQuery { generalised: true, ..SchemaQuery::default() });
    assert_eq!(general.matching, 1);
    let blue = list(SchemaQuery { pre: Some("object{colour=blue}".to_owned()), ..SchemaQuery::default() });
    assert_eq!(blue.matching, 2);
    let used = list(SchemaQuery { sort: SchemaSort::Uses, ..SchemaQuery::default() });
    assert!(used.schemas.is_sorted_by(|a, b| a.executions >= b.executions));
    for wrong in ["object{size=3}", "cat{}", "object"] {
        let query = SchemaQuery { pre: Some(wrong.to_owned()), ..SchemaQuery::default() };
        assert!(run.ask(&query).is_err(), "{wrong}");
    }
    let schema = run.ask(&DetailQuery { id: general.schemas[0].id }).unwrap();
    assert_eq!((schema.kind, schema.examples.len()), (SchemaKind::Generalised, 2));
    assert!(run.ask(&DetailQuery { id: 11 }).unwrap_err().0.contains("0 to 10"));
    let report = run.ask(&ReportQuery {}).unwrap();
    assert_eq!(report.stage_state, StageState::Finished);
    let status = run.ask(&StatusQuery {}).unwrap();
    assert_eq!(status.bodies.len(), 1);
    assert_eq!((status.memory_digest, status.durable_step), (report.memory_digest, None));
    assert!(status.memory_bytes > 1_000_000 && status.step_latency_us_p99 >= status.step_latency_us_p50);
}

#[test]
fn a_held_learner_takes_the_one_action_that_is_asked_for() {
    let mut run = InProcess::new(Row::new("row"), setup(3, curriculum())).unwrap();
    for _ in 0..10 {
        run.advance().unwrap();
    }
    run.stage(&StageCommand::Hold).unwrap();
    while run.advance().unwrap() == RunState::Running {}
    let actions = run.report().actions_total;
    for asked in 1..=3 {
        run.single_step().unwrap();
        while run.advance().unwrap() == RunState::Running {}
        assert!(run.learner().memory().content().progress.held);
        assert_eq!(run.report().actions_total, actions + asked);
    }
}

#[test]
fn an_explanation_adds_up_and_always_lists_what_was_chosen() {
    let mut run = InProcess::new(Row::new("row"), setup(1, curriculum())).unwrap();
    let explain =
        |run: &InProcess<Row>, step, candidates_max| run.ask(&ExplanationQuery { step, candidates_max });
    assert!(explain(&run, None, 5).is_err());
    let mut decided = 0;
    while run.advance().unwrap() == RunState::Running {
        let all = explain(&run, None, 1000).unwrap();
        let chosen = &all.candidates[usize::try_from(all.chosen).unwrap()];
        for candidate in &all.candidates {
            let sum: f64 = candidate.terms.iter().map(|term| term.value).sum();
            let excitation = sum / f64::from(candidate.distance);
            assert!((candidate.excitation - excitation).abs() < 1e-9, "{candidate:?}");
        }
        let short = explain(&run, Some(all.step), 1).unwrap();
        assert_eq!(short.candidates.len(), 1);
        assert_eq!(&short.candidates[usize::try_from(short.chosen).unwrap()], chosen);
        decided += 1;
    }
    assert!(decided > 10);
    assert!(explain(&run, Some(1_000_000), 5).unwrap_err().0.contains("has not been taken yet"));
}
