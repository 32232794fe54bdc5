//! Items with names in place of numbers, for those who read an export.

use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::{Observation, PropertyId, Value};
use pschema_learner::schema::{Form, ObservationId, Schema};
use pschema_learner::vocabulary::{PrimitiveId, ValueKind, Vocabulary, bin_middle};
use serde::Serialize;
use serde_json::Map;

use crate::format::v1::Kind;

/// An item with names in place of numbers.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(super) enum Named {
    /// A primitive, as it prints.
    Primitive(String),
    /// An observation.
    Observation {
        /// Its observation type.
        #[serde(rename = "type")]
        kind: String,
        /// Its properties with their values; a real is the middle of its bin.
        properties: Map<String, serde_json::Value>,
    },
    /// A schema: its observations or patterns as they print, in the order in which the item has them.
    Schema {
        /// Its pre-conditions.
        pre: Vec<String>,
        /// Of a concrete schema.
        #[serde(skip_serializing_if = "Option::is_none")]
        action: Option<String>,
        /// Of a generalised schema.
        #[serde(skip_serializing_if = "Option::is_none")]
        target: Option<Vec<String>>,
        /// Its post-conditions.
        post: Vec<String>,
        /// The observations that it is associated with.
        associated: Vec<String>,
    },
}

impl Named {
    /// The item of this kind and number; none unless it refers to others by number and is often looked at.
    pub(super) fn of(content: &Content, kind: Kind, number: u32) -> Option<Self> {
        let at = usize::try_from(number).ok()?;
        match kind {
            Kind::Primitive => {
                Some(Self::Primitive(notation::primitive(&content.vocabulary, PrimitiveId(number))))
            }
            Kind::Observation => Some(observation(&content.vocabulary, content.observations.get(at)?)),
            Kind::Schema => Some(schema(content, content.schemas.get(at)?)),
            _ => None,
        }
    }
}

fn observation(vocabulary: &Vocabulary, observation: &Observation) -> Named {
    let kind = vocabulary.types().get(usize::from(observation.kind().0));
    let property = |(property, seen): &(PropertyId, Value)| {
        let name = vocabulary.properties().get(usize::from(property.0)).cloned().unwrap_or_default();
        (name, value(vocabulary, *property, *seen))
    };
    Named::Observation {
        kind: kind.map(|known| known.declared.name.clone()).unwrap_or_default(),
        properties: observation.properties().iter().map(property).collect(),
    }
}

fn value(vocabulary: &Vocabulary, property: PropertyId, value: Value) -> serde_json::Value {
    match value {
        Value::Integer(number) => number.into(),
        Value::Boolean(value) => value.into(),
        Value::Symbol(symbol) => {
            let name = usize::try_from(symbol.0).ok().and_then(|at| vocabulary.symbols().get(at));
            name.map(String::as_str).into()
        }
        // The middle of the bin.
        Value::Bin(bin) => match vocabulary.property_kind(property) {
            Some(ValueKind::Real { resolution }) => bin_middle(bin, *resolution).into(),
            _ => bin.into(),
        },
    }
}

fn schema(content: &Content, schema: &Schema) -> Named {
    let vocabulary = &content.vocabulary;
    let known = |id: &ObservationId| notation::observation(vocabulary, content.observation(*id));
    let associated = schema.associations.iter().map(|one| known(&one.observation)).collect();
    match &schema.form {
        Form::Concrete(form) => Named::Schema {
            pre: form.pre.iter().map(known).collect(),
            action: Some(notation::primitive(vocabulary, form.action)),
            target: None,
            post: form.post.iter().map(|post| known(&post.what)).collect(),
            associated,
        },
        Form::Generalised(form) => {
            let lifted = |pattern| notation::pattern(vocabulary, pattern);
            Named::Schema {
                pre: form.pre.iter().map(lifted).collect(),
                action: None,
                target: Some(form.target.iter().map(lifted).collect()),
                post: form.post.iter().map(|post| lifted(&post.what)).collect(),
                associated,
            }
        }
    }
}
