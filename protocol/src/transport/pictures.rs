//! Pictures on their way from bodies to tools. A body sends them only while a tool watches, a tool gets only the newest, and
//! no process ever waits for one.

use std::time::{Duration, Instant};

use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::prelude::*;

use super::TransportError;
use super::debug::opaque_debug;
use super::error::setup;
use super::reserve::reserve;
use super::services::{self, Ipc, PicturePublisher, PictureService, PictureSubscriber, Role};
use super::waker::PeerBase;
use crate::domain::{Membership, PEER_SHARED_MEMORY_NEEDED, Place, require_shared_memory};
use crate::limits::WATCHERS_MAX;
use crate::picture::{Picture, PictureMessage};
use crate::wire::PictureHeader;
use crate::wire::picture::read;

/// The shortest time between two pictures of a body.
const EVERY_MIN: Duration = Duration::from_millis(30);
/// How many pictures are in shared memory at most: for each watcher one that waits and one that it looks at, and one that is
/// being written.
const PICTURES_KEPT: u64 = 2 * WATCHERS_MAX as u64 + 1;

/// The side of a body. An error here costs pictures, and nothing else.
pub(super) struct PictureOffer {
    service: PictureService,
    /// What every name of the epoch in shared memory begins with.
    prefix: String,
    /// The port and the bytes that a picture on it may have. It is made when the first tool watches, and made anew for
    /// larger pictures.
    publisher: Option<(PicturePublisher, usize)>,
    sent: Option<Instant>,
    broken: bool,
}

impl PictureOffer {
    pub(super) fn open(base: &PeerBase) -> Result<Self, TransportError> {
        let service = services::pictures(&base.node, Role::Peer)?;
        let prefix = base.epoch.prefix().to_owned();
        Ok(Self { service, prefix, publisher: None, sent: None, broken: false })
    }

    /// Whether a tool watches, and the last picture is old enough for another.
    pub(super) fn is_wanted(&self) -> bool {
        !self.broken
            && self.service.dynamic_config().number_of_subscribers() > 0
            && self.sent.is_none_or(|sent| sent.elapsed() >= EVERY_MIN)
    }

    /// Sends a picture to all tools that watch.
    pub(super) fn send(&mut self, picture: &Picture<'_>, session: u64, frame: u64) {
        self.sent = Some(Instant::now());
        let Some(bytes) = picture.bytes() else {
            return self.give_up(
                &"the body's picture has no size, too large a size, another than its bytes have, or a field that is nowhere",
            );
        };
        if let Err(error) = self.try_send(picture, bytes, &picture.header(session, frame)) {
            self.give_up(&error);
        }
    }

    fn give_up(&mut self, problem: &dyn std::fmt::Display) {
        tracing::warn!(%problem, "no pictures are sent");
        self.broken = true;
        self.publisher = None;
    }

    fn try_send(
        &mut self,
        picture: &Picture<'_>,
        bytes: usize,
        header: &PictureHeader,
    ) -> Result<(), TransportError> {
        if self.publisher.as_ref().is_none_or(|(_, room)| *room < bytes) {
            // The old port goes first: a body has one place on the service.
            self.publisher = None;
            self.publisher = Some((self.publisher(bytes)?, bytes));
        }
        let Some((publisher, _)) = &self.publisher else { return Ok(()) };
        let mut loan = publisher.loan_slice(bytes).map_err(setup("send a picture"))?;
        *loan.user_header_mut() = *header;
        picture.write(loan.payload_mut());
        loan.send().map_err(setup("send a picture"))?;
        Ok(())
    }

    fn publisher(&self, bytes: usize) -> Result<PicturePublisher, TransportError> {
        let needed = u64::try_from(bytes).unwrap_or(u64::MAX).saturating_mul(PICTURES_KEPT + 1);
        require_shared_memory(needed)?;
        let builder = self.service.publisher_builder().initial_max_slice_len(bytes).max_loaned_samples(1);
        let publisher = builder.create().map_err(setup("create a picture port"))?;
        reserve(&self.prefix, Some(publisher.id().value()))?;
        Ok(publisher)
    }
}

/// The side of a tool: the pictures of every body of a learner.
pub struct PictureWatch {
    subscriber: PictureSubscriber,
    _node: Node<Ipc>,
    /// Last, so that it is dropped last.
    epoch: Membership,
}

opaque_debug!(PictureWatch);

impl PictureWatch {
    /// Watches the bodies of the daemon that serves `place` now. From then on those that have an eye send pictures, some 30 a
    /// second at most.
    ///
    /// # Errors
    /// [`TransportError::Domain`] when no daemon serves the place, [`TransportError::Full`] when [`WATCHERS_MAX`] watch
    /// already, [`TransportError::Setup`] when iceoryx2 refuses.
    pub fn open(place: &Place) -> Result<Self, TransportError> {
        let record = place.served()?;
        require_shared_memory(PEER_SHARED_MEMORY_NEEDED)?;
        let epoch = Membership::new(place, &record);
        let node = services::node::<Ipc>(place, &record, "watcher")?;
        let service = services::pictures(&node, Role::Peer)?;
        let subscriber = service.subscriber_builder().create().map_err(|error| match error {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                TransportError::Full { sort: "watchers of pictures", limit: WATCHERS_MAX }
            }
            error => setup("watch pictures")(error),
        })?;
        Ok(Self { subscriber, _node: node, epoch })
    }

    /// The newest picture that came since the last call, of whichever body, or none. This never waits. A message that is no
    /// picture is passed over.
    ///
    /// # Errors
    /// What the transport said.
    pub fn newest(&self) -> Result<Option<PictureMessage>, TransportError> {
        let mut newest = None;
        // One waits for each body at most; more may come meanwhile, and are left for the next call.
        for _ in 0..crate::limits::BODIES_MAX {
            let Some(sample) = self.subscriber.receive().map_err(setup("receive a picture"))? else { break };
            match read(sample.user_header(), sample.payload()) {
                Ok(picture) => newest = Some(picture),
                Err(refusal) => tracing::debug!(%refusal, "what a body sent is no picture"),
            }
        }
        Ok(newest)
    }

    /// Whether the daemon still serves the learner. If not, no more pictures come.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.epoch.is_current()
    }
}
