//! A learner in the program's own process: what a daemon does with a frame, without a daemon.

use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::PathBuf;
use std::sync::Arc;

use pschema_inspect::{Question, Request, codec};
use pschema_learner::decision::Decision;
use pschema_learner::digest;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Memory;
use pschema_protocol::body::{BodyLoop, Outcome, Senses};
use pschema_protocol::description::{self, Description};
use pschema_protocol::wire::decode;
use pschema_protocol::wire::message::{OrderReport, Reply};
use pschema_server::goal;
use pschema_server::inspect;
use pschema_server::session::{Session, no_word};
use pschema_server::view::View;
use pschema_server::{LearnerSettings, Setup, config};
use pschema_store::past::export;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::body::of_kind;
use crate::declared::PlainDescription;
use crate::errors::{AnswerError, ArgumentError, DeclarationError, Error, FrameError, error};
use crate::values::{Action, SenseTable};

/// A body that was declared to a learner in this process.
struct Declared {
    description: Description,
    senses: SenseTable,
    session: Session,
    /// The number of its last frame.
    sequence: u64,
    /// The number of the frame whose reply asked for something, if its outcome is still to come.
    asked: Option<u64>,
}

/// A learner in this process. It decides as a daemon's learner does that is sent the same frames, and its memory has the same digest.
#[pyclass(module = "pschema._native")]
pub(crate) struct Learner {
    learner: pschema_learner::Learner,
    seed: u64,
    bodies: Vec<Declared>,
    words: Vec<String>,
    decision: Option<Decision>,
    /// The place in `bodies` of the one that took the last step.
    last: Option<usize>,
}

/// What the learner does under this profile.
fn mechanisms(profile: &str) -> PyResult<Mechanisms> {
    match profile {
        "full" => Ok(Mechanisms::FULL),
        "paper" => Ok(Mechanisms::PAPER),
        other => {
            Err(ArgumentError::new_err(format!("there is no profile {other:?}: give \"full\" or \"paper\"")))
        }
    }
}

impl Learner {
    fn going_on(learner: pschema_learner::Learner, seed: u64) -> Self {
        Self { learner, seed, bodies: Vec::new(), words: Vec::new(), decision: None, last: None }
    }

    fn body(&self, body: usize) -> PyResult<&Declared> {
        self.bodies.get(body).ok_or_else(no_body)
    }

    /// The learner as it is, to be asked.
    fn view(&self) -> View {
        let shown = self.last.and_then(|at| self.bodies.get(at));
        let perceived = shown.map(|body| (body.session.body(), body.session.perceived().to_vec()));
        let declared = shown.map(|body| Arc::clone(body.session.description()));
        View::alone("in-process", &self.learner, self.seed, self.decision.clone(), perceived)
            .declared(declared)
    }
}

fn no_body() -> PyErr {
    DeclarationError::new_err("no such body is declared: call declare() with its description first")
}

#[pymethods]
impl Learner {
    /// A learner that knows nothing. `settings` are `learner.PARAMETER=VALUE` and `values.NAME=NUMBER`, as `pschema server --set` takes them.
    #[new]
    fn new(seed: u64, profile: &str, curriculum: &str, settings: Vec<String>) -> PyResult<Self> {
        let usual = LearnerSettings::of(mechanisms(profile)?);
        let (curriculum, learner) = config::lesson(curriculum, usual, &settings)
            .map_err(|problem| ArgumentError::new_err(problem.to_string()))?;
        let learner = Setup { seed, learner, curriculum }.begin();
        Ok(Self::going_on(learner.map_err(|problem| ArgumentError::new_err(problem.to_string()))?, seed))
    }

    /// A learner that goes on from the file at `path`, which [`Learner::save`] or `pschema export` wrote.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let shown = path.display().to_string();
        let file = File::open(&path)
            .map_err(|problem| PyOSError::new_err(format!("cannot read {shown}: {problem}")))?;
        let read = py.detach(|| export::read(&mut BufReader::new(file), |_| ()));
        let read = read.map_err(|problem| error(format!("{shown}: {problem}")))?;
        let memory = Memory::restore(read.content, read.parameters);
        let learner = pschema_learner::Learner::resume(memory, read.curriculum).map_err(error)?;
        Ok(Self::going_on(learner, read.seed))
    }

    /// Writes memory as `pschema export` does. What is at `path` is replaced when all of it is written.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let memory = self.learner.memory();
        let identity = export::Identity {
            learner: "in-process",
            seed: self.seed,
            parameters: memory.parameters(),
            curriculum: self.learner.curriculum(),
        };
        let mut beside = path.clone().into_os_string();
        beside.push(".part");
        let write = || {
            let mut file = BufWriter::new(File::create(&beside)?);
            export::write(memory.content(), identity, &mut file, |_| ()).map_err(std::io::Error::other)?;
            file.into_inner().map_err(std::io::IntoInnerError::into_error).and_then(|mut file| {
                file.flush()?;
                file.sync_all()
            })?;
            std::fs::rename(&beside, &path)
        };
        let written = py.detach(write);
        written.map_err(|problem| PyOSError::new_err(format!("cannot write {}: {problem}", path.display())))
    }

    /// Takes in what a body declares, and returns its number.
    fn declare(&mut self, py: Python<'_>, description: PlainDescription<'_>) -> PyResult<usize> {
        let description = description.description()?;
        if let Some(known) = self.bodies.iter().position(|body| body.description == description) {
            return Ok(known);
        }
        if self.bodies.iter().any(|body| body.description.name == description.name) {
            let name = &description.name;
            return Err(DeclarationError::new_err(format!(
                "body {name} is declared already, and otherwise: give this one another name"
            )));
        }
        let refused = |problem: String| DeclarationError::new_err(problem);
        let number = self.bodies.len();
        let hello = BodyLoop::new(Described(description.clone())).hello();
        let hello =
            hello.and_then(|hello| decode::hello(&hello)).map_err(|problem| refused(problem.to_string()))?;
        let session = u64::try_from(number).unwrap_or(u64::MAX).saturating_add(1);
        let (session, _) = Session::attach(session, &hello, &mut self.learner)
            .map_err(|problem| refused(format!("body {}: {problem}", description.name)))?;
        let senses = SenseTable::of(&description, py);
        self.bodies.push(Declared { description, senses, session, sequence: 0, asked: None });
        Ok(number)
    }

    /// One step: what `body` senses now and how its last action went in, its next action out; none when there is nothing to do.
    fn step(
        &mut self,
        py: Python<'_>,
        body: usize,
        observations: &Bound<'_, PyAny>,
        kind: Option<&str>,
        reason: String,
    ) -> PyResult<Option<Action>> {
        let Self { learner, bodies, words, decision, last, .. } = self;
        let at = bodies.get_mut(body).ok_or_else(no_body)?;
        let mut senses = Senses::default();
        at.senses.read(observations, |sense, values| senses.observe(sense, values))?;
        let outcome = match kind {
            None if at.asked.is_some() => Some(Outcome::Done),
            None => None,
            Some(kind) => {
                let outcome = of_kind(kind, reason);
                Some(outcome.ok_or_else(|| PyValueError::new_err(format!("there is no outcome {kind:?}")))?)
            }
        };
        let report = match (outcome, at.asked) {
            (Some(outcome), Some(answers)) => Some(OrderReport { outcome, answers }),
            (None, _) => None,
            (Some(_), None) => {
                return Err(FrameError::new_err(
                    "an outcome is given of an action that the learner did not ask for: leave it out",
                ));
            }
        };
        at.sequence = at.sequence.saturating_add(1);
        let frame = senses.into_frame(at.session.number(), at.sequence, report.as_ref());
        let served = py.detach(|| at.session.frame(learner, &frame, words, false));
        if let Some(step) = served.step {
            *last = Some(body);
            if step.decision.is_some() {
                *decision = step.decision;
            }
        }
        at.asked = match served.reply {
            Reply::Act(_) | Reply::Arrange(_) => Some(at.sequence),
            Reply::Wait { .. } | Reply::Detach => None,
            // The outcome was not taken, and comes with the next frame.
            Reply::Refused { .. } => at.asked,
        };
        let asked = |order: &description::Action, scene| {
            let declared = if scene { &at.description.scene_commands } else { &at.description.actions };
            Ok(Some(Action::of(order, declared, scene)))
        };
        match served.reply {
            Reply::Act(order) => asked(&order, false),
            Reply::Arrange(order) => asked(&order, true),
            Reply::Wait { .. } | Reply::Detach => match served.problem {
                Some(problem) => Err(error(problem)),
                None => Ok(None),
            },
            Reply::Refused { reason, .. } => Err(FrameError::new_err(reason)),
        }
    }

    /// Words are heard together, with the next step.
    fn say(&mut self, words: Vec<String>) -> PyResult<()> {
        if let Some(problem) = words.iter().find_map(|word| no_word(word)) {
            return Err(ArgumentError::new_err(problem));
        }
        self.words.extend(words);
        Ok(())
    }

    /// Takes up a goal for `body`, to be pursued with at most `actions_max` actions: patterns, though they hold if they are wanted `again`,
    /// or most of a value.
    #[pyo3(signature = (body, goal, actions_max, again, most))]
    fn achieve(
        &mut self,
        body: usize,
        goal: Vec<String>,
        actions_max: u32,
        again: bool,
        most: Option<String>,
    ) -> PyResult<()> {
        let session = &self.body(body)?.session;
        let vocabulary = &self.learner.memory().content().vocabulary;
        let asked = goal::Asked { goal: &goal, again, most: most.as_deref() };
        let goal = goal::wanted(vocabulary, Some(session.description().as_ref()), asked)
            .map_err(|problem| AnswerError::new_err(problem.to_string()))?;
        let body = session.body();
        let begun = self.learner.pursue(body, goal, actions_max);
        begun.map(drop).map_err(|problem| AnswerError::new_err(problem.to_string()))
    }

    /// Calls off the goal that is pursued.
    fn cancel(&mut self) -> PyResult<()> {
        self.learner.cancel_goal().map(drop).map_err(|problem| AnswerError::new_err(problem.to_string()))
    }

    /// The reply to the bytes of a question, as a daemon gives it.
    fn request<'py>(&self, py: Python<'py>, request: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
        let question: Question = match codec::decode(request) {
            Ok(Request::Question(question)) => question,
            Ok(Request::Order(_)) => {
                return Err(Error::new_err("this is an order: call its function of the learner"));
            }
            Err(problem) => return Err(PyValueError::new_err(format!("no request: {problem}"))),
        };
        let view = self.view();
        Ok(PyBytes::new(py, &py.detach(|| inspect::reply(&view, &question))))
    }

    /// The digest of memory: the same for the same seed and the same frames, whoever steps the learner.
    fn digest(&self, py: Python<'_>) -> String {
        let content = self.learner.memory().content();
        py.detach(|| digest::digest(content))
    }

    /// Steps taken in the life of this memory.
    fn steps(&self) -> u64 {
        self.learner.memory().content().step
    }
}

/// A body that has a description and nothing else.
struct Described(Description);

impl pschema_protocol::body::Body for Described {
    fn describe(&self) -> Description {
        self.0.clone()
    }

    fn sense(&mut self, _: &mut Senses) {}

    fn act(&mut self, _: &description::Action) -> Outcome {
        Outcome::refused("this body does nothing")
    }
}
