//! The paper's example of an effect that need not matter (section II-A): pushing a block may knock a ball off
//! the table.

mod common;

use common::{Frame, body, place, sense};
use pschema_protocol::body::{Body, Outcome};
use pschema_protocol::description::Action;
use pschema_sim::body::SimBody;

const BLOCK: u32 = 0;
const BALL: u32 = 1;
const BLUE: u32 = 0;
const RED: u32 = 1;
/// The places that the world lists, after its ten generated ones.
const BLOCK_AT: usize = 10;
const BALL_AT: usize = 11;

/// The pushes of the repertoire: the short one, then the long one.
fn pushes(body: &SimBody) -> Vec<Action> {
    body.describe().repertoire.into_iter().filter(|ordered| Some(ordered.id) == body.ids().push).collect()
}

/// Puts both down and pushes; what is seen before and after.
fn push(seed: u64, which: usize) -> (Frame, Frame) {
    let mut body = body("block-and-ball", seed);
    let pushes = pushes(&body);
    assert_eq!(pushes.len(), 2);
    assert_eq!(place(&mut body, BLOCK, BLOCK_AT), Outcome::Done);
    assert_eq!(place(&mut body, BALL, BALL_AT), Outcome::Done);
    let before = sense(&mut body);
    assert_eq!(body.act(&pushes[which]), Outcome::Done);
    (before, sense(&mut body))
}

fn field_of(frame: &Frame, colour: u32) -> Option<i64> {
    frame.objects.iter().find(|(seen, _)| *seen == colour).map(|(_, field)| *field)
}

/// Of 40 seeds: block moved to the goal's field, ball gone.
fn pushed(which: usize) -> (usize, usize) {
    let (mut moved, mut gone) = (0, 0);
    for seed in 1..=40 {
        let (before, after) = push(seed, which);
        let block = field_of(&before, BLUE).expect("the block is seen");
        assert_eq!(field_of(&before, RED), Some(block + 2), "the ball is seen beyond the goal");
        moved += usize::from(field_of(&after, BLUE) == Some(block + 1));
        gone += usize::from(field_of(&after, RED).is_none());
    }
    println!("push {which}: block moved {moved} of 40 times, ball gone {gone}");
    (moved, gone)
}

#[test]
fn the_long_push_moves_the_block_and_knocks_the_ball_off_now_and_then() {
    let (moved, gone) = pushed(1);
    assert!(moved >= 30, "{moved}");
    assert!((8..=32).contains(&gone), "{gone}");
}

#[test]
fn the_short_push_moves_the_block_and_leaves_the_ball() {
    let (moved, gone) = pushed(0);
    assert!(moved >= 20, "{moved}");
    assert_eq!(gone, 0);
}

#[test]
fn a_push_repeats_for_its_seed() {
    assert_eq!(push(7, 1), push(7, 1));
}

#[test]
fn worlds_without_pushes_do_not_declare_or_obey_them() {
    let push = pushes(&body("block-and-ball", 1)).remove(0);
    for world in ["wide", "narrow"] {
        let mut body = body(world, 1);
        assert_eq!(body.describe().actions.len(), 1);
        assert!(pushes(&body).is_empty());
        assert!(matches!(body.act(&push), Outcome::Refused(_)));
    }
}
