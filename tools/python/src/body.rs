//! A body that is written in Python, run by the Rust crate `protocol`: the transport, the checks and the attaching are its.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use pschema_process::{LevelFilter, Log};
use pschema_protocol::body::{Body, Outcome, RunEnding, RunOptions, RunSummary, Senses};
use pschema_protocol::description::{self, Description};
use pschema_protocol::domain::{LearnerName, Place, RuntimeDir};
use pschema_protocol::picture::{FieldMark, Picture};
use pyo3::exceptions::{PyException, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::declared::PlainDescription;
use crate::errors::{ArgumentError, error, of_run};
use crate::stop::Stop;
use crate::values::{Action, SenseTable};

/// What the Python half hands over of a body: functions to call.
#[derive(FromPyObject)]
struct Calls {
    /// Returns the observations.
    sense: Py<PyAny>,
    /// Takes an action and returns how it went; none if it was carried out.
    act: Py<PyAny>,
    /// The same for a scene command.
    arrange: Py<PyAny>,
    /// Returns width, height, the bytes of the pixels and the fields, or none.
    picture: Py<PyAny>,
    /// Is told of an exception in `act` or `arrange`, for the log.
    failed: Py<PyAny>,
}

/// Why a run ends that its body ends: what the caller of the run is to be raised.
type Fault = Arc<Mutex<Option<PyErr>>>;

struct PythonBody {
    calls: Calls,
    description: Description,
    senses: SenseTable,
    shown: Option<Shown>,
    stop: Arc<AtomicBool>,
    fault: Fault,
    /// The process that attached. A child which was forked meanwhile has a copy of everything but the right to use it.
    pid: u32,
}

/// A picture as it came from Python.
struct Shown {
    width_px: u32,
    height_px: u32,
    rgb: Vec<u8>,
    fields: Vec<FieldMark>,
}

impl PythonBody {
    /// Ends the run, and has `fault` raised by it. The first one counts.
    fn end(&self, fault: PyErr) {
        self.stop.store(true, Ordering::Relaxed);
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
    }

    /// Ends a process that was forked while the body was attached and came back here: it would go on with the shared memory of its parent.
    fn check_process(&self, py: Python<'_>) {
        if std::process::id() == self.pid {
            return;
        }
        let told = "pschema: this process was forked while a body was attached, and only its parent may go on with the body: ended. \
                    Fork before the body attaches, or leave the child with os._exit\n";
        // The thread that writes the log is the parent's.
        drop(std::io::stderr().write_all(told.as_bytes()));
        // Without the interpreter's clean-up and the transport's, which would take the parent's session with it.
        let ended = py.import("os").and_then(|os| os.call_method1("_exit", (70,)));
        if let Err(raised) = ended {
            self.end(raised);
        }
    }

    fn order(&self, call: &Py<PyAny>, order: &description::Action, scene: bool) -> Outcome {
        let declared = if scene { &self.description.scene_commands } else { &self.description.actions };
        let action = Action::of(order, declared, scene);
        Python::attach(|py| {
            let called = call.call1(py, (action,));
            self.check_process(py);
            match called.and_then(|returned| outcome(returned.bind(py))) {
                Ok(Ok(outcome)) => outcome,
                Ok(Err(wrong)) => {
                    let outcome = Outcome::failed(&wrong);
                    self.end(wrong);
                    outcome
                }
                // Ctrl-C and sys.exit() end the body; whatever else goes wrong is one action that failed.
                Err(raised) if !raised.is_instance_of::<PyException>(py) => {
                    self.end(raised);
                    Outcome::failed("the body is leaving")
                }
                Err(raised) => {
                    let outcome = Outcome::failed(said(py, &raised));
                    if let Err(error) = self.calls.failed.call1(py, (raised,)) {
                        self.end(error);
                    }
                    outcome
                }
            }
        })
    }
}

/// An exception as the last line of its traceback says it.
fn said(py: Python<'_>, raised: &PyErr) -> String {
    let kind = raised.get_type(py).name().map_or_else(|_| "exception".to_owned(), |name| name.to_string());
    let text = raised.value(py).str().map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
    if text.is_empty() { kind } else { format!("{kind}: {text}") }
}

/// How an action went, as its function says; the inner error is a mistake in the function itself.
fn outcome(returned: &Bound<'_, PyAny>) -> PyResult<Result<Outcome, PyErr>> {
    if returned.is_none() {
        return Ok(Ok(Outcome::Done));
    }
    let said = (returned.getattr("kind"), returned.getattr("reason"));
    let (Ok(kind), Ok(reason)) = said else { return Ok(Err(no_outcome(returned))) };
    let (Ok(kind), Ok(reason)) = (kind.extract::<String>(), reason.extract::<String>()) else {
        return Ok(Err(no_outcome(returned)));
    };
    Ok(of_kind(&kind, reason).ok_or_else(|| no_outcome(returned)))
}

/// The outcome of this kind, as `pschema.Outcome` names it.
pub(crate) fn of_kind(kind: &str, reason: String) -> Option<Outcome> {
    Some(match kind {
        "done" => Outcome::Done,
        "refused" => Outcome::Refused(reason),
        "failed" => Outcome::Failed(reason),
        "timed-out" => Outcome::TimedOut,
        "episode-ended" => Outcome::EpisodeEnded,
        "episode-cut" => Outcome::EpisodeCut,
        _ => return None,
    })
}

fn no_outcome(returned: &Bound<'_, PyAny>) -> PyErr {
    let kind = returned.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string());
    PyTypeError::new_err(format!(
        "act() returned a {kind}: return nothing when the action was carried out, else a pschema.Outcome"
    ))
}

impl Body for PythonBody {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        Python::attach(|py| {
            // Signals are looked at here too: a body whose functions are native code would never see one.
            let sensed = py.check_signals().and_then(|()| self.calls.sense.call0(py));
            let sensed = sensed.and_then(|reported| {
                self.senses.read(reported.bind(py), |sense, values| frame.observe(sense, values))
            });
            self.check_process(py);
            if let Err(raised) = sensed {
                self.end(raised);
            }
        });
    }

    fn act(&mut self, action: &description::Action) -> Outcome {
        self.order(&self.calls.act, action, false)
    }

    fn arrange(&mut self, command: &description::Action) -> Outcome {
        self.order(&self.calls.arrange, command, true)
    }

    fn picture(&mut self) -> Option<Picture<'_>> {
        type Plain<'py> = (u32, u32, Bound<'py, PyBytes>, Vec<(f32, f32, f32)>);
        let taken = Python::attach(|py| -> PyResult<Option<Shown>> {
            let Some((width_px, height_px, rgb, fields)) =
                self.calls.picture.call0(py)?.extract::<Option<Plain<'_>>>(py)?
            else {
                return Ok(None);
            };
            let mark = |(x_px, y_px, radius_px)| FieldMark { x_px, y_px, radius_px };
            let fields = fields.into_iter().map(mark).collect();
            Ok(Some(Shown { width_px, height_px, rgb: rgb.as_bytes().to_vec(), fields }))
        });
        self.shown = match taken {
            Ok(shown) => shown,
            Err(raised) => {
                self.end(raised);
                None
            }
        };
        let shown = self.shown.as_ref()?;
        let Shown { width_px, height_px, ref rgb, ref fields } = *shown;
        Some(Picture { width_px, height_px, rgb, fields })
    }
}

/// How a run ended, as the Python half reads it: why, sessions, frames, orders, frames refused.
type PlainSummary = (&'static str, u64, u64, u64, u64);

/// Runs a body until `stop` is set, the daemon sends it away, or it has gone. The interpreter is free while the body waits.
#[pyfunction]
#[pyo3(signature = (calls, description, name, exit_when_daemon_gone, stop))]
pub(crate) fn run(
    py: Python<'_>,
    calls: &Bound<'_, PyAny>,
    description: PlainDescription<'_>,
    name: &str,
    exit_when_daemon_gone: bool,
    stop: &Stop,
) -> PyResult<PlainSummary> {
    let description = description.description()?;
    let options =
        RunOptions::new(place(name)?).stop(stop.flag()).exit_when_daemon_gone(exit_when_daemon_gone);
    let fault = Fault::default();
    let body = PythonBody {
        calls: calls.extract()?,
        senses: SenseTable::of(&description, py),
        description,
        shown: None,
        stop: stop.flag(),
        fault: Arc::clone(&fault),
        pid: std::process::id(),
    };
    Log::new(LevelFilter::WARN).begin();
    let ended = py.detach(|| pschema_protocol::body::run(body, &options));
    if let Some(fault) = fault.lock().unwrap_or_else(PoisonError::into_inner).take() {
        return Err(fault);
    }
    py.check_signals()?;
    let RunSummary { ending, sessions, frames, orders, refused, .. } = ended.map_err(of_run)?;
    let ending = match ending {
        RunEnding::Stopped => "stopped",
        RunEnding::Detached => "detached",
        RunEnding::DaemonGone => "daemon-gone",
        _ => return Err(error("the run ended for a reason that this release does not know")),
    };
    Ok((ending, sessions, frames, orders, refused))
}

/// Where the learner of this name is, by the environment.
pub(crate) fn place(name: &str) -> PyResult<Place> {
    let learner = LearnerName::new(name).map_err(|error| ArgumentError::new_err(error.to_string()))?;
    Ok(Place::new(RuntimeDir::from_environment().map_err(error)?, learner))
}
