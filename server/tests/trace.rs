//! The record of every step: the records that figures are drawn from have to agree with the report.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use common::{FIELDS, Row, curriculum, free, setup};
use pschema_inspect::{TracePage, TraceQuery, TraceRecord};
use pschema_server::in_process::{InProcess, RunState};

fn finished(seed: u64) -> InProcess<Row> {
    let mut run = InProcess::new(Row::new("row"), setup(seed, curriculum())).unwrap();
    while run.advance().unwrap() == RunState::Running {}
    run
}

fn page(run: &InProcess<Row>, from: u64) -> TracePage {
    run.ask(&TraceQuery { from }).unwrap()
}

/// All that is the same in every repetition.
fn timeless(page: TracePage) -> TracePage {
    let records = page.records.into_iter();
    let records = records.map(|record| TraceRecord { latency_us: 0.0, ..record }).collect();
    TracePage { records, ..page }
}

#[test]
fn the_records_tell_the_run_as_the_report_does() {
    let run = finished(3);
    let (page, report) = (page(&run, 0), run.report());
    assert_eq!((page.from, page.total), (0, page.records.len() as u64));
    assert_eq!(page.stages, ["babbling", "touching", "probe"]);
    let last = page.records.last().unwrap();
    assert_eq!((last.actions, last.schemas_total), (report.actions_total, report.schemas_total));
    assert!(page.records.is_sorted_by(|a, b| a.step < b.step && a.actions <= b.actions));
    assert!(page.records.iter().all(|record| record.latency_us > 0.0));
    for (at, stage) in report.stages.iter().enumerate() {
        let met = page.records.iter().filter(|record| record.trial_met == Some(true));
        // A trial's last step may already belong to the stage after it.
        let drawn: Vec<i64> = page
            .records
            .iter()
            .filter(|record| usize::try_from(record.stage).unwrap() == at)
            .flat_map(|record| record.drawn.iter().copied())
            .collect();
        assert_eq!(drawn, stage.drawn, "{}", stage.name);
        assert_eq!(met.count(), 8, "two touches and six probes");
        assert_eq!(stage.actions_of_trial.len(), usize::try_from(stage.trials).unwrap());
    }
}

#[test]
fn a_touch_is_predicted_by_the_schema_chosen_once_it_is_known() {
    let page = page(&finished(3), 0);
    let probing = page.records.iter().filter(|record| record.stage == 2);
    let decided: Vec<_> = probing.filter_map(|record| Some((record, record.decision.as_ref()?))).collect();
    assert_eq!(decided.len(), 6, "one decision for each place");
    for (record, decision) in decided {
        assert!(decision.generalised && decision.predicts.contains(&"touch".to_owned()), "{decision:?}");
        assert!(decision.excitation_top >= decision.excitation && decision.excitation > 0.0);
        assert!(record.perceived.iter().any(|one| one.kind == "object"), "{record:?}");
    }
    let babbling = &page.records[0];
    assert_eq!((babbling.trial, babbling.decision.as_ref().unwrap().schema), (0, None));
    let saturating = page.records.iter().filter(|record| record.stage == 0);
    let streaks = page.records.iter().map(|record| record.quiet_actions);
    assert_eq!(streaks.max(), Some(3), "three quiet actions end the stage");
    assert!(saturating.filter(|record| record.actions > 0).count() > usize::try_from(FIELDS).unwrap());
}

#[test]
fn the_same_seed_has_the_same_records_but_for_their_times() {
    assert_eq!(timeless(page(&finished(4), 0)), timeless(page(&finished(4), 0)));
    assert_ne!(timeless(page(&finished(4), 0)), timeless(page(&finished(5), 0)));
}

#[test]
fn pages_follow_one_another_while_the_run_goes_on() {
    let mut run = InProcess::new(Row::new("row"), setup(2, free())).unwrap();
    let mut records = Vec::new();
    let mut next = 0;
    for _ in 0..6_000 {
        run.advance().unwrap();
        if records.len() % 700 == 0 {
            let page = page(&run, next);
            assert_eq!(page.from, next);
            next += page.records.len() as u64;
            records.extend(page.records);
        }
    }
    loop {
        let page = page(&run, next);
        if page.records.is_empty() {
            assert_eq!(page.total, next);
            break;
        }
        next += page.records.len() as u64;
        records.extend(page.records);
    }
    assert!(records.len() > 4_096, "many pages: {}", records.len());
    assert!(records.is_sorted_by(|a, b| a.step < b.step));
    assert!(page(&run, u64::MAX).records.is_empty());
}
