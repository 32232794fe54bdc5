//! A connection to a daemon, and memories on disk: questions and orders go in as JSON, and so do answers come out.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::Duration;

use pschema_inspect::{Question, Request, codec};
use pschema_protocol::client::{self, ClientError, Purpose};
use pschema_protocol::domain::Place;
use pschema_tools::kit::MemoryOnDisk;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::body::place;
use crate::errors::{AnswerError, ArgumentError, error, of_client};

/// How often a wait for an answer looks whether the program was interrupted.
const LOOK_EVERY: Duration = Duration::from_millis(50);

type Answer = Result<Vec<u8>, ClientError>;

/// What the thread is asked for: the bytes of a request, and where its answer goes.
struct Errand {
    request: Vec<u8>,
    answer: SyncSender<Answer>,
}

/// A connection to the daemon of one learner. The transport belongs to one thread, which this object has; so any thread may ask.
#[pyclass(module = "pschema._native", frozen)]
pub(crate) struct Client {
    place: Place,
    timeout: Duration,
    errands: Mutex<SyncSender<Errand>>,
    /// The process that connected: a child of it has no such thread.
    pid: u32,
}

#[pymethods]
impl Client {
    /// Connects to the daemon of the learner `name`; each page of an answer may take `timeout_s`.
    #[new]
    fn new(py: Python<'_>, name: &str, timeout_s: f64) -> PyResult<Self> {
        let timeout = Duration::try_from_secs_f64(timeout_s)
            .map_err(|_| ArgumentError::new_err(format!("timeout_s = {timeout_s} is no time to wait")))?;
        let place = place(name)?;
        let (errands, waiting) = sync_channel(1);
        let (ready, is_ready) = sync_channel(1);
        let served = place.clone();
        let work = move || match client::Client::connect(&served, timeout) {
            Ok(client) => {
                if ready.send(None).is_ok() {
                    run_errands(&served, client, timeout, &waiting);
                }
            }
            // Nobody waits for it when the program was interrupted meanwhile.
            Err(error) => drop(ready.send(Some(error))),
        };
        let spawned = thread::Builder::new().name("pschema-client".to_owned()).spawn(work);
        drop(
            spawned
                .map_err(|problem| error(format!("cannot start a thread to ask the daemon: {problem}")))?,
        );
        match awaited(py, is_ready)? {
            None => Ok(Self { place, timeout, errands: Mutex::new(errands), pid: std::process::id() }),
            Some(failed) => Err(of_client(&failed)),
        }
    }

    /// Sends the bytes of a request, and returns those of the reply.
    fn request<'py>(&self, py: Python<'py>, request: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
        if std::process::id() != self.pid {
            return Err(PyRuntimeError::new_err(
                "this process was forked after it had connected to the daemon: connect again in the child",
            ));
        }
        let answer = match codec::decode::<Request>(request) {
            Ok(Request::Order(_)) => {
                // A place is kept for those who give orders, however many tools watch; so it is taken for the order alone.
                let (place, timeout, request) = (self.place.clone(), self.timeout, request.to_vec());
                let (answer, answered) = sync_channel(1);
                let work = move || {
                    let asked = client::Client::connect_for(Purpose::Order, &place, timeout)
                        .and_then(|mut client| client.request(&request));
                    // Nobody waits for it when the program was interrupted meanwhile.
                    drop(answer.send(asked));
                };
                let spawned = thread::Builder::new().name("pschema-order".to_owned()).spawn(work);
                drop(spawned.map_err(|problem| {
                    error(format!("cannot start a thread to ask the daemon: {problem}"))
                })?);
                awaited(py, answered)?
            }
            Ok(Request::Question(_)) => {
                let (answer, answered) = sync_channel(1);
                let errand = Errand { request: request.to_vec(), answer };
                let errands = self.errands.lock().unwrap_or_else(PoisonError::into_inner).clone();
                py.detach(|| errands.send(errand))
                    .map_err(|_| error("the thread that asks the daemon has ended"))?;
                awaited(py, answered)?
            }
            Err(problem) => return Err(PyValueError::new_err(format!("no request: {problem}"))),
        };
        match answer {
            Ok(answer) => Ok(PyBytes::new(py, &answer)),
            Err(failed) => Err(of_client(&failed)),
        }
    }
}

/// Asks one thing after another, until nobody can ask any more. A daemon that was replaced is connected to anew.
fn run_errands(place: &Place, mut client: client::Client, timeout: Duration, waiting: &Receiver<Errand>) {
    while let Ok(Errand { request, answer }) = waiting.recv() {
        let asked = if client.is_current() {
            client.request(&request)
        } else {
            client::Client::connect(place, timeout).and_then(|again| {
                client = again;
                client.request(&request)
            })
        };
        // Nobody waits for it when the program was interrupted meanwhile.
        drop(answer.send(asked));
    }
}

/// Waits for what another thread sends, and leaves when the program is interrupted. The interpreter is free meanwhile.
pub(crate) fn awaited<T: Send>(py: Python<'_>, receiver: Receiver<T>) -> PyResult<T> {
    // A receiver is one thread's at a time, which only a lock tells the compiler.
    let receiver = Mutex::new(receiver);
    loop {
        let received =
            py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(LOOK_EVERY));
        match received {
            Ok(received) => return Ok(received),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(error("the thread that asks the daemon has ended"));
            }
        }
    }
}

/// The memory in a data directory, with or without a daemon on it; nothing in it is changed.
#[pyclass(module = "pschema._native", frozen)]
pub(crate) struct Past {
    directory: PathBuf,
}

#[pymethods]
impl Past {
    #[new]
    fn new(directory: PathBuf) -> Self {
        Self { directory }
    }

    /// The reply to the bytes of a question about memory as it was after step `until`, or as it is.
    fn request<'py>(
        &self,
        py: Python<'py>,
        request: &[u8],
        until: Option<u64>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let question: Question = match codec::decode(request) {
            Ok(Request::Question(question)) => question,
            Ok(Request::Order(_)) => {
                return Err(AnswerError::new_err(
                    "a memory on disk is asked, and obeys no order: connect to its daemon by name",
                ));
            }
            Err(problem) => return Err(PyValueError::new_err(format!("no request: {problem}"))),
        };
        let directory = self.directory.clone();
        let reply = py.detach(move || MemoryOnDisk::open(&directory, until)?.reply(&question));
        Ok(PyBytes::new(py, &reply.map_err(|failure| AnswerError::new_err(failure.to_string()))?))
    }
}
