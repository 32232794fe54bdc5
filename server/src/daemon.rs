//! The daemon: one closed set of events, one loop, one thread. It steps the learner at its own pace; what a
//! tool wants to know is worked out on another thread.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pschema_inspect::codec::{self, Problem, Reply as ToolReply};
use pschema_inspect::{BodyState, BodyStatus, Order, Request, StageOrder};
use pschema_learner::effect::Effect;
use pschema_learner::progress::StageCommand;
use pschema_learner::{LearnerError, Step};
use pschema_protocol::domain::{OwnedDomain, Place};
use pschema_protocol::limits::BODIES_MAX;
use pschema_protocol::refusal::Refusal;
use pschema_protocol::transport::DaemonWaker;
use pschema_protocol::transport::server::{AttachReply, FrameReply, Incoming, RequestReply, ServerTransport};
use pschema_protocol::wire::decode;
use pschema_protocol::wire::message::{Introduction, RawFrame, RawHello, Reply};
use pschema_store::{Cause, Opened, Options, Store};

use crate::ServerError;
use crate::inspect::{NO_BODY, encoded, problem};
use crate::inspector::{Inspected, Inspector, JOBS_MAX};
use crate::keeper::{Keeper, Keeping, now_unix_ms};
use crate::mind::{HostFacts, Mind, Setup, View};
use crate::refusals::{LogBudget, Refusals};
use crate::session::{Session, is_through};
use crate::supervise::Supervisor;

/// How long the loop sleeps when nothing comes in; a stop flag set by a signal is seen within it.
const SLEEP_MAX: Duration = Duration::from_millis(100);
/// How long bodies have to come for their farewell when the daemon ends.
const FAREWELL_MAX: Duration = Duration::from_secs(1);
/// Steps that one action may take to be decided on: surroundings are arranged first where a trial begins.
const SINGLE_STEPS_MAX: u32 = 8;
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
    serve_kept(place, setup, None, stop)
}

/// As [`serve`], with a memory that is kept as `keeping` says: it goes on from what is there.
///
/// # Errors
/// As [`serve`]; and when memory can't be found again or not be kept any more. Nothing is done then that rests on what
/// is not on disk.
pub fn serve_kept(
    place: Place,
    setup: Setup,
    keeping: Option<&Keeping>,
    stop: &AtomicBool,
) -> Result<(), ServerError> {
    let name = place.learner().to_string();
    let mut transport = ServerTransport::create(OwnedDomain::create(place)?)?;
    let waker = transport.waker()?;
    let inspector = Inspector::start(move || waker.wake()).map_err(ServerError::Thread)?;
    let (mind, store) = match keeping {
        None => (Mind::new(setup)?, None),
        Some(keeping) => {
            found(&name, setup, keeping, transport.waker()?).map(|(mind, store)| (mind, Some(store)))?
        }
    };
    let mut daemon = Daemon::new(name, mind, inspector, Keeper::new(store));
    match daemon.keeper.facts() {
        Some(kept) => tracing::info!(
            learner = %daemon.name, pid = std::process::id(), directory = kept.directory,
            durability = %kept.durability, step = kept.durable_step, "ready"
        ),
        None => {
            tracing::info!(learner = %daemon.name, pid = std::process::id(), "ready; memory is kept in RAM only")
        }
    }
    let mut supervisor = Supervisor::from_environment();
    supervisor.ready(&daemon.summary());
    let sleep = SLEEP_MAX.min(supervisor.sleep_max());
    while !daemon.is_over(Instant::now()) {
        supervisor.turned(|| daemon.summary());
        transport.wait(sleep);
        if stop.load(Ordering::Relaxed) {
            daemon.on(Event::Signal);
        }
        transport.poll(&mut |incoming| daemon.on(incoming.into()));
        while let Some(answer) = daemon.inspector.answer() {
            daemon.on(Event::Inspected(answer));
        }
        daemon.release();
        if let Some(failure) = daemon.keeper.failure() {
            return Err(failure.into());
        }
        if std::mem::take(&mut daemon.rouse) {
            daemon.bodies.keys().for_each(|session| transport.rouse(*session));
        }
    }
    supervisor.stopping();
    tracing::info!(learner = %daemon.name, steps = daemon.mind.learner().memory().content().step, "ended");
    // What the inspector still works on is for tools that will find the daemon gone.
    daemon.keeper.finish(daemon.mind.learner().memory())?.for_each(Held::leave);
    Ok(())
}

/// The mind whose memory is in a data directory.
fn found(
    name: &str,
    setup: Setup,
    keeping: &Keeping,
    waker: DaemonWaker,
) -> Result<(Mind, Store), ServerError> {
    let Setup { seed, parameters, curriculum } = setup;
    parameters.check().map_err(LearnerError::from)?;
    curriculum.check().map_err(LearnerError::from)?;
    let options = Options {
        learner: name,
        seed,
        parameters: &parameters,
        curriculum: &curriculum,
        seed_given: keeping.seed_given,
        setting_given: keeping.setting_given,
        change: keeping.change,
        at_unix_ms: now_unix_ms(),
        durability: keeping.durability,
        retention: keeping.retention,
    };
    let wake = move || waker.wake();
    let Opened { learner, seed, changed, store } = pschema_store::open(&keeping.directory, options, wake)?;
    let found = store.recovered();
    tracing::info!(
        step = found.step,
        snapshot = found.snapshot_step,
        frames = found.frames,
        schemas = learner.memory().content().schemas.len(),
        seed,
        curriculum = learner.curriculum().name,
        "memory found"
    );
    if changed {
        tracing::warn!(
            curriculum = learner.curriculum().name,
            "it goes on under other parameters or another curriculum from here, as asked"
        );
    }
    Ok((Mind::resume(learner, seed), store))
}

/// What waits until memory is durable.
#[derive(Debug)]
enum Held {
    /// A reply to a body; when its frame came, if a step was taken on it.
    Reply(FrameReply, Reply, Option<Instant>),
    /// An answer to a tool.
    Answer(RequestReply, Vec<u8>),
}

impl Held {
    fn leave(self) {
        match self {
            Self::Reply(to, reply, _) => log_undelivered(to.send(&reply)),
            Self::Answer(to, bytes) => to.answer(bytes),
        }
    }
}

/// One action that is asked of a learner that is held.
#[derive(Clone, Copy, Debug)]
struct Single {
    /// The body that it is asked with: no other may take it.
    session: u64,
    /// Steps that there may still be until it is decided on.
    steps_left: u32,
}

impl Single {
    /// What is left of it after a step.
    fn after(self, step: &Step) -> Option<Self> {
        let steps_left = self.steps_left.saturating_sub(1);
        (step.decision.is_none() && steps_left > 0).then_some(Self { steps_left, ..self })
    }
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
    /// Messages refused, of bodies and tools.
    refusals: Refusals,
    /// How much may be logged of what peers do.
    log: LogBudget,
    inspector: Inspector,
    /// Whom to answer, and after which batch.
    asking: BTreeMap<u64, (RequestReply, u64)>,
    asked: u64,
    keeper: Keeper<Held>,
    /// The last batch that an order or a step led to.
    batch: u64,
    /// The one action that is asked of the learner while it is held, if one is.
    single: Option<Single>,
    /// Whether bodies that rest are wanted again.
    rouse: bool,
    /// Set when the daemon is ending: when it ends, whether bodies have left or not.
    ends_at: Option<Instant>,
}

impl Daemon {
    fn new(name: String, mind: Mind, inspector: Inspector, keeper: Keeper<Held>) -> Self {
        Self {
            name,
            mind,
            bodies: BTreeMap::new(),
            ended: Vec::new(),
            sessions: 0,
            refusals: Refusals::default(),
            log: LogBudget::default(),
            inspector,
            asking: BTreeMap::new(),
            asked: 0,
            keeper,
            batch: 0,
            single: None,
            rouse: false,
            ends_at: None,
        }
    }

    /// What it is doing, in a line.
    fn summary(&self) -> String {
        let Self { name, bodies, mind, .. } = self;
        let content = mind.learner().memory().content();
        format!(
            "learner {name}: step {}, {} schemas, bodies attached: {}",
            content.step,
            content.schemas.len(),
            bodies.len()
        )
    }

    fn is_over(&self, now: Instant) -> bool {
        self.ends_at.is_some_and(|end| self.bodies.is_empty() || now >= end)
    }

    fn on(&mut self, event: Event<'_>) {
        match event {
            Event::Hello { hello, reply } => self.hello(&hello, reply),
            Event::Frame { frame, reply } => self.frame(frame, reply),
            Event::PeerGone { session, farewell } => {
                self.gone(session, if farewell { BodyState::Left } else { BodyState::Lost })
            }
            Event::Tool { bytes, reply } => self.tool(&bytes, reply),
            Event::Refused { session, refusal } => self.refused(session, &refusal),
            Event::Inspected(Inspected { number, bytes }) => {
                if let Some((reply, batch)) = self.asking.remove(&number) {
                    self.keeper.hold(batch, Held::Answer(reply, bytes));
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
                    self.gone(session, BodyState::Lost);
                }
                sent
            }
            Err(refusal) => {
                self.count_refused(None, refusal.code(), &refusal.to_string());
                reply.refuse(&refusal, &name)
            }
        };
        if let Err(error) = sent {
            tracing::debug!(%error, "a body went before it was welcomed");
        }
    }

    /// Opens a session for a body.
    fn attach(&mut self, hello: &Introduction) -> Result<u64, Refusal> {
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
        let (session, effects) = attached.map_err(|error| Refusal::Declaration {
            place: format!("body {body}"),
            problem: error.to_string(),
        })?;
        // The welcome need not wait: nothing is done before the first step, which is written after this.
        self.keep(Cause::Declared(body), &effects);
        let (kind, pid) = (&hello.description.kind, hello.pid);
        if self.log.takes() {
            tracing::info!(session = self.sessions, %body, %kind, pid, "body attached");
        }
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
            return self.gone(number, BodyState::Left);
        }
        // One action while held: it goes on for this frame only. On disk that is one batch, so that whoever finds this memory
        // again, whenever the daemon died, finds it held.
        let single = self.single.filter(|single| single.session == number);
        let resumed = if single.is_some() { self.mind.once(&StageCommand::Resume) } else { Vec::new() };
        let listening = self.mind.is_listening(&body.session, student_attached);
        let served = self.mind.serve(&mut body.session, frame, listening);
        if let Reply::Refused { code, reason } = &served.reply {
            self.refusals.count(Some(number), *code, reason, &mut self.log);
        }
        let held = if single.is_some() { self.mind.once(&StageCommand::Hold) } else { Vec::new() };
        if let Some(step) = &served.step {
            let content = self.mind.learner().memory().content();
            let cause = Cause::Step(body.session.input());
            self.batch = match single {
                None => self.keeper.keep(cause, &step.effects, content),
                Some(_) => self.keeper.keep(cause, &[&resumed[..], &step.effects, &held].concat(), content),
            };
            self.single = single.and_then(|single| single.after(step));
        }
        let decided = began.elapsed();
        let stepped = served.step.is_some().then_some(began);
        self.keeper.hold(self.batch, Held::Reply(reply, served.reply, stepped));
        self.release();
        if let Some(body) = self.bodies.get(&number)
            && let Some(step) = served.step
        {
            self.mind.stepped(&body.session, step, decided);
        }
    }

    /// Has what changed memory written.
    fn keep(&mut self, cause: Cause<'_>, effects: &[Effect]) {
        self.batch = self.keeper.keep(cause, effects, self.mind.learner().memory().content());
    }

    /// Lets leave what may.
    fn release(&mut self) {
        while let Some(held) = self.keeper.released() {
            let began = if let Held::Reply(_, _, began) = &held { *began } else { None };
            held.leave();
            if let Some(began) = began {
                self.mind.committed(began.elapsed());
            }
        }
    }

    /// Counts a message that the transport refused: in the session of the process it came from, if it has one,
    /// so that `status` shows whose fault it is.
    fn refused(&mut self, session: Option<u64>, refusal: &Refusal) {
        let body = session.and_then(|number| self.bodies.get_mut(&number));
        let session = body.map(|body| {
            body.session.count_refused(refusal);
            body.session.number()
        });
        self.count_refused(session, refusal.code(), &refusal.to_string());
    }

    fn count_refused(&mut self, session: Option<u64>, code: u32, reason: &str) {
        self.refusals.count(session, code, reason, &mut self.log);
    }

    fn gone(&mut self, session: u64, state: BodyState) {
        let Some(body) = self.bodies.remove(&session) else { return };
        self.single = self.single.filter(|single| single.session != session);
        if self.log.takes() {
            tracing::info!(session, body = %body.session.description().name, %state, "body gone");
        }
        if self.ended.len() >= ENDED_KEPT_MAX {
            self.ended.remove(0);
        }
        self.ended.push(body_status(&body.session, body.pid, state));
    }

    fn tool(&mut self, bytes: &[u8], reply: RequestReply) {
        let request: Request = match codec::decode(bytes) {
            Ok(request) => request,
            Err(error) => {
                let refusal = Refusal::Request { problem: error.to_string() };
                self.count_refused(None, refusal.code(), &refusal.to_string());
                return reply.answer(problem(refusal.to_string()));
            }
        };
        // Looked at first: an order must not be obeyed and then refused.
        // What stops the learner is obeyed however many wait, and its answer may be that they do.
        let stops = matches!(request, Request::Order(Order::Shutdown(_) | Order::Stage(StageOrder::Hold)));
        if self.asking.len() >= JOBS_MAX && !stops {
            let full = format!("{JOBS_MAX} questions are waiting: ask again later; nothing was done");
            return reply.answer(problem(full));
        }
        let question = match request {
            Request::Question(question) => question,
            Request::Order(order) => {
                if let Err(why) = self.obey(&order) {
                    return reply.answer(encoded(&ToolReply::<()>::Problem(why)));
                }
                self.rouse |= matches!(order, Order::Say(_) | Order::Stage(_) | Order::Achieve(_));
                let Some(question) = order.told_by() else {
                    return reply.answer(encoded(&ToolReply::Answer(())));
                };
                question
            }
        };
        self.asked += 1;
        match self.inspector.ask(self.asked, question, self.view()) {
            Ok(()) => {
                self.asking.insert(self.asked, (reply, self.batch));
            }
            // It was obeyed, which is not to be taken for a refusal.
            Err(_) if stops => reply.answer(problem(format!(
                "it is held; {JOBS_MAX} questions are waiting, so no more can be told of it"
            ))),
            Err(answer) => reply.answer(answer),
        }
    }

    /// Obeys an order.
    fn obey(&mut self, order: &Order) -> Result<(), Problem> {
        match order {
            Order::Say(order) => self.mind.say(&order.words).map_err(Problem::of),
            Order::Stage(order) => self.lead(order),
            Order::Achieve(order) => {
                let body =
                    self.shown().map(|body| body.session.body()).ok_or_else(|| Problem::of(NO_BODY))?;
                let effects = self.mind.achieve(body, &order.goal, order.actions_max).map_err(Problem::of)?;
                let (goal, actions_max) = (order.goal.join(" and "), order.actions_max);
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
            StageOrder::Step => return self.single_step().map_err(Problem),
            StageOrder::Next => StageCommand::Next,
            StageOrder::Hold => StageCommand::Hold,
            StageOrder::Resume => StageCommand::Resume,
            StageOrder::Set(name) => StageCommand::Set(name.clone()),
        };
        let effects = self.mind.stage(&command).map_err(Problem::of)?;
        self.keep(Cause::Order(&ordered(&command)), &effects);
        self.single = None;
        Ok(())
    }

    /// Takes one action and is then held.
    fn single_step(&mut self) -> Result<(), String> {
        let content = self.mind.learner().memory().content();
        let progress = &content.progress;
        let pursues = content.pursuit.as_ref().is_some_and(|pursuit| pursuit.under_way());
        if let Some(why) = progress.stuck.as_deref().filter(|_| !pursues) {
            return Err(format!("there is no step to take: the learner is stuck: {why}"));
        }
        if is_through(self.mind.learner()) {
            return Err(
                "there is no step to take: the curriculum is over; `pschema stage set NAME` goes back"
                    .to_owned(),
            );
        }
        let session = self.shown().map(|body| body.session.number()).ok_or_else(|| NO_BODY.to_owned())?;
        let effects = self.mind.stage(&StageCommand::Hold).map_err(|error| error.to_string())?;
        self.keep(Cause::Order("stage step"), &effects);
        self.single = Some(Single { session, steps_left: SINGLE_STEPS_MAX });
        Ok(())
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
        let attached =
            self.bodies.values().map(|body| body_status(&body.session, body.pid, BodyState::Attached));
        self.mind.view(HostFacts {
            name: self.name.clone(),
            bodies: attached.chain(self.ended.iter().cloned()).collect(),
            world: shown.map(|body| body.session.world(learner)).unwrap_or_default(),
            perceived: shown.map(|body| (body.session.body(), body.session.perceived().to_vec())),
            before: shown.map(|body| body.session.perceived_before().to_vec()).unwrap_or_default(),
            storage: self.keeper.facts(),
            refused: self.refusals.counts(),
        })
    }
}

/// An operator's order as people give it.
fn ordered(command: &StageCommand) -> String {
    match command {
        StageCommand::Next => "stage next".to_owned(),
        StageCommand::Hold => "stage hold".to_owned(),
        StageCommand::Resume => "stage resume".to_owned(),
        StageCommand::Set(name) => format!("stage set {name}"),
    }
}

fn log_undelivered(sent: Result<(), pschema_protocol::transport::server::DeliveryError>) {
    if let Err(error) = sent {
        // The session ends when the transport notices that the body has gone. A body that asks and does not wait for
        // the reply could fill the log with this.
        tracing::debug!(%error, "a reply was not delivered");
    }
}

/// A session as tools see it.
pub(crate) fn body_status(session: &Session, pid: u32, state: BodyState) -> BodyStatus {
    let counters = session.counters();
    BodyStatus {
        id: session.number(),
        name: session.description().name.clone(),
        kind: session.description().kind.clone(),
        pid,
        state,
        frames: counters.frames,
        frames_refused: counters.frames_refused,
        last_refusal: counters.last_refusal.clone(),
    }
}
