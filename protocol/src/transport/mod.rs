//! How messages travel: over iceoryx2, which is named nowhere else. Frames, hellos and questions are requests on
//! request-response services; one event service for each direction wakes a process that waits. Ports are single-threaded.

pub mod body_link;
mod debug;
mod error;
mod gone;
mod held;
mod janitor;
mod payload;
pub mod pictures;
mod replies;
mod reserve;
pub mod server;
mod services;
mod spin;
pub mod tool_link;
mod waker;

pub use error::TransportError;
pub use services::{VERSION, bare_node};
pub use spin::{SPIN_US_MAX, SPIN_VARIABLE, Spin};
pub use waker::DaemonWaker;
