//! Recordings as JSON Lines, for programs and for publication.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use pschema_inspect::{SchemaSummary, TraceRecord};
use pschema_process::{Occupied, OutputError, Stream, stream};
use serde::Serialize;

use crate::failure::Failure;
use crate::output::named;

/// A file, a pipe or stdout that takes one object a line: `{"step": …}` or `{"schema": …}`.
pub(crate) struct JsonLinesFile {
    path: PathBuf,
    to: BufWriter<Stream>,
}

/// A line of the file.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(crate) enum RecordingEntry<'a> {
    /// A step.
    Step {
        /// The name of its stage.
        stage_name: &'a str,
        #[serde(flatten)]
        record: &'a TraceRecord,
    },
    /// A schema that was new.
    Schema {
        /// The step in which it was new.
        step: u64,
        #[serde(flatten)]
        schema: &'a SchemaSummary,
    },
}

impl JsonLinesFile {
    /// Makes the file, or opens the stream that `path` names. A file that is there is `occupied`. A FIFO is
    /// waited for until somebody reads it, or `stop` is set.
    pub(crate) fn create(path: &Path, occupied: Occupied, stop: &Arc<AtomicBool>) -> Result<Self, Failure> {
        let opened = stream(named(path), occupied, stop)?;
        Ok(Self { path: path.to_owned(), to: BufWriter::new(opened) })
    }

    /// Writes a step, in the stage of this name.
    pub(super) fn step(&mut self, record: &TraceRecord, stage: &str) -> Result<(), Failure> {
        self.write(&RecordingEntry::Step { stage_name: stage, record })
    }

    /// Writes a schema that was new in this step.
    pub(super) fn schema(&mut self, step: u64, schema: &SchemaSummary) -> Result<(), Failure> {
        self.write(&RecordingEntry::Schema { step, schema })
    }

    /// Makes everything written so far readable, because nothing more comes for a moment.
    pub(super) fn flush(&mut self) -> Result<(), Failure> {
        let written = self.to.flush();
        written.map_err(|error| self.failed(error))
    }

    /// Ends the recording.
    pub(super) fn finish(&mut self) -> Result<(), Failure> {
        self.flush()?;
        self.to.get_ref().sync().map_err(|error| self.failed(error))
    }

    fn write(&mut self, line: &RecordingEntry<'_>) -> Result<(), Failure> {
        let written = serde_json::to_writer(&mut self.to, line).map_err(io::Error::from);
        let written = written.and_then(|()| self.to.write_all(b"\n"));
        written.map_err(|error| self.failed(error))
    }

    fn failed(&self, source: io::Error) -> Failure {
        OutputError::Io { path: self.path.clone(), source }.into()
    }
}
