//! Answers to the questions of tools. Pure: a view of the learner in, an answer out. Lists are filtered, ordered and cut
//! here, so that no answer is longer than a tool asked for.

mod claims;
mod explain;
mod goals;
mod graph;
mod live;
mod question;
mod reply;
mod schemas;
mod stage;
mod status;
mod text;
mod trace;
mod why_not;

pub use question::Inspect;
pub use reply::reply;
pub(crate) use reply::{encoded, problem};
pub use schemas::LIST_MAX;
pub use status::report;
