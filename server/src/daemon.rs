//! The daemon: one closed set of events, one loop, one thread. It steps the learner at its own pace; what a
//! tool wants to know is worked out on another thread.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_learner::progress::StageCommand;
use pschema_protocol::domain::{OwnedDomain, Place};
use pschema_protocol::inspect::{Answer, BodyStatus, Request, StageOrder};
use pschema_protocol::limits::BODIES_MAX;
use pschema_protocol::message::{CheckedHello, RawFrame, RawHello, Reply};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::transport::server::{AttachReply, FrameReply, Incoming, RequestReply, ServerTransport};
use pschema_protocol::{codec, decode};

use crate::ServerError;
use crate::inspect::NO_BODY;
use crate::inspector::{Inspected, Inspector, encoded};
use crate::mind::{HostFacts, Mind, Setup, View};
use crate::session::Session;

/// How long the loop sleeps when nothing comes in; a stop flag set by a signal is seen within it.
const SLEEP_MAX: Duration = Duration::from_millis(100);
/// How long bodies have to come for their farewell when the daemon ends.
const FAREWELL_MAX: Duration = Duration::from_secs(1);
/// Sessions that are over and still shown.
const ENDED_KEPT_MAX: usize = 32;

/// Everything that can happen to the daemon.
enum Event<'a> {
    /// A body introduces itself.
    Hello { hello: RawHello, reply: AttachReply },
    /// A body reports, and asks what to do.
    Frame { frame: &'a RawFrame, reply: FrameReply },
    /// A body has gone.
    PeerGone { session: u64, farewell: bool },
    /// A tool asks or orders.
    Tool { bytes: Vec<u8>, reply: RequestReply },
    /// A message was refused before it came here; its sender's session, should it have one.
    Refused { session: Option<u64>, refusal: Refusal },
    /// The inspector has an answer.
    Inspected(Inspected),
    /// The daemon is to end.
    Signal,
}

impl<'a> From<Incoming<'a>> for Event<'a> {
    fn from(incoming: Incoming<'a>) -> Self {
        match incoming {
            Incoming::Hello { hello, reply } => Event::Hello { hello, reply },
            Incoming::Frame { frame, reply } => Event::Frame { frame, reply },
            Incoming::Request { bytes, reply } => Event::Tool { bytes, reply },
            Incoming::Refused { session, refusal } => Event::Refused { session, refusal },
            Incoming::BodyGone { session, farewell } => Event::PeerGone { session, farewell },
        }
    }
}

/// Serves a learner at `place` until `stop` is set or a tool ends it.
///
/// # Errors
/// When the learner can't be made, another daemon serves the place, or shared memory can't be used. Nothing
/// that a body or a tool does ends it.
pub fn serve(place: Place, setup: Setup, stop: &AtomicBool) -> Result<(), ServerError> {
    let mind = Mind::new(setup)?;
    let name = place.learner().to_string();
    let mut transport = ServerTransport::create(OwnedDomain::create(place)?)?;
    let waker = transport.waker()?;
    let inspector = Inspector::start(move || waker.wake()).map_err(ServerError::Thread)?;
    let mut daemon = Daemon::new(name, mind, inspector);
    tracing::info!(learner = %daemon.name, pid = std::process::id(), "ready; memory is kept in RAM only");
    while !daemon.is_over(Instant::now()) {
        transport.wait(SLEEP_MAX);
        if stop.load(Ordering::Relaxed) {
            daemon.on(Event::Signal);
        }
        transport.poll(&mut |incoming| daemon.on(incoming.into()));
        while let Some(answer) = daemon.inspector.answer() {
            daemon.on(Event::Inspected(answer));
        }
        if std::mem::take(&mut daemon.rouse) {
            daemon.bodies.keys().for_each(|session| transport.rouse(*session));
        }
    }
    tracing::info!(learner = %daemon.name, steps = daemon.mind.learner().memory().content().step, "ended");
    // What the inspector still works on is for tools that will find the daemon gone.
    Ok(())
}

struct Attached {
    session: Session,
    pid: u32,
}

struct Daemon {
    name: String,
    mind: Mind,
    bodies: BTreeMap<u64, Attached>,
    ended: Vec<BodyStatus>,
    sessions: u64,
    /// Messages refused that belonged to no session.
    strays: u64,
    inspector: Inspector,
    asking: BTreeMap<u64, RequestReply>,
    asked: u64,
    /// Whether bodies that rest are wanted again.
    rouse: bool,
    /// Set when the daemon is ending: when it ends, whether bodies have left or not.
    ends_at: Option<Instant>,
}

impl Daemon {
    fn new(name: String, mind: Mind, inspector: Inspector) -> Self {
        Self {
            name,
            mind,
            bodies: BTreeMap::new(),
            ended: Vec::new(),
            sessions: 0,
            strays: 0,
            inspector,
            asking: BTreeMap::new(),
            asked: 0,
            rouse: false,
            ends_at: None,
        }
    }

    fn is_over(&self, now: Instant) -> bool {
        self.ends_at.is_some_and(|end| self.bodies.is_empty() || now >= end)
    }

    fn on(&mut self, event: Event<'_>) {
        match event {
            Event::Hello { hello, reply } => self.hello(&hello, reply),
            Event::Frame { frame, reply } => self.frame(frame, reply),
            Event::PeerGone { session, farewell } => {
                self.gone(session, if farewell { "left" } else { "lost" })
            }
            Event::Tool { bytes, reply } => self.tool(&bytes, reply),
            Event::Refused { session, refusal } => self.refused(session, &refusal),
            Event::Inspected(Inspected { number, bytes }) => {
                if let Some(reply) = self.asking.remove(&number) {
                    reply.answer(bytes);
                }
            }
            Event::Signal => self.end(),
        }
    }

    fn end(&mut self) {
        if self.ends_at.is_none() {
            tracing::info!(bodies = self.bodies.len(), "ending");
            self.ends_at = Some(Instant::now() + FAREWELL_MAX);
            self.rouse = true;
        }
    }

    fn hello(&mut self, hello: &RawHello, reply: AttachReply) {
        let name = self.name.clone();
        let sent = match decode::hello(hello).and_then(|hello| self.attach(&hello)) {
            Ok(session) => {
                let sent = reply.accept(session, &name);
                if sent.is_err() {
                    self.gone(session, "lost");
                }
                sent
            }
            Err(refusal) => {
                self.strays += 1;
                log_refused(self.strays, None, &refusal.to_string());
                reply.refuse(&refusal, &name)
            }
        };
        if let Err(error) = sent {
            tracing::info!(%error, "a body went before it was welcomed");
        }
    }

    /// Opens a session for a body.
    fn attach(&mut self, hello: &CheckedHello) -> Result<u64, Refusal> {
        let body = &hello.description.name;
        let unwilling = |reason: String| Err(Refusal::Unwilling { reason });
        if self.ends_at.is_some() {
            return unwilling("the daemon is ending".to_owned());
        }
        if self.bodies.len() >= BODIES_MAX {
            return unwilling(format!("{BODIES_MAX} bodies are attached, which is all a daemon takes"));
        }
        if let Some(other) = self.bodies.values().find(|other| other.session.description().name == *body) {
            // Mostly the same body, whose end has not been noticed yet: it tries again in a moment.
            let (number, pid) = (other.session.number(), other.pid);
            return unwilling(format!(
                "body {body} is attached already, in session {number} by process {pid}"
            ));
        }
        self.sessions += 1;
        let attached = Session::attach(self.sessions, hello, self.mind.learner_mut());
        // A declaration that contradicts what was learnt stays wrong however often it is tried.
        let (session, _) = attached.map_err(|error| Refusal::Declaration {
            place: format!("body {body}"),
            problem: error.to_string(),
        })?;
        let (kind, pid) = (&hello.description.kind, hello.pid);
        tracing::info!(session = self.sessions, %body, %kind, pid, "body attached");
        self.ended.retain(|ended| ended.name != *body);
        self.bodies.insert(self.sessions, Attached { session, pid });
        Ok(self.sessions)
    }

    fn frame(&mut self, frame: &RawFrame, reply: FrameReply) {
        let began = Instant::now();
        let number = reply.session();
        let student = self.mind.learner().memory().content().progress.student;
        let student_attached = self.bodies.values().any(|body| Some(body.session.body()) == student);
        let Some(body) = self.bodies.get_mut(&number) else {
            return log_undelivered(reply.refuse(&Refusal::Session { found: number, expected: 0 }));
        };
        if self.ends_at.is_some() {
            log_undelivered(reply.send(&Reply::Detach));
            return self.gone(number, "left");
        }
        let listening = self.mind.is_listening(&body.session, student_attached);
        let served = self.mind.serve(&mut body.session, frame, listening);
        if let Reply::Refused { reason, .. } = &served.reply {
            log_refused(body.session.counters().frames_refused, Some(number), reason);
        }
        log_undelivered(reply.send(&served.reply));
        if let Some(step) = served.step {
            self.mind.stepped(&body.session, step, began);
        }
    }

    /// Counts a message that the transport refused: in the session of the process it came from, if it has one,
    /// so that `status` shows whose fault it is.
    fn refused(&mut self, session: Option<u64>, refusal: &Refusal) {
        let body = session.and_then(|number| self.bodies.get_mut(&number));
        let (session, count) = match body {
            Some(body) => {
                body.session.count_refused(refusal);
                (session, body.session.counters().frames_refused)
            }
            None => {
                self.strays += 1;
                (None, self.strays)
            }
        };
        log_refused(count, session, &refusal.to_string());
    }

    fn gone(&mut self, session: u64, state: &str) {
        let Some(body) = self.bodies.remove(&session) else { return };
        tracing::info!(session, body = %body.session.description().name, state, "body gone");
        if self.ended.len() >= ENDED_KEPT_MAX {
            self.ended.remove(0);
        }
        self.ended.push(body_status(&body.session, body.pid, state));
    }

    fn tool(&mut self, bytes: &[u8], reply: RequestReply) {
        let request: Request = match codec::decode(bytes) {
            Ok(request) => request,
            Err(error) => {
                let problem =
                    format!("the question can't be read ({error}): use tools and daemon of one release");
                return reply.answer(encoded(&Answer::Error(problem)));
            }
        };
        if let Err(answer) = self.obey(&request) {
            return reply.answer(encoded(&answer));
        }
        self.rouse |= matches!(request, Request::Say { .. } | Request::Stage(_) | Request::Achieve { .. });
        self.asked += 1;
        match self.inspector.ask(self.asked, request, self.view()) {
            Ok(()) => {
                self.asking.insert(self.asked, reply);
            }
            Err(answer) => reply.answer(answer),
        }
    }

    /// Obeys an order. `Err` is an answer that needs no inspection.
    fn obey(&mut self, request: &Request) -> Result<(), Answer> {
        let failed = |problem: String| Answer::Error(problem);
        match request {
            Request::Say { words } => self.mind.say(words).map_err(|error| failed(error.to_string())),
            Request::Stage(order) => {
                let command = match order {
                    StageOrder::Show => return Ok(()),
                    StageOrder::Next => StageCommand::Next,
                    StageOrder::Hold => StageCommand::Hold,
                    StageOrder::Resume => StageCommand::Resume,
                    StageOrder::Set(name) => StageCommand::Set(name.clone()),
                };
                self.mind.stage(&command).map_err(|error| failed(error.to_string()))
            }
            Request::Shutdown => {
                self.end();
                Err(Answer::Done)
            }
            Request::Status
            | Request::Schemas(_)
            | Request::Show { .. }
            | Request::Explain { .. }
            | Request::Report
            | Request::Trace { .. }
            | Request::Predict { .. }
            | Request::Plan { .. }
            | Request::Pursuit => Ok(()),
            Request::Achieve { goal, actions_max } => {
                let body = self.shown().map(|body| body.session.body());
                let body = body.ok_or_else(|| failed(NO_BODY.to_owned()))?;
                self.mind.achieve(body, goal, *actions_max).map_err(|error| failed(error.to_string()))
            }
            Request::Cancel { number } => {
                self.mind.cancel(*number).map_err(|error| failed(error.to_string()))
            }
        }
    }

    /// The body that tools ask about: the one that the curriculum leads, or the first attached.
    fn shown(&self) -> Option<&Attached> {
        let student = self.mind.learner().memory().content().progress.student;
        let led = self.bodies.values().find(|body| Some(body.session.body()) == student);
        led.or_else(|| self.bodies.values().next())
    }

    fn view(&self) -> View {
        let learner = self.mind.learner();
        let shown = self.shown();
        let attached = self.bodies.values().map(|body| body_status(&body.session, body.pid, "attached"));
        self.mind.view(HostFacts {
            name: self.name.clone(),
            bodies: attached.chain(self.ended.iter().cloned()).collect(),
            world: shown.map(|body| body.session.world(learner)).unwrap_or_default(),
            perceived: shown.map(|body| (body.session.body(), body.session.perceived().to_vec())),
        })
    }
}

/// Logs a refusal, the more rarely the more there are: a peer must not be able to fill a disk.
fn log_refused(count: u64, session: Option<u64>, reason: &str) {
    if count.is_power_of_two() {
        tracing::warn!(session, count, %reason, "refused");
    } else {
        tracing::debug!(session, count, %reason, "refused");
    }
}

fn log_undelivered(sent: Result<(), pschema_protocol::transport::server::Undelivered>) {
    if let Err(error) = sent {
        // The session ends when the transport notices that the body has gone.
        tracing::info!(%error, "a reply was not delivered");
    }
}

/// A session as tools see it.
pub(crate) fn body_status(session: &Session, pid: u32, state: &str) -> BodyStatus {
    let counters = session.counters();
    BodyStatus {
        id: session.number(),
        name: session.description().name.clone(),
        kind: session.description().kind.clone(),
        pid,
        state: state.to_owned(),
        frames: counters.frames,
        frames_refused: counters.frames_refused,
        last_refusal: counters.last_refusal.clone(),
    }
}
