//! Experiment 2 of the paper (section V) through the real thing: a daemon, a body, and words.

use pschema_tests::Sandbox;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

fn stage<'a>(figures: &'a Value, name: &str) -> &'a Value {
    let stages = figures["stages"].as_array().unwrap_or_else(|| panic!("no stages in {figures}"));
    stages
        .iter()
        .find(|stage| stage["name"] == name)
        .unwrap_or_else(|| panic!("no stage {name:?} in {figures}"))
}

#[test]
fn the_word_alone_directs_the_arm_back_to_the_block_also_at_a_new_place() {
    let sandbox = Sandbox::new(BINARY);
    let figures = sandbox.run(&["experiment", "exp2", "--seed", "2", "--json"]).json();
    for name in ["b: the word again", "d: the word at the new place"] {
        let told = stage(&figures, name);
        assert_eq!((&told["trials"], &told["trials_met"]), (&1.into(), &1.into()), "{told}");
        let actions = told["actions_of_trial"][0].as_u64();
        // The one that is under way as the word is said, and then the touch.
        assert!(actions.is_some_and(|actions| (1..=3).contains(&actions)), "{name}: {told}");
    }
    // The learner had lost interest before each word, and nobody ever told it the meaning of the word.
    for name in ["a: the first word", "c: a new place, no word"] {
        let told = stage(&figures, name);
        assert_eq!(told["trials_met"], 1, "{told}");
        assert!(told["actions"].as_u64() > Some(5), "{told}");
    }
    // Repeated over and over the word wears out, like any other sensation (VI-B).
    let measures = figures["measures"].as_array().expect("measures of experiment 2");
    let share = measures.iter().find(|measure| measure["name"].to_string().contains("every frame"));
    let share = share.and_then(|measure| measure["value"].as_f64()).expect("a share of decisions");
    assert!(share > 0.0 && share < 1.0, "{share}");
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
