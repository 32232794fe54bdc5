//! The wire between the learner daemon, bodies and tools.
//!
//! A body implements [`body::Body`] and calls [`body::run_from_args`]; a tool uses [`client::Client`]; the
//! daemon serves [`transport::server::ServerTransport`]. `docs/PROTOCOL.md` has the bytes.

pub mod body;
mod bounds;
pub mod check;
pub mod client;
pub mod codec;
pub mod decode;
pub mod description;
pub mod domain;
pub mod encode;
pub mod limits;
pub mod message;
pub mod observed;
pub mod picture;
pub mod refusal;
pub mod transport;
pub mod wire;
