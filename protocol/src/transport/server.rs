//! The daemon's end. It hands each message out with a handle, by which the daemon replies when it is ready to.

use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::*;

use super::debug::opaque_debug;
use super::error::setup;
use super::held::{Active, ActiveFrame, ActiveHello, ActiveTool, Clients};
use super::janitor::Janitor;
pub use super::replies::{AttachReply, DeliveryError, FrameReply, RequestReply};
use super::replies::{Bodies, Outbox, log_undelivered};
use super::reserve::{close_to_others, reserve};
use super::services::{
    self, AttachServer, FrameServer, FrameService, Ipc, PictureService, Role, ToolServer, WakeListener,
};
use super::waker::{PeerWaker, ROUSED};
use super::{DaemonWaker, Spin, TransportError};
use crate::domain::OwnedDomain;
use crate::limits::{BODIES_MAX, OBSERVATIONS_MAX, PAGE_BYTES, PRIMITIVES_MAX};
use crate::refusal::Refusal;
use crate::wire::message::{RawFrame, RawHello, Reply};
use crate::wire::{FrameHeader, Page, Reason, decode, purpose};

/// How often the transport looks whether the attached bodies still live.
const CHECK_EVERY: Duration = Duration::from_millis(50);
/// How soon pages that found no room are sent again, should the tool not ask for them before.
const RETRY_EVERY: Duration = Duration::from_millis(5);

/// A message that came in, or the end of a body.
#[derive(Debug)]
pub enum Incoming<'a> {
    /// A body introduces itself. Check it with [`decode::hello`].
    Hello {
        /// The description that the body claims.
        hello: RawHello,
        /// The handle to welcome or refuse it.
        reply: AttachReply,
    },
    /// A frame of an attached body, in its own session. Check it with [`decode::SessionChecks`].
    Frame {
        /// The frame as the body claims it.
        frame: &'a RawFrame,
        /// The handle to reply.
        reply: FrameReply,
    },
    /// A tool asks a question or gives an order.
    Request {
        /// The question or order, encoded.
        bytes: Vec<u8>,
        /// The handle to answer.
        reply: RequestReply,
    },
    /// The transport refused a message, and told its sender why. The daemon counts it.
    Refused {
        /// The session of the process that sent it, whatever session the message claims; none for a tool, and
        /// for a process that has no session.
        session: Option<u64>,
        /// Why.
        refusal: Refusal,
    },
    /// A body has gone: it said farewell, or its process has ended. Its session is closed.
    BodyGone {
        /// The session that is closed.
        session: u64,
        /// Whether the body said farewell.
        farewell: bool,
    },
}

/// The daemon's end of a domain. Dropping it ends the epoch and removes every file of it.
pub struct ServerTransport {
    // Dropped in this order: ports, then their node, then the domain they were in.
    attach: AttachServer,
    frames: FrameServer,
    tools: ToolServer,
    listener: WakeListener,
    waker: Rc<PeerWaker>,
    outbox: Outbox,
    bodies: Bodies,
    frame_service: Rc<FrameService>,
    attach_clients: Rc<Clients<ActiveHello>>,
    frame_clients: Rc<Clients<ActiveFrame>>,
    tool_clients: Rc<Clients<ActiveTool>>,
    /// Kept open and not used: bodies and tools meet on this service.
    _pictures: PictureService,
    frame: RawFrame,
    next_check: Instant,
    spin: Spin,
    /// Whether a message came since the transport last slept.
    happened: bool,
    woken: Arc<AtomicBool>,
    _janitor: Janitor,
    _node: Node<Ipc>,
    domain: OwnedDomain,
}

opaque_debug!(ServerTransport);

impl ServerTransport {
    /// Opens the services of a domain. From then on bodies and tools can connect.
    ///
    /// # Errors
    /// [`TransportError::SharedMemory`] when there is not enough of it, [`TransportError::Setup`] when
    /// iceoryx2 refuses.
    pub fn create(mut domain: OwnedDomain) -> Result<Self, TransportError> {
        let (place, record) = (domain.place(), domain.record());
        let node = services::node::<Ipc>(place, record, "daemon")?;
        close_to_others(&record.prefix)?;
        let wake_daemon = services::wake_daemon(&node, Role::Daemon)?;
        let wake_peers = services::wake_peers(&node, Role::Daemon)?;
        let listener =
            wake_daemon.listener_builder().create().map_err(setup("create the daemon's listener"))?;
        let waker = wake_peers.notifier_builder().create().map_err(setup("create the peers' waker"))?;
        let attach_service = services::attach(&node, Role::Daemon)?;
        let attach = attach_service.server_builder().set_backpressure_handler(services::fail_when_full);
        let attach = attach.create().map_err(setup("create the attach server"))?;
        let tool_service = services::tools(&node, Role::Daemon)?;
        let tools = tool_service.server_builder().max_loaned_responses_per_request(1);
        let tools = tools.set_backpressure_handler(services::fail_when_full);
        let tools = tools.create().map_err(setup("create the tool server"))?;
        let frame_service = Rc::new(services::frames(&node, Role::Daemon)?);
        let frames = frame_service.server_builder().set_backpressure_handler(services::fail_when_full);
        let frames = frames.create().map_err(setup("create the frame server"))?;
        let pictures = services::pictures(&node, Role::Daemon)?;
        // Before the janitor's thread makes files of its own.
        domain.note_files()?;
        let (place, record) = (domain.place(), domain.record());
        let janitor = Janitor::start(place, record)?;
        reserve(&record.prefix, None)?;
        // Announced last: a peer that connects now finds every port.
        domain.announce()?;
        Ok(Self {
            attach,
            frames,
            tools,
            listener,
            waker: Rc::new(PeerWaker::new(waker)),
            outbox: Outbox::default(),
            bodies: Bodies::default(),
            attach_clients: Clients::new(move |client| has_client!(attach_service, client)),
            frame_clients: Clients::new({
                let frame_service = Rc::clone(&frame_service);
                move |client| has_client!(frame_service, client)
            }),
            tool_clients: Clients::new(move |client| has_client!(tool_service, client)),
            frame_service,
            _pictures: pictures,
            frame: RawFrame { records: Vec::with_capacity(OBSERVATIONS_MAX), ..RawFrame::default() },
            next_check: Instant::now(),
            spin: Spin::usual(),
            happened: false,
            woken: Arc::default(),
            _janitor: janitor,
            _node: node,
            domain,
        })
    }

    /// The domain served.
    #[must_use]
    pub fn domain(&self) -> &OwnedDomain {
        &self.domain
    }

    /// A waker, by which another thread ends a wait of this transport.
    ///
    /// # Errors
    /// [`TransportError::Setup`] when iceoryx2 refuses.
    pub fn waker(&self) -> Result<DaemonWaker, TransportError> {
        DaemonWaker::create(self.domain.place(), self.domain.record(), self.woken.clone())
    }

    /// Makes the transport poll as long as `spin` says, instead of the usual time.
    pub fn set_spin(&mut self, spin: Spin) {
        self.spin = spin;
    }

    /// Waits until a message comes in, a waker is used, or `timeout` has passed. It polls first if a message came lately, then
    /// sleeps. Returns whether [`ServerTransport::poll`] has anything to do.
    pub fn wait(&mut self, timeout: Duration) -> bool {
        let start = Instant::now();
        let mut now = start;
        // Counted from now: the daemon may have worked on the last message for long.
        if std::mem::take(&mut self.happened) {
            self.spin.happened(now);
        }
        loop {
            if self.is_pending() {
                self.happened = true;
                return true;
            }
            // The flag is taken before the state that it announces is looked at: a waker used from here on sets it again.
            if self.woken.swap(false, Ordering::AcqRel) {
                self.happened = true;
                return self.has_more(now);
            }
            if now.duration_since(start) >= timeout || !self.spin.goes_on(now) {
                break;
            }
            std::hint::spin_loop();
            now = Instant::now();
        }
        let mut timeout = timeout.saturating_sub(now.duration_since(start));
        timeout = timeout.min(self.next_check.saturating_duration_since(now));
        if !self.outbox.borrow().is_empty() {
            timeout = timeout.min(RETRY_EVERY);
        }
        if !timeout.is_zero()
            && let Err(error) = self.listener.timed_wait(|_| {}, timeout)
        {
            // A signal came; the caller looks at its flags.
            tracing::trace!(?error, "woken");
        }
        let pending = self.is_pending();
        self.happened = self.woken.swap(false, Ordering::AcqRel) || pending;
        pending || self.has_more(Instant::now())
    }

    fn has_more(&self, now: Instant) -> bool {
        !self.outbox.borrow().is_empty() || now >= self.next_check
    }

    fn is_pending(&self) -> bool {
        // An error concerns one client that cannot be connected to: the others are served.
        self.frames.has_requests().unwrap_or(true)
            || self.attach.has_requests().unwrap_or(true)
            || self.tools.has_requests().unwrap_or(true)
    }

    /// Hands every message that came in to `on`, and sends more pages of answers that wait for room. This never blocks.
    pub fn poll(&mut self, on: &mut dyn FnMut(Incoming<'_>)) {
        self.frame_clients.begin_turn();
        self.attach_clients.begin_turn();
        self.tool_clients.begin_turn();
        self.poll_frames(on);
        self.poll_hellos(on);
        self.poll_tools(on);
        self.outbox.borrow_mut().retain_mut(|one| one.push(&self.waker));
        if Instant::now() >= self.next_check {
            self.next_check = Instant::now() + CHECK_EVERY;
            self.attach_clients.sweep();
            self.frame_clients.sweep();
            self.tool_clients.sweep();
            self.check_bodies(on);
        }
    }

    fn poll_frames(&mut self, on: &mut dyn FnMut(Incoming<'_>)) {
        // No more than all bodies together can have sent, so that none keeps the daemon from other work.
        let mut rest = 0..BODIES_MAX;
        while let Some(active) = next(&mut rest, || self.frames.receive(), Active::is_connected) {
            // This is the one copy: whatever the body writes from here on, it changes nothing that is checked.
            let header = *active.user_header();
            let claimed = usize::try_from(header.observation_count).unwrap_or(usize::MAX);
            self.frame.header = header;
            self.frame.records.clear();
            let records = active.payload().records.get(..claimed.min(OBSERVATIONS_MAX));
            self.frame.records.extend_from_slice(records.unwrap_or_default());
            self.frame.reason = if header.has_reason() { active.payload().reason } else { Reason::default() };
            let FrameHeader { session, sequence, wake, .. } = header;
            let own = self.session_of(&active.header().node_id());
            let held = self.frame_clients.hold(active);
            let reply = FrameReply { held, session, sequence, wake, waker: self.waker.clone() };
            match admit(own, &header) {
                Err(refusal) => {
                    log_undelivered(reply.refuse(&refusal));
                    on(Incoming::Refused { session: own, refusal });
                }
                Ok(()) if header.purpose == purpose::DETACH => {
                    self.bodies.borrow_mut().retain(|body| body.session != session);
                    log_undelivered(reply.send(&Reply::Detach));
                    on(Incoming::BodyGone { session, farewell: true });
                }
                Ok(()) => on(Incoming::Frame { frame: &self.frame, reply }),
            }
        }
    }

    /// The session of the process that has this node; none if it has no session.
    fn session_of(&self, node: &UniqueNodeId) -> Option<u64> {
        self.bodies.borrow().iter().find(|body| body.node == *node).map(|body| body.session)
    }

    /// Rouses a body that rests after a `wait` reply, so that it sends a fresh frame now. If it does not rest just then, its next
    /// rest is cut short.
    pub fn rouse(&self, session: u64) {
        let wake = self.bodies.borrow().iter().find(|body| body.session == session).map(|body| body.wake);
        if let Some(wake) = wake {
            self.waker.wake(wake, ROUSED);
        }
    }

    /// Hands out introductions. A process has one session. If it introduces itself again, its session before ends: the process
    /// could not use it beside the new one, and it would take a body's place.
    fn poll_hellos(&self, on: &mut dyn FnMut(Incoming<'_>)) {
        let mut rest = 0..BODIES_MAX;
        while let Some(active) = next(&mut rest, || self.attach.receive(), Active::is_connected) {
            if let Some(session) = self.session_of(&active.header().node_id()) {
                self.bodies.borrow_mut().retain(|body| body.session != session);
                on(Incoming::BodyGone { session, farewell: false });
            }
            let head = Box::new(active.payload().head);
            let claimed = usize::try_from(head.primitive_count).unwrap_or(usize::MAX);
            let primitives = active.payload().primitives.iter().take(claimed.min(PRIMITIVES_MAX));
            let hello = RawHello { primitives: primitives.copied().collect(), head };
            let reply = AttachReply {
                node: active.header().node_id(),
                wake: hello.head.wake,
                held: self.attach_clients.hold(active),
                waker: self.waker.clone(),
                bodies: self.bodies.clone(),
            };
            on(Incoming::Hello { hello, reply });
        }
    }

    fn poll_tools(&self, on: &mut dyn FnMut(Incoming<'_>)) {
        let mut rest = 0..services::TOOL_PLACES;
        while let Some(active) = next(&mut rest, || self.tools.receive(), Active::is_connected) {
            let page = *active.payload();
            let reply = RequestReply {
                held: self.tool_clients.hold(active),
                request: page.request,
                wake: page.wake,
                waker: self.waker.clone(),
                outbox: self.outbox.clone(),
            };
            match single_page(&page) {
                Ok(bytes) => on(Incoming::Request { bytes: bytes.to_vec(), reply }),
                Err(refusal) => {
                    reply.refuse(&refusal);
                    on(Incoming::Refused { session: None, refusal });
                }
            }
        }
    }

    /// Closes the sessions of bodies that have gone: the janitor has removed their ports, or they dropped them.
    fn check_bodies(&self, on: &mut dyn FnMut(Incoming<'_>)) {
        if self.bodies.borrow().is_empty() {
            return;
        }
        let mut alive = Vec::new();
        self.frame_service.dynamic_config().list_clients(|client| {
            alive.push(client.node_id);
            CallbackProgression::Continue
        });
        let mut gone = Vec::new();
        self.bodies.borrow_mut().retain(|body| {
            let lives = alive.contains(&body.node);
            if !lives {
                gone.push(body.session);
            }
            lives
        });
        for session in gone {
            on(Incoming::BodyGone { session, farewell: false });
        }
    }
}

/// Whether a client is on a service now.
macro_rules! has_client {
    ($service:expr, $client:expr) => {{
        let mut found = false;
        $service.dynamic_config().list_clients(|details| {
            found = details.client_id == $client;
            if found { CallbackProgression::Stop } else { CallbackProgression::Continue }
        });
        found
    }};
}
use has_client;

/// The next request on a port whose client waits for a reply; none if there is no more, or `rest` allows no more.
fn next<T, E: std::fmt::Debug>(
    rest: &mut Range<usize>,
    mut receive: impl FnMut() -> Result<Option<T>, E>,
    waits: impl Fn(&T) -> bool,
) -> Option<T> {
    rest.find_map(|_| match receive() {
        Ok(Some(request)) if !waits(&request) => None,
        Ok(request) => Some(request),
        // The error concerns one peer that cannot be connected to; messages of others still come.
        Err(error) => {
            tracing::debug!(?error, "a message could not be received");
            None
        }
    })?
}

/// Checks that a frame is of this protocol, and of `own`, the session of the process that sent it.
fn admit(own: Option<u64>, header: &FrameHeader) -> Result<(), Refusal> {
    decode::preamble(header.magic, header.version)?;
    if own != Some(header.session) {
        return Err(Refusal::Session { found: header.session, expected: own.unwrap_or(0) });
    }
    Ok(())
}

/// The bytes of a request, which must be one page.
fn single_page(page: &Page) -> Result<&[u8], Refusal> {
    decode::tool_preamble(page.magic, page.version)?;
    let wrong = |problem: String| Refusal::Page { page: page.page, pages: page.pages, problem };
    if page.page != 0 || page.pages != 1 {
        return Err(wrong("a request has one page".to_owned()));
    }
    let length = usize::try_from(page.length).unwrap_or(usize::MAX);
    let bytes = page.bytes.get(..length);
    bytes.ok_or_else(|| wrong(format!("it claims {length} bytes of {PAGE_BYTES}")))
}
