//! Asking a live daemon: the text for people, and the JSON that programs rely on (`docs/CLI.md`).

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use pschema_tests::{Sandbox, until};
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

fn has(value: &Value, fields: &[&str]) {
    for field in fields {
        assert!(value.get(field).is_some(), "{field} is missing in {value}");
    }
}

fn list<'a>(value: &'a Value, field: &str) -> &'a Vec<Value> {
    value[field].as_array().unwrap_or_else(|| panic!("{field} is no list in {value}"))
}

fn real(value: &Value, field: &str) -> f64 {
    value[field].as_f64().unwrap_or_else(|| panic!("{field} is no number in {value}"))
}

#[test]
fn a_learner_that_has_been_through_scenario_1_answers_everything() {
    let sandbox = Sandbox::new(BINARY);
    let _daemon = sandbox.daemon("default", &["--curriculum", "exp1-s1", "--seed", "1"]);
    let _body = sandbox.body("default", &["--seed", "1"]);
    sandbox.curriculum_over("default");
    let json = |arguments: &[&str]| sandbox.run(&[arguments, &["--json"]].concat()).json();
    let text = |arguments: &[&str]| {
        let finished = sandbox.run(arguments);
        assert_eq!(finished.code(), Some(0), "{arguments:?}: {finished:?}");
        let widest = finished.stdout.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        assert!(widest <= 80, "{arguments:?} is {widest} columns wide:\n{}", finished.stdout);
        finished.stdout
    };
    status(&json(&["status"]), &text(&["status"]));
    let generalised = schemas(&json(&["schemas", "--generalised"]), &text(&["schemas", "--generalised"]));
    let id = generalised.to_string();
    schema(&json(&["show", &id]), &text(&["show", &id]));
    explanation(&json(&["explain", "--candidates", "1000"]), &text(&["explain"]));
    let touching = json(&["schemas", "--post", "touch{}", "--limit", "1", "--sort", "probability"]);
    assert_eq!(list(&touching, "schemas").len(), 1, "{touching}");
    assert!(touching["matching"].as_u64() > Some(1), "two touches were learnt: {touching}");
    let stage = json(&["stage"]);
    assert_eq!(stage["finished"], true, "{stage}");
    assert!(text(&["stage", "show"]).contains("finished"));

    for (wrong, says) in [
        (&["show", "999999"][..], "999999"),
        (&["schemas", "--pre", "object{"], "pattern"),
        (&["explain", "--step", "1"], "step 1"),
        (&["stage", "set", "no such stage"], "no such stage"),
    ] {
        let finished = sandbox.run(wrong);
        assert_eq!(finished.code(), Some(1), "{wrong:?}: {finished:?}");
        assert!(finished.stderr.contains(says) && finished.stdout.is_empty(), "{wrong:?}: {finished:?}");
    }
}

fn status(json: &Value, text: &str) {
    has(
        json,
        &["name", "pid", "uptime_s", "step", "durable_step", "stage", "schemas_total", "schemas_generalised"],
    );
    has(json, &["step_latency_us_p50", "step_latency_us_p99", "memory_bytes", "memory_digest"]);
    has(json, &["saturation", "habituation", "trial"]);
    let body = &list(json, "bodies")[0];
    has(body, &["id", "kind", "state", "frames", "frames_refused", "last_refusal", "last_failure"]);
    assert_eq!((&body["state"], &body["frames_refused"]), (&"attached".into(), &0.into()), "{body}");
    for figure in ["memory_digest", "stage"] {
        assert!(text.contains(json[figure].as_str().unwrap()), "{figure} is not in\n{text}");
    }
}

/// Returns the number of the schema that generalises touching.
fn schemas(json: &Value, text: &str) -> u64 {
    let schemas = list(json, "schemas");
    assert!(!schemas.is_empty(), "{json}");
    has(
        &schemas[0],
        &["id", "kind", "pre", "action", "post", "executions", "successes", "probability", "low", "high"],
    );
    let touches = |schema: &&Value| schema["post"].to_string().contains("touch{}");
    let touching =
        schemas.iter().find(touches).unwrap_or_else(|| panic!("nothing generalises touching: {json}"));
    let id = touching["id"].as_u64().unwrap();
    assert!(text.contains(&id.to_string()), "{text}");
    id
}

fn schema(json: &Value, text: &str) {
    has(json, &["id", "kind", "action", "pre", "post", "associated", "executions", "successes", "parent"]);
    has(json, &["examples", "counter_examples", "created_step"]);
    assert_eq!(json["kind"], "generalised");
    let object = &list(json, "pre")[0];
    assert_eq!(object["type"], "object", "{object}");
    assert!(object["properties"]["field"]["var"].is_string(), "a variable is {{\"var\": …}}: {object}");
    for post in list(json, "post") {
        has(post, &["observation", "occurrences", "trials", "probability", "low", "high"]);
        assert!(
            real(post, "low") <= real(post, "probability") && real(post, "probability") <= real(post, "high"),
            "{post}"
        );
    }
    assert!(list(json, "examples").len() >= 2 && !list(json, "counter_examples").is_empty(), "{json}");
    assert!(text.contains("any field") && text.contains("it touches"), "it reads as a sentence:\n{text}");
}

/// Every candidate's excitation is the sum of its terms over its distance: equation (1).
fn explanation(json: &Value, text: &str) {
    has(json, &["step", "chosen", "candidates"]);
    let candidates = list(json, "candidates");
    let chosen = &candidates[usize::try_from(json["chosen"].as_u64().unwrap()).unwrap()];
    for candidate in candidates {
        has(candidate, &["schema", "binding", "distance", "excitation", "terms"]);
        for term in list(candidate, "terms") {
            has(term, &["observation", "seen", "shared", "attention", "probability", "weight", "value"]);
        }
        let sum: f64 = list(candidate, "terms").iter().map(|term| real(term, "value")).sum();
        let (distance, excitation) = (real(candidate, "distance"), real(candidate, "excitation"));
        assert!(
            (sum / distance - excitation).abs() < 1e-9,
            "{sum} / {distance} is not {excitation}: {candidate}"
        );
        assert!(
            excitation <= real(chosen, "excitation") + 1e-9,
            "more exciting than the chosen: {candidate}"
        );
    }
    let sentence = text.replace('\n', " ");
    assert!(sentence.starts_with("In step ") && sentence.contains("because"), "{text}");
}

#[test]
fn a_learner_can_be_held_and_resumed_and_hears_words() {
    let sandbox = Sandbox::new(BINARY);
    let _daemon = sandbox.daemon("default", &[]);
    let _body = sandbox.body("default", &[]);
    let _moving = sandbox.past("default", 5);

    let held = sandbox.run(&["stage", "hold", "--json"]).json();
    assert_eq!(held["stage_state"], "held", "{held}");
    let still = until("a held learner rests, its body not", || {
        let (one, other) = (sandbox.status("default"), sandbox.status("default"));
        let rests =
            one["step"] == other["step"] && one["bodies"][0]["frames"] != other["bodies"][0]["frames"];
        rests.then(|| other["step"].as_u64().unwrap())
    });
    let resumed = sandbox.run(&["stage", "resume", "--json"]).json();
    assert_ne!(resumed["stage_state"], "held", "{resumed}");
    let _again = sandbox.past("default", still);

    let said = sandbox.run(&["say", "touch"]);
    assert_eq!(said.code(), Some(0), "{said:?}");
    assert!(said.stdout.contains("touch"), "{said:?}");
    for unwritable in ["a{b=c}", "$x", "one,two", "\u{202e}touch", "\u{3164}", "two words"] {
        let refused = sandbox.run(&["say", unwritable]);
        assert!(refused.code() == Some(1) && refused.stderr.contains("is no word"), "{refused:?}");
    }
    // A word that was never met is no symbol to look for; this one is now.
    until("the word was heard", || {
        (sandbox.run(&["schemas", "--post", "word{text=touch}"]).code() == Some(0)).then_some(())
    });
}

#[test]
fn a_curriculum_can_be_moved_by_hand() {
    let sandbox = Sandbox::new(BINARY);
    // Nobody acts without a body, so the curriculum stays where it is put.
    let _daemon = sandbox.daemon("default", &["--curriculum", "exp1-s1"]);
    let _held = sandbox.run(&["stage", "hold", "--json"]).json();
    let _body = sandbox.body("default", &[]);
    until("the body is there", || {
        (sandbox.status("default")["bodies"][0]["state"] == "attached").then_some(())
    });
    for (order, stage) in
        [(&["set", "out of reach"][..], "out of reach"), (&["next"], "probe"), (&["show"], "probe")]
    {
        let report = sandbox.run(&[&["stage"], order, &["--json"]].concat()).json();
        assert_eq!(report["stage"], stage, "{order:?}: {report}");
    }
    let last = sandbox.run(&["stage", "next"]);
    assert_eq!(last.code(), Some(1), "{last:?}");
    assert!(last.stderr.contains("last stage"), "{last:?}");
}
