//! A body, as its author sees it: describe yourself, sense, act. [`run()`] is the whole life of a body
//! process around it; [`BodyLoop`] is the same without a process or shared memory.

mod driver;
mod run;

pub use driver::{BodyLoop, Directive};
pub use run::{Ending, RunError, RunOptions, RunSummary, run, run_from_args};

use crate::description::{Action, Description, Value};
use crate::limits::OBSERVATIONS_MAX;
use crate::picture::Picture;
use crate::wire::message::{OrderReport, RawFrame};
use crate::wire::{Observations, Record, encode};

/// A body the learner can live in.
pub trait Body {
    /// What this body senses and does. Asked once, before attaching.
    fn describe(&self) -> Description;

    /// Reports everything that holds now, into `frame`. Called once before each decision.
    fn sense(&mut self, frame: &mut Senses);

    /// Carries `action` out, to its end, and says how it went. `action` is within the declared limits: its
    /// index is declared, it has one value a parameter, each of the declared kind and range.
    fn act(&mut self, action: &Action) -> Outcome;

    /// What it saw when it last sensed, for people to look at; none when it has no eye, as most bodies. Asked for only
    /// while a tool watches, some 30 times a second at most.
    fn picture(&mut self) -> Option<Picture<'_>> {
        None
    }

    /// Arranges the surroundings as a curriculum asks. A body that declared no scene commands never
    /// gets one.
    fn arrange(&mut self, command: &Action) -> Outcome {
        tracing::warn!(?command, "this body arranges nothing");
        Outcome::Refused
    }
}

/// How an action (or scene command) went.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Carried out.
    Done,
    /// Not begun: outside what the body allows now.
    Refused,
    /// Begun and not completed: a fault of the body, of which nothing can be learnt.
    Failed,
    /// Not completed in the time the body allows.
    TimedOut,
}

/// What a body senses in one frame: observations of declared types, in any order. The daemon checks their values when the
/// frame comes to it, and says what is wrong with one that was not declared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Senses {
    records: Vec<Record>,
    /// Observations reported; those beyond the limit of a frame are counted and not kept.
    count: usize,
}

impl Senses {
    /// Nothing reported yet; what is reported goes where `records` are, which are forgotten.
    pub(crate) fn reusing(mut records: Vec<Record>) -> Self {
        records.clear();
        Self { records, count: 0 }
    }

    /// Reports one observation: the index of its type and one value a property, in declared order.
    pub fn observe(&mut self, observation_type: u16, values: &[Value]) {
        self.count += 1;
        if self.records.len() < OBSERVATIONS_MAX {
            self.records.push(encode::record(observation_type, values));
        }
    }

    /// What has been reported so far, at most as much as a frame holds.
    #[must_use]
    pub fn observations(&self) -> Observations<'_> {
        Observations::of(&self.records)
    }

    /// The frame with all that was reported. Of too many observations all are counted, so that the frame is refused and
    /// not cut.
    pub(crate) fn into_frame(self, session: u64, sequence: u64, report: Option<OrderReport>) -> RawFrame {
        let count = u32::try_from(self.count).unwrap_or(u32::MAX);
        RawFrame { header: encode::frame_header(session, sequence, report, count), records: self.records }
    }
}
