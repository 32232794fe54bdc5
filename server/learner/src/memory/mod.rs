//! Memory: what is known ([`Content`]), the indexes that make it fast to ask, and [`Memory::apply`], the only thing that
//! changes it.

pub(crate) mod apply;
mod check;
pub mod chunks;
pub(crate) mod content;
pub mod digest;
pub(crate) mod draft;
pub mod evidence;
pub(crate) mod groups;
pub(crate) mod index;
pub(crate) mod instance;
pub(crate) mod matching;
pub mod notation;
pub(crate) mod outline;
pub(crate) mod pages;
pub(crate) mod shape;

pub use apply::Memory;
pub use content::Content;
