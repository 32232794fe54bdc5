//! The transport's floor: requests and responses of iceoryx2 with nothing around them, to measure against. The same
//! bytes go the same way and who sleeps is woken in the same way, but nothing is checked, nobody is known by a session, and
//! nothing else is served.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::port::client::Client;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;

use super::TransportError;
use super::debug::opaque_debug;
use super::error::setup;
use super::services::{
    self, Ipc, Role, WakeListener, WakeNotifier, by_role, one_request_at_a_time, service_name,
};
use super::spin::{SPIN_US_MAX, Spin};
use crate::domain::{DomainRecord, Membership, Place};
use crate::limits::OBSERVATIONS_MAX;
use crate::wire::{FrameHeader, Record, WireReply};

/// A header, as long as a frame's.
type Header = [u64; size_of::<FrameHeader>() / 8];
/// A reply, as long as a body's.
pub type BareReply = [u64; size_of::<WireReply>() / 8];
/// Words of one record.
pub const RECORD_WORDS: usize = size_of::<Record>() / 8;
const WORDS_MAX: usize = OBSERVATIONS_MAX * RECORD_WORDS;
/// How often who sleeps looks up.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// How often who polls looks when there was nothing for long.
const DOZE: Duration = Duration::from_millis(1);
/// How long a client waits for its reply.
const PATIENCE: Duration = Duration::from_secs(10);

type BareService =
    iceoryx2::service::port_factory::request_response::PortFactory<Ipc, [u64], Header, BareReply, ()>;

fn service(node: &Node<Ipc>, role: Role) -> Result<BareService, TransportError> {
    let name = service_name("bare/frames")?;
    let builder = node.service_builder(&name).request_response::<[u64], BareReply>();
    let builder = builder.request_user_header::<Header>();
    by_role!(one_request_at_a_time!(builder, clients: 1, responses: 1), role, "bare service")
}

/// The events that wake one side.
fn wake_service(node: &Node<Ipc>, name: &str, role: Role) -> Result<services::EventService, TransportError> {
    let builder = services::events(node, name)?.max_listeners(1).max_notifiers(1).event_id_max_value(0);
    by_role!(builder, role, "bare wake service")
}

/// How one side waits for the other.
struct Waiting {
    listener: WakeListener,
    notifier: WakeNotifier,
    wake: BareWake,
    spin: Spin,
}

/// How the two sides wait for each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BareWake {
    /// They poll, and wake nobody: who had nothing for long looks a thousand times a second from then on.
    Polls,
    /// They wake each other, having polled first for so long.
    Events(Spin),
}

impl Waiting {
    fn open(node: &Node<Ipc>, role: Role, wake: BareWake) -> Result<Self, TransportError> {
        let server = wake_service(node, "bare/wake-server", role)?;
        let client = wake_service(node, "bare/wake-client", role)?;
        let (own, other) = if role == Role::Daemon { (server, client) } else { (client, server) };
        let listener = own.listener_builder().create().map_err(setup("create a bare listener"))?;
        let notifier = other.notifier_builder().create().map_err(setup("create a bare notifier"))?;
        let spin = match wake {
            BareWake::Polls => Spin::new(SPIN_US_MAX),
            BareWake::Events(spin) => spin,
        };
        Ok(Self { listener, notifier, wake, spin })
    }

    fn happened(&mut self) {
        self.spin.happened(Instant::now());
    }

    fn notify(&self) {
        if self.wake != BareWake::Polls
            && let Err(error) = self.notifier.notify()
        {
            tracing::debug!(?error, "the other side could not be woken");
        }
    }

    fn pause(&mut self) {
        if self.spin.goes_on(Instant::now()) {
            std::hint::spin_loop();
        } else {
            // Nobody wakes who polls.
            let most = if self.wake == BareWake::Polls { DOZE } else { LOOK_EVERY };
            // An error is a signal, and the caller looks again.
            self.listener.timed_wait(|_| {}, most).ok();
        }
    }
}

/// The side that replies.
pub struct BareServer {
    server: Server<Ipc, [u64], Header, BareReply, ()>,
    waiting: Waiting,
    _node: Node<Ipc>,
    // Last, so that it is dropped last.
    _epoch: Membership,
}

impl BareServer {
    /// Opens it on the domain of the daemon that serves `place` in this process.
    ///
    /// # Errors
    /// [`TransportError::Setup`] when iceoryx2 refuses, [`TransportError::Domain`] when nobody serves.
    pub fn create(place: &Place, wake: BareWake) -> Result<Self, TransportError> {
        let (node, epoch) = node(place, &place.served()?)?;
        let server = service(&node, Role::Daemon)?.server_builder().create();
        let server = server.map_err(setup("create the bare server"))?;
        let waiting = Waiting::open(&node, Role::Daemon, wake)?;
        Ok(Self { server, waiting, _node: node, _epoch: epoch })
    }

    /// Replies to what comes, having read all of it, until `stop` is set.
    ///
    /// # Errors
    /// [`TransportError::Setup`] when iceoryx2 refuses.
    pub fn serve(&mut self, stop: &AtomicBool) -> Result<(), TransportError> {
        let mut turns = 0_u32;
        loop {
            turns = turns.wrapping_add(1);
            if turns.is_multiple_of(64) && stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            let Some(request) = self.server.receive().map_err(setup("receive a bare request"))? else {
                self.waiting.pause();
                continue;
            };
            let read = request.payload().iter().fold(0_u64, |sum, word| sum.wrapping_add(*word));
            let mut reply = [0; size_of::<BareReply>() / 8];
            reply[0] = read;
            reply[1] = request.user_header()[0];
            if let Err(error) = request.send_copy(reply) {
                tracing::debug!(?error, "a bare reply could not be sent");
            }
            self.waiting.notify();
            self.waiting.happened();
        }
    }
}

/// The side that asks.
pub struct BareClient {
    client: Client<Ipc, [u64], Header, BareReply, ()>,
    waiting: Waiting,
    _node: Node<Ipc>,
    // Last, so that it is dropped last.
    _epoch: Membership,
}

impl BareClient {
    /// Connects to the server on the domain of `place`.
    ///
    /// # Errors
    /// As [`BareServer::create`]; also while the server is not there yet.
    pub fn open(place: &Place, wake: BareWake) -> Result<Self, TransportError> {
        let (node, epoch) = node(place, &place.served()?)?;
        let client = service(&node, Role::Peer)?.client_builder().initial_max_slice_len(WORDS_MAX).create();
        let client = client.map_err(setup("create the bare client"))?;
        let waiting = Waiting::open(&node, Role::Peer, wake)?;
        Ok(Self { client, waiting, _node: node, _epoch: epoch })
    }

    /// Sends `payload`, at most as long as a full frame, and waits for the reply: the sum of its words comes first in it.
    ///
    /// # Errors
    /// [`TransportError::Setup`] when iceoryx2 refuses, [`TransportError::TimedOut`] after 10 s.
    pub fn exchange(&mut self, payload: &[u64]) -> Result<BareReply, TransportError> {
        let loan = self.client.loan_slice_uninit(payload.len()).map_err(setup("loan a bare request"))?;
        let mut request = loan.write_from_slice(payload);
        *request.user_header_mut() = [payload.len() as u64; size_of::<Header>() / 8];
        let pending = request.send().map_err(setup("send a bare request"))?;
        self.waiting.notify();
        self.waiting.happened();
        let start = Instant::now();
        loop {
            if let Some(reply) = pending.receive().map_err(setup("receive a bare reply"))? {
                return Ok(*reply.payload());
            }
            if start.elapsed() > PATIENCE {
                return Err(TransportError::TimedOut { waited: PATIENCE });
            }
            self.waiting.pause();
        }
    }
}

fn node(place: &Place, record: &DomainRecord) -> Result<(Node<Ipc>, Membership), TransportError> {
    let epoch = Membership::new(place, record);
    Ok((services::node::<Ipc>(place, record, "bare")?, epoch))
}

opaque_debug!(BareServer, BareClient);
