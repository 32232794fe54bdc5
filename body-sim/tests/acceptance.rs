//! What a learner relies on, driving the body as a daemon would, without one.

mod common;

use std::collections::BTreeSet;

use common::{BLUE_BLOCK, Choices, Frame, block_xy, body, body_in, moved_m, place, places, reach, sense};
use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, ActionId, Value};
use pschema_sim::body::SimBody;
use pschema_sim::config::WIDE;

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

/// Scenario 3 of the paper tries every posture with a block at every place. What a posture does must not depend
/// on the block, except at the block.
#[test]
fn every_posture_leads_to_its_field_whatever_stands_on_the_table() {
    for world in ["wide", "narrow"] {
        let mut body = body(world, 8);
        let repertoire = body.describe().repertoire;
        let fields: Vec<i64> = body.workspace().taught.iter().map(|taught| taught.field as i64).collect();
        let (mut pairs, mut unseen) = (0, 0);
        for (position, at) in places(&body, true).into_iter().step_by(17) {
            assert_eq!(place(&mut body, BLUE_BLOCK, position), Outcome::Done);
            // A step that has no factor in common with either number of postures, to come from all sides.
            for index in (0..repertoire.len()).map(|index| index * 101 % repertoire.len()) {
                assert_eq!(body.act(&repertoire[index]), Outcome::Done);
                let frame = sense(&mut body);
                assert_eq!(frame.finger, Some(fields[index]), "position {position}");
                assert_eq!(frame.touch, fields[index] == at.field as i64, "position {position}: {frame:?}");
                pairs += 1;
                match frame.objects.as_slice() {
                    [] => unseen += 1,
                    seen => assert_eq!(seen, [(0, at.field as i64)], "position {position}"),
                }
            }
        }
        println!("hidden in {unseen} of {pairs}");
        assert!(unseen * 1000 <= pairs * 3, "hidden in {unseen} of {pairs}");
    }
}

#[test]
fn faults_of_the_world_file_are_felt_and_repeat_for_a_seed() {
    let noisy = WIDE
        .replacen("finger_misplaced = 0 ", "finger_misplaced = 0.2 ", 1)
        .replacen("blob_missed = 0 ", "blob_missed = 0.1 ", 1)
        .replacen("touch_false = 0 ", "touch_false = 0.3 ", 1)
        .replacen("move_error_mm = 0 ", "move_error_mm = 4 ", 1);
    let run = |seed| {
        let mut body = body_in(&noisy, seed);
        let repertoire = body.describe().repertoire;
        let fields: Vec<i64> = body.workspace().taught.iter().map(|taught| taught.field as i64).collect();
        let mut frames = Vec::new();
        for (posture, field) in repertoire.iter().zip(fields) {
            assert_eq!(body.act(posture), Outcome::Done);
            frames.push((field, sense(&mut body)));
        }
        frames
    };
    let frames = run(1);
    let share = |is: &dyn Fn(&(i64, Frame)) -> bool| {
        frames.iter().filter(|frame| is(frame)).count() as f64 / frames.len() as f64
    };
    let missed = share(&|(_, frame)| frame.finger.is_none());
    let misplaced = share(&|(field, frame)| frame.finger.is_some_and(|seen| seen != *field));
    let felt = share(&|(_, frame)| frame.touch);
    println!("missed {missed}, misplaced {misplaced}, felt {felt}");
    assert!((0.04..0.18).contains(&missed) && (0.1..0.28).contains(&misplaced), "{missed} {misplaced}");
    assert!((0.2..0.4).contains(&felt), "{felt}");
    assert_eq!(frames, run(1));
    assert_ne!(frames, run(2));
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

/// The touch reflex works at any speed and from any side: here of a finger that slides from posture to posture
/// and so meets more than it is sent to.
#[test]
fn a_block_met_on_the_way_is_hardly_pushed() {
    let mut body = body_in(&WIDE.replacen("lift_mm = 50", "lift_mm = 0", 1), 6);
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
        assert!((0.0105..0.05).contains(&height_m), "block {block} is at {height_m} m");
    }
    let touch = body.ids().touch;
    let touches = frames.iter().filter(|f| f.observations().iter().any(|o| o.sense() == touch)).count();
    println!("{touches} of 500 moves ended in touch");
    // One posture of 224 touches each of three blocks.
    assert!((2..20).contains(&touches), "{touches}");
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
    let ids = body.ids();
    let unknown = ActionId::from_index(9);
    for (id, parameters) in [
        (ids.move_to, vec![Value::Real(1.0), Value::Real(1.0)]),
        (ids.move_to, vec![Value::Real(f64::NAN), Value::Real(0.5)]),
        (ids.move_to, vec![Value::Real(-0.1), Value::Real(0.5)]),
        (ids.move_to, vec![Value::Real(0.5)]),
        (unknown, vec![]),
    ] {
        let action = Action { id, parameters };
        assert!(matches!(body.act(&action), Outcome::Refused(_)), "{action:?}");
    }
    for (id, parameters) in [
        (ids.place, vec![Value::Symbol(99), Value::Integer(0)]),
        (ids.place, vec![Value::Symbol(0), Value::Integer(-1)]),
        (ids.place, vec![Value::Symbol(0), Value::Integer(1_000_000)]),
        (ids.place, vec![Value::Symbol(1), Value::Integer(10)]),
        (ids.remove, vec![Value::Symbol(77)]),
        (unknown, vec![]),
    ] {
        let command = Action { id, parameters };
        assert!(matches!(body.arrange(&command), Outcome::Refused(_)), "{command:?}");
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
    assert_eq!(body.arrange(&Action::new(body.ids().park, ())), Outcome::Done);
    let parked = sense(&mut body);
    assert!(parked.finger.is_none() && !parked.touch && parked.objects.len() == 1, "{parked:?}");
    let remove = Action::new(body.ids().remove, [Value::Symbol(BLUE_BLOCK)]);
    assert_eq!(body.arrange(&remove), Outcome::Done);
    assert_eq!(sense(&mut body), Frame::default());
    reach(&mut body, field);
    assert!(!sense(&mut body).touch, "what was taken away cannot be touched");
    assert_eq!(place(&mut body, BLUE_BLOCK, 30), Outcome::Done);
    assert_eq!(sense(&mut body).objects.len(), 1);
}
