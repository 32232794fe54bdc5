//! The description of a line of an export.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use super::line::{FirstLine, Line};
use crate::format::v1::Item;

/// A line of an export, to be described as a JSON Schema. The types of its items are frozen, and nobody else's to use.
#[derive(Clone, Copy, Debug)]
pub struct ExportLine;

impl JsonSchema for ExportLine {
    fn schema_name() -> Cow<'static, str> {
        "ExportLine".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The first line of an export says whose memory it is; each other line is one item of the memory.",
            "anyOf": [FirstLine::json_schema(generator), Line::<Item>::json_schema(generator)],
        })
    }
}
