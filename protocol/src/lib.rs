#![doc = include_str!("../README.md")]
#![deny(missing_docs)]

pub mod body;
pub mod client;
pub mod description;
pub mod domain;
pub mod limits;
mod outcome;
pub mod picture;
pub mod prelude;
pub mod refusal;
#[doc(hidden)]
pub mod transport;
#[doc(hidden)]
pub mod wire;

pub use transport::TransportError;
