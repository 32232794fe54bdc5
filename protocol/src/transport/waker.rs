//! Waking who waits: the daemon by anyone, a peer by the daemon.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use iceoryx2::port::notifier::{ListenerKey, Notifier};
use iceoryx2::prelude::*;

use super::TransportError;
use super::debug::opaque_debug;
use super::error::setup;
use super::services::{self, Role, WakeListener, WakeNotifier};
use crate::domain::{DomainRecord, Membership, PEER_SHARED_MEMORY_NEEDED, Place, require_shared_memory};

/// What a peer is woken for: something was sent to it.
pub(super) const REPLIED: EventId = EventId::new(0);
/// What a body is woken for: it shall rest no longer.
pub(super) const ROUSED: EventId = EventId::new(1);

/// Wakes the daemon out of [`super::server::ServerTransport::wait`], from any thread of the daemon.
pub struct DaemonWaker {
    /// Looked at by an end that polls.
    woken: Arc<AtomicBool>,
    notifier: Notifier<ipc_threadsafe::Service>,
    /// The notifier lives on it.
    _node: Node<ipc_threadsafe::Service>,
}

opaque_debug!(DaemonWaker);

impl DaemonWaker {
    pub(super) fn create(
        place: &Place,
        record: &DomainRecord,
        woken: Arc<AtomicBool>,
    ) -> Result<Self, TransportError> {
        let node = services::node::<ipc_threadsafe::Service>(place, record, "waker")?;
        let service = services::wake_daemon(&node, Role::Peer)?;
        let notifier = service.notifier_builder().create().map_err(setup("create a waker"))?;
        Ok(Self { woken, notifier, _node: node })
    }

    /// Wakes the daemon, or keeps it from sleeping the next time.
    pub fn wake(&self) {
        self.woken.store(true, Ordering::Release);
        if let Err(error) = self.notifier.notify() {
            tracing::warn!(?error, "the daemon could not be woken");
        }
    }
}

/// The daemon's way to wake each peer by the number it gave.
pub(super) struct PeerWaker {
    notifier: WakeNotifier,
    keys: RefCell<BTreeMap<u64, ListenerKey>>,
}

impl PeerWaker {
    pub(super) fn new(notifier: WakeNotifier) -> Self {
        Self { notifier, keys: RefCell::new(BTreeMap::new()) }
    }

    /// Wakes the peer that gave `wake`, if it listens. One that does not is found out when its process is.
    pub(super) fn wake(&self, wake: u64, why: EventId) {
        let key = self.keys.borrow().get(&wake).copied();
        if key.is_some_and(|key| self.notifier.notify_single_listener_with_custom_event_id(&key, why).is_ok())
        {
            return;
        }
        let Ok(name) = services::wake_name(wake) else { return };
        // Peers come and go: the keys of all who listen now replace those known.
        let mut keys = self.keys.borrow_mut();
        keys.clear();
        self.notifier.for_each_listener(|peer, details| {
            if let Ok(number) = u64::from_str_radix(details.listener_name.as_str(), 16) {
                keys.insert(number, peer.listener_key());
            }
            if details.listener_name == name && peer.notify_with_custom_event_id(why).is_err() {
                tracing::debug!(wake, "a peer could not be woken");
            }
            CallbackProgression::Continue
        });
    }
}

/// What every body and tool has: its node, a listener the daemon wakes it by, and a way to wake the daemon.
pub(super) struct PeerBase {
    pub(super) wake: u64,
    pub(super) listener: WakeListener,
    daemon: WakeNotifier,
    pub(super) node: Node<services::Ipc>,
    /// Last, so that it is dropped last.
    pub(super) epoch: Membership,
}

impl PeerBase {
    /// Joins the epoch of the daemon that serves `place` now, as a `sort` of peer.
    pub(super) fn open(place: &Place, sort: &str) -> Result<Self, TransportError> {
        let record = &place.served()?;
        require_shared_memory(PEER_SHARED_MEMORY_NEEDED)?;
        let epoch = Membership::new(place, record);
        let node = services::node::<services::Ipc>(place, record, sort)?;
        let wake = RandomState::new().hash_one(std::process::id());
        let peers = services::wake_peers(&node, Role::Peer)?;
        let listener = peers.listener_builder().name(&services::wake_name(wake)?).create();
        let listener = listener.map_err(setup("create a wake listener"))?;
        let daemon = services::wake_daemon(&node, Role::Peer)?.notifier_builder().create();
        let daemon = daemon.map_err(setup("create the daemon's waker"))?;
        Ok(Self { wake, listener, daemon, node, epoch })
    }

    /// Wakes the daemon.
    pub(super) fn notify(&self) {
        if let Err(error) = self.daemon.notify() {
            tracing::debug!(?error, "the daemon could not be woken");
        }
    }
}
