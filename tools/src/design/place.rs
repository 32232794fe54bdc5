//! Where something stands in a file of settings.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A file of settings with the places of its keys and values, in bytes from its beginning.
pub(super) struct Places<'a>(DeTable<'a>);

impl<'a> Places<'a> {
    /// The places in a text.
    pub(super) fn of(text: &'a str) -> Self {
        Self(DeTable::parse(text).map(Spanned::into_inner).unwrap_or_default())
    }

    /// The place of the value to which these keys and indices lead; the beginning of the file where there is none.
    pub(super) fn value(&self, way: &[&str]) -> Range<usize> {
        self.find(way).map_or(0..0, |(_, value)| value)
    }

    /// The place of the last of these keys.
    pub(super) fn key(&self, way: &[&str]) -> Range<usize> {
        self.find(way).map_or(0..0, |(key, _)| key)
    }

    fn find(&self, way: &[&str]) -> Option<(Range<usize>, Range<usize>)> {
        let (first, rest) = way.split_first()?;
        let (mut key, mut value) = self.0.get_key_value(*first).map(|(key, value)| (key.span(), value))?;
        for step in rest {
            (key, value) = match value.get_ref() {
                DeValue::Table(table) => {
                    table.get_key_value(*step).map(|(key, value)| (key.span(), value))?
                }
                DeValue::Array(list) => {
                    list.get(step.parse::<usize>().ok()?).map(|value| (value.span(), value))?
                }
                _ => return None,
            };
        }
        Some((key, value.span()))
    }
}
