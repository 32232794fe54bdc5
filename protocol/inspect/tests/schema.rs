//! The files in `schema` are what the types say of themselves. After a change of a type, `UPDATE_EXPECT=1` writes them anew:
//! read the difference, for field names are promised to keep their meaning.

#![allow(clippy::unwrap_used)] // A test panics to fail.

use std::collections::BTreeSet;
use std::path::Path;

use expect_test::expect_file;
use pschema_inspect::{
    ClaimList, Explanation, Graph, Live, Plan, Prediction, Pursuit, Report, Request, SchemaDetail,
    SchemaList, Status, TracePage, WhyNot,
};
use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};

/// What is written by a daemon, and by `--json`.
fn written<T: JsonSchema>() -> Schema {
    SchemaSettings::default().for_serialize().into_generator().into_root_schema_for::<T>()
}

/// What is read by a daemon.
fn read<T: JsonSchema>() -> Schema {
    SchemaSettings::default().for_deserialize().into_generator().into_root_schema_for::<T>()
}

#[test]
fn the_files_are_what_the_types_say() {
    let schemas = [
        ("achieve", written::<Pursuit>()),
        ("claims", written::<ClaimList>()),
        ("explain", written::<Explanation>()),
        ("graph", written::<Graph>()),
        ("live", written::<Live>()),
        ("plan", written::<Plan>()),
        ("predict", written::<Prediction>()),
        ("request", read::<Request>()),
        ("say", written::<Report>()),
        ("schemas", written::<SchemaList>()),
        ("show", written::<SchemaDetail>()),
        ("stage", written::<Report>()),
        ("status", written::<Status>()),
        ("trace", written::<TracePage>()),
        ("why-not", written::<WhyNot>()),
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
