//! What `pschema-bench` measures beside the learner: that each figure stands beside its baseline, of the same work.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use std::process::Command;

use serde_json::Value;

fn figures(arguments: &[&str]) -> Value {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pschema-bench"));
    let output = command.args(arguments).args(["--json", "-q"]).output().unwrap();
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn figure(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("{name} is no number in {of}"))
}

fn is_ratio(of: &Value, ratio: &str, ours: &str, baseline: &str) {
    let expected = figure(of, ours) / figure(of, baseline);
    assert!((expected - figure(of, ratio)).abs() < 1e-6, "{ratio} is not {ours} to {baseline}: {of}");
}

#[test]
fn every_measurement_has_help_with_an_example() {
    for what in ["decision", "memory", "durability", "restart", "inspect", "ipc", "sim", "vision", "tasks"] {
        let help = Command::new(env!("CARGO_BIN_EXE_pschema-bench")).args([what, "--help"]).output().unwrap();
        let help = String::from_utf8(help.stdout).unwrap();
        assert!(help.contains(&format!("Example:\n  pschema-bench {what}")), "{what}:\n{help}");
    }
}

#[test]
fn round_trips_are_measured_against_bare_ones_in_every_way_of_waiting() {
    let figures = figures(&["ipc", "--rounds", "100"]);
    let rows = figures["rows"].as_array().unwrap();
    let ways: Vec<_> = rows.iter().map(|row| (&row["mode"], figure(row, "payload_bytes") as u32)).collect();
    let modes = ["polling", "event", "hybrid"].map(Value::from);
    let expected: Vec<_> =
        modes.iter().flat_map(|mode| [64, 4_096, 262_144].map(|payload| (mode, payload))).collect();
    assert_eq!(ways, expected);
    for row in rows {
        assert_eq!(figure(row, "exchanges") as u32, 100);
        let apart = figure(row, "record_bytes") - figure(row, "payload_bytes");
        assert!((0.0..72.0).contains(&apart), "whole records, and no more than needed: {row}");
        is_ratio(row, "ratio_p50", "ours_us_p50", "bare_us_p50");
        is_ratio(row, "ratio_p99", "ours_us_p99", "bare_us_p99");
        assert!(figure(row, "socket_us_p50") > 0.0 && figure(row, "atomic_us_p50") > 0.0, "{row}");
    }
}

#[test]
fn the_simulated_body_is_measured_against_the_engine_on_the_same_way() {
    let figures = figures(&["sim", "--rounds", "30"]);
    assert_eq!(figure(&figures, "actions") as u32, 30);
    assert!(figure(&figures, "steps") > 300.0 && figure(&figures, "actions_per_s") > 0.0, "{figures}");
    // Blocks that are elsewhere would be other work.
    assert!(figure(&figures, "apart_mm_max") < 2.0, "{figures}");
    is_ratio(&figures, "ratio", "step_us", "rapier_step_us");
    is_ratio(&figures, "ratio_p50", "action_ms_p50", "rapier_action_ms_p50");
}

#[test]
fn looking_is_measured_on_pictures_with_something_in_them() {
    let figures = figures(&["vision", "--rounds", "30"]);
    assert_eq!((figure(&figures, "width_px") as u32, figure(&figures, "height_px") as u32), (780, 580));
    assert_eq!(figure(&figures, "frames") as u32, 30);
    assert!(figure(&figures, "blobs_mean") >= 1.0, "{figures}");
    is_ratio(&figures, "ratio_p50", "frame_ms_p50", "copy_ms_p50");
    is_ratio(&figures, "ratio_look_at_all_p50", "look_at_all_ms_p50", "copy_ms_p50");
}

#[test]
fn foretelling_is_measured_against_the_truth_and_a_table() {
    let row = |world: &str| -> Value {
        let figures = figures(&["tasks", "--seeds", "1..2", "--world", world]);
        assert_eq!((figure(&figures, "seeds") as u32, figures["rows"].as_array().unwrap().len()), (2, 1));
        figures["rows"][0].clone()
    };
    // Own actions, and nothing by chance: the table has it all after a while, and so has the learner.
    let push = row("push:fields=3");
    assert_eq!(
        (push["figure"].as_str(), push["world"].as_str()),
        (Some("total variation"), Some("push:fields=3"))
    );
    assert!(figure(&push, "bound") < 1e-9 && figure(&push["first_order"], "median") < 1e-9, "{push}");
    assert!(figure(&push["ours"], "median") < figure(&push, "nothing_changes"), "{push}");
    // Others' actions, and a hidden state: the truth knows it, and a table of the first order cannot.
    let flip = row("flip");
    assert_eq!(flip["figure"].as_str(), Some("wrong predictions"));
    assert!(figure(&flip, "bound") < 1e-9, "{flip}");
    assert!((figure(&flip["first_order"], "median") - 0.334).abs() < 0.03, "{flip}");
    assert!(figure(&flip["ours"], "median") <= figure(&flip, "nothing_changes"), "{flip}");
    let course = flip["course"].as_array().unwrap();
    let actions: Vec<_> = course.iter().map(|stand| figure(stand, "actions") as u32).collect();
    assert_eq!(actions, [312, 625, 1_250, 2_500, 5_000]);
}

#[test]
fn a_world_that_there_is_not_is_refused_with_those_that_there_are() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pschema-bench"));
    let output = command.args(["tasks", "--world", "flop"]).output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && told.contains("there are: flip"), "{told}");
}

#[test]
fn durability_is_measured_against_the_bare_disk() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_pschema-bench"));
    command.args(["durability", "--rounds", "100", "--json", "-q", "--data"]).arg(&data);
    let output = command.env("PSCHEMA_RUNTIME_DIR", folder.path().join("run")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let figures: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = figures["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    for row in rows {
        assert!(figure(row, "bytes") > 50.0 && figure(row, "bare_us_p50") > 0.0, "{row}");
        // Whether the action waits for the disk is for the store's own tests: beside other work no time is sure to be the longer one.
        assert!(figure(row, "without_disk_us_p50") > 0.0, "{row}");
        is_ratio(row, "ratio_p50", "ours_us_p50", "bare_us_p50");
    }
    assert_eq!(std::fs::read_dir(&data).unwrap().count(), 0, "the files of the measurement are removed");
}
