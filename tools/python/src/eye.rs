//! The pictures of a learner's bodies, as they come.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread;

use pschema_protocol::picture::PictureMessage;
use pschema_protocol::transport::pictures::PictureWatch;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::body::place;
use crate::client::awaited;
use crate::errors::error;

/// What was seen, or what was wrong.
type Seen = Result<Option<PictureMessage>, String>;

/// The session of the body that took it, how many frames it had exchanged in that before, width and height, the bytes of the pixels, and the
/// fields as x, y and radius in pixels.
type PlainPicture<'py> = (u64, u64, u32, u32, Bound<'py, PyBytes>, Vec<(f32, f32, f32)>);

/// Watches the pictures of all bodies of one learner; they send them only while somebody does. The transport belongs to one thread, which
/// this object has; so any thread may look.
#[pyclass(module = "pschema._native", frozen)]
pub(crate) struct Eye {
    looks: Mutex<SyncSender<SyncSender<Seen>>>,
    /// The process that watches: a child of it has no such thread.
    pid: u32,
}

#[pymethods]
impl Eye {
    /// Watches the bodies of the learner `name`, whose daemon runs.
    #[new]
    fn new(py: Python<'_>, name: &str) -> PyResult<Self> {
        let place = place(name)?;
        let (looks, waiting) = sync_channel(1);
        let (ready, is_ready) = sync_channel::<Seen>(1);
        let work = move || match PictureWatch::open(&place) {
            Ok(watch) => {
                if ready.send(Ok(None)).is_ok() {
                    watched(&watch, &waiting);
                }
            }
            // Nobody waits for it when the program was interrupted meanwhile.
            Err(problem) => drop(ready.send(Err(problem.to_string()))),
        };
        let spawned = thread::Builder::new().name("pschema-eye".to_owned()).spawn(work);
        drop(spawned.map_err(|problem| error(format!("cannot start a thread that sees: {problem}")))?);
        awaited(py, is_ready)?.map_err(error)?;
        Ok(Self { looks: Mutex::new(looks), pid: std::process::id() })
    }

    /// The newest picture that came since the last call, of whichever body. None if none came. This never waits for one.
    fn newest<'py>(&self, py: Python<'py>) -> PyResult<Option<PlainPicture<'py>>> {
        if std::process::id() != self.pid {
            let problem = "this process was forked after it had begun to see: watch again in the child";
            return Err(PyRuntimeError::new_err(problem));
        }
        let (sees, seen) = sync_channel(1);
        let looks = self.looks.lock().unwrap_or_else(PoisonError::into_inner).clone();
        py.detach(|| looks.send(sees)).map_err(|_| error("the thread that sees has ended"))?;
        let Some(picture) = awaited(py, seen)?.map_err(error)? else { return Ok(None) };
        let fields = picture.fields.iter().map(|field| (field.x_px, field.y_px, field.radius_px)).collect();
        let rgb = PyBytes::new(py, &picture.rgb);
        Ok(Some((picture.session, picture.frame, picture.width_px, picture.height_px, rgb, fields)))
    }
}

/// Looks whenever it is asked to, until nobody can ask any more.
fn watched(watch: &PictureWatch, waiting: &Receiver<SyncSender<Seen>>) {
    while let Ok(sees) = waiting.recv() {
        // Nobody waits for it when the program was interrupted meanwhile.
        drop(sees.send(watch.newest().map_err(|problem| problem.to_string())));
    }
}
