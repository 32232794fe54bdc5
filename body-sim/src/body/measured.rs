//! The physics engine alone on the way that a body's finger took: what an action would cost without a body around it.

use std::time::{Duration, Instant};

use pschema_protocol::body::{Body, Outcome};
use pschema_protocol::description::Action;

use super::{SimBody, finger_pose, world_setup};
use crate::world::World;

/// What one action took.
#[derive(Clone, Debug, PartialEq)]
pub struct Lap {
    /// How it ended.
    pub outcome: Outcome,
    /// Of the whole action, by the body.
    pub body: Duration,
    /// Of the same steps of the same blocks and finger, by the physics engine alone.
    pub alone: Duration,
    /// Steps of simulated time in it.
    pub steps: usize,
}

/// The physics engine alone, in a world that was built as the body's.
pub struct Alone(World);

impl std::fmt::Debug for Alone {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str("Alone")
    }
}

impl Alone {
    /// A world as `body` lives in.
    #[must_use]
    pub fn beside(body: &SimBody) -> Self {
        let mut alone = Self(World::new(&world_setup(&body.workspace), &finger_pose(&body.posture)));
        alone.be_as(body);
        alone
    }

    /// Everything to where it is around `body`, as after something was put on the table.
    pub fn be_as(&mut self, body: &SimBody) {
        self.0.be_as(&body.world);
        // What was put down comes to rest; it does so around the body, too.
        let finger = finger_pose(&body.posture);
        (0..crate::world::STEPS_PER_S).for_each(|_| self.0.step_alone(&finger));
    }

    /// Has `body` carry out an action, and takes the same way after it.
    pub fn lap(&mut self, body: &mut SimBody, action: &Action) -> Lap {
        body.path = Some(Vec::new());
        let began = Instant::now();
        let outcome = body.act(action);
        let took = began.elapsed();
        let path = body.path.take().unwrap_or_default();
        let began = Instant::now();
        path.iter().for_each(|finger| self.0.step_alone(finger));
        Lap { outcome, body: took, alone: began.elapsed(), steps: path.len() }
    }

    /// How far the blocks are from where they are around `body`, in metres: the farthest of them.
    #[must_use]
    pub fn apart_m(&self, body: &SimBody) -> f64 {
        let blocks = 0..self.0.block_count();
        let both = blocks.filter_map(|block| self.0.block(block).zip(body.world.block(block)));
        both.map(|(a, b)| (a.translation.vector - b.translation.vector).norm()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use pschema_protocol::description::Value;

    use super::*;
    use crate::config::WorldFile;

    #[test]
    fn the_engine_alone_does_what_happens_around_the_body() {
        let file = WorldFile::load("wide").unwrap();
        let mut body = SimBody::new("arm", file, "wide", 1, false).unwrap();
        let repertoire = body.describe().repertoire;
        let (at, field) = body
            .workspace
            .places
            .iter()
            .enumerate()
            .find_map(|(at, place)| place.within_reach.then_some((at, place.field)))
            .unwrap();
        let put = Action::new(body.ids().place, (Value::Symbol(0), i64::try_from(at).unwrap()));
        assert_eq!(body.arrange(&put), Outcome::Done);
        let mut alone = Alone::beside(&body);
        assert!(alone.apart_m(&body) < 0.001, "{} m", alone.apart_m(&body));
        let there = body.workspace.taught.iter().position(|taught| taught.field == field).unwrap();
        for action in [there, 0, there] {
            let lap = alone.lap(&mut body, &repertoire[action]);
            assert_eq!(lap.outcome, Outcome::Done);
            assert!(lap.steps > 10 && lap.body > Duration::ZERO && lap.alone > Duration::ZERO, "{lap:?}");
            assert!(alone.apart_m(&body) < 0.002, "{} m", alone.apart_m(&body));
        }
    }
}
