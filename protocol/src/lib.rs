//! The wire between the learner daemon, bodies and tools.
//!
//! A body implements [`body::Body`] and calls [`body::run_from_args`]; a tool uses [`client::Client`]; the
//! daemon serves [`transport::server::ServerTransport`]. `docs/PROTOCOL.md` has the bytes.

pub mod body;
pub mod client;
pub mod codec;
pub mod description;
pub mod domain;
pub mod limits;
pub mod picture;
pub mod refusal;
pub mod transport;
pub mod wire;
