#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod body;
mod catalogue;
pub mod declaration;
mod distribution;
pub mod tables;
mod world;
mod worlds;

pub use body::ExactBody;
pub use catalogue::{Entry, Number, WORLDS, WorldError, kind, names, open};
pub use distribution::{Distribution, chances};
pub use world::{Situation, World, situation};
