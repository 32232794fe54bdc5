//! Driving the body as a daemon would, without one.
#![allow(dead_code, reason = "each test program uses its part")]

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Value};
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;
use pschema_sim::workspace::TablePlace;

pub(crate) const BLUE_BLOCK: u32 = 0;

pub(crate) fn body(world: &str, seed: u64) -> SimBody {
    println!("world {world}, seed {seed}");
    let file = WorldFile::load(world).expect("a shipped world");
    SimBody::new("arm", file, world, seed, false).expect("a consistent world")
}

/// A body in a world given by its text.
pub(crate) fn body_in(world: &str, seed: u64) -> SimBody {
    println!("seed {seed}");
    let file = WorldFile::parse("test", world).expect("a world");
    SimBody::new("arm", file, "test", seed, false).expect("a consistent world")
}

pub(crate) fn reach(body: &mut SimBody, field: usize) -> Outcome {
    let taught = *body.workspace().taught_for(field).expect("a field of a place is reachable");
    body.act(&Action::new(body.ids().move_to, [taught.joints.j1, taught.joints.j2]))
}

pub(crate) fn place(body: &mut SimBody, object: u32, position: usize) -> Outcome {
    body.arrange(&Action::new(body.ids().place, (Value::Symbol(object), position as i64)))
}

pub(crate) fn places(body: &SimBody, within_reach: bool) -> Vec<(usize, TablePlace)> {
    let places = body.workspace().places.iter().copied().enumerate();
    places.filter(|(_, place)| place.within_reach == within_reach).collect()
}

/// A frame, taken apart.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Frame {
    pub(crate) finger: Option<i64>,
    pub(crate) objects: Vec<(u32, i64)>,
    pub(crate) touch: bool,
    pub(crate) contacts: Vec<u32>,
}

pub(crate) fn sense(body: &mut SimBody) -> Frame {
    let mut senses = Senses::default();
    body.sense(&mut senses);
    let (ids, mut frame) = (body.ids(), Frame::default());
    for observation in senses.observations().iter() {
        let values: Vec<_> = observation.values().collect();
        match values[..] {
            [Value::Symbol(0), Value::Integer(field)] if observation.sense() == ids.finger => {
                assert_eq!(frame.finger.replace(field), None, "one finger");
            }
            [Value::Symbol(colour), Value::Integer(field)] if observation.sense() == ids.object => {
                frame.objects.push((colour, field));
            }
            [] if observation.sense() == ids.touch => frame.touch = true,
            [Value::Symbol(side)] if observation.sense() == ids.contact => frame.contacts.push(side),
            _ => panic!("not declared: {observation:?}"),
        }
    }
    frame
}

/// How far a block has been moved along the table, in metres.
pub(crate) fn moved_m(body: &SimBody, before: (f64, f64)) -> f64 {
    let now = body.world().block(BLUE_BLOCK as usize).expect("the block is still there").translation.vector;
    ((now.x - before.0).powi(2) + (now.y - before.1).powi(2)).sqrt()
}

pub(crate) fn block_xy(body: &SimBody) -> (f64, f64) {
    let at = body.world().block(BLUE_BLOCK as usize).expect("the block is there").translation.vector;
    (at.x, at.y)
}

/// A small generator for the tests' own choices.
pub(crate) struct Choices(pub(crate) u64);

impl Choices {
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % limit
    }
}
