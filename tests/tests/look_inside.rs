//! Looking inside a learner that goes on living: at steps long past, at schemas that were not chosen, at the graph of all schemas.

use pschema_tests::Sandbox;
use serde_json::Value;

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

/// Decisions that a daemon keeps.
const KEPT: u64 = 64;

#[test]
fn a_step_that_the_daemon_no_longer_keeps_is_explained_from_its_memory_on_disk_while_it_goes_on() {
    let sandbox = Sandbox::new(BINARY);
    let life = sandbox.runtime().join("life");
    let life = life.to_str().unwrap();
    let _daemon = sandbox.daemon("default", &["--data", life, "--seed", "5", "--snapshot-every", "16KiB"]);
    let _body = sandbox.body("default", &["--seed", "5"]);
    assert!(sandbox.past("default", 3 * KEPT) > 0);
    let json = |arguments: &[&str]| -> Value {
        let finished = sandbox.run(&[arguments, &["--json"]].concat());
        assert_eq!(finished.code(), Some(0), "{arguments:?}: {finished:?}");
        finished.json()
    };
    // Explained while it was the last, and again when the daemon has long forgotten it, beside the steps that go on.
    let then = json(&["explain", "--candidates", "1000"]);
    let step = then["step"].to_string();
    for _ in 0..5 {
        let now = sandbox.past("default", then["step"].as_u64().unwrap() + 2 * KEPT);
        for early in [KEPT / 2, KEPT, 2 * KEPT] {
            let told = json(&["explain", "--step", &early.to_string(), "--candidates", "1000"]);
            let offline =
                json(&["explain", "--data", life, "--step", &early.to_string(), "--candidates", "1000"]);
            assert_eq!((told["step"].as_u64(), &told), (Some(early), &offline), "at step {now}");
        }
        assert_eq!(json(&["explain", "--step", &step, "--candidates", "1000"]), then, "at step {now}");
    }
    let why = json(&["explain", "--why-not", "3", "--step", &step]);
    assert_eq!((why["step"].to_string(), &why["schema"]), (step.clone(), &Value::from(3)));
    assert_eq!(why, json(&["explain", "--why-not", "3", "--step", &step, "--data", life]));
    assert!(why["verdict"].is_string() && why["chosen"]["terms"].is_array(), "{why}");
    let text = sandbox.run(&["explain", "--why-not", "3", "--step", &step]);
    assert!(text.code() == Some(0) && text.stdout.starts_with("Schema 3 "), "{text:?}");
    // The latest decision can be asked about while the next is made.
    for _ in 0..5 {
        assert_eq!(json(&["explain", "--why-not", "3"])["schema"], 3);
    }
    let beyond = sandbox.run(&["explain", "--step", "100000000"]);
    assert!(beyond.code() == Some(1) && beyond.stderr.contains("has not been taken yet"), "{beyond:?}");
    assert_eq!(json(&["verify", "--data", life])["sound"], true, "reading it changed nothing");
}

#[test]
fn without_memory_on_disk_it_is_said_that_nothing_older_is_kept() {
    let sandbox = Sandbox::new(BINARY);
    let _daemon = sandbox.daemon("default", &["--seed", "5"]);
    let _body = sandbox.body("default", &["--seed", "5"]);
    assert!(sandbox.past("default", 2 * KEPT) > 0);
    let gone = sandbox.run(&["explain", "--step", "3"]);
    assert_eq!(gone.code(), Some(1), "{gone:?}");
    assert!(gone.stderr.contains("in RAM only") && gone.stderr.contains("--data DIR"), "{gone:?}");
    assert!(gone.stderr.contains("not among the last 64 decisions"), "{gone:?}");
}

#[test]
fn the_graph_is_drawn_live_and_from_disk_the_same() {
    let sandbox = Sandbox::new(BINARY);
    let life = sandbox.runtime().join("life");
    let life = life.to_str().unwrap();
    let daemon = sandbox.daemon("default", &["--data", life, "--curriculum", "exp1-s1", "--seed", "1"]);
    let body = sandbox.body("default", &["--seed", "1"]);
    sandbox.curriculum_over("default");
    let law = sandbox.run(&["schemas", "--generalised", "--json"]).json()["schemas"][0]["id"].to_string();
    let asked: [&[&str]; 4] = [
        &["graph"],
        &["graph", "--limit", "20"],
        &["graph", "--around", &law, "--depth", "2", "--limit", "30"],
        &["graph", "--around", &law, "--format", "dot"],
    ];
    let written = |arguments: &[&str]| {
        let finished = sandbox.run(arguments);
        assert_eq!(finished.code(), Some(0), "{arguments:?}: {finished:?}");
        finished.stdout
    };
    let live: Vec<_> = asked.iter().map(|arguments| written(arguments)).collect();
    let svg = sandbox.runtime().join("around.svg");
    assert_eq!(written(&["graph", "--limit", "20", "--out", svg.to_str().unwrap()]), "");
    assert_eq!(std::fs::read_to_string(&svg).unwrap(), live[1]);
    assert!(live[1].starts_with("<svg ") && live[3].starts_with("digraph "));
    let graph: Value =
        serde_json::from_str(&written(&["graph", "--limit", "20", "--format", "json"])).unwrap();
    assert_eq!((&graph["shown"], &graph["truncated"]), (&Value::from(20), &Value::Bool(true)));
    assert!(graph["nodes_total"].as_u64() > Some(200), "{}", graph["nodes_total"]);
    let nowhere = sandbox.run(&["graph", "--around", "99999"]);
    assert!(nowhere.code() == Some(1) && nowhere.stderr.contains("99999"), "{nowhere:?}");
    drop(body);
    drop(daemon);
    for (arguments, live) in asked.iter().zip(&live) {
        let past = written(&[*arguments, &["--data", life]].concat());
        // Frames went on after the last step that changed anything.
        let timeless = |text: &str| {
            let lines = text.lines().filter(|line| !line.contains("after step"));
            lines.map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(timeless(&past), timeless(live), "{arguments:?}");
    }
    let early = written(&["graph", "--data", life, "--until", "50"]);
    assert!(early.contains("after step 50"), "{}", &early[..300]);
}

/// What a learner of the full profile holds to be so is told by its daemon, and by the memory that the daemon keeps on disk.
#[test]
fn claims_are_told_live_and_from_disk_the_same() {
    let sandbox = Sandbox::new(BINARY);
    let life = sandbox.runtime().join("life");
    let life = life.to_str().unwrap();
    let full =
        ["--data", life, "--curriculum", "exp1-s1", "--seed", "1", "--set", "learner.profile=\"full\""];
    let daemon = sandbox.daemon("default", &full);
    let body = sandbox.body("default", &["--seed", "1"]);
    sandbox.curriculum_over("default");
    let json = |arguments: &[&str]| -> Value {
        let finished = sandbox.run(&[arguments, &["--json"]].concat());
        assert_eq!(finished.code(), Some(0), "{arguments:?}: {finished:?}");
        finished.json()
    };
    assert_eq!(json(&["status"])["profile"], "full");
    let action = json(&["explain"])["action"].as_str().unwrap().to_owned();
    let asked: [&[&str]; 4] = [&["claims"], &["claims", "move"], &["claims", &action], &["predict", &action]];
    let told: Vec<_> = asked.iter().map(|question| json(question)).collect();
    let touch =
        told[1]["claims"].as_array().unwrap().iter().find(|tree| tree["types"][0] == "touch").unwrap();
    let named = &touch["claim"]["exceptions"][0]["because"]["condition"]["observed"]["properties"]["field"];
    assert_eq!(named["named"]["by"], "effect", "{touch}");
    assert!(told[3]["claims"].as_array().is_some_and(|foretold| !foretold.is_empty()), "{}", told[3]);
    let text = sandbox.run(&["claims", "move"]);
    assert!(text.stdout.contains("but where object{field=effect(finger).field}"), "{text:?}");
    drop((body, daemon));
    for (question, told) in asked.iter().zip(&told) {
        assert_eq!(json(&[question, &["--data", life][..]].concat()), *told, "{question:?}");
    }
}
