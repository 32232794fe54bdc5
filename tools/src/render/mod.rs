//! Turns answers of a daemon into text for people, pictures and metrics. Pure: values in, text out.

pub(crate) mod claims;
pub(crate) mod explanation;
pub(crate) mod goals;
pub(crate) mod graph;
pub(crate) mod journal;
pub(crate) mod metrics;
pub(crate) mod past_status;
pub(crate) mod schema;
pub(crate) mod statistics;
pub(crate) mod status;
pub(crate) mod story;
pub(crate) mod table;
pub(crate) mod time;
pub(crate) mod why_not;
pub(crate) mod words;

#[cfg(test)]
mod tests;
