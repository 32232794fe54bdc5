//! Descriptions of the types whose JSON is not what their declaration says.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};

use crate::notation::{NamedValues, ValueText};
use crate::stage::StageState;

impl JsonSchema for NamedValues {
    fn schema_name() -> Cow<'static, str> {
        "NamedValues".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut schema = <BTreeMap<String, ValueText>>::json_schema(generator);
        schema.insert("description".to_owned(), "Names with values, in their order.".into());
        schema
    }
}

impl JsonSchema for StageState {
    fn schema_name() -> Cow<'static, str> {
        "StageState".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "What a curriculum is doing: one of a few words, or `stuck: ` and why.",
            "type": "string",
            "pattern": "^(acting|saturated|habituating|held|finished|waiting for a body|stuck: .*)$",
        })
    }
}
