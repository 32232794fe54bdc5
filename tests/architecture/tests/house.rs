//! The house stands as `ARCHITECTURE.md` says: no file imports another that imports it back, no storey imports a higher one,
//! and the walls between crates hold.

use pschema_architecture::plan::Plan;
use pschema_architecture::source::Imports;
use pschema_architecture::workspace::{members, root};
use pschema_architecture::{rings, storeys};

fn plan() -> Plan {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md"));
    Plan::read(&page.unwrap_or_else(|error| panic!("ARCHITECTURE.md: {error}")))
}

/// What every library and every program of the workspace imports.
fn imports() -> Vec<&'static Imports> {
    members().values().flat_map(|member| &member.imports).collect()
}

#[test]
fn every_import_is_followed_to_its_file() {
    let lost: Vec<_> = imports().into_iter().flat_map(|imports| &imports.lost).collect();
    assert!(lost.is_empty(), "source.rs can't follow these paths: {lost:#?}");
    let arrows: usize = imports().iter().map(|imports| imports.arrows.len()).sum();
    assert!(arrows > 2_000, "only {arrows} imports were found in the whole workspace");
}

#[test]
fn no_files_import_each_other_in_a_ring() {
    let rings: Vec<String> = imports()
        .into_iter()
        .flat_map(|imports| rings::rings(&imports.arrows))
        .map(|ring| rings::told(&ring))
        .collect();
    assert!(
        rings.is_empty(),
        "{} rings of files that import each other. What two of them need belongs into a file below both.\n{}",
        rings.len(),
        rings.join("\n")
    );
}

#[test]
fn no_storey_imports_a_higher_one() {
    let plan = plan();
    assert!(!plan.storeys.is_empty(), "ARCHITECTURE.md gives no crate storeys");
    let imports = imports();
    let crates = plan.storeys.iter();
    let problems: Vec<String> =
        crates.flat_map(|(folder, storeys)| storeys::problems(folder, storeys, &imports)).collect();
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

#[test]
fn crates_are_built_on_each_other_as_the_map_says() {
    let plan = plan();
    for (name, member) in members() {
        let Some(built_on) = plan.crates.get(name) else {
            panic!("{name} is not on the map in ARCHITECTURE.md");
        };
        assert_eq!(&member.built_on, built_on, "{name}: Cargo.toml, and the map in ARCHITECTURE.md");
    }
    for name in plan.crates.keys() {
        assert!(
            members().contains_key(name),
            "the map in ARCHITECTURE.md has {name}, and there is no such crate"
        );
    }
}

#[test]
fn a_crate_of_others_is_named_only_where_the_plan_says() {
    for (name, places) in plan().named_only_in {
        let mut seen = false;
        for (file, _) in
            imports().into_iter().flat_map(|imports| &imports.foreign).filter(|(_, used)| *used == name)
        {
            let allowed = places.iter().any(|place| file.starts_with(place));
            assert!(allowed, "{} names {name}; ARCHITECTURE.md allows it in {places:?}", file.display());
            seen = true;
        }
        assert!(seen, "nothing names {name} any more: take it out of ARCHITECTURE.md");
    }
}

#[test]
fn who_writes_a_body_compiles_nothing_of_the_learner() {
    let linked = &members()["pschema-protocol"].linked;
    for absent in ["pschema-learner", "pschema-inspect", "pschema-store", "pschema-server"] {
        assert!(!linked.contains(absent), "pschema-protocol links {absent}");
    }
}

#[test]
fn the_arm_that_can_break_things_is_driven_without_physics_and_without_the_learner() {
    let linked = &members()["pschema-adept"].linked;
    for absent in ["rapier3d", "pschema-sim", "pschema-vplus-emulator", "pschema-learner", "pschema-server"] {
        assert!(!linked.contains(absent), "pschema-adept links {absent}");
    }
}
