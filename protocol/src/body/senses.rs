//! What a body senses in one frame.

use crate::description::{SenseId, Values};
use crate::limits::OBSERVATIONS_MAX;
use crate::wire::message::{OrderReport, RawFrame};
use crate::wire::{FrameHeader, Observations, Record, encode};

/// What a body senses in one frame: observations of declared types, in any order. The daemon checks their values when the
/// frame comes to it, and says what is wrong with one that was not declared.
///
/// ```
/// use pschema_protocol::body::Senses;
/// use pschema_protocol::description::{Description, ObservationType, Property, Value};
///
/// let mut description = Description::new("eye", "camera");
/// let colour = Property::symbol("colour", ["red", "blue"]);
/// let object = ObservationType::state("object").property(colour).property(Property::integer("field", 0..=99));
/// let object = description.observation(object);
/// let dark = description.observation(ObservationType::event("dark"));
///
/// let mut frame = Senses::default();
/// frame.observe(object, (Value::symbol(1), 42));
/// frame.observe(dark, ());
/// assert_eq!(frame.observations().len(), 2);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Senses {
    records: Vec<Record>,
    /// Observations reported; those beyond the limit of a frame are counted and not kept.
    count: usize,
}

impl Senses {
    /// Nothing reported yet; what is reported takes the place of `records`.
    pub(super) fn reusing(mut records: Vec<Record>) -> Self {
        records.clear();
        Self { records, count: 0 }
    }

    /// Reports one observation: its type, and one value a property, in declared order.
    pub fn observe(&mut self, sense: SenseId, values: impl Values) {
        self.count += 1;
        if self.records.len() < OBSERVATIONS_MAX {
            self.records.push(values.read(|values| encode::record(sense.index(), values)));
        }
    }

    /// What has been reported so far, at most as much as a frame holds.
    #[must_use]
    pub fn observations(&self) -> Observations<'_> {
        Observations::of(&self.records)
    }

    /// The frame that says all of it, for a host that has the learner in its own process. Of too many observations all are counted, so that
    /// the frame is refused and not cut.
    #[doc(hidden)]
    #[must_use]
    pub fn into_frame(self, session: u64, sequence: u64, report: Option<&OrderReport>) -> RawFrame {
        let observation_count = u32::try_from(self.count).unwrap_or(u32::MAX);
        let header = FrameHeader { session, sequence, observation_count, ..FrameHeader::default() };
        encode::frame(header, report, self.records)
    }
}
