//! Experiment 1, scenario 1 of the paper (section IV-A) through the real thing: a daemon process, a body process,
//! shared memory between them, physics, and blobs found in rendered pictures.

use pschema_tests::Sandbox;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

fn experiment(arguments: &[&str]) -> Value {
    Sandbox::new(BINARY).run(&[&["experiment", "exp1-s1", "--json"], arguments].concat()).json()
}

fn number(figures: &Value, field: &str) -> u64 {
    figures[field].as_u64().unwrap_or_else(|| panic!("{field} is no number in {figures}"))
}

/// Within a tenth of the paper's figures.
fn is_near(ours: u64, published: u64) -> bool {
    ours.abs_diff(published) * 10 <= published
}

#[test]
fn scenario_1_over_shared_memory_gives_the_papers_figures_and_the_same_memory_as_in_one_process() {
    let figures = experiment(&["--seed", "1"]);
    assert!(is_near(number(&figures, "schemas_total"), 227), "{figures}");
    assert_eq!(
        number(&figures, "schemas_total"),
        number(&figures, "schemas_concrete") + number(&figures, "schemas_generalised")
    );
    assert_eq!(number(&figures, "placements"), 2, "{figures}");
    assert!(number(&figures, "counter_examples") >= 1, "pointing out of reach is an exception: {figures}");
    let probe = &figures["probe"];
    assert_eq!(number(probe, "placements_tried"), 97, "{figures}");
    assert!(number(probe, "touched_first_try") * 100 >= 95 * 97, "{figures}");
    assert_eq!(figures["published"]["schemas_total"], 227);
    for field in
        ["experiment", "seed", "actions_total", "wall_s", "step_latency_us_p50", "step_latency_us_p99"]
    {
        assert!(!figures[field].is_null(), "{field} is missing in {figures}");
    }

    let in_process = experiment(&["--seed", "1", "--in-process"]);
    assert_eq!(in_process["memory_digest"], figures["memory_digest"]);
    let stages = |figures: &Value| figures["stages"].clone();
    assert_eq!(stages(&in_process), stages(&figures));
}

#[test]
fn the_narrow_world_gives_about_half_as_many_schemas() {
    let figures = experiment(&["--world", "narrow", "--in-process"]);
    assert!(is_near(number(&figures, "schemas_total"), 115), "{figures}");
    assert_eq!(number(&figures, "placements"), 2, "{figures}");
}

#[test]
fn several_seeds_print_one_object_a_line_and_learn_different_memories() {
    let finished =
        Sandbox::new(BINARY).run(&["experiment", "exp1-s1", "--seeds", "3..4", "--in-process", "--json"]);
    assert_eq!(finished.code(), Some(0), "{finished:?}");
    let runs: Vec<Value> = finished.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(runs.iter().map(|run| number(run, "seed")).collect::<Vec<_>>(), [3, 4]);
    assert_ne!(runs[0]["memory_digest"], runs[1]["memory_digest"]);
}

#[test]
fn a_world_that_cannot_be_read_fails_with_the_bodys_reason() {
    for mode in [&["--in-process"][..], &[]] {
        let arguments = [&["experiment", "exp1-s1", "--world", "/nowhere/w.toml"], mode].concat();
        let finished = Sandbox::new(BINARY).run(&arguments);
        assert_eq!(finished.code(), Some(1), "{finished:?}");
        assert!(finished.stderr.contains("/nowhere/w.toml"), "{finished:?}");
        assert!(finished.stdout.is_empty(), "{finished:?}");
    }
}
