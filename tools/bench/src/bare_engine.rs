//! The physics engine alone, with the finger on the way that a body's finger took: the cost of an action without a body
//! around the engine.

use std::time::{Duration, Instant};

use pschema_protocol::body::{Body, Outcome};
use pschema_protocol::description::Action;
use pschema_sim::body::SimBody;
use pschema_sim::world::{STEPS_PER_S, World};

/// The time that one action took.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lap {
    /// How it ended.
    pub(crate) outcome: Outcome,
    /// Time of the whole action, by the body.
    pub(crate) body: Duration,
    /// Time of the same steps of the same blocks and finger, by the physics engine alone.
    pub(crate) alone: Duration,
    /// Steps of simulated time in the action.
    pub(crate) steps: usize,
}

/// The physics engine alone, with a world that was built like the body's.
pub(crate) struct BareEngine(World);

impl std::fmt::Debug for BareEngine {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str("BareEngine")
    }
}

impl BareEngine {
    /// An engine whose world is like that of `body`.
    pub(crate) fn beside(body: &SimBody) -> Self {
        let mut alone = Self(body.bare_world());
        alone.be_as(body);
        alone
    }

    /// Brings everything to where it is around `body`, as is needed after an object was put on the table.
    pub(crate) fn be_as(&mut self, body: &SimBody) {
        self.0.be_as(body.world());
        // The object comes to rest here, as it does around the body.
        let finger = body.finger_pose();
        (0..STEPS_PER_S).for_each(|_| self.0.step_alone(&finger));
    }

    /// Has `body` carry out an action, and takes the same way after it.
    pub(crate) fn lap(&mut self, body: &mut SimBody, action: &Action) -> Lap {
        body.record_path();
        let began = Instant::now();
        let outcome = body.act(action);
        let took = began.elapsed();
        let path = body.take_path();
        let began = Instant::now();
        path.iter().for_each(|finger| self.0.step_alone(finger));
        Lap { outcome, body: took, alone: began.elapsed(), steps: path.len() }
    }

    /// How far the blocks are from where they are around `body`, in metres: the farthest of them.
    pub(crate) fn apart_m(&self, body: &SimBody) -> f64 {
        let blocks = 0..self.0.block_count();
        let both = blocks.filter_map(|block| self.0.block(block).zip(body.world().block(block)));
        both.map(|(a, b)| (a.translation.vector - b.translation.vector).norm()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use pschema_protocol::description::Value;

    use super::*;
    use pschema_sim::config::WorldFile;

    #[test]
    fn the_engine_alone_does_what_happens_around_the_body() {
        let file = WorldFile::load("wide").unwrap();
        let mut body = SimBody::new("arm", file, "wide", 1, false).unwrap();
        let repertoire = body.describe().repertoire;
        let (at, field) = body
            .workspace()
            .places
            .iter()
            .enumerate()
            .find_map(|(at, place)| place.within_reach.then_some((at, place.field)))
            .unwrap();
        let put = Action::new(body.ids().place, (Value::symbol(0), at as i64));
        assert_eq!(body.arrange(&put), Outcome::Done);
        let mut alone = BareEngine::beside(&body);
        assert!(alone.apart_m(&body) < 0.001, "{} m", alone.apart_m(&body));
        let there = body.workspace().taught.iter().position(|taught| taught.field == field).unwrap();
        for action in [there, 0, there] {
            let lap = alone.lap(&mut body, &repertoire[action]);
            assert_eq!(lap.outcome, Outcome::Done);
            assert!(lap.steps > 10 && lap.body > Duration::ZERO && lap.alone > Duration::ZERO, "{lap:?}");
            assert!(alone.apart_m(&body) < 0.002, "{} m", alone.apart_m(&body));
        }
    }
}
