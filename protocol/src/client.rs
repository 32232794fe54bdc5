//! What every tool uses to ask a daemon.

use std::time::{Duration, Instant};

use pschema_process::require_descriptors;

use crate::domain::{DomainError, Place};
use crate::limits::PEER_DESCRIPTORS_NEEDED;
use crate::transport::TransportError;
pub use crate::transport::tool_link::Purpose;
use crate::transport::tool_link::ToolLink;

/// Why a tool got no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ClientError {
    /// The transport, or the daemon's refusal.
    #[error(transparent)]
    Transport(#[from] TransportError),
}

impl ClientError {
    /// Whether there is no daemon to ask: none was started, it is still starting, or it has gone.
    #[must_use]
    pub fn is_no_daemon(&self) -> bool {
        matches!(
            self,
            Self::Transport(
                TransportError::Domain(DomainError::NotServed { .. } | DomainError::Starting { .. })
                    | TransportError::DaemonGone
            )
        )
    }

    /// Whether a request may have been received that was not answered: whether an order was obeyed is then not known.
    #[must_use]
    pub fn is_unanswered(&self) -> bool {
        matches!(self, Self::Transport(TransportError::TimedOut { .. } | TransportError::DaemonGone))
    }
}

/// A connection to a daemon.
///
/// ```no_run
/// use std::time::Duration;
///
/// use pschema_protocol::client::Client;
/// use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
///
/// let place = Place::new(RuntimeDir::from_environment()?, LearnerName::new("demo")?);
/// match Client::connect(&place, Duration::from_secs(5)) {
///     Ok(client) => assert!(client.is_current()),
///     Err(error) if error.is_no_daemon() => println!("start a daemon first"),
///     Err(error) => return Err(error.into()),
/// }
/// # Ok::<_, Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Client {
    link: ToolLink,
    timeout: Duration,
}

/// How soon a daemon that is still starting is tried again.
const RETRY_EVERY: Duration = Duration::from_millis(10);
/// How long a daemon is tried again that has no place, or is being replaced.
const PLACE_PATIENCE: Duration = Duration::from_secs(1);

impl Client {
    /// Connects to the daemon that serves `place`. `timeout` is how long to wait here for one that is still
    /// starting, and later for each page of an answer.
    ///
    /// # Errors
    /// See [`ClientError::is_no_daemon`]; [`TransportError::Full`] when the daemon has its number of tools.
    pub fn connect(place: &Place, timeout: Duration) -> Result<Self, ClientError> {
        Self::connect_for(Purpose::Question, place, timeout)
    }

    /// As [`Client::connect`], for a `purpose`. Connect for an [`Order`](Purpose::Order) only to give one, or to ask one
    /// thing, and leave soon: the places that are kept for it are few.
    ///
    /// # Errors
    /// As [`Client::connect`].
    pub fn connect_for(purpose: Purpose, place: &Place, timeout: Duration) -> Result<Self, ClientError> {
        require_descriptors("a tool", PEER_DESCRIPTORS_NEEDED).map_err(TransportError::from)?;
        let start = Instant::now();
        loop {
            match ToolLink::connect(place, purpose) {
                Ok(link) => return Ok(Self { link, timeout }),
                Err(error) => {
                    let patience = match error {
                        TransportError::Domain(DomainError::Starting { .. }) => timeout,
                        // It was replaced just now; or a dead tool's place is not cleaned up yet.
                        TransportError::Setup { .. } | TransportError::Full { .. } => {
                            timeout.min(PLACE_PATIENCE)
                        }
                        _ => Duration::ZERO,
                    };
                    if start.elapsed() >= patience {
                        return Err(error.into());
                    }
                    std::thread::sleep(RETRY_EVERY);
                }
            }
        }
    }

    /// Asks with bytes and returns those of the answer.
    ///
    /// # Errors
    /// As [`ToolLink::request`].
    pub fn request(&mut self, bytes: &[u8]) -> Result<Vec<u8>, ClientError> {
        Ok(self.link.request(bytes, self.timeout)?)
    }

    /// Whether the daemon connected to still serves the learner.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.link.is_current()
    }
}
