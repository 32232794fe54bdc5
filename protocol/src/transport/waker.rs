//! Waking a process that waits: any thread or peer wakes the daemon, and the daemon wakes a peer.

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

/// The event that says to a peer: a message was sent to you.
pub(super) const REPLIED: EventId = EventId::new(0);
/// The event that says to a body: do not rest any longer.
pub(super) const ROUSED: EventId = EventId::new(1);

/// Wakes the daemon out of [`super::server::ServerTransport::wait`], from any thread of the daemon.
pub struct DaemonWaker {
    /// Set when the daemon is woken; the daemon looks at it while it polls.
    woken: Arc<AtomicBool>,
    notifier: Notifier<ipc_threadsafe::Service>,
    /// The node of the notifier, which ends with it.
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

    /// Wakes the daemon. If it is awake, it does not sleep the next time.
    pub fn wake(&self) {
        self.woken.store(true, Ordering::Release);
        if let Err(error) = self.notifier.notify() {
            tracing::warn!(?error, "the daemon could not be woken");
        }
    }
}

/// What the daemon wakes each peer with, by the wake number that the peer chose.
pub(super) struct PeerWaker {
    notifier: WakeNotifier,
    keys: RefCell<BTreeMap<u64, ListenerKey>>,
}

impl PeerWaker {
    pub(super) fn new(notifier: WakeNotifier) -> Self {
        Self { notifier, keys: RefCell::new(BTreeMap::new()) }
    }

    /// Wakes the peer whose wake number is `wake`, if it listens. That a peer has died is found out elsewhere.
    pub(super) fn wake(&self, wake: u64, why: EventId) {
        let key = self.keys.borrow().get(&wake).copied();
        if key.is_some_and(|key| self.notifier.notify_single_listener_with_custom_event_id(&key, why).is_ok())
        {
            return;
        }
        let Ok(name) = services::wake_name(wake) else { return };
        // The peer is new. Peers come and go, so the keys of all that listen now replace the known ones.
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

/// What every body and tool has on an epoch: a node, a listener by which the daemon wakes it, and a notifier that wakes the
/// daemon.
pub(super) struct PeerBase {
    pub(super) wake: u64,
    pub(super) listener: WakeListener,
    daemon: WakeNotifier,
    pub(super) node: Node<services::Ipc>,
    /// Dropped last, because it sweeps the epoch's files if the epoch has ended.
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

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::thread;
    use std::time::Duration;

    use super::*;
    use crate::domain::{LearnerName, OwnedDomain, RuntimeDir};

    /// iceoryx2's issue 1811 tells of events that a waiting listener does not receive. One that is lost would delay a reply until
    /// the end of the wait.
    #[test]
    fn events_wake_a_listener_each_time() {
        const ROUNDS: u32 = 5_000;
        const PATIENCE: Duration = Duration::from_secs(60);
        let directory = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
        let runtime = RuntimeDir::at(&directory.path().join("run")).unwrap();
        let place = Place::new(runtime, LearnerName::new("waker").unwrap());
        let domain = OwnedDomain::create(place.clone()).unwrap();
        let (place, record) = (domain.place(), domain.record());
        let (woken, wakes) = channel();
        thread::scope(|scope| {
            scope.spawn(move || {
                let node = services::node::<services::Ipc>(place, record, "listener").unwrap();
                let service = services::wake_daemon(&node, Role::Daemon).unwrap();
                let listener = service.listener_builder().create().unwrap();
                woken.send(0).unwrap();
                for _ in 0..ROUNDS {
                    woken.send(listener.timed_wait(|_| {}, PATIENCE).unwrap()).unwrap();
                }
            });
            assert_eq!(wakes.recv(), Ok(0), "it listens");
            let waker = DaemonWaker::create(place, record, Arc::default()).unwrap();
            for round in 0..ROUNDS {
                waker.wake();
                // The listener waits already, or is about to, or is on its way back.
                assert_eq!(wakes.recv(), Ok(1), "round {round}");
            }
        });
    }
}
