//! The paper's example of what need not matter (section II-A), in the simulated world: the long push moves the block and
//! now and then knocks a ball off the table; the short one moves the block and leaves the ball.

use std::path::{Path, PathBuf};

use pschema_tests::{Sandbox, until};
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

/// Block and ball are put where the world file says, and one thing is done; again and again. At last they are put
/// there once more, and what is done then is done without seeing them.
const CURRICULUM: &str = r#"
name = "block and ball"
afterwards = "hold"

[learner]
profile = "paper"

[[stage]]
name = "pushing"
lift = ["finger", "object"]
trials = 190
arrange = [
    { place = { object = "blue-block", position = 10 } },
    { place = { object = "red-ball", position = 11 } },
]
trial_actions_max = 1

[[stage]]
name = "set out"
lift = ["finger"]
learning = false
trials = 1
arrange = [
    { place = { object = "blue-block", position = 10 } },
    { place = { object = "red-ball", position = 11 } },
]
trial_actions_max = 1
"#;

/// The world without its short push.
fn far_only(directory: &Path) -> PathBuf {
    let world = concat!(env!("CARGO_MANIFEST_DIR"), "/../body-sim/worlds/block-and-ball.toml");
    let text = std::fs::read_to_string(world).unwrap_or_else(|error| panic!("{world}: {error}"));
    let start = text.find("[[pushes]]").expect("the world has pushes");
    let end = start + 2 + text[start + 2..].find("[[pushes]]").expect("the world has two pushes");
    let path = directory.join("far-only.toml");
    std::fs::write(&path, [&text[..start], &text[end..]].concat()).expect("a directory to write to");
    path
}

/// The field of the object of this colour, in the perceived world that `status` prints.
fn field(sandbox: &Sandbox, colour: &str) -> i64 {
    let status = sandbox.status("b");
    let world = status["world"].as_array().expect("a list");
    let start = format!("object{{colour={colour}, field=");
    let seen = world.iter().filter_map(Value::as_str).find_map(|seen| seen.strip_prefix(&start));
    let field = seen.and_then(|seen| seen.trim_end_matches('}').parse().ok());
    field.unwrap_or_else(|| panic!("no {colour} object is seen: {status}"))
}

fn plan(sandbox: &Sandbox, goal: &[&str]) -> Value {
    let plan = sandbox.run(&[&["plan", "--name", "b", "--json"], goal].concat()).json();
    assert_eq!(plan["state"], "found", "{plan}");
    plan
}

fn probability(plan: &Value) -> f64 {
    plan["probability"].as_f64().expect("a probability")
}

/// Whether any step of the plan relies on an object of this colour.
fn relies_on(plan: &Value, colour: &str) -> bool {
    let steps = plan["steps"].as_array().expect("steps").iter();
    let mut relied = steps.flat_map(|step| step["relies_on"].as_array().expect("a list"));
    relied.any(|relied| relied["observation"]["properties"]["colour"] == colour)
}

fn order(sandbox: &Sandbox, order: &[&str]) {
    let finished = sandbox.run(&[&["--name", "b", "stage"], order].concat());
    assert_eq!(finished.code(), Some(0), "{finished:?}");
}

#[test]
fn that_the_ball_may_fall_does_not_matter_to_who_moves_the_block() {
    let directory = tempfile::Builder::new().prefix("pst-").tempdir_in("/tmp").expect("a directory");
    let curriculum = directory.path().join("curriculum.toml");
    std::fs::write(&curriculum, CURRICULUM).expect("a directory to write to");
    let far_only = far_only(directory.path());
    let sandbox = Sandbox::new(BINARY);
    // The body learns to push otherwise meanwhile, and is the same for that.
    let arguments = ["--curriculum", &curriculum.to_string_lossy(), "--seed", "1", "--accept-changes"];
    let daemon = sandbox.daemon("b", &arguments);
    let body = sandbox.body("b", &["--world", &far_only.to_string_lossy(), "--seed", "1"]);
    sandbox.curriculum_over("b");

    // Held, in a stage in which they are seen: nothing is done, and plans can be made.
    order(&sandbox, &["hold"]);
    order(&sandbox, &["set", "pushing"]);
    let (block, ball) = (field(&sandbox, "blue"), field(&sandbox, "red"));
    let moved = format!("object{{colour=blue, field={}}}", block + 1);
    let stays = format!("object{{colour=red, field={ball}}}");
    let alone = plan(&sandbox, &[&moved]);
    let both = plan(&sandbox, &[&moved, &stays]);
    let push = |plan: &Value| plan["steps"][0]["schema"]["action"].as_str().map(str::to_owned);
    assert_eq!(push(&alone), push(&both), "there is only the long push");
    assert!(push(&alone).is_some_and(|push| push.starts_with("push(")), "{alone}");
    assert!(!relies_on(&alone, "red") && relies_on(&both, "red"), "{alone}\n{both}");
    assert!(probability(&alone) > 0.8, "{alone}");
    let falls = 1.0 - probability(&both) / probability(&alone);
    assert!((0.1..=0.9).contains(&falls), "the ball falls now and then: {falls}");

    // With the short push as well, whoever wants the ball to stay takes that.
    assert_eq!(body.ended().code(), Some(0));
    let body = sandbox.body("b", &["--world", "block-and-ball", "--seed", "1"]);
    until("the body is there", || {
        let status = sandbox.status("b");
        let bodies = status["bodies"].as_array().expect("a list").clone();
        bodies.iter().any(|body| body["state"] == "attached").then_some(())
    });
    order(&sandbox, &["resume"]);
    sandbox.curriculum_over("b");
    order(&sandbox, &["hold"]);
    order(&sandbox, &["set", "pushing"]);
    assert_eq!((field(&sandbox, "blue"), field(&sandbox, "red")), (block, ball));
    let careful = plan(&sandbox, &[&moved, &stays]);
    assert_ne!(push(&careful), push(&both), "{careful}");
    assert!(probability(&careful) > probability(&both), "{careful}");
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
