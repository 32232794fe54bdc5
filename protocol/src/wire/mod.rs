//! What crosses shared memory: its bytes ([`layout`](self)), the messages that they make ([`message`]), how values become
//! bytes ([`encode`]), and how bytes that a peer sent become values that passed every check ([`decode`], [`check`]).
//!
//! The author of a body in Rust needs none of it. It is for the daemon, for tests of bodies, and for measuring.

mod bounds;
pub mod check;
pub mod decode;
pub mod encode;
mod layout;
pub mod message;
mod observations;
pub mod picture;

pub use layout::*;
pub use observations::{ObservationRecord, Observations};
