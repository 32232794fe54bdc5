//! Where blocks are: on the table, in the hand, or on each other.

use fastrand::Rng;

/// Where a block is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Place {
    Table,
    Hand,
    On(usize),
}

/// Whether nothing stands on `block`, and it is not in the hand.
pub(crate) fn is_clear(places: &[Place], block: usize) -> bool {
    places.get(block).is_some_and(|place| *place != Place::Hand) && !places.contains(&Place::On(block))
}

/// So many blocks in random order: the first in the hand with probability .5, each other one on the table or on top of a tower, all choices
/// alike.
pub(crate) fn scattered(blocks: usize, random: &mut Rng) -> Vec<Place> {
    let mut order: Vec<_> = (0..blocks).collect();
    random.shuffle(&mut order);
    let (mut places, mut tops) = (vec![Place::Table; blocks], Vec::new());
    for (at, block) in order.into_iter().enumerate() {
        if at == 0 && random.bool() {
            places[block] = Place::Hand;
            continue;
        }
        match random.usize(..=tops.len()) {
            choice if choice == tops.len() => tops.push(block),
            choice => places[block] = Place::On(std::mem::replace(&mut tops[choice], block)),
        }
    }
    places
}
