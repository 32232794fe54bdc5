//! Tries every taught posture with a block at every place, as scenario 3 of the paper does, and counts what a
//! learner would be shown: `cargo run --release -p pschema-sim --example survey -- wide 1 [places]`.

use std::collections::BTreeSet;
use std::error::Error;
use std::time::{Duration, Instant};

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{Action, Value};
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;

/// What was counted; `pairs` of a place and a posture.
#[derive(Debug, Default)]
struct Survey {
    pairs: usize,
    not_done: usize,
    /// No object was reported.
    unseen: usize,
    /// The object was reported elsewhere than where it was put, though it still stands there.
    misplaced: usize,
    /// The block no longer stood in the field it was put in.
    displaced: usize,
    /// Places whose block ended in another field.
    places_displaced: usize,
    /// The finger was not seen in the posture's field.
    stopped_short: usize,
    finger_unseen: usize,
    touches: usize,
    touches_elsewhere: usize,
    /// Different (object, posture, outcome) in all: schemas, roughly.
    kinds: usize,
    acting: Duration,
    sensing: Duration,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let world = arguments.first().map_or("wide", String::as_str);
    let seed: u64 = arguments.get(1).map_or(Ok(1), |seed| seed.parse())?;
    let every: usize = arguments.get(2).map_or(Ok(1), |every| every.parse())?;
    let mut body = SimBody::new("arm", WorldFile::load(world)?, world, seed, false)?;
    let survey = survey(&mut body, seed, every.max(1));
    println!("world {world}, seed {seed}");
    println!("{survey:#?}");
    let share = |count: usize| 100.0 * count as f64 / survey.pairs as f64;
    println!(
        "unseen {:.3} %, misplaced {:.3} %, displaced {:.3} %, stopped short {:.3} %",
        share(survey.unseen),
        share(survey.misplaced),
        share(survey.displaced),
        share(survey.stopped_short)
    );
    let each = |time: Duration| time.as_secs_f64() * 1e3 / survey.pairs as f64;
    println!("{:.3} ms a move, {:.3} ms a frame", each(survey.acting), each(survey.sensing));
    Ok(())
}

fn survey(body: &mut SimBody, seed: u64, every: usize) -> Survey {
    let (repertoire, ids) = (body.describe().repertoire, body.ids());
    let places = body.workspace().places.clone();
    let fields: Vec<i64> = body.workspace().taught.iter().map(|taught| taught.field as i64).collect();
    let mut survey = Survey::default();
    let mut kinds = BTreeSet::new();
    let mut random = seed;
    for (position, place) in places.iter().enumerate().filter(|(_, place)| place.within_reach).step_by(every)
    {
        let put = Action::new(ids.place, (Value::Symbol(0), position as i64));
        if body.arrange(&put) != Outcome::Done {
            println!("place {position} was refused");
            continue;
        }
        let mut order: Vec<usize> = (0..repertoire.len()).collect();
        for index in (1..order.len()).rev() {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            order.swap(index, (random >> 33) as usize % (index + 1));
        }
        let put_at = place.field as i64;
        let mut before = Some(put_at);
        for posture in order {
            let began = Instant::now();
            let outcome = body.act(&repertoire[posture]);
            let acted = Instant::now();
            let mut senses = Senses::default();
            body.sense(&mut senses);
            survey.acting += acted - began;
            survey.sensing += acted.elapsed();
            survey.pairs += 1;
            survey.not_done += usize::from(outcome != Outcome::Done);
            let (mut object, mut finger, mut touch) = (None, None, false);
            for observation in senses.observations().iter() {
                let values: Vec<_> = observation.values().collect();
                match values[..] {
                    [_, Value::Integer(field)] if observation.sense() == ids.finger => finger = Some(field),
                    [_, Value::Integer(field)] if observation.sense() == ids.object => object = Some(field),
                    _ => touch |= observation.sense() == ids.touch,
                }
            }
            survey.unseen += usize::from(object.is_none());
            survey.finger_unseen += usize::from(finger.is_none());
            survey.stopped_short += usize::from(finger.is_some() && finger != Some(fields[posture]));
            survey.touches += usize::from(touch);
            survey.touches_elsewhere += usize::from(touch && fields[posture] != put_at);
            let stands = stands_in(body);
            survey.displaced += usize::from(stands != Some(put_at));
            survey.misplaced += usize::from(object.is_some() && object != stands);
            kinds.insert((before, posture, object, finger, touch));
            before = object;
        }
        survey.places_displaced += usize::from(stands_in(body) != Some(put_at));
    }
    survey.kinds = kinds.len();
    survey
}

/// The field in which the block's top would be seen if nothing hid it.
fn stands_in(body: &SimBody) -> Option<i64> {
    let mut at = body.world().block(0)?.translation.vector;
    at.z += 0.6 * body.world().form(0).half_m();
    let workspace = body.workspace();
    let (u, v) = workspace.camera.project(&at.into())?;
    workspace.fields.field_at(u, v).map(|field| field as i64)
}
