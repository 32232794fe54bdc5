use pschema_inspect::{Reason, TraceDecision, TraceRecord};

use super::*;
use crate::design::Peak;
use crate::golden::check;
use crate::run::tests::{report, stage};
use crate::run::{Experiment, Knowledge, Outcome, Overrides, Results, Trace, TracedStep};

fn step(step: u64, stage: u32, trial: u32, schemas: u32) -> TracedStep {
    let text = |text: &str| vec![text.to_owned()];
    let touching = stage == 1;
    let record = TraceRecord {
        step,
        stage,
        trial,
        drawn: Vec::new(),
        trial_met: None,
        actions: step,
        schemas_total: schemas,
        schemas_generalised: 0,
        failure: None,
        perceived: Vec::new(),
        heard: if step == 255 { text("touch") } else { Vec::new() },
        decision: Some(TraceDecision {
            excitation_top: 1.0 + (step % 5) as f64,
            excitation: 1.0,
            schema: Some(schemas),
            generalised: touching,
            distance: 1,
            action: "move(j1=0.43, j2=0.84)".to_owned(),
            reason: Reason::Excitation,
            predicts: text(if touching { "finger touch" } else { "finger" }),
        }),
        quiet_actions: 0,
        habituating: false,
        latency_us: 50.0 + (step % 7) as f64,
    };
    TracedStep {
        record,
        perceived: "finger{field=4}".into(),
        object_at: touching.then_some(4),
        effector_at: Some(4),
        reached: step == 260,
        touching,
        came: [].into(),
    }
}

/// A step in which nothing was decided.
fn undecided(mut step: TracedStep, drawn: &[i64], trial_met: Option<bool>) -> TracedStep {
    (step.record.decision, step.touching) = (None, false);
    (step.record.drawn, step.record.trial_met) = (drawn.to_vec(), trial_met);
    step
}

fn trace() -> Trace {
    let mut steps: Vec<TracedStep> = (0..240).map(|n| step(n, 0, 0, n as u32)).collect();
    steps.push(undecided(step(240, 1, 1, 240), &[17], None));
    steps.extend((240..260).map(|n| step(n, 1, 1, 241)));
    steps.push(undecided(step(260, 1, 1, 241), &[], Some(true)));
    let mut trace = Trace::default();
    trace.stages = vec!["motor babbling".to_owned(), "first <touches> & \"more\"".to_owned()];
    trace.steps = steps;
    trace
}

/// An experiment that names itself in a way that no page should take at its word.
fn experiment() -> Experiment {
    let mut experiment = Experiment::new("exp1-s1", Overrides::default()).unwrap();
    let design = &mut experiment.design;
    design.title = "Touching <script>alert('&')</script>".to_owned();
    design.stages = trace().stages;
    design.peaks = vec![Peak { label: "a<b".to_owned(), stage: design.stages[1].clone(), trial: None }];
    design.map = None;
    design.measures.clear();
    experiment
}

fn outcome(experiment: &Experiment, seed: u64) -> Outcome {
    let summaries = vec![
        stage("motor babbling", true, &[], &[]),
        stage("first <touches> & \"more\"", true, &[true], &[1]),
    ];
    let mut report = report(summaries);
    report.seed = seed;
    let results = Results::new(&experiment.design, &experiment.conditions[0], &report, Vec::new(), 4.25);
    Outcome { results, trace: trace(), learnt: Knowledge::default() }
}

fn provenance() -> Provenance {
    Provenance {
        date: "2011-08-24 12:00 UTC".to_owned(),
        command: "pschema experiment exp1-s1 --seeds 1..2 --out report".to_owned(),
        version: "0.0.0".to_owned(),
        machine: "a machine".to_owned(),
    }
}

fn group<'a>(experiment: &'a Experiment, outcomes: &'a [Outcome]) -> Group<'a> {
    let parameters = "Parameters { generalisation: true }".to_owned();
    Group { parameters, ..Group::new(&experiment.conditions[0], outcomes) }
}

fn made() -> String {
    let experiment = experiment();
    let outcomes = [outcome(&experiment, 1), outcome(&experiment, 2)];
    let section = Section { design: &experiment.design, groups: vec![group(&experiment, &outcomes)] };
    page::page(&[section], &provenance())
}

/// After a change, look at the page in a browser.
#[test]
fn the_page_is_the_golden_one() {
    check("report.html", &made());
}

#[test]
fn nothing_is_fetched_and_nothing_is_run() {
    let page = made();
    for wrong in ["<script", "http:", "https:", "src=", "@import", "url(", "alert('&')", "<touches>", "a<b"] {
        assert!(!page.contains(wrong), "{wrong} is in the page");
    }
    assert!(page.contains("Touching &lt;script&gt;alert('&amp;')&lt;/script&gt;"));
    assert!(page.contains("first &lt;touches&gt; &amp; "), "stages are named in the caption");
}

#[test]
fn every_figure_is_drawn_for_a_desk_and_for_a_telephone() {
    let page = made();
    let drawings = page.matches("<svg viewBox=\"0 0 720 ").count();
    assert_eq!(drawings, 3, "growth, excitation, time");
    assert_eq!(page.matches("<svg viewBox=\"0 0 360 ").count(), drawings);
    assert!(!page.contains("NaN") && !page.contains("inf "), "every place is a number");
}

#[test]
fn a_report_is_a_page_and_its_raw_figures() {
    let folder = tempfile::tempdir().unwrap();
    let experiment = experiment();
    let outcomes = [outcome(&experiment, 1), outcome(&experiment, 2)];
    let section = Section { design: &experiment.design, groups: vec![group(&experiment, &outcomes)] };
    let written = write(&folder.path().join("new/report"), &[section], &provenance()).unwrap();
    let beside = |name: &str| std::fs::read_to_string(written.with_file_name(name)).unwrap();
    assert_eq!(std::fs::read_to_string(&written).unwrap(), made());
    let steps = beside("exp1-s1.steps.csv");
    assert_eq!(steps.lines().count(), 1 + 2 * trace().steps.len());
    assert!(steps.contains(r#""first <touches> & ""more""""#), "texts are quoted");
    let trials = beside("exp1-s1.trials.csv");
    assert!(trials.ends_with(",2,\"first <touches> & \"\"more\"\"\",1,17,20,true,4,20,true\n"), "{trials}");
    let runs: Vec<serde_json::Value> =
        beside("runs.jsonl").lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(runs.iter().map(|run| run["seed"].as_u64()).collect::<Vec<_>>(), [Some(1), Some(2)]);
    assert!(beside("comparison.csv").contains("exp1-s1,,schemas,227,228,228,228,2,"));
}

#[test]
fn a_folder_that_cannot_be_written_is_said_before_anything_is_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "mine").unwrap();
    let experiment = Experiment::new("exp1-s1", Overrides::default()).unwrap();
    let prepared = |folder: &Path, occupied| prepare(folder, [&experiment.design], occupied);
    let error = prepared(&file, Occupied::Refused).unwrap_err().to_string();
    assert!(error.contains("cannot create") && error.contains("file"), "{error}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    // Nor is anything lost of an earlier report, or of another program's page.
    for name in ["index.html", "runs.jsonl", "exp1-s1.trials.csv"] {
        let folder = folder.path().join(format!("of {name}"));
        prepared(&folder, Occupied::Refused).unwrap();
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0, "nothing is made yet");
        std::fs::write(folder.join(name), "mine").unwrap();
        let error = prepared(&folder, Occupied::Refused).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("--overwrite"), "{error}");
        prepared(&folder, Occupied::Replaced).unwrap();
        assert_eq!(std::fs::read_to_string(folder.join(name)).unwrap(), "mine");
    }
}

#[test]
fn names_become_parts_of_file_names() {
    assert_eq!(file_name("exp1-s1"), "exp1-s1");
    assert_eq!(file_name("../mine & yours"), "___mine___yours");
    assert_eq!(file_name(""), "experiment");
}
