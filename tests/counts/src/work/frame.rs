//! The frame of a body as the daemon decodes it: every check of the header and of each observation, and every value read.

use std::hint::black_box;

use pschema_protocol::body::BodyLoop;
use pschema_protocol::prelude::*;
use pschema_protocol::refusal::Refusal;
use pschema_protocol::wire::decode::{self, SessionChecks};

use crate::counted::{Tally, counted};
use crate::failure::CountFailure;

const ROUNDS: u64 = 500;
/// Observations in a frame: four kibibytes of records.
const OBSERVATIONS: i64 = 56;
/// The number of the session.
const SESSION: u64 = 1;

/// A body that senses many things of one type.
struct Crowd {
    description: Description,
    object: SenseId,
}

impl Crowd {
    fn new() -> Self {
        let mut description = Description::new("crowd", "crowd");
        let field = Property::integer("field", 0..=OBSERVATIONS - 1);
        let colour = Property::symbol("colour", ["red", "green", "blue"]);
        let object =
            description.observation(ObservationType::state("object").property(field).property(colour));
        description.action_with_primitives(ActionType::new("rest"));
        Self { description, object }
    }
}

impl Body for Crowd {
    fn describe(&self) -> Description {
        self.description.clone()
    }

    fn sense(&mut self, frame: &mut Senses) {
        for (field, colour) in (0..OBSERVATIONS).zip((0..3).cycle()) {
            frame.observe(self.object, (field, Value::symbol(colour)));
        }
    }

    fn act(&mut self, _: &Action) -> Outcome {
        Outcome::Done
    }
}

pub(super) fn carry_out() -> Result<Tally, CountFailure> {
    let mut body = BodyLoop::new(Crowd::new());
    let hello = body.hello().map_err(CountFailure::of("frame"))?;
    let introduced = decode::hello(&hello).map_err(CountFailure::of("frame"))?;
    body.attached(SESSION);
    let mut checks = SessionChecks::new(SESSION, introduced.description);
    let mut raw = body.next_frame().clone();
    let mut tally = Tally::default();
    for sequence in 1..=ROUNDS {
        raw.header.sequence = sequence;
        let sum = counted(&mut tally, || {
            let frame = checks.check(black_box(&raw))?;
            let values = frame.observations.iter().flat_map(|observation| observation.values());
            Ok::<i64, Refusal>(values.map(number).sum())
        });
        let sum = sum.map_err(CountFailure::of("frame"))?;
        tally.result = tally.result.wrapping_add(sum.unsigned_abs());
    }
    Ok(tally)
}

/// A value as a number, so that it is read.
fn number(value: Value) -> i64 {
    match value {
        Value::Integer(number) => number,
        Value::Symbol(number) => i64::from(number),
        Value::Boolean(is_so) => i64::from(is_so),
        Value::Real(_) => 0,
    }
}
