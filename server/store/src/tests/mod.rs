//! Tests of the store as a whole, and the disk that they lose power on.

mod claims;
mod forged;
mod golden;
mod journal;
mod keeping;
mod places;
mod profile;
mod sizes;
mod slow;
pub(crate) mod store;
pub(crate) mod twin;
