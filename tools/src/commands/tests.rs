//! The files in `schema` are what the types say that `--json` prints of them.

use std::collections::BTreeSet;
use std::path::Path;

use expect_test::expect_file;
use pschema_store::past::Verification;
use pschema_store::past::export::ExportLine;
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

use super::conformance::Conformance;
use super::doctor::Findings;
use super::import::ImportReport;
use super::journal::JournalLine;
use super::repair::RepairReport;
use super::replay::ReplayReport;
use crate::record::{RecordingEntry, RecordingSummary};
use crate::render::past_status::PastStatus;
use crate::run::Results;

fn printed<T: JsonSchema>() -> Schema {
    SchemaSettings::default().for_serialize().into_generator().into_root_schema_for::<T>()
}

/// Field names are promised to keep their meaning: read the difference before you accept it.
#[test]
fn the_schema_files_are_what_the_types_say() {
    let schemas = [
        ("conformance", printed::<Conformance<'_>>()),
        ("doctor", printed::<Findings>()),
        ("experiment", printed::<Results>()),
        ("export", printed::<ExportLine>()),
        ("import", printed::<ImportReport>()),
        ("journal", printed::<JournalLine<'_>>()),
        ("record", printed::<RecordingSummary>()),
        ("record-jsonl", printed::<RecordingEntry<'_>>()),
        ("repair", printed::<RepairReport<'_>>()),
        ("replay", printed::<ReplayReport>()),
        ("status-data", printed::<PastStatus<'_>>()),
        ("verify", printed::<Verification>()),
    ];
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schema");
    for (name, schema) in &schemas {
        let written = serde_json::to_string_pretty(schema).unwrap() + "\n";
        expect_file![folder.join(format!("{name}.json"))].assert_eq(&written);
    }
    let known: BTreeSet<_> = schemas.iter().map(|(name, _)| format!("{name}.json")).collect();
    let files = std::fs::read_dir(&folder).unwrap();
    let files: BTreeSet<_> = files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    assert_eq!(files, known, "each file is of a type");
}
