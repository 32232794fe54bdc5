//! What a recording is written to.

use pschema_inspect::{SchemaSummary, TraceRecord};
use pschema_protocol::picture::PictureMessage;

use crate::failure::Failure;

/// Something that writes steps down.
pub(crate) trait Recorder {
    /// Writes a step, in the stage of this name.
    fn step(&mut self, record: &TraceRecord, stage: &str) -> Result<(), Failure>;
    /// Writes a schema that was new in this step.
    fn schema(&mut self, step: u64, schema: &SchemaSummary) -> Result<(), Failure>;
    /// Writes a picture that the body took about this step.
    fn picture(&mut self, step: u64, seen: &PictureMessage) -> Result<(), Failure>;
    /// Makes everything written so far readable, because nothing more comes for a moment.
    fn flush(&mut self) -> Result<(), Failure>;
    /// Ends the recording.
    fn finish(&mut self) -> Result<(), Failure>;
}
