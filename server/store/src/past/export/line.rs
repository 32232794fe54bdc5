//! Lines of an export. After the first, each is an object whose first field is an item of the memory, under the name of its
//! kind. Fields after it are for those who read the file: `id` is the item's number, and `named` says the same as the item
//! with names in place of numbers.

use std::fmt;

use serde::de::{
    DeserializeSeed, Deserializer, EnumAccess, Error, IgnoredAny, MapAccess, VariantAccess, Visitor,
};
use serde::{Deserialize, Serialize, forward_to_deserialize_any};

use super::named::Named;
use crate::format::v1::Item;

/// The first line.
#[derive(Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct FirstLine {
    /// The format, and whose memory it is.
    pub(super) pschema: Header,
}

/// What the first line says.
#[derive(Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct Header {
    /// The version of the format.
    pub(super) format: u32,
    /// The name of the learner.
    pub(super) learner: String,
    /// As text: many readers of JSON can't take so large a number.
    pub(super) seed: String,
    /// The digest of the memory, in hexadecimal.
    pub(super) memory_digest: String,
}

/// Any other line. `I` is an [`Item`] or a reference to one.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct Line<I> {
    #[serde(flatten)]
    pub(super) item: I,
    /// The number that others refer to the item by.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) id: Option<u32>,
    /// Not read back: it follows from the item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) named: Option<Named>,
}

/// The fields that may follow an item.
#[derive(Deserialize)]
#[serde(field_identifier, rename_all = "snake_case")]
enum Aside {
    Id,
    Named,
}

// Written by hand, for `flatten` would take all of a line into memory before it looks at it, and then could not say where in
// the line something is wrong.
impl<'de> Deserialize<'de> for Line<Item> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Fields;

        impl<'de> Visitor<'de> for Fields {
            type Value = Line<Item>;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("an object that begins with an item of a memory")
            }

            fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Line<Item>, M::Error> {
                let item = Item::deserialize(FirstField(&mut map))?;
                let mut id = None;
                while let Some(field) = map.next_key()? {
                    match field {
                        Aside::Id => id = Some(map.next_value()?),
                        Aside::Named => drop(map.next_value::<IgnoredAny>()?),
                    }
                }
                Ok(Line { item, id, named: None })
            }
        }

        from.deserialize_map(Fields)
    }
}

/// The first field of an object as the variant of an enum.
struct FirstField<'m, M>(&'m mut M);

impl<'de, M: MapAccess<'de>> Deserializer<'de> for FirstField<'_, M> {
    type Error = M::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, M::Error> {
        visitor.visit_enum(self)
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 u8 u16 u32 u64 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq
        tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de, M: MapAccess<'de>> EnumAccess<'de> for FirstField<'_, M> {
    type Error = M::Error;
    type Variant = Self;

    fn variant_seed<V: DeserializeSeed<'de>>(self, seed: V) -> Result<(V::Value, Self), M::Error> {
        let variant = self.0.next_key_seed(seed)?;
        Ok((variant.ok_or_else(|| Error::custom("the object has no fields"))?, self))
    }
}

impl<'de, M: MapAccess<'de>> VariantAccess<'de> for FirstField<'_, M> {
    type Error = M::Error;

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, M::Error> {
        self.0.next_value_seed(seed)
    }

    // Items have no variants of these forms.

    fn unit_variant(self) -> Result<(), M::Error> {
        Err(Error::custom("an item without a value"))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, _: V) -> Result<V::Value, M::Error> {
        Err(Error::custom("an item of several values"))
    }

    fn struct_variant<V: Visitor<'de>>(self, _: &'static [&'static str], _: V) -> Result<V::Value, M::Error> {
        Err(Error::custom("an item of several fields"))
    }
}
