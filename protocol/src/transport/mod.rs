//! How messages travel: iceoryx2, named nowhere else. Request-response services for what is asked and
//! answered, one event service a direction to wake who waits. Ports are single-threaded.

pub mod bare;
pub mod body_link;
mod debug;
mod error;
mod gone;
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
pub use services::VERSION;
pub use spin::{SPIN_US_MAX, SPIN_VARIABLE, Spin};
pub use waker::DaemonWaker;
