//! The services of a domain. Every process makes or opens them here, with every setting given, so that all agree.

use std::fs;
use std::hash::{BuildHasher, RandomState};
use std::io::Write;
use std::sync::Once;

use iceoryx2::port::BackpressureAction;
use iceoryx2::port::client::Client;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::Service as AnyService;
use iceoryx2::service::builder::event::Builder as EventBuilder;
use iceoryx2::service::port_factory::{event, publish_subscribe, request_response};

use super::TransportError;
use super::error::{opening, setup};
use crate::domain::{DomainRecord, Membership, Place, private_file};
use crate::limits::{BODIES_MAX, OPERATORS_MAX, TOOLS_MAX, WATCHERS_MAX};
use crate::wire::{FrameHeader, Page, PictureHeader, Welcome, WireFrame, WireHello, WireReply};

/// Version of iceoryx2. Every process on a domain must use exactly this one.
pub const VERSION: &str = "0.10.0";

pub(super) type Ipc = ipc::Service;
pub(super) type AttachService = request_response::PortFactory<Ipc, WireHello, (), Welcome, ()>;
pub(super) type FrameService = request_response::PortFactory<Ipc, WireFrame, FrameHeader, WireReply, ()>;
pub(super) type ToolService = request_response::PortFactory<Ipc, Page, (), Page, ()>;
pub(super) type PictureService = publish_subscribe::PortFactory<Ipc, [u8], PictureHeader>;
pub(super) type PicturePublisher = Publisher<Ipc, [u8], PictureHeader>;
pub(super) type PictureSubscriber = Subscriber<Ipc, [u8], PictureHeader>;
pub(super) type EventService = event::PortFactory<Ipc>;
pub(super) type AttachServer = Server<Ipc, WireHello, (), Welcome, ()>;
pub(super) type FrameServer = Server<Ipc, WireFrame, FrameHeader, WireReply, ()>;
pub(super) type ToolServer = Server<Ipc, Page, (), Page, ()>;
pub(super) type FrameClient = Client<Ipc, WireFrame, FrameHeader, WireReply, ()>;
pub(super) type ToolClient = Client<Ipc, Page, (), Page, ()>;
pub(super) type WakeListener = Listener<Ipc>;
pub(super) type WakeNotifier = Notifier<Ipc>;

/// How many pages of an answer may be under way to one tool.
pub(super) const PAGES_IN_FLIGHT: usize = 4;
/// How many replies may be under way to one body: its own, and one to the body that had its place before (`held`).
const REPLIES_IN_FLIGHT: usize = 2;
/// Requests are numbered from a random number below this one (`held`).
const FIRST_REQUEST_MAX: u64 = 1 << 10;
/// How many bodies may introduce themselves at once. A body leaves the service when it is welcomed.
const ATTACHING_MAX: usize = BODIES_MAX + 2;
/// How many processes may be on a service at once: all peers, the daemon, its janitor and wakers, and as many dead processes
/// that are not cleaned up yet.
const NODES_MAX: usize = 2 * (BODIES_MAX + TOOL_PLACES + WATCHERS_MAX) + 8;
/// How many tools may be connected at once.
pub(super) const TOOL_PLACES: usize = TOOLS_MAX + OPERATORS_MAX;

/// Which side of a service a process is on: the daemon makes the service, a peer opens it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Role {
    /// The daemon makes the services of its epoch.
    Daemon,
    /// Bodies and tools open them.
    Peer,
}

/// Makes a process's node on the domain of an epoch. `name` is for people.
pub(super) fn node<S: AnyService>(
    place: &Place,
    record: &DomainRecord,
    name: &str,
) -> Result<Node<S>, TransportError> {
    own_settings(place);
    let config = config(&place.epoch_root(record), &record.prefix)?;
    NodeBuilder::new()
        .name(&NodeName::new(name).map_err(setup("name the node"))?)
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<S>()
        .map_err(setup("create the node"))
}

/// A node on the epoch that is served at `place`, for measuring iceoryx2 by itself. The membership is to be dropped after it.
///
/// # Errors
/// [`TransportError::Domain`] when no daemon serves the place, [`TransportError::Setup`] when iceoryx2 refuses.
pub fn bare_node(place: &Place) -> Result<(Node<Ipc>, Membership), TransportError> {
    let record = place.served()?;
    let epoch = Membership::new(place, &record);
    Ok((node(place, &record, "bare")?, epoch))
}

fn config(root: &std::path::Path, prefix: &str) -> Result<Config, TransportError> {
    let root = Path::new(root.as_os_str().as_encoded_bytes());
    let mut config = Config::default();
    config.global.set_root_path(&root.map_err(setup("use the epoch's directory"))?);
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(setup("use the epoch's prefix"))?;
    // Only the daemon's janitor cleans up after dead processes, so that a frame never waits for that.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    Ok(config)
}

/// Makes iceoryx2 read our settings and no others, and log errors only. This happens once in each process.
fn own_settings(place: &Place) {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        set_log_level(LogLevel::Error);
        // Without this, iceoryx2 would read ./config/iceoryx2.toml of the working directory, and use it when it
        // cleans up after a process whose own settings are lost. Our settings name a place where there is nothing.
        let path = place.runtime().path().join(".settings.toml");
        let nowhere = place.runtime().path().join(".nowhere");
        let text = format!("[global]\nroot-path = \"{}\"\nprefix = \"psnone-\"\n", nowhere.display());
        let written = fs::read_to_string(&path).is_ok_and(|found| found == text) || {
            let temporary = path.with_extension(std::process::id().to_string());
            let file = private_file(&temporary);
            file.is_ok_and(|mut file| {
                file.write_all(text.as_bytes()).and_then(|()| fs::rename(&temporary, &path)).is_ok()
            })
        };
        let path = FilePath::new(path.as_os_str().as_encoded_bytes());
        let used = path.is_ok_and(|path| Config::setup_global_config_from_file(&path).is_ok());
        if !written || !used {
            tracing::warn!(runtime = %place.runtime().path().display(), "cannot give iceoryx2 its settings");
        }
    });
}

/// Gives a service on which the daemon is asked its settings: each client has one request under way, and a message that
/// finds no room fails instead of another being dropped.
///
/// Fire-and-forget is on for the daemon's sake, though nobody forgets a request. Without it, iceoryx2 0.10.0 takes the
/// request of a client that has left out of its queue, hands it to nobody and never gives it back. The connection then
/// stays for good, and with 128 of them the next client that leaves while its request is held ends the daemon.
macro_rules! one_request_at_a_time {
    ($builder:expr, clients: $clients:expr, responses: $responses:expr) => {
        $builder
            .max_servers(1)
            .max_clients($clients)
            .max_nodes(NODES_MAX)
            .max_active_requests_per_client(1)
            .max_loaned_requests(1)
            .max_response_buffer_size($responses)
            .max_borrowed_responses_per_pending_response(1)
            .enable_fire_and_forget_requests(true)
            .enable_safe_overflow_for_requests(false)
            .enable_safe_overflow_for_responses(false)
    };
}

/// Makes the service that `$builder` describes, or opens it, whichever is `$role`'s part; `$name` says which it is in errors.
macro_rules! by_role {
    ($builder:expr, $role:expr, $name:literal) => {
        match $role {
            Role::Daemon => $builder.create().map_err(setup(concat!("create the ", $name))),
            Role::Peer => $builder.open().map_err(opening(concat!("open the ", $name))),
        }
    };
}

/// The service on which bodies introduce themselves.
pub(super) fn attach(node: &Node<Ipc>, role: Role) -> Result<AttachService, TransportError> {
    let name = service_name("pschema/attach")?;
    let builder = node.service_builder(&name).request_response::<WireHello, Welcome>();
    let builder = one_request_at_a_time!(builder, clients: ATTACHING_MAX, responses: REPLIES_IN_FLIGHT);
    by_role!(builder, role, "attach service")
}

/// The service on which bodies send frames.
pub(super) fn frames(node: &Node<Ipc>, role: Role) -> Result<FrameService, TransportError> {
    let name = service_name("pschema/frames")?;
    let builder = node.service_builder(&name).request_response::<WireFrame, WireReply>();
    let builder = builder.request_user_header::<FrameHeader>();
    let builder = one_request_at_a_time!(builder, clients: BODIES_MAX, responses: REPLIES_IN_FLIGHT);
    by_role!(builder, role, "frame service")
}

/// The service on which tools ask questions and give orders.
pub(super) fn tools(node: &Node<Ipc>, role: Role) -> Result<ToolService, TransportError> {
    let name = service_name("pschema/tools")?;
    let builder = node.service_builder(&name).request_response::<Page, Page>();
    let builder = one_request_at_a_time!(builder, clients: TOOL_PLACES, responses: PAGES_IN_FLIGHT);
    by_role!(builder, role, "tool service")
}

/// The service on which bodies send pictures to tools that watch. The daemon makes it and does not use it.
pub(super) fn pictures(node: &Node<Ipc>, role: Role) -> Result<PictureService, TransportError> {
    let builder = node
        .service_builder(&service_name("pschema/pictures")?)
        .publish_subscribe::<[u8]>()
        .user_header::<PictureHeader>()
        .max_publishers(BODIES_MAX)
        .max_subscribers(WATCHERS_MAX)
        .max_nodes(NODES_MAX)
        .subscriber_max_buffer_size(1)
        .subscriber_max_borrowed_samples(1)
        .history_size(0)
        // A watcher that is slow or stopped misses pictures, and no body waits for it.
        .enable_safe_overflow(true);
    by_role!(builder, role, "picture service")
}

/// The event service that wakes the daemon.
pub(super) fn wake_daemon<S: AnyService>(
    node: &Node<S>,
    role: Role,
) -> Result<event::PortFactory<S>, TransportError> {
    let builder = events(node, "pschema/wake-daemon")?;
    let builder = builder.max_listeners(1).max_notifiers(NODES_MAX).event_id_max_value(0);
    by_role!(builder, role, "daemon's wake service")
}

/// The event service that wakes bodies and tools, each by its own listener.
pub(super) fn wake_peers(node: &Node<Ipc>, role: Role) -> Result<EventService, TransportError> {
    let builder = events(node, "pschema/wake-peers")?;
    let builder = builder.max_listeners(NODES_MAX).max_notifiers(1).event_id_max_value(1);
    by_role!(builder, role, "peers' wake service")
}

/// The builder of an event service on which iceoryx2 raises no events of its own.
fn events<S: AnyService>(node: &Node<S>, name: &str) -> Result<EventBuilder<S>, TransportError> {
    let builder = node.service_builder(&service_name(name)?).event().max_nodes(NODES_MAX).disable_deadline();
    let builder = builder.disable_notifier_created_event().disable_notifier_dropped_event();
    Ok(builder.disable_notifier_dead_event())
}

/// What happens to a message for which there is no room: sending it fails. It neither blocks, so that a stopped peer never
/// stops the daemon, nor is it dropped in silence.
pub(super) fn fail_when_full(_: &iceoryx2::port::BackpressureInfo) -> BackpressureAction {
    BackpressureAction::DiscardDataAndFail
}

/// The port name of the listener of the peer with the wake number `wake`.
pub(super) fn wake_name(wake: u64) -> Result<PortName, TransportError> {
    PortName::new(&format!("{wake:016x}")).map_err(setup("name the wake listener"))
}

fn service_name(name: &str) -> Result<ServiceName, TransportError> {
    ServiceName::new(name).map_err(setup("name a service"))
}

/// Makes a client on a service of an epoch, and reserves its shared memory; `$limit` is how many there may be, and `$sort`
/// says what they are.
macro_rules! client {
    ($service:expr, $epoch:expr, $limit:expr, $sort:literal) => {{
        let client = $service.client_builder().set_backpressure_handler(services::fail_when_full).create();
        let client = client.map_err(services::client_error($sort, $limit))?;
        // Each request that is loaned uses a number up.
        for _ in 0..services::first_request() {
            drop(client.loan_uninit().map_err($crate::transport::error::setup("number requests"))?);
        }
        $crate::transport::reserve::reserve($epoch.prefix(), Some(client.id().value()))?;
        client
    }};
}
pub(super) use client;

/// A random number of the first request of a client.
pub(super) fn first_request() -> u64 {
    RandomState::new().hash_one(()) % FIRST_REQUEST_MAX
}

/// For `map_err`: why a client could not be made, where a full service is an error of its own.
pub(super) fn client_error(
    sort: &'static str,
    limit: usize,
) -> impl FnOnce(iceoryx2::service::port_factory::client::ClientCreateError) -> TransportError {
    use iceoryx2::service::port_factory::client::ClientCreateError;
    move |error| match error {
        ClientCreateError::ExceedsMaxSupportedClients => TransportError::Full { sort, limit },
        error => setup("create a client")(error),
    }
}
