//! The handles by which the daemon replies when it is ready to, and the answers that are on their way to tools.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::SendError;

use super::debug::opaque_debug;
use super::held::{ActiveFrame, ActiveHello, ActiveTool, Held};
use super::services::PAGES_IN_FLIGHT;
use super::waker::{PeerWaker, REPLIED};
use crate::limits::{ANSWER_BYTES_MAX, PAGE_BYTES, PAGES_MAX};
use crate::refusal::Refusal;
use crate::wire::message::Reply;
use crate::wire::{Page, Welcome, encode};

/// How long a tool may leave an answer unread before the answer is dropped.
const ANSWER_PATIENCE: Duration = Duration::from_secs(5);

/// A body that is attached: its session, its process's node, and its wake number.
#[derive(Debug)]
pub(super) struct Attachment {
    pub(super) session: u64,
    pub(super) node: UniqueNodeId,
    pub(super) wake: u64,
}

pub(super) type Bodies = Rc<RefCell<Vec<Attachment>>>;
pub(super) type Outbox = Rc<RefCell<Vec<Outgoing>>>;

pub(super) fn log_undelivered(result: Result<(), DeliveryError>) {
    if let Err(error) = result {
        tracing::debug!(%error, "not delivered");
    }
}

/// A reply did not reach its peer. Mostly the peer has gone.
#[derive(Debug, thiserror::Error)]
#[error("the peer could not be reached: {0}")]
pub struct DeliveryError(String);

impl DeliveryError {
    fn of(error: SendError) -> Self {
        Self(format!("{error:?}"))
    }

    fn gone() -> Self {
        Self("it has left".to_owned())
    }
}

/// The handle to welcome or refuse a body. It may be kept and used later. If it is dropped unused, the body tries again.
pub struct AttachReply {
    pub(super) held: Held<ActiveHello>,
    pub(super) node: UniqueNodeId,
    pub(super) wake: u64,
    pub(super) waker: Rc<PeerWaker>,
    pub(super) bodies: Bodies,
}

impl AttachReply {
    /// Opens `session` (above zero, not used before) for the body.
    ///
    /// # Errors
    /// [`DeliveryError`] when the body has gone; the session is not open then.
    pub fn accept(self, session: u64, learner: &str) -> Result<(), DeliveryError> {
        self.bodies.borrow_mut().push(Attachment { session, node: self.node, wake: self.wake });
        let sent = self.send(encode::welcome(session, learner));
        if sent.is_err() {
            self.bodies.borrow_mut().retain(|body| body.session != session);
        }
        sent
    }

    /// Tells the body why it is not welcome.
    ///
    /// # Errors
    /// [`DeliveryError`] when the body has gone.
    pub fn refuse(self, refusal: &Refusal, learner: &str) -> Result<(), DeliveryError> {
        self.send(encode::unwelcome(refusal, learner))
    }

    fn send(&self, welcome: Welcome) -> Result<(), DeliveryError> {
        let active = self.held.of_waiting_client().ok_or_else(DeliveryError::gone)?;
        let sent = active.send_copy(Welcome { wake: self.wake, ..welcome }).map_err(DeliveryError::of);
        self.waker.wake(self.wake, REPLIED);
        sent
    }
}

/// The handle to reply to a frame. It may be kept until the step is durable. If it is dropped unused, the body attaches again.
pub struct FrameReply {
    pub(super) held: Held<ActiveFrame>,
    pub(super) session: u64,
    pub(super) sequence: u64,
    pub(super) wake: u64,
    pub(super) waker: Rc<PeerWaker>,
}

impl FrameReply {
    /// The session the frame claims to be of.
    #[must_use]
    pub fn session(&self) -> u64 {
        self.session
    }

    /// Sends the reply and wakes the body.
    ///
    /// # Errors
    /// [`DeliveryError`] when the body has gone.
    pub fn send(self, reply: &Reply) -> Result<(), DeliveryError> {
        let active = self.held.of_waiting_client().ok_or_else(DeliveryError::gone)?;
        let sent = active.send_copy(encode::reply(self.session, self.sequence, reply));
        self.waker.wake(self.wake, REPLIED);
        sent.map_err(DeliveryError::of)
    }

    /// Tells the body why its frame was not taken.
    ///
    /// # Errors
    /// [`DeliveryError`] when the body has gone.
    pub fn refuse(self, refusal: &Refusal) -> Result<(), DeliveryError> {
        self.send(&Reply::Refused { code: refusal.code(), reason: refusal.to_string() })
    }
}

/// The handle to answer a tool. It may be kept and used later. If it is dropped unused, the tool learns that there is no
/// answer.
pub struct RequestReply {
    pub(super) held: Held<ActiveTool>,
    pub(super) request: u64,
    pub(super) wake: u64,
    pub(super) waker: Rc<PeerWaker>,
    pub(super) outbox: Outbox,
}

impl RequestReply {
    /// Answers. Pages for which there is no room are sent as the tool reads on; an answer that is left unread for 5 s is
    /// dropped. An answer longer than [`ANSWER_BYTES_MAX`] becomes a refusal.
    pub fn answer(self, bytes: Vec<u8>) {
        if bytes.len() > ANSWER_BYTES_MAX {
            let reason =
                format!("the answer has {} bytes, at most {ANSWER_BYTES_MAX} fit: ask for less", bytes.len());
            return self.refuse(&Refusal::Unwilling { reason });
        }
        self.send(bytes, 0);
    }

    /// Tells the tool why there is no answer.
    pub fn refuse(self, refusal: &Refusal) {
        self.send(refusal.to_string().into_bytes(), refusal.code());
    }

    fn send(self, bytes: Vec<u8>, code: u32) {
        let Self { held, request, wake, waker, outbox } = self;
        let deadline = Instant::now() + ANSWER_PATIENCE;
        let mut outgoing = Outgoing { held, request, wake, code, bytes, next: 0, deadline };
        if outgoing.push(&waker) {
            outbox.borrow_mut().push(outgoing);
        }
    }
}

opaque_debug!(AttachReply, FrameReply, RequestReply);

/// An answer on its way, page by page.
pub(super) struct Outgoing {
    held: Held<ActiveTool>,
    request: u64,
    wake: u64,
    code: u32,
    bytes: Vec<u8>,
    next: usize,
    deadline: Instant,
}

impl Outgoing {
    /// Sends as many pages as find room. Returns whether more are left and the tool is still there.
    pub(super) fn push(&mut self, waker: &PeerWaker) -> bool {
        let pages = self.bytes.len().div_ceil(PAGE_BYTES).max(1);
        debug_assert!(pages <= PAGES_MAX, "{pages} pages");
        let before = self.next;
        let Some(active) = self.held.of_waiting_client() else {
            tracing::debug!(page = self.next, pages, "an answer was dropped: its tool has left");
            return false;
        };
        while self.next < pages {
            match active.send_copy(self.page(pages)) {
                Ok(()) => self.next += 1,
                Err(SendError::UnableToDeliver | SendError::LoanError(_)) => break,
                Err(error) => {
                    tracing::debug!(?error, "an answer could not be sent");
                    return false;
                }
            }
        }
        if self.next > before {
            self.deadline = Instant::now() + ANSWER_PATIENCE;
            waker.wake(self.wake, REPLIED);
        } else if Instant::now() > self.deadline {
            tracing::debug!(page = self.next, pages, "an answer left unread was dropped");
            return false;
        }
        self.next < pages
    }

    fn page(&self, pages: usize) -> Page {
        let rest = self.bytes.get(self.next * PAGE_BYTES..).unwrap_or_default();
        let mut page = encode::page(self.request, (self.next, pages), rest);
        page.code = self.code;
        page
    }
}

const _: () = assert!(PAGES_IN_FLIGHT >= 1);
