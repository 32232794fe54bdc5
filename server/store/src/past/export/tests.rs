//! Out and back, and what is refused on the way back.

use pschema_learner::random::Random;

use super::*;
use crate::past::tests::{all, lived};

fn written(imported: &Imported) -> Vec<u8> {
    let about = About {
        learner: &imported.learner,
        seed: imported.seed,
        parameters: &imported.parameters,
        curriculum: &imported.curriculum,
    };
    let mut bytes = Vec::new();
    write(&imported.content, about, &mut bytes, |_| ()).unwrap();
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

fn back(bytes: &[u8]) -> Result<Imported, ExportError> {
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
        let mut lines = lines.clone();
        lines[at] = line;
        refused(&lines, wrong_at + 1, says);
    };
    let without = |at: usize, wrong_at: usize, says: &str| {
        let mut lines = lines.clone();
        lines.remove(at);
        refused(&lines, wrong_at + 1, says);
    };
    let (schema, end) = (at("schema"), lines.len() - 1);
    without(0, 0, "the first line must be a `pschema` line");
    with(
        0,
        &lines[0].replacen("\"format\":1", "\"format\":2", 1),
        0,
        "format 2, and this release reads formats 1",
    );
    with(0, &lines[0].replace("\"attention\":true,", ""), 0, "missing field `attention`");
    without(schema, schema, "schema 1 stands where schema 0 is next");
    with(schema, &lines[schema].replace("\"finger\"", "\"foot\""), schema, "declares the type \"foot\"");
    with(
        schema,
        &lines[schema].replace("\"primitive\":", "\"primitive\":9"),
        end,
        "refers to something that is not there",
    );
    with(
        schema,
        &lines[schema].replace("\"successes\":", "\"successes\":1"),
        end,
        "a line was changed or lost",
    );
    with(schema, "{\"schema\":1}", schema, "not a line of an export");
    with(schema, "{\"dream\":{}}", schema, "unknown variant `dream`");
    with(schema, lines[at("symbol")], schema, "stands in a line above");
    without(at("generator"), end - 1, &format!("there are {end} lines, and {} were written", end + 1));
    let recounted = lines[end].replace(&format!("\"lines\":{}", end + 1), &format!("\"lines\":{end}"));
    let fewer: Vec<&str> = lines[..end].iter().copied().filter(|line| !line.contains("generator")).collect();
    refused(&[&fewer[..], &[&recounted]].concat(), end, "there is no `generator` line");
    refused(&lines[..schema], schema + 1, "it ends before its `end` line");
    let twice: Vec<&str> = lines.iter().chain(&lines).copied().collect();
    refused(&twice, lines.len() + 1, "something follows");
    let long = format!("{{\"symbol\":{{\"name\":\"{}\"}}}}", "x".repeat(LINE_BYTES_MAX as usize));
    with(at("symbol"), &long, at("symbol"), "longer than 16777216 bytes");
    let deep = "[".repeat(100_000);
    with(schema, &deep, schema, "not a line of an export");
    assert!(back(b"").unwrap_err().to_string().starts_with("line 1: it ends before"));
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
