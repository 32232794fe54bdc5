//! Goals on real processes: after experiment 1, scenario 1 of the paper the learner is asked to touch, to point, and
//! to do what it can't.

use pschema_tests::{Sandbox, until};
use rustix::process::Signal;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

/// Where the world has an observation of this type, in the words of a pattern: `field=17`.
fn place(status: &Value, kind: &str) -> Option<String> {
    let world = status["world"].as_array()?;
    let seen = world.iter().filter_map(Value::as_str).find(|seen| seen.starts_with(kind))?;
    Some(format!("field={}", seen.split("field=").nth(1)?.trim_end_matches('}')))
}

#[test]
fn after_scenario_1_a_goal_touches_the_block_where_learning_never_did() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("g", &["--curriculum", "exp1-s1", "--seed", "3"]);
    for command in ["plan", "achieve"] {
        let alone = sandbox.run(&[command, "touch{}", "--name", "g"]);
        assert_eq!(alone.code(), Some(1), "{alone:?}");
        assert!(alone.stderr.contains("no body is attached"), "{alone:?}");
    }
    let body = sandbox.body("g", &["--seed", "3"]);
    sandbox.curriculum_over("g");
    let learnt = sandbox.status("g");
    let block = place(&learnt, "object{").expect("the last placement of the probe");

    // Away from the block, then to it. The block lies where it was put with learning frozen.
    let away =
        sandbox.run(&["schemas", "--post", "finger{field=$x}", "--limit", "1", "--json", "--name", "g"]);
    let away = away.json()["schemas"][0]["post"][0].as_str().map(str::to_owned).expect("a babbled schema");
    let moved = sandbox.run(&["achieve", &away, "--name", "g"]);
    assert_eq!(moved.code(), Some(0), "{moved:?}");
    assert!(place(&sandbox.status("g"), "finger{") != Some(block.clone()), "the finger is elsewhere now");

    let planned = sandbox.run(&["plan", "touch{}", "--name", "g", "--json"]).json();
    assert_eq!((&planned["state"], planned["steps"].as_array().map(Vec::len)), (&"found".into(), Some(1)));
    assert_eq!(planned["steps"][0]["schema"]["kind"], "generalised", "no example is that of this place");
    let touched = sandbox.run(&["achieve", "touch{}", "--name", "g"]);
    assert_eq!(touched.code(), Some(0), "{touched:?}");
    assert!(touched.stdout.starts_with("touch{} was achieved"), "{touched:?}");
    assert!(touched.stderr.contains("Plan: schema"), "{touched:?}");
    assert_eq!(place(&sandbox.status("g"), "finger{"), Some(block.clone()), "it touches the block");

    let why = sandbox.run(&["explain", "--name", "g", "--json"]).json();
    assert_eq!((&why["reason"], &why["goal"]["goal"][0]), (&"goal".into(), &"touch{}".into()), "{why}");
    let after = sandbox.status("g");
    assert_eq!((&after["stage_state"], &after["goal"]), (&"finished".into(), &Value::Null));
    assert_eq!(after["schemas_total"], learnt["schemas_total"], "the last stage does not learn");

    // A prediction of the same action, without doing it.
    let action = planned["steps"][0]["schema"]["action"].as_str().expect("a primitive").to_owned();
    let told = sandbox.run(&["predict", &action, "--name", "g", "--json"]).json();
    let outcomes = told["outcomes"].as_array().expect("outcomes");
    let touch = outcomes.iter().find(|outcome| outcome["observation"]["type"] == "touch");
    assert!(touch.is_some_and(|touch| touch["trials"].as_u64() > Some(1)), "{told}");

    let here = sandbox.run(&["plan", &format!("object{{{block}}}"), "--name", "g"]);
    assert!(here.stdout.contains("holds already"), "{here:?}");
    let beyond = sandbox.run(&["achieve", "object{field=100000}", "--name", "g"]);
    assert!(beyond.stderr.contains("will never be so") && beyond.stderr.contains("0..=388"), "{beyond:?}");
    let never = sandbox.run(&["achieve", "object{field=388}", "--json", "--name", "g"]);
    assert_eq!(never.code(), Some(1), "{never:?}");
    assert!(never.stderr.contains("nothing known leads there"), "{never:?}");
    let end: Value = serde_json::from_str(&never.stdout).expect("JSON also of what was not achieved");
    assert_eq!((&end["achieved"], &end["actions"]), (&false.into(), &0.into()));

    assert_eq!(sandbox.run(&["--name", "g", "stage", "hold"]).code(), Some(0));
    let held = sandbox.run(&["achieve", "touch{}", "--name", "g"]);
    assert_eq!(held.code(), Some(1), "{held:?}");
    assert!(held.stderr.contains("stage resume"), "{held:?}");
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

#[test]
fn one_goal_at_a_time_and_whoever_waits_for_it_can_call_it_off() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("g", &["--seed", "1"]);
    let body = sandbox.body("g", &[]);
    until("a schema is known", || {
        let known = sandbox.run(&["schemas", "--limit", "1", "--json", "--name", "g"]).json();
        known["schemas"][0]["post"][0].is_string().then_some(())
    });
    // A body that does not move leaves a goal as it is for as long as the test takes.
    body.signal(Signal::STOP);
    let known = sandbox.run(&["schemas", "--limit", "1", "--json", "--name", "g"]).json();
    let goal = known["schemas"][0]["post"][0].as_str().expect("what the first action led to").to_owned();
    let pursuing = sandbox.start(&["achieve", &goal, "--actions-max", "7", "--name", "g"]);
    let pursued = until("the goal is taken up", || {
        let status = sandbox.status("g");
        (!status["goal"].is_null()).then(|| status["goal"].clone())
    });
    assert_eq!((&pursued["goal"][0], &pursued["actions_max"]), (&goal.as_str().into(), &7.into()));
    let shown = sandbox.run(&["status", "--name", "g"]);
    assert!(shown.stdout.contains("pursued by arm"), "{shown:?}");
    let second = sandbox.run(&["achieve", "touch{}", "--name", "g"]);
    assert_eq!(second.code(), Some(1), "{second:?}");
    assert!(second.stderr.contains("goal 1 is pursued") && second.stderr.contains(&goal), "{second:?}");
    pursuing.signal(Signal::INT);
    let interrupted = pursuing.finished();
    assert_eq!(interrupted.code(), Some(1), "{interrupted:?}");
    assert!(interrupted.stderr.contains("called off"), "{interrupted:?}");
    assert!(sandbox.status("g")["goal"].is_null());

    let late = sandbox.run(&["achieve", &goal, "--wait", "1", "--json", "--name", "g"]);
    assert_eq!(late.code(), Some(1), "{late:?}");
    assert!(late.stderr.contains("--wait"), "{late:?}");
    let end: Value = serde_json::from_str(&late.stdout).expect("JSON also of what was not achieved");
    assert_eq!((&end["number"], &end["state"]), (&2.into(), &"cancelled".into()));

    body.signal(Signal::CONT);
    let done = sandbox.run(&["achieve", &goal, "--name", "g"]);
    assert_eq!(done.code(), Some(0), "{done:?}");
    assert_eq!(body.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
    assert_eq!(sandbox.left(), Vec::<String>::new());
}
