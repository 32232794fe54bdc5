//! Steps as a recording for the Rerun viewer: the camera with its fields, excitation, schemas and speed as curves,
//! decisions, words and new schemas as text, all over the step.

use std::path::Path;

use pschema_inspect::{SchemaSummary, TraceRecord};
use pschema_protocol::picture::PictureMessage;
use re_sdk::{RecordingStream, RecordingStreamBuilder};
use re_sdk_types::AsComponents;
use re_sdk_types::archetypes::{Image, Points2D, Scalars, TextLog};

use super::recorder::Recorder;
use crate::failure::Failure;
use crate::render::words::summary_notation;

/// The timeline of a recording.
const STEP: &str = "step";

/// A recording on its way into a file.
pub(super) struct Recording {
    stream: RecordingStream,
    stage: String,
}

impl Recording {
    pub(super) fn create(path: &Path, learner: &str) -> Result<Self, Failure> {
        let stream = RecordingStreamBuilder::new("pschema").recording_name(learner.to_owned()).save(path);
        let stream =
            stream.map_err(|error| Failure::Failed(format!("cannot write {}: {error}", path.display())))?;
        Ok(Self { stream, stage: String::new() })
    }

    fn at(&self, step: u64) {
        self.stream.set_time_sequence(STEP, i64::try_from(step).unwrap_or(i64::MAX));
    }

    fn log(&self, place: &str, what: &impl AsComponents) -> Result<(), Failure> {
        self.stream.log(place, what).map_err(Failure::of)
    }

    fn scalar(&self, place: &str, value: f64) -> Result<(), Failure> {
        self.log(place, &Scalars::single(value))
    }
}

impl Recorder for Recording {
    fn step(&mut self, record: &TraceRecord, stage: &str) -> Result<(), Failure> {
        self.at(record.step);
        if self.stage != stage {
            stage.clone_into(&mut self.stage);
            self.log("mind/stage", &TextLog::new(stage))?;
        }
        self.scalar("memory/schemas", f64::from(record.schemas_total))?;
        self.scalar("memory/generalised", f64::from(record.schemas_generalised))?;
        self.scalar("speed/step_us", record.latency_us)?;
        for word in &record.heard {
            self.log("world/heard", &TextLog::new(word.as_str()))?;
        }
        if let Some(decision) = &record.decision {
            self.scalar("excitation/top", decision.excitation_top)?;
            self.scalar("excitation/chosen", decision.excitation)?;
            self.scalar("mind/distance", f64::from(decision.distance))?;
            let schema =
                decision.schema.map_or_else(|| "untried".to_owned(), |schema| format!("schema {schema}"));
            self.log(
                "mind/decision",
                &TextLog::new(format!("{} ({schema}, {})", decision.action, decision.reason)),
            )?;
        }
        Ok(())
    }

    fn schema(&mut self, step: u64, schema: &SchemaSummary) -> Result<(), Failure> {
        self.at(step);
        let text = format!("{} ({}): {}", schema.id, schema.kind, summary_notation(schema));
        self.log("memory/new", &TextLog::new(text))
    }

    fn picture(&mut self, step: u64, seen: &PictureMessage) -> Result<(), Failure> {
        self.at(step);
        self.log("world/camera", &Image::from_rgb24(seen.rgb.clone(), [seen.width_px, seen.height_px]))?;
        let fields = Points2D::new(seen.fields.iter().map(|field| [field.x_px, field.y_px]))
            .with_radii(seen.fields.iter().map(|field| field.radius_px / 4.0))
            .with_labels((0..seen.fields.len()).map(|number| number.to_string()))
            .with_show_labels(false);
        self.log("world/camera/fields", &fields)
    }

    /// The stream sees to it by itself, some times a second.
    fn flush(&mut self) -> Result<(), Failure> {
        Ok(())
    }

    fn finish(&mut self) -> Result<(), Failure> {
        self.stream.flush_blocking().map_err(Failure::of)
    }
}
