//! Reads the source of the workspace as far as its imports go, so that a test can compare it with `ARCHITECTURE.md`
//! (`tests/house.rs`). This crate is built on none of ours: the test takes seconds, whatever has changed.
#![forbid(unsafe_code)]

#[cfg(test)]
mod fixtures;
pub mod plan;
pub mod rings;
pub mod source;
pub mod storeys;
pub mod workspace;
