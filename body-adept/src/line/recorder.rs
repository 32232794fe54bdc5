//! Writes the recording of a line: one event a line of text, with its time.

use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use pschema_process::{Occupied, OutputError, Stream, stream};

/// Longest recording written, in bytes. Later events are not recorded.
const BYTES_MAX: u64 = 1 << 30;

struct RecordingFile {
    file: BufWriter<Stream>,
    since: Instant,
    bytes: u64,
}

/// Writes a recording. Clones write the same one. Without a file it does nothing.
#[derive(Clone, Default)]
pub struct LineRecorder(Option<Arc<Mutex<RecordingFile>>>);

impl LineRecorder {
    /// Begins a recording at a path where there is nothing yet, or a FIFO or device.
    ///
    /// # Errors
    /// When it cannot be written, or is there already.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        Ok(Self::to(stream(path, Occupied::Refused, &Arc::default())?))
    }

    /// Begins a recording in an open stream.
    #[must_use]
    pub fn to(file: Stream) -> Self {
        let file = BufWriter::new(file);
        Self(Some(Arc::new(Mutex::new(RecordingFile { file, since: Instant::now(), bytes: 0 }))))
    }

    /// Records one event.
    pub fn event(&self, what: &str, text: &str) {
        let Some(writing) = &self.0 else { return };
        let mut writing = writing.lock().unwrap_or_else(PoisonError::into_inner);
        if writing.bytes > BYTES_MAX {
            return;
        }
        let line =
            format!("{:.6} {what} {}\n", writing.since.elapsed().as_secs_f64(), text.replace('\n', " "));
        writing.bytes = writing.bytes.saturating_add(line.len() as u64);
        // To the disk at once: the last events before an end matter most.
        if let Err(error) = writing.file.write_all(line.as_bytes()).and_then(|()| writing.file.flush()) {
            tracing::error!(%error, "the recording cannot be written and ends");
            writing.bytes = u64::MAX;
        } else if writing.bytes > BYTES_MAX {
            tracing::warn!("the recording has reached 1 GiB and ends");
        }
    }

    /// Records that the order to stop was sent.
    pub(crate) fn stopped(&self, bytes: &[u8]) {
        self.bytes("stop", bytes);
    }

    /// Records bytes.
    pub(super) fn bytes(&self, what: &str, bytes: &[u8]) {
        if self.0.is_some() {
            self.event(what, &format!("\"{}\"", bytes.escape_ascii()));
        }
    }
}
