//! The whole of the Adept arm's path - text on a serial line, pictures from a socket, touch as digital inputs - under a
//! learner: it learns what the simulated arm learns, and knows what the simulated arm has learnt.

use std::path::Path;

use pschema_tests::{Sandbox, processes_with, until};
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

fn experiment(name: &str, arguments: &[&str]) -> Value {
    Sandbox::new(BINARY).run(&[&["experiment", name, "--json"], arguments].concat()).json()
}

fn number(figures: &Value, field: &str) -> u64 {
    figures[field].as_u64().unwrap_or_else(|| panic!("{field} is no number in {figures}"))
}

#[test]
fn scenario_1_is_learnt_on_the_emulated_arm_within_the_papers_figures() {
    let figures = experiment("exp1-s1-narrow", &["--body", "adept", "--seed", "1"]);
    assert_eq!(figures["body"], "adept");
    assert!(number(&figures, "schemas_total").abs_diff(115) * 10 <= 115, "{figures}");
    assert_eq!(number(&figures, "placements"), 2, "{figures}");
    assert_eq!(number(&figures, "counter_examples"), 1, "{figures}");
    let probe = &figures["probe"];
    assert_eq!(number(probe, "placements_tried"), 97);
    assert!(number(probe, "touched_first_try") * 100 >= 95 * 97, "{figures}");
}

#[test]
fn what_was_learnt_in_simulation_is_used_by_the_emulated_arm_without_learning() {
    let processes = experiment("exp4-transfer", &["--seed", "2"]);
    let probe = &processes["probe"];
    assert_eq!(number(probe, "placements_tried"), 100);
    assert!(number(probe, "touched_first_try") >= 90, "{processes}");
    let learning =
        processes["stages"].as_array().expect("stages").iter().any(|stage| stage["learning"] == true);
    assert!(!learning, "nothing is learnt any more: {processes}");
    // As many schemas as scenario 1 leaves.
    let simulated = experiment("exp1-s1-narrow", &["--seed", "2", "--in-process"]);
    assert_eq!(processes["schemas_total"], simulated["schemas_total"]);
    let in_process = experiment("exp4-transfer", &["--seed", "2", "--in-process"]);
    assert_eq!(in_process["memory_digest"], processes["memory_digest"]);
}

#[test]
fn what_the_emulated_arm_cannot_do_is_explained() {
    let sandbox = Sandbox::new(BINARY);
    for mode in [&["--in-process"][..], &[]] {
        let wide = [&["experiment", "exp1-s1", "--body", "adept"], mode].concat();
        let wide = sandbox.run(&wide);
        assert_eq!(wide.code(), Some(2), "{wide:?}");
        assert!(wide.stderr.contains("--world narrow"), "{wide:?}");
    }
    let nowhere = sandbox.run(&["adept"]);
    assert_eq!(nowhere.code(), Some(2), "{nowhere:?}");
    assert!(nowhere.stderr.contains("--port"), "{nowhere:?}");
}

#[test]
fn the_demo_on_the_emulated_arm_tells_its_story_and_leaves_nothing() {
    let sandbox = Sandbox::new(BINARY);
    let process = sandbox.start(&["demo", "--body", "adept", "--seed", "3"]);
    let pid = process.pid();
    let own = format!("demo-{pid}");
    let directory = until("the demo has its directory", || pschema_tests::demo_directory(pid));
    let link = directory.join("adept.line").display().to_string();
    let demo = process.finished();
    assert_eq!(demo.code(), Some(0), "{demo:?}");
    for told in ["serial line", "babbling", "generalised after placement 2", "remembers the exception"] {
        assert!(demo.stderr.contains(told), "{told:?} is not in the story:\n{}", demo.stderr);
    }
    assert!(demo.stdout.contains("116"), "{}", demo.stdout);
    assert_eq!(processes_with(&own), Vec::<u32>::new());
    assert_eq!(processes_with(&link), Vec::<u32>::new(), "the emulator has ended");
    assert!(!Path::new(&directory).exists(), "{} is left", directory.display());
}
