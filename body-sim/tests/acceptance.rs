//! What a learner relies on, driving the body as a daemon would, without one.

use std::collections::BTreeSet;

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Value};
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;
use pschema_sim::declare::{action, observation, scene};
use pschema_sim::workspace::Place;

const BLUE_BLOCK: u32 = 0;

fn body(world: &str, seed: u64) -> SimBody {
    println!("world {world}, seed {seed}");
    let file = WorldFile::load(world).expect("a shipped world");
    SimBody::new("arm", file, world, seed, false).expect("a consistent world")
}

fn reach(body: &mut SimBody, field: usize) -> Outcome {
    let taught = *body.workspace().taught_for(field).expect("a field of a place is reachable");
    let parameters = vec![Value::Real(taught.joints.j1), Value::Real(taught.joints.j2)];
    body.act(&Action { action: action::MOVE, parameters })
}

fn place(body: &mut SimBody, object: u32, position: usize) -> Outcome {
    let parameters = vec![Value::Symbol(object), Value::Integer(position as i64)];
    body.arrange(&Action { action: scene::PLACE, parameters })
}

fn places(body: &SimBody, within_reach: bool) -> Vec<(usize, Place)> {
    let places = body.workspace().places.iter().copied().enumerate();
    places.filter(|(_, place)| place.within_reach == within_reach).collect()
}

/// A frame, taken apart.
#[derive(Debug, Default, PartialEq)]
struct Frame {
    finger: Option<i64>,
    objects: Vec<(u32, i64)>,
    touch: bool,
    contacts: Vec<u32>,
}

fn sense(body: &mut SimBody) -> Frame {
    let mut senses = Senses::default();
    body.sense(&mut senses);
    let mut frame = Frame::default();
    for observed in senses.observations() {
        match (observed.observation_type, observed.values.as_slice()) {
            (observation::FINGER, &[Value::Symbol(0), Value::Integer(field)]) => {
                assert_eq!(frame.finger.replace(field), None, "one finger");
            }
            (observation::OBJECT, &[Value::Symbol(colour), Value::Integer(field)]) => {
                frame.objects.push((colour, field));
            }
            (observation::TOUCH, []) => frame.touch = true,
            (observation::CONTACT, &[Value::Symbol(side)]) => frame.contacts.push(side),
            other => panic!("not declared: {other:?}"),
        }
    }
    frame
}

/// How far a block has been moved along the table, in metres.
fn moved_m(body: &SimBody, before: (f64, f64)) -> f64 {
    let now = body.world().block(BLUE_BLOCK as usize).expect("the block is still there").translation.vector;
    ((now.x - before.0).powi(2) + (now.y - before.1).powi(2)).sqrt()
}

fn block_xy(body: &SimBody) -> (f64, f64) {
    let at = body.world().block(BLUE_BLOCK as usize).expect("the block is there").translation.vector;
    (at.x, at.y)
}

#[test]
fn the_finger_is_seen_in_as_many_fields_as_published() {
    for (world, fields) in [("wide", 224), ("narrow", 112)] {
        let mut body = body(world, 1);
        let mut seen = BTreeSet::new();
        let repertoire = body.describe().repertoire;
        assert_eq!(repertoire.len(), fields);
        for posture in &repertoire {
            assert_eq!(body.act(posture), Outcome::Done, "{posture:?}");
            let frame = sense(&mut body);
            assert!(!frame.touch && frame.objects.is_empty(), "nothing is on the table: {frame:?}");
            seen.insert(frame.finger.unwrap_or_else(|| panic!("no finger is seen at {posture:?}")));
        }
        assert_eq!(seen.len(), fields, "{world}");
    }
}

#[test]
fn a_block_anywhere_on_the_table_is_touched_where_it_is_seen() {
    for (world, seed) in [("wide", 1), ("wide", 2), ("narrow", 3)] {
        let mut body = body(world, seed);
        let (mut touched, mut furthest_m) = (0, 0.0_f64);
        let all = places(&body, true);
        assert_eq!(all.len(), 100);
        for (position, at) in &all {
            assert_eq!(place(&mut body, BLUE_BLOCK, *position), Outcome::Done);
            let before = sense(&mut body);
            assert_eq!(before.finger, None, "parked, the finger is out of sight");
            assert_eq!(before.objects, [(0, at.field as i64)], "position {position}");
            let stood = block_xy(&body);
            assert_eq!(reach(&mut body, at.field), Outcome::Done);
            let after = sense(&mut body);
            furthest_m = furthest_m.max(moved_m(&body, stood));
            let as_expected = after.touch
                && after.finger == Some(at.field as i64)
                && after.objects == before.objects
                && !after.contacts.is_empty();
            if as_expected {
                touched += 1;
            } else {
                println!("position {position} in field {}: {before:?} -> {after:?}", at.field);
            }
        }
        println!("touched {touched} of 100, pushed {:.2} mm at most", furthest_m * 1e3);
        assert!(touched >= 98, "{touched}");
        assert!(furthest_m < 0.005, "a block was pushed {furthest_m} m");
    }
}

#[test]
fn a_block_beyond_reach_is_pointed_at() {
    for (world, seed) in [("wide", 1), ("narrow", 2)] {
        let mut body = body(world, seed);
        let all = places(&body, false);
        assert!(all.len() >= 8);
        for (position, at) in all {
            assert_eq!(place(&mut body, BLUE_BLOCK, position), Outcome::Done);
            let before = sense(&mut body);
            assert_eq!(before.objects, [(0, at.field as i64)], "position {position}");
            let stood = block_xy(&body);
            assert_eq!(reach(&mut body, at.field), Outcome::Done);
            let after = sense(&mut body);
            assert!(!after.touch && after.contacts.is_empty(), "position {position}: {after:?}");
            assert_eq!(after.finger, Some(at.field as i64), "position {position}");
            assert_eq!(after.objects, before.objects, "position {position}");
            assert!(moved_m(&body, stood) < 1e-4, "position {position}");
        }
    }
}

/// A learner repeats what excites it: the block must not wander off because it is touched again.
#[test]
fn a_block_touched_again_stays_in_its_field() {
    let mut body = body("wide", 4);
    let mut kept = 0;
    let all = places(&body, true);
    for (position, at) in &all {
        place(&mut body, BLUE_BLOCK, *position);
        for _ in 0..3 {
            reach(&mut body, at.field);
        }
        let after = sense(&mut body);
        let field = at.field as i64;
        kept += usize::from(after.touch && after.finger == Some(field) && after.objects == [(0, field)]);
    }
    println!("{kept} of {}", all.len());
    assert!(kept >= 98, "{kept}");
}

/// The touch reflex works at any speed and from any side.
#[test]
fn a_block_met_on_the_way_is_hardly_pushed() {
    let mut body = body("wide", 6);
    let repertoire = body.describe().repertoire;
    let mut choices = Choices(3);
    let (mut met, mut furthest_m) = (0, 0.0_f64);
    for _ in 0..400 {
        // Sweeps across the table, with the block anywhere.
        place(&mut body, BLUE_BLOCK, choices.below(100));
        body.act(&repertoire[choices.below(repertoire.len())]);
        if !body.world().gaps().is_empty() {
            continue;
        }
        let stood = block_xy(&body);
        assert_eq!(body.act(&repertoire[choices.below(repertoire.len())]), Outcome::Done);
        furthest_m = furthest_m.max(moved_m(&body, stood));
        met += usize::from(sense(&mut body).touch);
    }
    println!("met {met} times, pushed {:.2} mm at most", furthest_m * 1e3);
    assert!(met >= 10, "{met}");
    assert!(furthest_m < 0.008, "{furthest_m} m");
}

/// A small generator for the tests' own choices.
struct Choices(u64);

impl Choices {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % limit
    }
}

/// Moves at random among blocks, as babbling does; every frame.
fn babble(body: &mut SimBody, seed: u64, moves: usize) -> Vec<Senses> {
    let mut choices = Choices(seed);
    let repertoire = body.describe().repertoire;
    let within = places(body, true).len();
    let mut frames = Vec::new();
    for count in 0..moves {
        if count % 50 == 0 {
            for object in 0..3 {
                // Refused when another block is in the way, which is as good.
                let _: Outcome = place(body, object, choices.below(within));
            }
        }
        let outcome = body.act(&repertoire[choices.below(repertoire.len())]);
        assert_eq!(outcome, Outcome::Done, "move {count}");
        let mut frame = Senses::default();
        body.sense(&mut frame);
        frames.push(frame);
    }
    frames
}

#[test]
fn random_moves_leave_blocks_on_the_table() {
    let mut body = body("wide", 5);
    let frames = babble(&mut body, 99, 500);
    for block in 0..3 {
        let at = body.world().block(block).unwrap_or_else(|| panic!("block {block} is lost"));
        assert!(at.translation.vector.iter().all(|x| x.is_finite()));
        let height_m = at.translation.vector.z;
        assert!((0.0115..0.05).contains(&height_m), "block {block} is at {height_m} m");
    }
    let touches = frames
        .iter()
        .filter(|f| f.observations().iter().any(|o| o.observation_type == observation::TOUCH))
        .count();
    println!("{touches} of 500 moves ended in touch");
    assert!(touches > 5, "{touches}");
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let run = |seed| babble(&mut body("wide", seed), 7, 60);
    let first = run(11);
    assert_eq!(first, run(11));
    // Not asserted, as tuning changes it: for comparing machines and builds.
    let digest = format!("{first:?}").bytes().fold(0xCBF2_9CE4_8422_2325_u64, |sum, byte| {
        (sum ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3)
    });
    println!("digest of the run: {digest:016x}");
    // Placed a little differently, blocks are touched a little differently.
    let trace = |seed| {
        let mut body = body("wide", seed);
        place(&mut body, BLUE_BLOCK, 40);
        block_xy(&body)
    };
    assert_ne!(trace(11), trace(12));
}

#[test]
fn orders_out_of_range_are_refused_and_change_nothing() {
    let mut body = body("wide", 1);
    assert_eq!(place(&mut body, BLUE_BLOCK, 10), Outcome::Done);
    let before = sense(&mut body);
    let act =
        |body: &mut SimBody, action: u16, parameters: Vec<Value>| body.act(&Action { action, parameters });
    for (index, parameters) in [
        (action::MOVE, vec![Value::Real(1.0), Value::Real(1.0)]),
        (action::MOVE, vec![Value::Real(f64::NAN), Value::Real(0.5)]),
        (action::MOVE, vec![Value::Real(-0.1), Value::Real(0.5)]),
        (action::MOVE, vec![Value::Real(0.5)]),
        (9, vec![]),
    ] {
        assert_eq!(act(&mut body, index, parameters.clone()), Outcome::Refused, "{index} {parameters:?}");
    }
    let arrange = |body: &mut SimBody, action: u16, parameters: Vec<Value>| {
        body.arrange(&Action { action, parameters })
    };
    for (index, parameters) in [
        (scene::PLACE, vec![Value::Symbol(99), Value::Integer(0)]),
        (scene::PLACE, vec![Value::Symbol(0), Value::Integer(-1)]),
        (scene::PLACE, vec![Value::Symbol(0), Value::Integer(1_000_000)]),
        (scene::PLACE, vec![Value::Symbol(1), Value::Integer(10)]),
        (scene::REMOVE, vec![Value::Symbol(77)]),
        (9, vec![]),
    ] {
        assert_eq!(arrange(&mut body, index, parameters.clone()), Outcome::Refused, "{index} {parameters:?}");
    }
    assert_eq!(sense(&mut body), before);
}

#[test]
fn an_object_can_be_taken_away_and_put_back_and_the_arm_parked() {
    let mut body = body("wide", 1);
    assert_eq!(place(&mut body, BLUE_BLOCK, 30), Outcome::Done);
    let field = body.workspace().places[30].field;
    reach(&mut body, field);
    assert!(sense(&mut body).touch);
    assert_eq!(body.arrange(&Action { action: scene::PARK, parameters: vec![] }), Outcome::Done);
    let parked = sense(&mut body);
    assert!(parked.finger.is_none() && !parked.touch && parked.objects.len() == 1, "{parked:?}");
    let remove = Action { action: scene::REMOVE, parameters: vec![Value::Symbol(BLUE_BLOCK)] };
    assert_eq!(body.arrange(&remove), Outcome::Done);
    assert_eq!(sense(&mut body), Frame::default());
    reach(&mut body, field);
    assert!(!sense(&mut body).touch, "what was taken away cannot be touched");
    assert_eq!(place(&mut body, BLUE_BLOCK, 30), Outcome::Done);
    assert_eq!(sense(&mut body).objects.len(), 1);
}
