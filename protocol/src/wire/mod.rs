//! The messages that cross shared memory: the structures that they are made of, the same messages as plain values
//! ([`message`]), how values become structures ([`encode`]), and how structures that a peer sent become values that have
//! passed every check ([`decode`], [`check`]).
//!
//! The author of a body in Rust needs none of this. It is for the daemon, for tests of bodies, and for measuring.

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
