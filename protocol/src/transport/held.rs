//! Requests that the daemon holds until it can reply.
//!
//! In iceoryx2 0.10.0 a request names its client by the place that the client has among the others, and by a number that counts
//! from 0 in each client. A client that leaves gives its place to the next one. A reply to the first would then reach the second,
//! if that has a request with the same number under way, and the end of the first's request would end the second's
//! (iceoryx2 issue 1905; mended after that release). Here a reply is sent only while the client is there that asked; a request
//! whose end would do harm is kept until it can't; and clients begin to count at random (`services::client`), so that
//! this is rare. What gets through all the same the receiver skips, by the numbers in the message.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::identifiers::UniqueClientId;

use super::services::Ipc;
use crate::wire::{FrameHeader, Page, Welcome, WireFrame, WireHello, WireReply};

pub(super) type ActiveHello = ActiveRequest<Ipc, WireHello, (), Welcome, ()>;
pub(super) type ActiveFrame = ActiveRequest<Ipc, WireFrame, FrameHeader, WireReply, ()>;
pub(super) type ActiveTool = ActiveRequest<Ipc, Page, (), Page, ()>;

/// A request as iceoryx2 hands it out.
pub(super) trait Active {
    /// The client that sent it.
    fn origin(&self) -> UniqueClientId;
    /// Whether the place of that client has a request of this number under way.
    fn is_connected(&self) -> bool;
}

macro_rules! active {
    ($($request:ty),+) => {$(
        impl Active for $request {
            fn origin(&self) -> UniqueClientId {
                Self::origin(self)
            }

            fn is_connected(&self) -> bool {
                Self::is_connected(self)
            }
        }
    )+};
}

active!(ActiveHello, ActiveFrame, ActiveTool);

/// The clients of a service, and the requests of clients that have left which can't be dropped yet.
pub(super) struct Clients<A> {
    is_there: Box<dyn Fn(UniqueClientId) -> bool>,
    /// How often the daemon has looked for requests. A client that asked in the present turn is taken to be there: to look for
    /// it costs a third as much as a whole reply.
    turn: Cell<u64>,
    strays: RefCell<Vec<A>>,
}

impl<A: Active> Clients<A> {
    /// The clients of a service; `is_there` tells whether one of them is on it now.
    pub(super) fn new(is_there: impl Fn(UniqueClientId) -> bool + 'static) -> Rc<Self> {
        Rc::new(Self { is_there: Box::new(is_there), turn: Cell::default(), strays: RefCell::default() })
    }

    /// Begins to look for requests once more.
    pub(super) fn begin_turn(&self) {
        self.turn.set(self.turn.get().wrapping_add(1));
    }

    /// Holds a request that came in.
    pub(super) fn hold(self: &Rc<Self>, active: A) -> Held<A> {
        Held { active: Some(active), turn: self.turn.get(), clients: Rc::clone(self) }
    }

    /// Drops the requests kept so far whose end does no harm any more.
    pub(super) fn sweep(&self) {
        self.strays.borrow_mut().retain(Active::is_connected);
    }
}

/// A request that came in, and its client. It is dropped only when that ends no request but this one.
pub(super) struct Held<A: Active> {
    active: Option<A>,
    /// The turn in which it came in.
    turn: u64,
    clients: Rc<Clients<A>>,
}

impl<A: Active> Held<A> {
    /// The request, as long as the client that sent it waits for a reply.
    pub(super) fn of_waiting_client(&self) -> Option<&A> {
        self.active.as_ref().filter(|active| active.is_connected() && self.is_there(active))
    }

    fn is_there(&self, active: &A) -> bool {
        self.turn == self.clients.turn.get() || (self.clients.is_there)(active.origin())
    }
}

impl<A: Active> Drop for Held<A> {
    fn drop(&mut self) {
        if let Some(active) = self.active.take()
            && active.is_connected()
            && !self.is_there(&active)
        {
            self.clients.strays.borrow_mut().push(active);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;
    use std::thread;
    use std::time::Duration;

    use crate::description::Description;
    use crate::domain::{LearnerName, OwnedDomain, Place, RuntimeDir, shared_memory_files};
    use crate::transport::TransportError;
    use crate::transport::body_link::BodyLink;
    use crate::transport::server::{FrameReply, Incoming, RequestReply, ServerTransport};
    use crate::transport::tool_link::{Purpose, ToolLink};
    use crate::wire::message::{RawFrame, Reply};
    use crate::wire::{MAGIC, VERSION, decode, purpose};

    const PATIENCE: Duration = Duration::from_secs(60);

    struct Daemon {
        transport: ServerTransport,
        place: Place,
        sessions: u64,
        requests: Vec<(Vec<u8>, RequestReply)>,
        frames: Vec<FrameReply>,
        _directory: tempfile::TempDir,
    }

    impl Daemon {
        fn start() -> Self {
            let directory = tempfile::Builder::new().prefix("ps").tempdir_in("/tmp").unwrap();
            let runtime = RuntimeDir::at(&directory.path().join("run")).unwrap();
            let place = Place::new(runtime, LearnerName::new("held").unwrap());
            let transport = ServerTransport::create(OwnedDomain::create(place.clone()).unwrap()).unwrap();
            let (requests, frames) = (Vec::new(), Vec::new());
            Self { transport, place, sessions: 0, requests, frames, _directory: directory }
        }

        /// How many segments of shared memory there are.
        fn segments(&self) -> usize {
            let record = self.place.served().unwrap();
            shared_memory_files(&record.prefix).unwrap().len()
        }

        /// Takes what comes in, and holds it, until there is a message, or `is_over`.
        fn receive(&mut self, is_over: impl Fn() -> bool) {
            let before = self.requests.len() + self.frames.len();
            while self.requests.len() + self.frames.len() == before && !is_over() {
                self.transport.wait(Duration::from_millis(5));
                let (sessions, requests, frames) = (&mut self.sessions, &mut self.requests, &mut self.frames);
                self.transport.poll(&mut |incoming| match incoming {
                    Incoming::Request { bytes, reply } => requests.push((bytes, reply)),
                    Incoming::Frame { reply, .. } => frames.push(reply),
                    Incoming::Hello { reply, .. } => {
                        *sessions += 1;
                        reply.accept(*sessions, "held").unwrap();
                    }
                    Incoming::Refused { .. } | Incoming::BodyGone { .. } => {}
                });
            }
        }
    }

    /// With a disk that took long to confirm, `show 7` after an interrupted `show 3` told schema 3.
    #[test]
    fn a_late_answer_reaches_no_tool_that_took_the_place_of_its_own() {
        let mut daemon = Daemon::start();
        let rounds = std::env::var("PSCHEMA_LATE_ANSWERS").ok().and_then(|rounds| rounds.parse().ok());
        for round in 0..rounds.unwrap_or(100_u32) {
            while daemon.requests.is_empty() {
                let place = daemon.place.clone();
                let leaving = thread::spawn(move || {
                    let mut leaving = ToolLink::connect(&place, Purpose::Question).unwrap();
                    let interrupted = leaving.request(b"of the one that left", Duration::from_millis(2));
                    assert!(matches!(interrupted, Err(TransportError::TimedOut { .. })), "{interrupted:?}");
                });
                daemon.receive(|| leaving.is_finished());
                leaving.join().unwrap();
            }
            let place = daemon.place.clone();
            let asking = thread::spawn(move || {
                ToolLink::connect(&place, Purpose::Question)
                    .unwrap()
                    .request(&round.to_le_bytes(), PATIENCE)
                    .unwrap()
            });
            daemon.receive(|| asking.is_finished());
            // The first is answered, or dropped, while the second waits. Now and then the second asks again before that.
            for (number, (bytes, reply)) in daemon.requests.drain(..).enumerate() {
                if number > 0 || round % 2 == 0 {
                    reply.answer(bytes);
                }
            }
            while !asking.is_finished() {
                daemon.receive(|| asking.is_finished());
            }
            assert_eq!(asking.join().unwrap(), round.to_le_bytes(), "round {round}");
        }
    }

    /// What a client sent before it left, and the daemon had not taken by then, kept its connection for good.
    #[test]
    fn a_request_of_a_client_that_has_left_leaves_nothing() {
        let mut daemon = Daemon::start();
        daemon.transport.poll(&mut |_| {});
        let before = daemon.segments();
        for _ in 0..200 {
            let mut leaving = ToolLink::connect(&daemon.place, Purpose::Question).unwrap();
            daemon.transport.poll(&mut |_| {});
            let interrupted = leaving.request(b"of the one that left", Duration::ZERO);
            assert!(matches!(interrupted, Err(TransportError::TimedOut { .. })), "{interrupted:?}");
            drop(leaving);
            daemon.transport.poll(&mut |_| panic!("nobody waits for a reply"));
        }
        // The janitor may have made its own meanwhile.
        assert!(daemon.segments() < before + 8, "{} and {before} before", daemon.segments());
    }

    /// A body that attached right after one that was killed in its first frame ended for good.
    #[test]
    fn a_late_reply_reaches_no_body_that_took_the_place_of_its_own() {
        let mut daemon = Daemon::start();
        let frame = |session| {
            let mut frame = RawFrame::default();
            frame.header.magic = MAGIC;
            frame.header.version = VERSION;
            frame.header.session = session;
            frame.header.sequence = 1;
            frame.header.purpose = purpose::OBSERVE;
            frame
        };
        let description = Description::new("body", "test");
        for round in 0..4 {
            let place = daemon.place.clone();
            let of_leaver = description.clone();
            let leaving = thread::spawn(move || {
                let mut link = BodyLink::attach(&place, &of_leaver, &AtomicBool::new(false)).unwrap();
                let session = link.session();
                let left = link.exchange(&frame(session), &AtomicBool::new(true));
                assert!(matches!(left, Err(TransportError::Stopped)), "{left:?}");
            });
            daemon.receive(|| leaving.is_finished());
            leaving.join().unwrap();
            let (place, of_next) = (daemon.place.clone(), description.clone());
            let attached = thread::spawn(move || {
                let mut link = BodyLink::attach(&place, &of_next, &AtomicBool::new(false)).unwrap();
                let session = link.session();
                let reply = link.exchange(&frame(session), &AtomicBool::new(false)).unwrap();
                decode::reply(&reply, &of_next, session, 1).unwrap()
            });
            while daemon.frames.len() < 2 {
                daemon.receive(|| attached.is_finished());
            }
            let mut late = daemon.frames.drain(..);
            let (of_leaver, own) = (late.next().unwrap(), late.next().unwrap());
            assert!(of_leaver.send(&Reply::Wait { ms: 1 }).is_err());
            own.send(&Reply::Wait { ms: 2 }).unwrap();
            drop(late);
            assert_eq!(attached.join().unwrap(), Reply::Wait { ms: 2 }, "round {round}");
        }
    }
}
