//! What tools ask of a learner, and what it answers.
//!
//! A [`Request`] is a [`Question`], which changes nothing, or an [`Order`]. Each kind of question and each kind of order
//! is a type that names the type of its answer ([`Ask`]). Requests and answers travel as JSON ([`codec`]), and the JSON
//! of an answer is what `pschema --json` prints: field names are stable and carry their units. The folder `schema` has a
//! JSON Schema for each of them.
//!
//! [`ask()`] asks by whatever carries bytes; `pschema_protocol::client::Client` is what carries them to a daemon.
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod ask;
mod claims;
mod closed_set;
pub mod codec;
mod decision;
#[cfg(feature = "schema")]
mod described;
mod goals;
mod graph;
mod live;
mod notation;
mod number;
mod request;
mod schema;
mod stage;
mod status;
mod trace;
mod warning;
mod why_not;

pub use ask::{AskError, ask};
pub use claims::*;
pub use decision::*;
pub use goals::*;
pub use graph::*;
pub use live::*;
pub use notation::*;
pub use request::*;
pub use schema::*;
pub use stage::*;
pub use status::*;
pub use trace::*;
pub use warning::*;
pub use why_not::*;
