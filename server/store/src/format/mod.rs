//! The types that are on disk, one module for each version of the format. A version that was released is never
//! changed: a new one is added beside it, and every release reads all of them.

pub(crate) mod mirror;
pub(crate) mod v1;

/// The version that is written.
pub(crate) const VERSION: u32 = 1;
