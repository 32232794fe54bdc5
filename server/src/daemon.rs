//! The daemon: one closed set of events, one loop, one thread. The loop steps the learner at its own pace; another thread
//! works out the answers to the questions of tools.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_inspect::codec::{self, Problem, Reply as ToolReply};
use pschema_inspect::{BodyState, Order, OrderFailure, Request, StageOrder};
use pschema_learner::effect::Effect;
use pschema_learner::progress::StageCommand;
use pschema_process::require_descriptors;
use pschema_protocol::domain::{OwnedDomain, Place, RuntimeDir};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::transport::server::{
    AttachReply, DeliveryError, FrameReply, Incoming, RequestReply, ServerTransport,
};
use pschema_protocol::wire::decode;
use pschema_protocol::wire::message::{Introduction, RawFrame, RawHello, Reply};
use pschema_store::Cause;

use crate::error::ServerError;
use crate::inspect::{encoded, problem};
use crate::inspector::{Inspector, JOBS_MAX};
use crate::keeper::{Keeper, Keeping};
use crate::mind::{Mind, NO_BODY};
use crate::opening;
use crate::refusals::{LogBudget, Refusals};
use crate::resident::{self, Gauge};
use crate::session::Session;
use crate::sessions::{Attachment, Sessions};
use crate::setup::Setup;
use crate::supervise::Supervisor;
use crate::view::{Host, View};
use crate::waker::Waker;

/// How long the loop sleeps at most when nothing comes in. Within that time it sees a stop flag that a signal set.
const SLEEP_MAX: Duration = Duration::from_millis(100);
/// How often the daemon looks whether peers can still reach it.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// How long the daemon waits at its end for bodies to ask once more, so that it can send them away.
const FAREWELL_MAX: Duration = Duration::from_secs(1);

/// The files that a daemon with all its bodies and tools has open, generously rounded up. One that has none left could not go on
/// to another file of the journal.
const DESCRIPTORS_NEEDED: u64 = 1024;

/// What a daemon allows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Hosting {
    /// How many bytes of memory the process may take until nothing new is learnt; none without a limit.
    pub memory_max: Option<u64>,
    /// Whether a body may declare otherwise than when it attached before.
    pub accept_changes: bool,
}

/// Everything that can happen to the daemon.
enum Event<'a> {
    /// A body or a tool sent something, or has gone.
    Incoming(Incoming<'a>),
    /// The inspector has worked out an answer, encoded here.
    Answer(Asker, Vec<u8>),
    /// A signal asks the daemon to end.
    Signal,
}

/// Serves a learner at `place` until `stop` is set or a tool orders the daemon to end. Memory is in RAM and ends with
/// the daemon.
///
/// # Errors
/// When the learner can't be made, another daemon serves the place, or shared memory can't be used. Nothing else that a
/// body or a tool does ends the daemon.
pub fn serve(place: Place, setup: Setup, stop: &AtomicBool) -> Result<(), ServerError> {
    serve_kept(place, setup, None, Hosting::default(), stop)
}

/// As [`serve`], with a memory that is kept as `keeping` says: the learner goes on from the memory that the data
/// directory holds.
///
/// # Errors
/// As [`serve`]; and when memory can't be read from the data directory, or can no longer be written to it. In that case
/// no reply leaves that rests on a step that is not on disk.
pub fn serve_kept(
    place: Place,
    setup: Setup,
    keeping: Option<&Keeping>,
    hosting: Hosting,
    stop: &AtomicBool,
) -> Result<(), ServerError> {
    require_descriptors("a daemon with all its bodies and tools", DESCRIPTORS_NEEDED)?;
    let name: Arc<str> = place.learner().to_string().into();
    let domain = OwnedDomain::create(place.clone())?;
    let waker = Waker::default();
    let woken = waker.clone();
    let inspector = Inspector::start(move || woken.wake()).map_err(ServerError::Thread)?;
    let (mind, store) = match keeping {
        None => (Mind::new(setup)?, None),
        Some(keeping) => {
            let opened = opening::open_unless_stopped(&name, setup, keeping, waker.clone(), stop)?;
            let Some((mind, store)) = opened else { return Ok(()) };
            (mind, Some(store))
        }
    };
    // Only now: bodies and tools that come while memory is being found, which may take long, are told that the daemon is starting.
    let mut transport = ServerTransport::create(domain)?;
    waker.renew(transport.waker()?);
    let mut daemon = Daemon::new(name, mind, inspector, Keeper::new(store), hosting);
    match daemon.keeper.storage() {
        Some(storage) => tracing::info!(
            learner = %daemon.name, pid = std::process::id(), directory = storage.directory,
            durability = %storage.durability, step = storage.durable_step, "ready"
        ),
        None => {
            tracing::info!(learner = %daemon.name, pid = std::process::id(), "ready; memory is kept in RAM only")
        }
    }
    daemon.tell_if_full();
    let mut supervisor = Supervisor::from_environment();
    supervisor.ready(&daemon.summary());
    let sleep = SLEEP_MAX.min(supervisor.sleep_max());
    let mut next_look = Instant::now();
    while !daemon.is_over(Instant::now()) {
        supervisor.turned(|| daemon.summary());
        transport.wait(sleep);
        if stop.load(Ordering::Relaxed) {
            daemon.on(Event::Signal);
        }
        transport.poll(&mut |incoming| daemon.on(Event::Incoming(incoming)));
        while let Some((asker, answer)) = daemon.inspector.answer() {
            daemon.on(Event::Answer(asker, answer));
        }
        daemon.release();
        daemon.measure();
        if let Some(failure) = daemon.keeper.failure() {
            return Err(failure.into());
        }
        if Instant::now() >= next_look {
            next_look = Instant::now() + LOOK_EVERY;
            if let Some(why) = transport.domain().loss() {
                daemon.lose_peers();
                transport = anew(transport, &place, why)?;
                waker.renew(transport.waker()?);
            }
        }
        if std::mem::take(&mut daemon.rouse) {
            daemon.sessions.numbers().for_each(|session| transport.rouse(session));
        }
    }
    supervisor.stopping();
    // Answers that the inspector still works on are dropped: their tools find the daemon gone.
    daemon.keeper.finish(daemon.mind.learner().memory())?.for_each(Delivery::deliver);
    tracing::info!(learner = %daemon.name, steps = daemon.mind.learner().memory().content().step, "ended");
    Ok(())
}

/// Begins a new epoch in place of one that no peer can join any more. Memory stays; bodies and tools connect anew.
fn anew(lost: ServerTransport, place: &Place, why: String) -> Result<ServerTransport, ServerError> {
    tracing::warn!(%why, "bodies and tools can't reach the daemon any more: it begins a new epoch");
    // The lock is taken anew as well.
    drop(lost);
    let begin = || {
        // The runtime directory may have gone with all that was in it.
        let runtime = RuntimeDir::at(place.runtime().path())?;
        let domain = OwnedDomain::create(Place::new(runtime, place.learner().clone()))?;
        Ok(ServerTransport::create(domain)?)
    };
    begin().map_err(|error: ServerError| ServerError::Unreachable { why, error: Box::new(error) })
}

/// A tool that waits for an answer.
struct Asker {
    reply: RequestReply,
    /// The batch that must be durable before the answer leaves, of an order that changed memory. A question waits for no disk.
    batch: Option<u64>,
}

/// A message for a body or a tool, which leaves when memory is durable.
#[derive(Debug)]
enum Delivery {
    /// A reply to a body; with the time at which its frame came, if a step was taken on it.
    Reply(FrameReply, Reply, Option<Instant>),
    /// An answer to a tool.
    Answer(RequestReply, Vec<u8>),
}

impl Delivery {
    fn deliver(self) {
        match self {
            Self::Reply(to, reply, _) => log_undelivered(to.send(&reply)),
            Self::Answer(to, bytes) => to.answer(bytes),
        }
    }
}

struct Daemon {
    name: Arc<str>,
    mind: Mind,
    sessions: Sessions,
    /// Messages of bodies and tools that were refused.
    refusals: Refusals,
    /// How many lines of the log peers may still cause.
    log: LogBudget,
    inspector: Inspector<Asker>,
    keeper: Keeper<Delivery>,
    /// The number of the last batch of changes that was handed to the keeper.
    batch: u64,
    hosting: Hosting,
    gauge: Gauge,
    /// How much it took when the trace of decisions last gave something up: as much is taken still, and free to be used.
    spared_at: u64,
    /// Set when an order may have given resting bodies something to do: they are woken.
    rouse: bool,
    /// Set when the daemon is ending: the time at which it ends even if bodies are still attached.
    ends_at: Option<Instant>,
}

impl Daemon {
    fn new(
        name: Arc<str>,
        mind: Mind,
        inspector: Inspector<Asker>,
        keeper: Keeper<Delivery>,
        hosting: Hosting,
    ) -> Self {
        Self {
            name,
            mind,
            sessions: Sessions::default(),
            refusals: Refusals::default(),
            log: LogBudget::default(),
            inspector,
            keeper,
            batch: 0,
            hosting,
            gauge: Gauge::default(),
            spared_at: 0,
            rouse: false,
            ends_at: None,
        }
    }

    /// The learner's name, step and schemas and how many bodies are attached, in one line for the service manager.
    fn summary(&self) -> String {
        let Self { name, sessions, mind, .. } = self;
        let content = mind.learner().memory().content();
        format!(
            "learner {name}: step {}, {} schemas, bodies attached: {}",
            content.step,
            content.schemas.len(),
            sessions.numbers().len()
        )
    }

    fn is_over(&self, now: Instant) -> bool {
        self.ends_at.is_some_and(|end| self.sessions.numbers().len() == 0 || now >= end)
    }

    fn on(&mut self, event: Event<'_>) {
        match event {
            Event::Incoming(Incoming::Hello { hello, reply }) => self.hello(&hello, reply),
            Event::Incoming(Incoming::Frame { frame, reply }) => self.frame(frame, reply),
            Event::Incoming(Incoming::BodyGone { session, farewell }) => {
                self.gone(session, if farewell { BodyState::Left } else { BodyState::Lost });
            }
            Event::Incoming(Incoming::Request { bytes, reply }) => self.tool(&bytes, reply),
            Event::Incoming(Incoming::Refused { session, refusal }) => self.refused(session, &refusal),
            Event::Answer(Asker { reply, batch: None }, bytes) => reply.answer(bytes),
            Event::Answer(Asker { reply, batch: Some(batch) }, bytes) => {
                self.keeper.hold(batch, Delivery::Answer(reply, bytes));
            }
            Event::Signal => self.end(),
        }
    }

    /// The memory that the process may take, and the part of it below which there is room again: a little less does not count as
    /// room, for what was freed is soon taken again.
    fn memory_bounds(&self) -> (u64, u64) {
        let max = self.hosting.memory_max.unwrap_or(u64::MAX);
        (max, max / 10 * 9)
    }

    /// Warns of a memory that was full before this start, and is still.
    fn tell_if_full(&self) {
        let ((max, room_below), bytes) = (self.memory_bounds(), resident::bytes());
        if self.mind.learner().memory().content().full && bytes >= room_below {
            tracing::warn!(
                bytes,
                max,
                "memory is as full as it was: nothing new is learnt. Give a larger --memory-max, or none, and declare coarser senses"
            );
        }
    }

    /// Has the learner take in nothing new while the process takes as much memory as it may. The trace of decisions gives way first.
    fn measure(&mut self) {
        let (max, room_below) = self.memory_bounds();
        let was_full = self.mind.learner().memory().content().full;
        // A memory that is full grows no more.
        let near_at = if was_full { u64::MAX } else { max / 4 * 3 };
        let Some(bytes) = self.gauge.read(Instant::now(), near_at, resident::bytes) else { return };
        if bytes < room_below {
            self.mind.trace_mut().lengthen();
        }
        let full = if was_full { bytes >= room_below } else { bytes >= max && bytes > self.spared_at };
        if full && self.mind.trace_mut().shorten() {
            self.spared_at = bytes;
            return;
        }
        let effects = self.mind.learner_mut().set_full(full);
        if effects.is_empty() {
            return;
        }
        if full {
            tracing::warn!(bytes, max, "memory has come to --memory-max: nothing new is learnt from here");
            self.keep(Cause::Order("memory-max: learn nothing new"), &effects);
        } else {
            tracing::info!(bytes, max, "memory has room again: learning goes on");
            self.keep(Cause::Order("memory-max: learn again"), &effects);
        }
    }

    fn end(&mut self) {
        if self.ends_at.is_none() {
            tracing::info!(bodies = self.sessions.numbers().len(), "ending");
            self.ends_at = Some(Instant::now() + FAREWELL_MAX);
            self.rouse = true;
        }
    }

    /// Closes every session and gives up what waits to be sent: nobody is there any more to receive it.
    fn lose_peers(&mut self) {
        let numbers: Vec<_> = self.sessions.numbers().collect();
        for number in numbers {
            self.gone(number, BodyState::Lost);
        }
        self.inspector.forget_askers();
        self.keeper.forget_waiting();
    }

    fn hello(&mut self, hello: &RawHello, reply: AttachReply) {
        let name = self.name.clone();
        let sent = match decode::hello(hello).and_then(|hello| self.attach(&hello)) {
            Ok(session) => {
                let sent = reply.accept(session, &name);
                if sent.is_err() {
                    self.gone(session, BodyState::Lost);
                }
                sent
            }
            Err(refusal) => {
                self.count_refused(None, &refusal);
                reply.refuse(&refusal, &name)
            }
        };
        if let Err(error) = sent {
            tracing::debug!(%error, "a body went before it was welcomed");
        }
    }

    /// Opens a session for a body.
    fn attach(&mut self, hello: &Introduction) -> Result<u64, Refusal> {
        if self.ends_at.is_some() {
            return Err(Refusal::Unwilling { reason: "the daemon is ending".to_owned() });
        }
        let Attachment { session, declared: mut effects, described, accepted } =
            self.sessions.open(hello, self.mind.learner_mut(), self.hosting.accept_changes)?;
        let (body, kind) = (&hello.description.name, &hello.description.kind);
        // The welcome need not wait: nothing is done before the first step, which is written after this.
        let cause = match &accepted {
            Some(accepted) => {
                self.keep(Cause::Declared(body), &std::mem::take(&mut effects));
                Cause::Order(accepted)
            }
            None => Cause::Declared(body),
        };
        effects.extend(described);
        if let Some(session) = self.sessions.get(session) {
            effects.extend(self.mind.examine(session));
        }
        self.keep(cause, &effects);
        if self.log.takes() {
            tracing::info!(session, %body, %kind, pid = hello.pid, "body attached");
        }
        Ok(session)
    }

    fn frame(&mut self, frame: &RawFrame, reply: FrameReply) {
        // Before it is learnt from: many may come before the loop turns.
        self.measure();
        let began = Instant::now();
        let number = reply.session();
        let student_attached = self.sessions.of(self.mind.student()).is_some();
        let Some(session) = self.sessions.get_mut(number) else {
            return log_undelivered(reply.refuse(&Refusal::Session { found: number, expected: 0 }));
        };
        if self.ends_at.is_some() {
            log_undelivered(reply.send(&Reply::Detach));
            return self.gone(number, BodyState::Left);
        }
        let served = self.mind.serve(session, frame, student_attached);
        if let Reply::Refused { code, reason } = &served.reply {
            self.refusals.count(Some(number), *code, reason, &mut self.log);
        }
        if let Some(step) = &served.step {
            let content = self.mind.learner().memory().content();
            if let Some(failure) = session.failure_at(content.step)
                && session.failures_alike().is_power_of_two()
                && self.log.takes()
            {
                log_failure(session, failure);
            }
            for warning in &served.warnings {
                let body = &session.status().name;
                tracing::warn!(session = number, %body, "what the body declares can't be learnt as it is: {warning}");
            }
            self.batch = self.keeper.keep(Cause::Step(session.input()), &step.effects, content);
        }
        let decided = began.elapsed();
        let stepped = served.step.is_some().then_some(began);
        self.keeper.hold(self.batch, Delivery::Reply(reply, served.reply, stepped));
        self.release();
        if let Some(session) = self.sessions.get(number)
            && let Some(step) = served.step
        {
            self.mind.stepped(session, step, decided);
        }
    }

    /// Hands the keeper the `effects` that changed memory, to be written to disk as one batch.
    fn keep(&mut self, cause: Cause<'_>, effects: &[Effect]) {
        self.batch = self.keeper.keep(cause, effects, self.mind.learner().memory().content());
    }

    /// Sends every reply and answer whose batch is durable.
    fn release(&mut self) {
        while let Some(delivery) = self.keeper.released() {
            let began = if let Delivery::Reply(_, _, began) = &delivery { *began } else { None };
            delivery.deliver();
            if let Some(began) = began {
                self.mind.committed(began.elapsed());
            }
        }
    }

    /// Counts a message that the transport refused. If the sending process has a session the message is counted there
    /// too, so that `status` shows which body is faulty.
    fn refused(&mut self, session: Option<u64>, refusal: &Refusal) {
        let session = session.filter(|number| {
            let session = self.sessions.get_mut(*number);
            session.map(|session| session.count_refused(refusal)).is_some()
        });
        self.count_refused(session, refusal);
    }

    fn count_refused(&mut self, session: Option<u64>, refusal: &Refusal) {
        self.refusals.count(session, refusal.code(), &refusal.to_string(), &mut self.log);
    }

    fn gone(&mut self, session: u64, state: BodyState) {
        let Some(status) = self.sessions.close(session, state) else { return };
        if self.log.takes() {
            tracing::info!(session, body = %status.name, %state, "body gone");
        }
    }

    fn tool(&mut self, bytes: &[u8], reply: RequestReply) {
        let request: Request = match codec::decode(bytes) {
            Ok(request) => request,
            Err(error) => {
                let refusal = Refusal::Request { problem: error.to_string() };
                self.count_refused(None, &refusal);
                return reply.answer(problem(refusal.to_string()));
            }
        };
        // Whether there is room is looked at first: an order must not be obeyed and then refused. An order that stops the
        // learner is obeyed however many questions wait; its answer may be that they do.
        let stops = matches!(request, Request::Order(Order::Shutdown(_) | Order::Stage(StageOrder::Hold)));
        if self.inspector.is_full() && !stops {
            let full = format!("{JOBS_MAX} questions are waiting: ask again later; nothing was done");
            return reply.answer(problem(full));
        }
        let (question, batch) = match request {
            Request::Question(question) => (question, None),
            Request::Order(order) => {
                if let Err(why) = self.obey(&order) {
                    return reply.answer(encoded(&ToolReply::<()>::Problem(why)));
                }
                self.rouse |= matches!(order, Order::Say(_) | Order::Stage(_) | Order::Achieve(_));
                let Some(question) = order.told_by() else {
                    return reply.answer(encoded(&ToolReply::Answer(())));
                };
                // Words wait in RAM to be heard, and nothing of them is on disk before.
                (question, (!matches!(order, Order::Say(_))).then_some(self.batch))
            }
        };
        let asker = Asker { reply, batch };
        if let Err((Asker { reply, .. }, why)) = self.inspector.ask(question, self.view(), asker) {
            let why = if stops {
                // The order was obeyed: the answer must not read as a refusal.
                format!("it is held; {JOBS_MAX} questions are waiting, so no more can be told of it")
            } else {
                why
            };
            reply.answer(problem(why));
        }
    }

    /// Obeys an order.
    fn obey(&mut self, order: &Order) -> Result<(), Problem> {
        match order {
            Order::Say(order) => self.mind.say(&order.words).map_err(Problem::of),
            Order::Stage(order) => self.lead(order),
            Order::Achieve(order) => {
                let session = self.sessions.shown(self.mind.student()).ok_or_else(|| Problem::of(NO_BODY))?;
                let effects = self.mind.achieve(session, order).map_err(Problem::of)?;
                let again = if order.again { " again" } else { "" };
                let patterns = || order.goal.join(" and ") + again;
                let goal = order.most.as_ref().map_or_else(patterns, |most| format!("most {most}"));
                let actions_max = order.actions_max;
                self.keep(
                    Cause::Order(&format!("achieve {goal} with at most {actions_max} actions")),
                    &effects,
                );
                Ok(())
            }
            Order::Cancel(order) => {
                let effects = self.mind.cancel(order.number).map_err(Problem::of)?;
                self.keep(Cause::Order(&format!("cancel {}", order.number)), &effects);
                Ok(())
            }
            Order::Shutdown(_) => {
                self.end();
                Ok(())
            }
        }
    }

    /// Obeys an order to the curriculum.
    fn lead(&mut self, order: &StageOrder) -> Result<(), Problem> {
        let command = match order {
            StageOrder::Step => return self.single_step(),
            StageOrder::Next => StageCommand::Next,
            StageOrder::Hold => StageCommand::Hold,
            StageOrder::Resume => StageCommand::Resume,
            StageOrder::Set(name) => StageCommand::Set(name.clone()),
        };
        let mut effects = self.mind.stage(&command).map_err(Problem::of)?;
        // A name that stands for nothing is as wrong in the stage that was entered.
        if let Some(session) = self.sessions.shown(self.mind.student()) {
            effects.extend(self.mind.examine(session));
        }
        self.keep(Cause::Order(&ordered(&command)), &effects);
        Ok(())
    }

    /// Obeys `stage step`: the learner takes one action and is held after it.
    fn single_step(&mut self) -> Result<(), Problem> {
        let session = self.sessions.shown(self.mind.student());
        let effects = self.mind.single_step(session).map_err(Problem::of)?;
        self.keep(Cause::Order("stage step"), &effects);
        Ok(())
    }

    /// The session of the body that tools ask about.
    fn shown(&self) -> Option<&Session> {
        self.sessions.shown(self.mind.student())
    }

    fn view(&self) -> View {
        let host = Host {
            bodies: self.sessions.statuses(),
            storage: self.keeper.storage(),
            refusals: self.refusals.clone(),
            memory_max: self.hosting.memory_max,
        };
        self.mind.view(self.name.clone(), self.shown(), host)
    }
}

/// An operator's order as it is typed, for the journal.
fn ordered(command: &StageCommand) -> String {
    match command {
        StageCommand::Next => "stage next".to_owned(),
        StageCommand::Hold => "stage hold".to_owned(),
        StageCommand::Resume => "stage resume".to_owned(),
        StageCommand::Set(name) => format!("stage set {name}"),
    }
}

/// Logs that a body did not carry an order out. Of the same failure again and again the first, the second, the fourth and
/// so on are logged.
fn log_failure(session: &Session, failure: &OrderFailure) {
    let OrderFailure { outcome, reason, step } = failure;
    let (number, body, count) = (session.number(), &session.status().name, session.failures_alike());
    let reason = reason.as_deref().unwrap_or("none given");
    tracing::warn!(session = number, %body, step, count, %outcome, %reason, "an order was not carried out");
}

fn log_undelivered(sent: Result<(), DeliveryError>) {
    if let Err(error) = sent {
        // The session ends when the transport notices that the body has gone. This is logged at a level that is off by
        // default: a body that asks and does not wait for the reply could fill the log.
        tracing::debug!(%error, "a reply was not delivered");
    }
}
