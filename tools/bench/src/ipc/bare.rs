//! The floor of the transport: requests and responses of iceoryx2 with nothing around them. The same bytes go the same way, and
//! a side that sleeps is woken in the same way, but nothing is checked, there are no sessions, and nothing else is served.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, request_response};
use pschema_protocol::domain::{Membership, Place};
use pschema_protocol::limits::OBSERVATIONS_MAX;
use pschema_protocol::transport::{SPIN_US_MAX, Spin, bare_node};
use pschema_protocol::wire::{FrameHeader, Record, WireReply};
use pschema_tools::kit::Failure;

type Ipc = ipc::Service;
/// A header, as long as a frame's.
type Header = [u64; size_of::<FrameHeader>() / 8];
/// A reply, as long as a body's.
pub(super) type BareReply = [u64; size_of::<WireReply>() / 8];
/// Words of one record.
pub(super) const RECORD_WORDS: usize = size_of::<Record>() / 8;
const WORDS_MAX: usize = OBSERVATIONS_MAX * RECORD_WORDS;
/// How often a side that sleeps looks whether there is a message.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// How often a side that polls looks when there was no message for long.
const DOZE: Duration = Duration::from_millis(1);
/// How long a client waits for its reply.
const PATIENCE: Duration = Duration::from_secs(10);

type BareService = request_response::PortFactory<Ipc, [u64], Header, BareReply, ()>;

/// For `map_err`: a failure of iceoryx2, with what was being done.
fn failed<E: std::fmt::Debug>(doing: &'static str) -> impl FnOnce(E) -> Failure {
    move |error| Failure::of(format!("cannot {doing}: {error:?}"))
}

/// Which side makes the services, and which opens them.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Server,
    Client,
}

/// The service, with the settings that the protocol's has.
fn service(node: &Node<Ipc>, role: Role) -> Result<BareService, Failure> {
    let name = ServiceName::new("bare/frames").map_err(failed("name a service"))?;
    let builder = node
        .service_builder(&name)
        .request_response::<[u64], BareReply>()
        .request_user_header::<Header>()
        .max_servers(1)
        .max_clients(1)
        .max_active_requests_per_client(1)
        .max_loaned_requests(1)
        .max_response_buffer_size(1)
        .max_borrowed_responses_per_pending_response(1)
        .enable_fire_and_forget_requests(false)
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(false);
    match role {
        Role::Server => builder.create().map_err(failed("create the bare service")),
        Role::Client => builder.open().map_err(failed("open the bare service")),
    }
}

/// The events that wake one side.
fn wake_service(node: &Node<Ipc>, name: &str, role: Role) -> Result<event::PortFactory<Ipc>, Failure> {
    let name = ServiceName::new(name).map_err(failed("name a service"))?;
    let builder = node.service_builder(&name).event().max_listeners(1).max_notifiers(1).event_id_max_value(0);
    match role {
        Role::Server => builder.create().map_err(failed("create a bare wake service")),
        Role::Client => builder.open().map_err(failed("open a bare wake service")),
    }
}

/// How one side waits for the other.
struct Waiting {
    listener: Listener<Ipc>,
    notifier: Notifier<Ipc>,
    wake: BareWake,
    spin: Spin,
}

/// How the two sides wait for each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BareWake {
    /// They poll, and do not wake each other. A side without a message for long looks a thousand times a second from then on.
    Polls,
    /// They poll for so long, then sleep, and wake each other.
    Events(Spin),
}

impl Waiting {
    fn open(node: &Node<Ipc>, role: Role, wake: BareWake) -> Result<Self, Failure> {
        let server = wake_service(node, "bare/wake-server", role)?;
        let client = wake_service(node, "bare/wake-client", role)?;
        let (own, other) = if role == Role::Server { (server, client) } else { (client, server) };
        let listener = own.listener_builder().create().map_err(failed("create a bare listener"))?;
        let notifier = other.notifier_builder().create().map_err(failed("create a bare notifier"))?;
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
        if self.wake != BareWake::Polls {
            // A side that can't be woken has gone, which the next exchange finds out.
            self.notifier.notify().ok();
        }
    }

    fn pause(&mut self) {
        if self.spin.goes_on(Instant::now()) {
            std::hint::spin_loop();
        } else {
            // A side that polls is not woken.
            let most = if self.wake == BareWake::Polls { DOZE } else { LOOK_EVERY };
            // An error means that a signal came, and the caller looks again.
            self.listener.timed_wait(|_| {}, most).ok();
        }
    }
}

/// The side that replies.
pub(super) struct BareServer {
    server: Server<Ipc, [u64], Header, BareReply, ()>,
    waiting: Waiting,
    _node: Node<Ipc>,
    // Dropped last.
    _epoch: Membership,
}

impl BareServer {
    /// Opens the service on the domain of the daemon that serves `place` in this process.
    pub(super) fn create(place: &Place, wake: BareWake) -> Result<Self, Failure> {
        let (node, epoch) = bare_node(place).map_err(Failure::of)?;
        let server = service(&node, Role::Server)?.server_builder().create();
        let server = server.map_err(failed("create the bare server"))?;
        let waiting = Waiting::open(&node, Role::Server, wake)?;
        Ok(Self { server, waiting, _node: node, _epoch: epoch })
    }

    /// Reads each request and replies to it, until `stop` is set.
    pub(super) fn serve(&mut self, stop: &AtomicBool) -> Result<(), Failure> {
        let mut turns = 0_u32;
        loop {
            turns = turns.wrapping_add(1);
            if turns.is_multiple_of(64) && stop.load(Ordering::Relaxed) {
                return Ok(());
            }
            let Some(request) = self.server.receive().map_err(failed("receive a bare request"))? else {
                self.waiting.pause();
                continue;
            };
            let read = request.payload().iter().fold(0_u64, |sum, word| sum.wrapping_add(*word));
            let mut reply = [0; size_of::<BareReply>() / 8];
            reply[0] = read;
            reply[1] = request.user_header()[0];
            // A client that can't be reached has gone.
            request.send_copy(reply).ok();
            self.waiting.notify();
            self.waiting.happened();
        }
    }
}

/// The side that asks.
pub(super) struct BareClient {
    client: Client<Ipc, [u64], Header, BareReply, ()>,
    waiting: Waiting,
    _node: Node<Ipc>,
    // Dropped last.
    _epoch: Membership,
}

impl BareClient {
    /// Connects to the server on the domain of `place`.
    pub(super) fn open(place: &Place, wake: BareWake) -> Result<Self, Failure> {
        let (node, epoch) = bare_node(place).map_err(Failure::of)?;
        let client = service(&node, Role::Client)?.client_builder().initial_max_slice_len(WORDS_MAX).create();
        let client = client.map_err(failed("create the bare client"))?;
        let waiting = Waiting::open(&node, Role::Client, wake)?;
        Ok(Self { client, waiting, _node: node, _epoch: epoch })
    }

    /// Sends `payload`, at most as long as a full frame, and waits for the reply: the sum of its words comes first in it.
    pub(super) fn exchange(&mut self, payload: &[u64]) -> Result<BareReply, Failure> {
        let loan = self.client.loan_slice_uninit(payload.len()).map_err(failed("loan a bare request"))?;
        let mut request = loan.write_from_slice(payload);
        *request.user_header_mut() = [payload.len() as u64; size_of::<Header>() / 8];
        let pending = request.send().map_err(failed("send a bare request"))?;
        self.waiting.notify();
        self.waiting.happened();
        let start = Instant::now();
        loop {
            if let Some(reply) = pending.receive().map_err(failed("receive a bare reply"))? {
                return Ok(*reply.payload());
            }
            if start.elapsed() > PATIENCE {
                return Err(Failure::of(format!("no bare reply came within {PATIENCE:?}")));
            }
            self.waiting.pause();
        }
    }
}
