//! A body, as its author sees it: describe yourself, sense, act. [`run()`] is the whole life of a body
//! process around it; [`BodyLoop`] is the same without a process or shared memory.

mod driver;
mod run;

pub use driver::{BodyLoop, Directive};
pub use run::{Ending, RunError, RunOptions, RunSummary, run, run_from_args};

use crate::description::{Action, Description, Value};
use crate::picture::Picture;

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

/// What a body senses in one frame: observations of declared types, in any order. Values are checked
/// when the frame is sent, not here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Senses {
    observations: Vec<SensedObservation>,
}

/// One observation as the body reports it.
#[derive(Clone, Debug, PartialEq)]
pub struct SensedObservation {
    /// Index into [`Description::observation_types`].
    pub observation_type: u16,
    /// One value a property, in declared order.
    pub values: Vec<Value>,
}

impl Senses {
    /// Reports one observation: the index of its type and one value a property, in declared order.
    pub fn observe(&mut self, observation_type: u16, values: &[Value]) {
        self.observations.push(SensedObservation { observation_type, values: values.to_vec() });
    }

    /// What has been reported so far.
    #[must_use]
    pub fn observations(&self) -> &[SensedObservation] {
        &self.observations
    }

    /// Forgets everything reported, for the next frame.
    pub fn clear(&mut self) {
        self.observations.clear();
    }
}
