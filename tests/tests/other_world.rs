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

/// Another world under another body's name is nothing that a daemon could refuse: two arms may share a memory. It is told.
#[test]
fn another_world_under_another_name_is_told() {
    let sandbox = Sandbox::new(BINARY);
    let daemon = sandbox.daemon("default", &[]);
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
