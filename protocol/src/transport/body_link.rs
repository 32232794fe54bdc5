//! The end of a body. It introduces the body once, then exchanges frames for replies.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;

use super::debug::opaque_debug;
use super::error::setup;
use super::gone::has_gone;
use super::payload::{write_frame, write_hello};
use super::pictures::PictureOffer;
use super::services::{self, FrameClient, Ipc, Role, client};
use super::waker::{PeerBase, ROUSED};
use super::{Spin, TransportError};
use crate::description::Description;
use crate::domain::Place;
use crate::limits::BODIES_MAX;
use crate::picture::Picture;
use crate::wire::message::{Admission, RawFrame, RawHello};
use crate::wire::{FrameHeader, Welcome, WireFrame, WireReply, decode, encode, purpose};

/// How often a waiting body looks whether the daemon lives, and whether the body is told to stop.
const LOOK_EVERY: Duration = Duration::from_millis(50);
/// How long a body waits for its welcome. The daemon may be stopped or very busy.
const WELCOME_PATIENCE: Duration = Duration::from_secs(30);
/// How long a body that is told to stop still waits for a reply.
const STOP_PATIENCE: Duration = Duration::from_millis(500);

type PendingReply = PendingResponse<Ipc, WireFrame, FrameHeader, WireReply, ()>;

/// A body's connection to a daemon, with its session open.
pub struct BodyLink {
    client: FrameClient,
    pictures: PictureOffer,
    base: PeerBase,
    session: u64,
    spin: Spin,
    /// Whether the daemon roused the body since its last rest.
    roused: Cell<bool>,
}

opaque_debug!(BodyLink);

impl BodyLink {
    /// Introduces the body to the daemon that serves `place` now.
    ///
    /// # Errors
    /// [`TransportError::Domain`] when none serves it or it is still starting, [`TransportError::Full`] when
    /// it has its number of bodies, [`TransportError::Refused`] with its reason, [`TransportError::Setup`] when
    /// iceoryx2 refuses, as it does when the daemon ends or is replaced meanwhile, [`TransportError::Stopped`]
    /// when `stop` was set.
    pub fn attach(
        place: &Place,
        description: &Description,
        stop: &AtomicBool,
    ) -> Result<Self, TransportError> {
        let base = PeerBase::open(place, "body")?;
        tracing::trace!("node open");
        let hello = encode::hello(description, std::process::id(), base.wake).map_err(|refusal| {
            TransportError::Refused { code: refusal.code(), reason: refusal.to_string() }
        })?;
        // Made before the hello is sent: by this port the daemon knows that the body lives.
        let client = client!(services::frames(&base.node, Role::Peer)?, base.epoch, BODIES_MAX, "bodies");
        tracing::trace!("frame port open");
        let pictures = PictureOffer::open(&base)?;
        let mut link =
            Self { client, pictures, base, session: 0, spin: Spin::usual(), roused: Cell::default() };
        let welcome = link.introduce(&hello, stop)?;
        match decode::welcome(&welcome).map_err(TransportError::Wrong)? {
            Admission::Accepted { session, .. } => link.session = session,
            Admission::Refused { code, reason } => return Err(TransportError::Refused { code, reason }),
        }
        Ok(link)
    }

    fn introduce(&self, hello: &RawHello, stop: &AtomicBool) -> Result<Welcome, TransportError> {
        let service = services::attach(&self.base.node, Role::Peer)?;
        let client = client!(service, self.base.epoch, BODIES_MAX, "bodies attaching");
        let loan = client.loan_uninit().map_err(setup("send the hello"))?;
        tracing::trace!("hello loaned");
        let pending = write_hello(loan, hello).send().map_err(setup("send the hello"))?;
        self.base.notify();
        tracing::trace!("hello sent");
        let start = Instant::now();
        loop {
            while let Some(welcome) = pending.receive().map_err(setup("receive the welcome"))? {
                // One to another body, which had this one's place on the service before, is not ours.
                if welcome.wake == self.base.wake {
                    tracing::trace!("welcome received");
                    return Ok(*welcome.payload());
                }
            }
            if stop.load(Ordering::Relaxed) {
                return Err(TransportError::Stopped);
            }
            if start.elapsed() > WELCOME_PATIENCE {
                return Err(TransportError::TimedOut { waited: WELCOME_PATIENCE });
            }
            if has_gone(|| pending.is_connected(), || self.base.epoch.is_current(), || pending.has_response())
            {
                return Err(TransportError::DaemonGone);
            }
            // An error means that a signal came, and the loop looks again.
            self.base.listener.timed_wait(|_| {}, LOOK_EVERY).ok();
        }
    }

    /// Makes the body poll as long as `spin` says, instead of the usual time.
    pub fn set_spin(&mut self, spin: Spin) {
        self.spin = spin;
    }

    /// The number of the session.
    #[must_use]
    pub fn session(&self) -> u64 {
        self.session
    }

    /// Whether a tool watches the body's pictures, and the last one is old enough for another.
    #[must_use]
    pub fn is_watched(&self) -> bool {
        self.pictures.is_wanted()
    }

    /// Sends a picture to the tools that watch; `frame` is how many frames the body has exchanged in the session. An error is
    /// logged, and no more pictures are sent in this session.
    pub fn show(&mut self, picture: &Picture<'_>, frame: u64) {
        self.pictures.send(picture, self.session, frame);
    }

    /// Sends a frame and waits for the reply as long as the daemon lives. The daemon may keep a reply until the step is durable,
    /// or be stopped for a while.
    ///
    /// # Errors
    /// [`TransportError::DaemonGone`] when the daemon has gone, [`TransportError::Stopped`] when `stop` was set and no reply came
    /// soon, or an error of the transport.
    pub fn exchange(&mut self, frame: &RawFrame, stop: &AtomicBool) -> Result<WireReply, TransportError> {
        let header = FrameHeader { wake: self.base.wake, ..frame.header };
        let loan = self.client.loan_uninit().map_err(setup("send a frame"))?;
        tracing::trace!(sequence = header.sequence, "frame loaned");
        let pending = write_frame(loan, &header, frame).send().map_err(setup("send a frame"))?;
        self.base.notify();
        tracing::trace!(sequence = header.sequence, "frame sent");
        self.receive(&pending, &header, stop)
    }

    fn receive(
        &self,
        pending: &PendingReply,
        to: &FrameHeader,
        stop: &AtomicBool,
    ) -> Result<WireReply, TransportError> {
        let start = Instant::now();
        let mut stopped = None;
        let mut silence = SilenceLog::new(self.base.epoch.daemon_pid());
        let mut spin = self.spin;
        spin.happened(start);
        loop {
            while let Some(reply) = pending.receive().map_err(setup("receive a reply"))? {
                // One to another body, which had this one's place on the service before, is not ours.
                if (reply.session, reply.sequence) == (to.session, to.sequence) {
                    tracing::trace!("reply received");
                    silence.over(start.elapsed());
                    return Ok(*reply.payload());
                }
            }
            if spin.goes_on(Instant::now()) {
                std::hint::spin_loop();
                continue;
            }
            self.listen(LOOK_EVERY);
            if pending.has_response() {
                continue;
            }
            silence.lasts(start.elapsed());
            if stop.load(Ordering::Relaxed) {
                let since = *stopped.get_or_insert_with(Instant::now);
                if since.elapsed() >= STOP_PATIENCE {
                    return Err(TransportError::Stopped);
                }
            }
            if has_gone(|| pending.is_connected(), || self.base.epoch.is_current(), || pending.has_response())
            {
                return Err(TransportError::DaemonGone);
            }
        }
    }

    /// Waits for an event, and notes whether the daemon rouses the body. An error means that a signal came, and the caller looks
    /// at its flags.
    fn listen(&self, time: Duration) {
        let heard = self
            .base
            .listener
            .timed_wait(|heard| self.roused.set(self.roused.get() | (heard.id == ROUSED)), time);
        heard.ok();
    }

    /// Rests for `time`, or until the daemon rouses the body or `stop` is set. A body that was roused while it waited for the reply
    /// that sent it to rest does not rest.
    pub fn rest(&self, time: Duration, stop: &AtomicBool) {
        let end = Instant::now() + time;
        while !self.roused.take() && !stop.load(Ordering::Relaxed) {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            // The event of the last reply may be heard only now, and is no reason to get up.
            self.listen(left.min(LOOK_EVERY));
        }
    }

    /// Says farewell, so that the daemon closes the session at once, and does not have to find the body gone.
    pub fn detach(mut self) {
        let header =
            FrameHeader { session: self.session, purpose: purpose::DETACH, ..FrameHeader::default() };
        let frame = RawFrame { header, ..RawFrame::default() };
        // With the stop flag set, the wait for the reply is short.
        if let Err(error) = self.exchange(&frame, &AtomicBool::new(true)) {
            tracing::debug!(%error, "left without a farewell");
        }
    }
}

/// Logs that a daemon which lives does not reply. It is stopped, very busy or waiting for the disk, and nothing else says so. The body holds still
/// meanwhile: its last action ended before the frame, and no other begins before a reply.
struct SilenceLog {
    pid: u32,
    /// After which time of silence it logs next: after a second, then each time after twice as long.
    next: Duration,
}

impl SilenceLog {
    const FIRST: Duration = Duration::from_secs(1);

    fn new(pid: u32) -> Self {
        Self { pid, next: Self::FIRST }
    }

    fn lasts(&mut self, waited: Duration) {
        if waited < self.next {
            return;
        }
        self.next = self.next.saturating_mul(2);
        tracing::warn!(
            daemon = self.pid,
            waited_s = waited.as_secs(),
            "the daemon does not reply: it is stopped, very busy, or waiting for a slow disk; holding until it does or ends"
        );
    }

    fn over(&self, waited: Duration) {
        if self.next > Self::FIRST {
            tracing::info!(
                daemon = self.pid,
                waited_s = waited.as_secs(),
                "the daemon replies again; going on"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::domain::{LearnerName, OwnedDomain, RuntimeDir};
    use crate::transport::server::{Incoming, ServerTransport};

    /// One process that introduced itself again and again, under a new name each time, took all places there are.
    #[test]
    fn introducing_oneself_again_ends_the_session_before() {
        let directory = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
        let runtime = RuntimeDir::at(&directory.path().join("run")).unwrap();
        let place = Place::new(runtime, LearnerName::new("again").unwrap());
        let stop = Arc::new(AtomicBool::new(false));
        let (ready, is_ready) = std::sync::mpsc::channel();
        let daemon = {
            let (place, stop) = (place.clone(), stop.clone());
            std::thread::spawn(move || {
                let mut transport = ServerTransport::create(OwnedDomain::create(place).unwrap()).unwrap();
                ready.send(()).unwrap();
                let (mut sessions, mut gone) = (0, Vec::new());
                while !stop.load(Ordering::Relaxed) {
                    transport.wait(Duration::from_millis(20));
                    transport.poll(&mut |incoming| match incoming {
                        Incoming::Hello { reply, .. } => {
                            sessions += 1;
                            reply.accept(sessions, "again").unwrap();
                        }
                        Incoming::BodyGone { session, farewell } => gone.push((session, farewell)),
                        _ => {}
                    });
                }
                gone
            })
        };
        is_ready.recv().unwrap();
        let description = Description::new("body", "test");
        let link = BodyLink::attach(&place, &description, &AtomicBool::new(false)).unwrap();
        let hello = encode::hello(&description, std::process::id(), link.base.wake).unwrap();
        for session in 2..5 {
            let welcome = link.introduce(&hello, &AtomicBool::new(false)).unwrap();
            assert_eq!(welcome.session, session);
        }
        stop.store(true, Ordering::Relaxed);
        assert_eq!(daemon.join().unwrap(), [(1, false), (2, false), (3, false)]);
    }
}
