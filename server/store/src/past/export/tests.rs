//! Out and back, and what is refused on the way back.

use pschema_learner::random::Random;

use super::*;
use crate::past::tests::{all, lived};

fn written(imported: &Import) -> Vec<u8> {
    let identity = Identity {
        learner: &imported.learner,
        seed: imported.seed,
        parameters: &imported.parameters,
        curriculum: &imported.curriculum,
    };
    let mut bytes = Vec::new();
    write(&imported.content, identity, &mut bytes, |_| ()).unwrap();
    bytes
}

/// An export of a life of `steps` steps, with the digest of its memory.
fn export(seed: u64, steps: u64) -> (Vec<u8>, String) {
    let lived = lived(seed, 1, steps, all(), true);
    let past = lived.past();
    let moment = past.moment(None).unwrap();
    let mut bytes = Vec::new();
    let mut told = 0;
    let lines = past.export(&moment, &mut bytes, |lines| told = lines).unwrap();
    assert_eq!((lines.lines, &lines.memory_digest), (told + 1, lived.digests.last().unwrap()));
    (bytes, lines.memory_digest)
}

fn back(bytes: &[u8]) -> Result<Import, ExportError> {
    read(&mut &*bytes, |_| ())
}

#[test]
fn memory_comes_back_the_same() {
    for seed in 20..24 {
        let (bytes, digest) = export(seed, 400);
        let imported = back(&bytes).unwrap();
        assert_eq!(imported.lines.memory_digest, digest, "seed {seed}");
        assert_eq!(written(&imported), bytes, "seed {seed}: and is written as it was");
    }
}

#[test]
fn a_file_of_format_1_is_read_and_written_as_it_always_was() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/golden/export-1.jsonl");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(path, export(7, 60).0).unwrap();
    }
    let golden = std::fs::read(path).unwrap();
    let imported = back(&golden).unwrap();
    assert_eq!((imported.content.step, imported.seed), (60, 7));
    assert_eq!(String::from_utf8(written(&imported)), String::from_utf8(golden));
}

#[test]
fn a_wrong_line_is_named_with_what_is_wrong() {
    let (bytes, _) = export(20, 60);
    let text = String::from_utf8(bytes).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let at = |kind: &str| lines.iter().position(|line| line.starts_with(&format!("{{\"{kind}\""))).unwrap();
    let refused = |lines: &[&str], line: usize, says: &str| {
        let error = back((lines.join("\n") + "\n").as_bytes()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("line {line}: ")) && error.contains(says), "{says}: {error}");
    };
    let with = |at: usize, line: &str, wrong_at: usize, says: &str| {
        assert_ne!(lines[at], line, "{says}");
        let mut lines = lines.clone();
        lines[at] = line;
        refused(&lines, wrong_at + 1, says);
    };
    let without = |at: usize, wrong_at: usize, says: &str| {
        let mut lines = lines.clone();
        lines.remove(at);
        refused(&lines, wrong_at + 1, says);
    };
    let (memory, observation, schema, end) = (at("memory"), at("observation"), at("schema"), lines.len() - 1);
    without(0, 0, "the first line must be a `pschema` line");
    with(
        0,
        &lines[0].replacen("\"format\":1", "\"format\":2", 1),
        0,
        "format 2, and this release reads formats 1",
    );
    without(memory, memory, "there is no `memory`");
    with(memory, &lines[memory].replace("\"attention\":true,", ""), memory, "missing field `attention`");
    with(
        memory,
        &lines[memory].replace("\"association_weight\":0.8", "\"association_weight\":1.8"),
        memory,
        "no learner can live under its settings: association_weight = 1.8",
    );
    without(schema, schema, "schema 1 stands where schema 0 is next");
    without(at("property"), at("property"), "property 1 stands where property 0 is next");
    let other_type = lines[observation].replacen("\"kind\":", "\"kind\":9", 1);
    with(
        observation,
        &other_type,
        observation,
        "an observation type, a property or a symbol that was never declared",
    );
    let other_action = lines[schema].replacen("\"action\":", "\"action\":9", 1);
    with(schema, &other_action, schema, "it refers to primitive 9");
    with(
        schema,
        &lines[schema].replacen("\"pre\":[", "\"pre\":[700", 1),
        schema,
        "refers to observation 700",
    );
    with(
        schema,
        &lines[schema].replacen("\"trials\":", "\"trials\":1", 1),
        end,
        "a line was changed or lost",
    );
    let more_than_tried = lines[schema].replacen("\"occurrences\":", "\"occurrences\":900", 1);
    with(schema, &more_than_tried, schema, "something happened 900");
    with(schema, "{\"schema\":1}", schema, "not a line of an export: invalid type: integer `1`");
    with(schema, "{\"dream\":{}}", schema, "unknown variant `dream`");
    with(schema, "{}", schema, "the object has no fields");
    let asked = lines[schema].replace(",\"id\":0", ",\"id\":0,\"mood\":\"good\"");
    with(schema, &asked, schema, "unknown field `mood`");
    with(schema, lines[at("symbol")], schema, "`symbol` stands after `observation`");
    with(
        at("symbol") + 1,
        &lines[at("symbol")].replace("\"id\":0", "\"id\":1"),
        at("symbol") + 1,
        "the symbol \"red\" was there before",
    );
    let again = lines[observation].replace("\"id\":0", "\"id\":1");
    with(observation + 1, &again, observation + 1, "this observation was there before");
    without(at("progress"), at("progress"), "there is no `progress`");
    without(at("generator"), end - 1, "there is no `generator`");
    let twice = [&lines[..end], &[lines[at("generator")]], &lines[end..]].concat();
    refused(&twice, end + 1, "a second `generator`");
    let recounted = lines[end].replace(&format!("\"items\":{}", end - 1), &format!("\"items\":{end}"));
    with(end, &recounted, end, &format!("{end} items are announced, and there are {}", end - 1));
    with(memory, &lines[memory].replace("\"schemas\":", "\"schemas\":1"), end, "schemas are announced");
    refused(&lines[..schema], schema + 1, "the file ends before its `end` line");
    let twice: Vec<&str> = lines.iter().chain(&lines).copied().collect();
    refused(&twice, lines.len() + 1, "something follows");
    let long = format!("{{\"symbol\":\"{}\"}}", "x".repeat(LINE_BYTES_MAX as usize));
    with(at("symbol"), &long, at("symbol"), "longer than 16777216 bytes");
    let deep = "[".repeat(100_000);
    with(schema, &deep, schema, "not a line of an export");
    assert!(back(b"").unwrap_err().to_string().starts_with("line 1: the file ends before"));
}

/// What is wrong is found in the line, too.
#[test]
fn the_place_in_a_line_is_named() {
    let (bytes, _) = export(20, 60);
    let text = String::from_utf8(bytes).unwrap();
    let line = text.lines().find(|line| line.starts_with("{\"schema\"")).unwrap();
    let wrong = line.replacen("\"created_step\":", "\"created_step\":x", 1);
    let column = wrong.find(":x").unwrap() + 2;
    let error = back(text.replace(line, &wrong).as_bytes()).unwrap_err().to_string();
    assert!(error.contains(&format!("column {column}")), "{error}");
}

/// Lines can be read without knowing numbers.
#[test]
fn names_stand_beside_numbers() {
    let (bytes, _) = export(20, 200);
    let text = String::from_utf8(bytes).unwrap();
    let lines: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |kind: &'static str| lines.iter().filter(move |line| !line[kind].is_null());
    let named: Vec<_> = of("observation").map(|line| line["named"].to_string()).collect();
    assert!(named.contains(&r#"{"properties":{"field":3},"type":"finger"}"#.to_owned()), "{named:?}");
    for (number, line) in of("schema").enumerate() {
        assert_eq!(line["id"], number);
        let form = &line["schema"]["form"];
        let concrete = !form["concrete"].is_null();
        let form = &form[if concrete { "concrete" } else { "generalised" }];
        for part in ["pre", "post"] {
            let count = |value: &serde_json::Value| value.as_array().unwrap().len();
            assert_eq!(count(&form[part]), count(&line["named"][part]), "{line}");
        }
        assert_eq!(
            (concrete, !concrete),
            (line["named"]["action"].is_string(), line["named"]["target"].is_array())
        );
    }
}

/// Bytes changed, lines swapped, dropped and repeated: it is the same memory or it is refused, and nothing panics.
#[test]
fn whatever_is_changed_is_noticed() {
    let (bytes, digest) = export(21, 40);
    let mut random = Random::from_seed(21);
    for case in 0..3_000 {
        let mut changed = bytes.clone();
        match random.below(4) {
            0 => {
                let at = random.below(changed.len());
                changed[at] = random.below(256) as u8;
            }
            1 => {
                // Another digit for a digit: JSON stays JSON.
                let digits: Vec<_> = (0..changed.len()).filter(|at| changed[*at].is_ascii_digit()).collect();
                changed[digits[random.below(digits.len())]] = b'0' + random.below(10) as u8;
            }
            _ => {
                let mut lines: Vec<&[u8]> = bytes.split_inclusive(|byte| *byte == b'\n').collect();
                let (one, other) = (random.below(lines.len()), random.below(lines.len()));
                match random.below(3) {
                    0 => lines.swap(one, other),
                    1 => drop(lines.remove(one)),
                    _ => lines.insert(other, lines[one]),
                }
                changed = lines.concat();
            }
        }
        if let Ok(imported) = back(&changed) {
            assert_eq!(imported.lines.memory_digest, digest, "case {case}");
        }
    }
}
