//! A body comes back under its name and is in another world.

use pschema_tests::{Sandbox, until};

const BINARY: &str = env!("CARGO_BIN_EXE_pschema-under-test");

#[test]
fn another_world_under_the_same_life_is_refused_until_it_is_accepted() {
    let sandbox = Sandbox::new(BINARY);
    let life = sandbox.runtime().join("life");
    let data = ["--data", life.to_str().unwrap()];
    let daemon = sandbox.daemon("default", &data);
    let wide = sandbox.body("default", &["--world", "wide"]);
    let _moving = sandbox.past("default", 20);
    assert_eq!(wide.ended().code(), Some(0));
    let step = |sandbox: &Sandbox| sandbox.status("default")["step"].as_u64().unwrap();
    // The same body again is no other.
    let at = step(&sandbox);
    let wide = sandbox.body("default", &["--world", "wide"]);
    let _on = sandbox.past("default", at);
    assert_eq!(wide.ended().code(), Some(0));
    until("its end is noticed", || {
        (sandbox.status("default")["bodies"][0]["state"] != "attached").then_some(())
    });

    let digest = |sandbox: &Sandbox| sandbox.status("default")["memory_digest"].clone();
    let before = digest(&sandbox);
    let narrow = sandbox.body("default", &["--world", "narrow"]).finished();
    assert_eq!(narrow.code(), Some(1), "{narrow:?}");
    assert!(narrow.stderr.contains("declares otherwise than before"), "{narrow:?}");
    assert!(daemon.stderr().contains("repertoire was"), "{}", daemon.stderr());
    assert!(daemon.stderr().contains("--accept-changes"), "{}", daemon.stderr());
    assert_eq!(digest(&sandbox), before, "nothing was taken of it");
    assert_eq!(daemon.ended().code(), Some(0));

    // It is refused by the next daemon too, which has it from the disk.
    let daemon = sandbox.daemon("default", &data);
    assert_eq!(sandbox.body("default", &["--world", "narrow"]).finished().code(), Some(1));
    assert_eq!(daemon.ended().code(), Some(0));

    let daemon = sandbox.daemon("default", &[&data[..], &["--accept-changes"]].concat());
    let at = step(&sandbox);
    let narrow = sandbox.body("default", &["--world", "narrow"]);
    let _on = sandbox.past("default", at);
    assert!(daemon.stderr().contains("accepted, as asked"), "{}", daemon.stderr());
    assert_eq!(narrow.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
    // From here on it is the narrow world that is known.
    let daemon = sandbox.daemon("default", &data);
    let wide = sandbox.body("default", &["--world", "wide"]).finished();
    assert_eq!(wide.code(), Some(1), "{wide:?}");
    assert_eq!(daemon.ended().code(), Some(0));
    // The acceptance is in the journal, and what it was about.
    let journal = sandbox.run(&["journal", data[0], data[1], "--json", "--limit", "100000"]);
    let told = "accept-changes: body arm declares otherwise than before: ";
    assert_eq!(journal.stdout.matches(told).count(), 1, "{}", journal.stdout);
    let journal = sandbox.run(&["journal", data[0], data[1], "--effects", "--limit", "100000"]);
    assert_eq!(journal.stdout.matches("describes itself: kind: sim-arm").count(), 2, "{}", journal.stdout);
    let verified = sandbox.run(&["verify", "--data", data[1], "--relearn"]);
    assert_eq!(verified.code(), Some(0), "{verified:?}");
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Another friction changes nothing that a body senses or does, and what was learnt all the same.
#[test]
fn a_world_that_looks_alike_is_refused_under_the_same_name_and_under_another() {
    let sandbox = Sandbox::new(BINARY);
    let (data, slippery) = (sandbox.runtime().join("life"), sandbox.runtime().join("wide.toml"));
    let data = ["--data", data.to_str().unwrap()];
    let text = pschema_sim::config::WIDE.replacen("friction = 0.9", "friction = 0.1", 1);
    std::fs::write(&slippery, text).unwrap();
    let slippery = ["--world", slippery.to_str().unwrap()];
    let daemon = sandbox.daemon("default", &data);
    // That a body has made a step shows that it was taken.
    let steps = |arguments: &[&str]| {
        let at = sandbox.status("default")["step"].as_u64().unwrap();
        let body = sandbox.body("default", arguments);
        let _on = sandbox.past("default", at);
        assert_eq!(body.ended().code(), Some(0));
    };
    steps(&["--world", "wide"]);

    let alike = sandbox.body("default", &slippery).finished();
    assert_eq!(alike.code(), Some(1), "{alike:?}");
    assert!(alike.stderr.contains("world was wide-") && alike.stderr.contains(", is wide-"), "{alike:?}");
    let other = [&slippery[..], &["--body", "other"]].concat();
    let refused = sandbox.body("default", &other).finished();
    assert_eq!(refused.code(), Some(1), "{refused:?}");
    assert!(
        refused.stderr.contains("is in another world than body arm of this memory: wide-"),
        "{refused:?}"
    );
    // Another arm in the same world is welcome.
    steps(&["--world", "wide", "--body", "twin"]);
    assert_eq!(daemon.ended().code(), Some(0));

    let daemon = sandbox.daemon("default", &[&data[..], &["--accept-changes"]].concat());
    steps(&other);
    assert!(daemon.stderr().contains("accepted, as asked"), "{}", daemon.stderr());
    assert_eq!(daemon.ended().code(), Some(0));

    // What was accepted once stays so, and the journal tells of it.
    let daemon = sandbox.daemon("default", &data);
    steps(&other);
    assert_eq!(daemon.ended().code(), Some(0));
    let journal = sandbox.run(&["journal", data[0], data[1], "--json", "--limit", "100000"]);
    let told = "accept-changes: body other is in another world than body arm of this memory: wide-";
    assert_eq!(journal.stdout.matches(told).count(), 1, "{}", journal.stdout);
    let verified = sandbox.run(&["verify", "--data", data[1], "--relearn"]);
    assert_eq!(verified.code(), Some(0), "{verified:?}");
    assert_eq!(sandbox.left(), Vec::<String>::new());
}

/// Two arms of one world may share a memory. Senses that stand for something else in each are told, as here where it was accepted
/// that they are in two worlds.
#[test]
fn other_ranges_under_another_name_are_told() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &["--accept-changes"]);
    let wide = sandbox.body("default", &["--world", "wide"]);
    let at = sandbox.past("default", 20);
    assert_eq!(wide.ended().code(), Some(0));
    let again = sandbox.body("default", &["--world", "wide", "--body", "twin"]);
    daemon.says("body=twin");
    assert!(!daemon.stderr().contains("means something else"), "{}", daemon.stderr());
    assert_eq!(again.ended().code(), Some(0));
    let narrow = sandbox.body("default", &["--world", "narrow", "--body", "other"]);
    daemon.says("means something else by what it senses than another body of this memory");
    daemon.says("sense finger is ");
    let _on = sandbox.past("default", at);
    assert_eq!(narrow.ended().code(), Some(0));
    assert_eq!(daemon.ended().code(), Some(0));
}
