//! A picture of the simulated camera after an action: rendered, and blobs found in it where it has changed.

use pschema_protocol::prelude::*;
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;

use crate::counted::{Tally, counted};
use crate::failure::CountFailure;

const ROUNDS: usize = 40;
const WORLD: &str = "wide";
const SEED: u64 = 1;
/// Actions, and places of blocks, are taken in an order without a pattern: each so many after the last.
const STRIDE: usize = 89;

pub(super) fn carry_out() -> Result<Tally, CountFailure> {
    let file = WorldFile::load(WORLD).map_err(CountFailure::of("picture"))?;
    let mut body = SimBody::new("arm", file, WORLD, SEED, false).map_err(CountFailure::of("picture"))?;
    let repertoire = body.describe().repertoire;
    put_blocks(&mut body)?;
    // The first picture is drawn whole, and no other.
    body.render();
    drop(body.look_at_picture());
    let mut tally = Tally::default();
    for round in 0..ROUNDS {
        let outcome = body.act(&repertoire[round * STRIDE % repertoire.len()]);
        if outcome != Outcome::Done {
            return Err(CountFailure::of("picture")(format!("an action ended as {outcome:?}")));
        }
        let seen = counted(&mut tally, || {
            body.render();
            body.look_at_picture()
        });
        tally.result = tally.result.wrapping_mul(31).wrapping_add(seen.objects.len() as u64);
    }
    Ok(tally)
}

/// Puts each block where there is room, so that there is something to look at.
fn put_blocks(body: &mut SimBody) -> Result<(), CountFailure> {
    let places = body.workspace().places.len();
    let mut next = 0;
    for block in 0..body.world().block_count() {
        let is_placed = (0..places).any(|_| {
            next = (next + STRIDE) % places;
            let position = i64::try_from(next).unwrap_or(0);
            let put = Action::new(body.ids().place, (Value::symbol(block), position));
            body.arrange(&put) == Outcome::Done
        });
        if !is_placed {
            return Err(CountFailure::of("picture")(format!("there is no room for block {block}")));
        }
    }
    Ok(())
}
