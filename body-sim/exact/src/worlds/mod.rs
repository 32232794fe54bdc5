//! The worlds, one a file but for those that differ in numbers only.

pub(crate) mod blocks;
pub(crate) mod cart;
pub(crate) mod grid;
pub(crate) mod gripper;
pub(crate) mod hand_eye;
pub(crate) mod hidden;
pub(crate) mod posture;
pub(crate) mod push;
pub(crate) mod puzzle;
pub(crate) mod table;
pub(crate) mod towers;
pub(crate) mod toys;
