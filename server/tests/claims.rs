//! What is told of claims: what they foretell, the claims themselves and the evidence for them.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use common::{FIELDS, Row, curriculum, place, setup};
use pschema_inspect::{
    Claim, ClaimCondition, ClaimList, ClaimQuery, DetailQuery, ExplanationQuery, Foretold, Prediction,
    PredictionQuery, SchemaKind, SchemaQuery, StatusQuery, ValueText, Verdict, WhyNotQuery,
};
use pschema_learner::curriculum::{Argument, Pool, Stage};
use pschema_learner::mechanisms::Mechanisms;
use pschema_server::in_process::{InProcess, RunState};
use pschema_server::{LearnerSettings, Setup};

type Run = InProcess<Row>;

/// A learner that keeps claims, and touches blocks on a row with nothing staged: first blue ones; then red ones, which can't be felt.
fn begun(seed: u64) -> Run {
    let learner = LearnerSettings::of(Mechanisms::FULL);
    let pool = |name: &str| Pool { name: name.to_owned(), from: 0, to: FIELDS - 1 };
    let mut curriculum = curriculum();
    curriculum.pools = vec![pool("blue"), pool("red")];
    let touching = curriculum.stages.swap_remove(1);
    let placed = |colour: &str| vec![place(&format!("{colour}-block"), Argument::Draw(colour.to_owned()))];
    let stage = |colour: &str, actions| Stage {
        name: colour.to_owned(),
        arrange: placed(colour),
        trials: 8,
        trial_actions_max: actions,
        ..touching.clone()
    };
    curriculum.stages = vec![stage("blue", 20), stage("red", 8)];
    let setup = Setup { learner, ..setup(seed, curriculum) };
    InProcess::new(Row::feeling_blue_alone("row"), setup).unwrap()
}

/// Whether the last step decided something.
fn has_decided(run: &Run) -> bool {
    let last = run.ask(&ExplanationQuery { step: None, candidates_max: 1 });
    last.is_ok_and(|last| last.step == run.report().step)
}

/// The same, when it has touched the last blue block, and the first red one is there.
fn touched(seed: u64) -> Run {
    let mut run = begun(seed);
    while run.report().stage != "red" || !has_decided(&run) {
        run.advance().unwrap();
    }
    run
}

/// The same, when its curriculum is over.
fn finished(seed: u64) -> Run {
    let mut run = begun(seed);
    while run.advance().unwrap() == RunState::Running {}
    run
}

fn move_to(field: i64) -> String {
    // As they print: with two decimals where these are of the same bin.
    const REACHES: [&str; FIELDS as usize] =
        ["0.00", "0.125", "0.25", "0.38", "0.50", "0.625", "0.75", "0.88"];
    format!("move(reach={})", REACHES[usize::try_from(field % FIELDS).unwrap()])
}

fn predict(run: &Run, field: i64) -> Prediction {
    run.ask(&PredictionQuery { action: move_to(field) }).unwrap()
}

fn claims(run: &Run, action: Option<&str>) -> ClaimList {
    run.ask(&ClaimQuery { action: action.map(str::to_owned), ..ClaimQuery::default() }).unwrap()
}

/// What is foretold of reaching for the block once more while the last touch of it is felt.
fn while_touching(seed: u64) -> Prediction {
    let mut run = begun(seed);
    while run.report().stages.first().is_none_or(|stage| stage.trials_met < 7) {
        run.advance().unwrap();
    }
    while predict(&run, 0).world.iter().all(|o| o.kind != "touch") {
        run.advance().unwrap();
    }
    predict(&run, block(&run))
}

/// Where the block is.
fn block(run: &Run) -> i64 {
    let world = predict(run, 0).world;
    let field = world.iter().find(|o| o.kind == "object").unwrap().properties.get("field");
    let Some(ValueText::Integer(field)) = field else { panic!("{field:?}") };
    *field
}

fn of<'a>(foretold: &'a [Foretold], kind: &str) -> &'a Foretold {
    foretold.iter().find(|facet| facet.types.iter().any(|known| known == kind)).unwrap()
}

/// Prints a condition by the names in it.
fn named(condition: &ClaimCondition) -> Vec<String> {
    let ClaimCondition::Observed(observation) = condition else { return Vec::new() };
    let text = |value: &ValueText| match value {
        ValueText::Named { named } => Some(named.to_string()),
        _ => None,
    };
    observation.properties.iter().filter_map(|(_, value)| text(value)).collect()
}

#[test]
fn a_prediction_is_what_claims_foretell_of_types_that_change_together() {
    let run = touched(1);
    let field = block(&run);
    let there = predict(&run, field);
    let touch = of(&there.claims, "touch");
    assert!(touch.attributed && touch.trials > 0);
    let top = &touch.outcomes[0];
    assert_eq!(top.observed.iter().filter(|o| o.kind == "touch").count(), 1, "{top:?}");
    assert!((top.probability - f64::from(top.occurrences) / f64::from(touch.trials)).abs() < 1e-9);
    // The condition is that the block is where the finger will be.
    let because = touch.because.first().unwrap();
    assert_eq!(named(&because.condition), ["effect(finger).field"], "{touch:?}");
    assert!(because.gain_bits > 0.0 && because.trials_with > 0 && because.trials_without > 0, "{because:?}");

    // What is told of one observation by itself is the sum of the joint outcomes that it is in.
    for facet in &there.claims {
        for outcome in &facet.outcomes {
            for observation in &outcome.appears {
                let together = facet.outcomes.iter().filter(|o| o.appears.contains(observation));
                let single = there.outcomes.iter().find(|c| !c.absent && c.observation == *observation);
                let occurrences: u32 = together.map(|outcome| outcome.occurrences).sum();
                assert_eq!(single.map(|c| (c.occurrences, c.trials)), Some((occurrences, facet.trials)));
            }
        }
    }

    // A touch that is felt now is over with its frame: one that follows is another.
    let felt = while_touching(1);
    assert!(felt.world.iter().any(|o| o.kind == "touch"), "{felt:?}");
    let again = &of(&felt.claims, "touch").outcomes[0];
    assert_eq!((again.observed.len(), again.appears.len()), (1, 1), "{again:?}");

    // Elsewhere it is an outcome that nothing is felt.
    let elsewhere = predict(&run, field + 3);
    let touch = of(&elsewhere.claims, "touch");
    assert!(touch.outcomes[0].observed.iter().all(|o| o.kind != "touch"), "{touch:?}");
    assert!(touch.outcomes[0].occurrences > 0);
}

/// All experiences with an action are counted once in its tree, and the evidence of a condition is what its tree counts.
#[test]
fn claims_are_told_as_a_tree_whose_counts_add_up() {
    fn trials(claim: &Claim) -> u32 {
        claim.trials + claim.exceptions.iter().map(trials).sum::<u32>()
    }
    fn check(claim: &Claim) -> usize {
        let mut later = trials(claim);
        for exception in &claim.exceptions {
            let evidence = exception.because.as_ref().unwrap();
            assert_eq!(evidence.trials_with, trials(exception));
            assert_eq!(evidence.trials_with + evidence.trials_without, later);
            later -= evidence.trials_with;
            let with: u32 = evidence.outcomes.iter().map(|outcome| outcome.with).sum();
            assert!(with <= evidence.trials_with && evidence.gain_bits > 0.0);
        }
        claim.exceptions.iter().map(check).sum::<usize>() + claim.exceptions.len()
    }
    let run = finished(2);
    let all = claims(&run, None);
    assert_eq!(all.matching as usize, all.claims.len());
    let exceptions: usize = all.claims.iter().map(|tree| check(&tree.claim)).sum();
    assert!(exceptions > 0, "{all:?}");
    let general = claims(&run, Some("move"));
    assert!(!general.claims.is_empty());
    assert!(
        general
            .claims
            .iter()
            .all(|tree| tree.action.as_deref() == Some("move") && tree.claim.because.is_none())
    );
    assert!(all.claims.iter().any(|tree| tree.action.is_none()), "what is to be expected whatever is done");
    let one = claims(&run, Some(&move_to(3)));
    assert!(one.claims.iter().all(|tree| tree.action.as_ref() == Some(&move_to(3))));

    // Page by page they are the same.
    let pages = (0..all.matching).map(|offset| ClaimQuery { limit: 1, offset, action: None });
    let paged: Vec<_> = pages.flat_map(|page| run.ask(&page).unwrap().claims).collect();
    assert_eq!(paged, all.claims);
    let unknown = run.ask(&ClaimQuery { action: Some("fly".to_owned()), ..ClaimQuery::default() });
    assert!(unknown.err().unwrap().0.contains("move"));
}

/// What a schema rests on is told with it, and what was foretold with a decision.
#[test]
fn schemas_and_decisions_are_told_with_their_claims() {
    let run = touched(1);
    let status = run.ask(&StatusQuery {}).unwrap();
    assert_eq!(status.profile, "full");
    let touching = SchemaQuery { post: Some("touch{}".to_owned()), ..SchemaQuery::default() };
    let touching = run.ask(&touching).unwrap().schemas;
    assert!(touching.iter().any(|schema| schema.kind == SchemaKind::Generalised), "{touching:?}");
    for schema in touching {
        let detail = run.ask(&DetailQuery { id: schema.id }).unwrap();
        let touch = of(&detail.claims, "touch");
        let named: Vec<_> = touch.because.iter().flat_map(|one| named(&one.condition)).collect();
        assert_eq!(named, ["effect(finger).field"], "{detail:?}");
    }
    let why = |step| run.ask(&ExplanationQuery { step, candidates_max: 3 });
    let last = why(None).unwrap();
    assert_eq!(last.claims, run.ask(&PredictionQuery { action: last.action.clone() }).unwrap().claims);
    assert!(!last.claims.is_empty());
    let earlier = (0..last.step).rev().find_map(|step| why(Some(step)).ok()).unwrap();
    assert!(earlier.claims.is_empty(), "claims of an earlier step are no longer there");
}

/// Red blocks are not felt: a law for all colours is not applied to them, and the condition in its way is told.
#[test]
fn a_law_that_is_not_applied_because_of_another_claim_is_told_with_its_condition() {
    let mut told = 0;
    let mut run = touched(1);
    while run.advance().unwrap() == RunState::Running {
        if !has_decided(&run) {
            continue;
        }
        let laws = run.ask(&SchemaQuery { generalised: true, ..SchemaQuery::default() }).unwrap().schemas;
        for law in laws {
            let why = run.ask(&WhyNotQuery { schema: law.id, step: None }).unwrap();
            if let Verdict::OtherClaims { claims } = &why.verdict {
                let touch = of(claims, "touch");
                println!("{}: {touch:?}", why.text);
                assert!(touch.outcomes[0].observed.iter().all(|o| o.kind != "touch"), "{touch:?}");
                told += 1;
            }
        }
    }
    assert!(told > 0, "every law is applied");
}

#[test]
fn the_learner_of_the_paper_has_no_claims_and_says_how_to_have_them() {
    let mut run = InProcess::new(Row::new("row"), setup(1, curriculum())).unwrap();
    while run.advance().unwrap() == RunState::Running {}
    assert!(predict(&run, 0).claims.is_empty());
    assert_eq!(run.ask(&StatusQuery {}).unwrap().profile, "paper");
    let problem = run.ask(&ClaimQuery::default()).err().unwrap().0;
    assert!(problem.contains("profile = \"paper\""), "{problem}");
}
