//! A body under examination: its process, and this process in the place of its daemon.

use std::collections::VecDeque;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use pschema_learner::Learner;
use pschema_learner::curriculum::Curriculum;
use pschema_learner::parameters::Parameters;
use pschema_process::{Stop, relay};
use pschema_protocol::description::{Action, ActionType, Description, Value, ValueKind};
use pschema_protocol::domain::{LearnerName, OwnedDomain, Place, RuntimeDir};
use pschema_protocol::refusal::Refusal;
use pschema_protocol::transport::server::{AttachReply, FrameReply, Incoming, ServerTransport};
use pschema_protocol::wire::decode::{self, SessionChecks};
use pschema_protocol::wire::message::{RawFrame, RawHello, Reply};
use pschema_protocol::wire::purpose;
use pschema_server::session::Session;
use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use tempfile::TempDir;

use crate::failure::Failure;
use crate::run::runtime_directory;

/// Longest sleep between two looks at a process.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// Longest wait for a message before the process of the body is looked at.
const SLICE: Duration = Duration::from_millis(20);

/// How often a resting body is roused.
const ROUSE_EVERY: Duration = Duration::from_millis(100);

/// Why a check failed, in words for the author of the body.
pub(super) type Problem = String;

/// A message of the body.
enum Message {
    Hello(RawHello, AttachReply),
    Frame(Box<RawFrame>, FrameReply),
    /// The transport refused a message.
    Refused(Refusal),
    Gone {
        farewell: bool,
    },
}

/// The session of the body, at a frame that waits for its reply.
struct Open {
    checks: SessionChecks,
    frame: Box<RawFrame>,
    reply: FrameReply,
}

/// A body under examination. Parts are dropped in this order: what waits for a reply before the daemon's end, the process of the body
/// last.
pub(super) struct Examined<'a> {
    open: Option<Open>,
    messages: VecDeque<Message>,
    daemon: Option<ServerTransport>,
    process: Option<Process>,
    command: &'a str,
    name: LearnerName,
    patience: Duration,
    stop: &'a Stop,
    sessions: u64,
    /// What the body could do better in the check that is tried.
    advice: Option<String>,
    directory: TempDir,
}

/// The process of the body and those that it started. Dropping it ends them.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        if let Ok(pid) = i32::try_from(self.0.id())
            && let Some(group) = Pid::from_raw(pid)
        {
            // It has usually ended by now, with all that it started.
            kill_process_group(group, Signal::KILL).ok();
        }
        self.0.wait().ok();
    }
}

impl<'a> Examined<'a> {
    /// A body that `command` starts, and that is to attach to the learner `name`. Nothing is started yet.
    pub(super) fn new(
        command: &'a str,
        name: LearnerName,
        patience: Duration,
        stop: &'a Stop,
    ) -> Result<Self, Failure> {
        Ok(Self {
            open: None,
            messages: VecDeque::new(),
            daemon: None,
            process: None,
            command,
            name,
            patience,
            stop,
            sessions: 0,
            advice: None,
            directory: runtime_directory()?,
        })
    }

    /// Ends the body and the daemon's side, so that the next check begins anew.
    pub(super) fn begin_anew(&mut self) {
        self.advice = None;
        self.end_daemon();
        self.process = None;
    }

    /// Begins a new epoch: the daemon's side as after a restart.
    fn begin_daemon(&mut self) -> Result<&mut ServerTransport, Problem> {
        if self.daemon.is_none() {
            let runtime = RuntimeDir::at(self.directory.path()).map_err(|error| error.to_string())?;
            let domain = OwnedDomain::create(Place::new(runtime, self.name.clone()));
            let domain = domain.map_err(|error| error.to_string())?;
            self.daemon = Some(ServerTransport::create(domain).map_err(|error| error.to_string())?);
        }
        self.daemon.as_mut().ok_or_else(|| "there is no daemon".to_owned())
    }

    /// Ends the daemon's side as if it had been killed: the body is not told.
    pub(super) fn end_daemon(&mut self) {
        self.open = None;
        self.messages.clear();
        self.daemon = None;
    }

    /// Starts the body, unless it runs.
    pub(super) fn begin_process(&mut self) -> Result<(), Problem> {
        if self.process.is_none() {
            let mut shell = Command::new("sh");
            // `exec` makes the command replace the shell, so that it gets the signals itself.
            shell.args(["-c", &format!("exec {}", self.command)]);
            shell.env("PSCHEMA_RUNTIME_DIR", self.directory.path()).env("PSCHEMA_NAME", self.name.as_str());
            shell.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).process_group(0);
            let started = shell.spawn().map_err(|error| format!("the command can't be started: {error}"));
            let mut started = started?;
            let stderr = started.stderr.take();
            self.process = Some(Process(started));
            let told = stderr.map_or(Ok(()), relay);
            told.map_err(|error| format!("what the body says can't be told: {error}"))?;
        }
        Ok(())
    }

    /// The next message of the body; none when the time is up.
    fn message(&mut self, within: Duration) -> Result<Option<Message>, Problem> {
        let begun = Instant::now();
        loop {
            if let Some(message) = self.messages.pop_front() {
                return Ok(Some(message));
            }
            let Some(left) = within.checked_sub(begun.elapsed()) else { return Ok(None) };
            self.stop.check().map_err(|error| error.to_string())?;
            if let Some(status) = self.status()? {
                return Err(format!("the body ended ({status})"));
            }
            let Self { daemon, messages, sessions, .. } = self;
            let Some(daemon) = daemon else { return Ok(None) };
            daemon.wait(left.min(SLICE));
            daemon.poll(&mut |incoming| match incoming {
                Incoming::Hello { hello, reply } => messages.push_back(Message::Hello(hello, reply)),
                Incoming::Frame { frame, reply } => {
                    messages.push_back(Message::Frame(Box::new(frame.clone()), reply))
                }
                // A body that feels the daemon's pulse is told that it lives.
                Incoming::Request { reply, .. } => {
                    reply.answer(b"{\"problem\": \"no learner is here\"}".to_vec())
                }
                Incoming::Refused { session: None, .. } => {}
                Incoming::Refused { refusal, .. } => messages.push_back(Message::Refused(refusal)),
                Incoming::BodyGone { session, farewell } if session == *sessions => {
                    messages.push_back(Message::Gone { farewell });
                }
                // The end of an earlier session is noticed late.
                Incoming::BodyGone { .. } => {}
            });
        }
    }

    /// How the body's process ended; none while it runs.
    fn status(&mut self) -> Result<Option<ExitStatus>, Problem> {
        let Some(Process(child)) = &mut self.process else { return Ok(None) };
        child.try_wait().map_err(|error| format!("the body can't be watched: {error}"))
    }

    fn patient(&mut self, wanted: &str) -> Result<Message, Problem> {
        let patience = self.patience;
        let message = self.message(patience)?;
        message.ok_or_else(|| format!("no {wanted} came within {} s", patience.as_secs_f64()))
    }

    /// The next hello, unchecked.
    pub(super) fn hello(&mut self) -> Result<(RawHello, AttachReply), Problem> {
        self.begin_daemon()?;
        self.begin_process()?;
        self.open = None;
        loop {
            match self.patient("hello")? {
                Message::Hello(hello, reply) => return Ok((hello, reply)),
                // Its session before has come to its end.
                Message::Gone { .. } => {}
                Message::Frame(frame, _) => {
                    return Err(format!("frame {} came where a hello was due", frame.header.sequence));
                }
                Message::Refused(refusal) => {
                    return Err(format!("a message came where a hello was due: {refusal}"));
                }
            }
        }
    }

    /// Has the body attach, unless it is, and brings it to a frame that waits for its reply.
    pub(super) fn attach(&mut self) -> Result<(), Problem> {
        if self.open.is_some() {
            return Ok(());
        }
        let (hello, reply) = self.hello()?;
        let description = described(&hello)?;
        self.welcome(description, reply)
    }

    /// Opens a session, and waits for its first frame.
    pub(super) fn welcome(&mut self, description: Description, reply: AttachReply) -> Result<(), Problem> {
        self.sessions += 1;
        self.messages.clear();
        let accepted = reply.accept(self.sessions, self.name.as_str());
        accepted.map_err(|error| format!("the welcome could not be delivered: {error}"))?;
        let mut checks = SessionChecks::new(self.sessions, description);
        let (frame, reply) = self.frame()?;
        let report = checks.check(&frame).map_err(|refusal| refused(1, &refusal))?.report;
        if report.is_some() {
            return Err(
                "the first frame of a session reports an outcome: nothing was ordered in it".to_owned()
            );
        }
        self.open = Some(Open { checks, frame, reply });
        Ok(())
    }

    fn frame(&mut self) -> Result<(Box<RawFrame>, FrameReply), Problem> {
        match self.patient("frame")? {
            Message::Frame(frame, reply) => Ok((frame, reply)),
            Message::Hello(..) => Err("a hello came where a frame was due".to_owned()),
            Message::Refused(refusal) => Err(refusal.to_string()),
            Message::Gone { .. } => Err("the body left where a frame was due".to_owned()),
        }
    }

    fn take(&mut self) -> Result<Open, Problem> {
        self.attach()?;
        self.open.take().ok_or_else(|| "the body is not attached".to_owned())
    }

    /// The body as it described itself.
    pub(super) fn description(&mut self) -> Result<Description, Problem> {
        self.attach()?;
        let open = self.open.as_ref().ok_or("the body is not attached")?;
        Ok(open.checks.description().clone())
    }

    /// Replies to the body's frame, and waits for the next, which must be acceptable.
    pub(super) fn exchange(&mut self, reply: &Reply) -> Result<(), Problem> {
        let Open { mut checks, reply: to, .. } = self.take()?;
        to.send(reply).map_err(|error| format!("a reply could not be delivered: {error}"))?;
        checks.replied(reply);
        let (frame, reply) = self.frame()?;
        let sequence = frame.header.sequence;
        checks.check(&frame).map_err(|refusal| refused(sequence, &refusal))?;
        self.open = Some(Open { checks, frame, reply });
        Ok(())
    }

    /// Gives an order, refuses the frame that reports its outcome, and waits for the next, which must report the same.
    pub(super) fn refuse_once(&mut self, order: &Reply) -> Result<(), Problem> {
        let Open { mut checks, reply, .. } = self.take()?;
        reply.send(order).map_err(|error| format!("an order could not be delivered: {error}"))?;
        checks.replied(order);
        let (frame, reply) = self.frame()?;
        let first = frame.header;
        checks.clone().check(&frame).map_err(|refusal| refused(first.sequence, &refusal))?;
        // A frame that is refused for its content uses its number up, and its outcome counts as not reported.
        let mut spoilt = frame;
        spoilt.header.purpose = purpose::DETACH;
        if checks.check(&spoilt).is_ok() {
            return Err("no frame could be refused".to_owned());
        }
        let reason = "a trial: report the outcome again".to_owned();
        reply
            .refuse(&Refusal::Unwilling { reason })
            .map_err(|error| format!("a refusal could not be delivered: {error}"))?;
        let (frame, reply) = self.frame()?;
        let again = frame.header;
        checks.check(&frame).map_err(|refusal| refused(again.sequence, &refusal))?;
        if again.outcome != first.outcome {
            return Err(format!(
                "outcome {} was reported in the frame that was refused, and {} in the next",
                first.outcome, again.outcome
            ));
        }
        self.open = Some(Open { checks, frame, reply });
        Ok(())
    }

    /// Refuses the body's frame, for it to attach anew.
    pub(super) fn close_session(&mut self) -> Result<(), Problem> {
        let Open { checks, reply, .. } = self.take()?;
        let refusal = Refusal::Session { found: checks.number(), expected: 0 };
        reply.refuse(&refusal).map_err(|error| format!("a refusal could not be delivered: {error}"))
    }

    /// Gives an order, and waits for nothing.
    pub(super) fn give(&mut self, order: &Reply) -> Result<(), Problem> {
        let Open { reply, .. } = self.take()?;
        reply.send(order).map_err(|error| format!("an order could not be delivered: {error}"))
    }

    /// Sends the body away.
    pub(super) fn send_away(&mut self) -> Result<(), Problem> {
        let Open { reply, .. } = self.take()?;
        reply.send(&Reply::Detach).map_err(|error| format!("a reply could not be delivered: {error}"))
    }

    /// Replies that the body is to rest, and rouses it again and again if wanted: a body that does not rest yet may miss it.
    /// Returns the time after which its next frame came.
    pub(super) fn rest(&mut self, ms: u32, roused: bool) -> Result<Duration, Problem> {
        let Open { mut checks, reply, .. } = self.take()?;
        let begun = Instant::now();
        let wait = Reply::Wait { ms };
        reply.send(&wait).map_err(|error| format!("a reply could not be delivered: {error}"))?;
        checks.replied(&wait);
        while roused && self.messages.is_empty() && begun.elapsed() < self.patience {
            if let Some(daemon) = &self.daemon {
                daemon.rouse(checks.number());
            }
            let message = self.message(ROUSE_EVERY)?;
            self.messages.extend(message);
        }
        let (frame, reply) = self.frame()?;
        let after = begun.elapsed();
        let sequence = frame.header.sequence;
        checks.check(&frame).map_err(|refusal| refused(sequence, &refusal))?;
        self.open = Some(Open { checks, frame, reply });
        Ok(after)
    }

    /// Lets the body wait for its reply. It must hold still meanwhile.
    pub(super) fn pause(&mut self, time: Duration) -> Result<(), Problem> {
        self.attach()?;
        match self.message(time)? {
            None => Ok(()),
            Some(Message::Frame(frame, _)) => {
                Err(format!("frame {} came before the reply to the one before it", frame.header.sequence))
            }
            Some(Message::Hello(..)) => Err("it attached anew although the daemon lives".to_owned()),
            Some(Message::Gone { .. }) => Err("it left although the daemon lives".to_owned()),
            Some(Message::Refused(refusal)) => Err(refusal.to_string()),
        }
    }

    /// Makes sure that a body which was sent away does not come back for a while. It may end, with success.
    pub(super) fn stays_away(&mut self, time: Duration) -> Result<(), Problem> {
        let begun = Instant::now();
        while let Some(left) = time.checked_sub(begun.elapsed()) {
            if let Some(status) = self.status()? {
                self.process = None;
                return if status.success() {
                    Ok(())
                } else {
                    Err(format!("it ended with a failure ({status})"))
                };
            }
            match self.message(left.min(SLICE)) {
                Ok(Some(Message::Hello(..))) => return Err("it attached again".to_owned()),
                Ok(Some(Message::Frame(..))) => return Err("it sent another frame".to_owned()),
                // The status is looked at above.
                Ok(_) | Err(_) => {}
            }
        }
        Ok(())
    }

    /// The outcome in the frame that waits for its reply.
    pub(super) fn outcome(&self) -> u32 {
        self.open.as_ref().map_or(0, |open| open.frame.header.outcome)
    }

    /// Asks the body to end, and waits until it has. With a daemon it gets its replies meanwhile. Returns whether it said farewell.
    pub(super) fn terminate(&mut self) -> Result<bool, Problem> {
        let Some(Process(child)) = &self.process else { return Err("the body does not run".to_owned()) };
        let pid = i32::try_from(child.id()).ok().and_then(Pid::from_raw);
        let pid = pid.ok_or("the body has no process")?;
        kill_process(pid, Signal::TERM).map_err(|error| format!("SIGTERM could not be sent: {error}"))?;
        if let Some(Open { reply, .. }) = self.open.take() {
            // It may have looked away already.
            reply.send(&Reply::Wait { ms: 0 }).ok();
        }
        self.ended("SIGTERM")
    }

    /// Notes what the body could do better; of several in one check the first is told.
    pub(super) fn advise(&mut self, advice: impl Into<String>) {
        self.advice.get_or_insert(advice.into());
    }

    /// What the body could do better in the check that has ended; none if nothing.
    pub(super) fn advice(&mut self) -> Option<String> {
        self.advice.take()
    }

    /// Waits until the body has ended. Returns whether it said farewell.
    pub(super) fn ended(&mut self, after: &str) -> Result<bool, Problem> {
        let begun = Instant::now();
        let mut said_farewell = false;
        let status = loop {
            if let Some(status) = self.status()? {
                break status;
            }
            if begun.elapsed() > self.patience {
                return Err(format!("it had not ended {} s after {after}", self.patience.as_secs_f64()));
            }
            if self.daemon.is_none() {
                thread::sleep(LOOK_EVERY);
                continue;
            }
            match self.message(SLICE) {
                Ok(Some(Message::Gone { farewell })) => said_farewell |= farewell,
                Ok(Some(Message::Frame(_, reply))) => drop(reply.send(&Reply::Wait { ms: 0 })),
                // The status is looked at above.
                Ok(_) | Err(_) => {}
            }
        };
        // A farewell may have come just before the end of the process.
        if let Some(daemon) = &mut self.daemon {
            daemon.poll(&mut |incoming| {
                said_farewell |= matches!(incoming, Incoming::BodyGone { farewell: true, .. });
            });
        }
        said_farewell |= self.messages.drain(..).any(|one| matches!(one, Message::Gone { farewell: true }));
        self.process = None;
        if !status.success() {
            self.advise(format!("it ended with a failure ({status}) after {after}"));
        }
        Ok(said_farewell)
    }
}

fn refused(sequence: u64, refusal: &Refusal) -> Problem {
    format!("frame {sequence}: {refusal} (refusal {})", refusal.code())
}

/// The description in a hello, if a daemon would take it.
pub(super) fn described(hello: &RawHello) -> Result<Description, Problem> {
    let told = |refusal: Refusal| format!("{refusal} (refusal {})", refusal.code());
    let introduction = decode::hello(hello).map_err(told)?;
    let learner = Learner::new(1, Parameters::default(), Curriculum::free("conformance"));
    let mut learner = learner.map_err(|error| error.to_string())?;
    Session::attach(1, &introduction, &mut learner).map_err(|error| error.to_string())?;
    Ok(introduction.description)
}

/// An order with the least values that its parameters may have.
pub(super) fn least(order: &ActionType, command: Action) -> Action {
    let value = |kind: &ValueKind| match kind {
        ValueKind::Integer { min, .. } => Value::Integer(*min),
        ValueKind::Symbol { .. } => Value::Symbol(0),
        ValueKind::Boolean => Value::Boolean(false),
        ValueKind::Real { min, .. } => Value::Real(*min),
    };
    Action { parameters: order.parameters.iter().map(|one| value(&one.kind)).collect(), ..command }
}
