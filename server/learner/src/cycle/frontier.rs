//! The frontier: what may be learnt in contexts that are not here and can be reached by what claims foretell. Something new to do draws
//! the learner there, by as much as curiosity would if it were there, times the probability of the way, over its length: equation 1's own
//! d. So it does not wait until chance leads it on.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use rustc_hash::FxHashSet;

use crate::cycle::claims;
use crate::cycle::curiosity::Curiosity;
use crate::memory::Memory;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// How much is looked at in one search: for each action in each context one more than there are observations.
const LOOKS_MAX: usize = 4_096;
/// A context that is reached less surely than this is not looked at.
const LIKELY: f64 = 0.05;

/// What may be learnt elsewhere, and how to get there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frontier {
    /// The first action of the way.
    pub(crate) first: PrimitiveId,
    /// The contexts that follow on the way, each with what is done there; the new primitive is the last.
    pub(crate) way: Vec<(WorldState, PrimitiveId)>,
    /// The primitive that is new there.
    pub(crate) new: PrimitiveId,
    /// The actions until then, as many as are expected, the new one included.
    pub(crate) distance: u32,
    /// How much may be learnt there, from 0 to 1, times the probability of getting there.
    pub(crate) weight: f64,
}

impl Frontier {
    /// How much it draws.
    pub(crate) fn pull(&self) -> f64 {
        self.weight / f64::from(self.distance)
    }
}

/// A context that can be reached.
struct Node {
    context: Box<[Observation]>,
    /// The actions to it, as many as are expected.
    far: f64,
    /// The probability of coming there.
    likely: f64,
    /// The node from which it is reached, and by which action; none of where the search begins.
    from: Option<(usize, PrimitiveId)>,
}

/// Looks for what draws more than `least`, in weight over distance. None if there is nothing in reach that does.
pub(crate) fn search(
    memory: &Memory,
    body: BodyId,
    world: &WorldState,
    curiosity: &Curiosity,
    least: f64,
) -> Option<Frontier> {
    let content = memory.content();
    let vocabulary = &content.vocabulary;
    let repertoire = vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |body| &body.repertoire);
    let most = curiosity.most()?;
    let kinds: BTreeSet<_> =
        (0..u16::try_from(vocabulary.types().len()).unwrap_or(u16::MAX)).map(TypeId).collect();
    let none = BTreeSet::new();
    let start: Box<[_]> = claims::context(content, world).observations().into();
    let mut known: FxHashSet<Box<[Observation]>> = FxHashSet::from_iter([start.clone()]);
    let mut nodes = vec![Node { context: start, far: 0.0, likely: 1.0, from: None }];
    let mut waiting = BinaryHeap::from([(1.0_f64.to_bits(), Reverse(0))]);
    let mut best: Option<(f64, usize, PrimitiveId, f64)> = None;
    let mut looks = 0;
    while let Some((_, Reverse(at))) = waiting.pop() {
        let Node { ref context, far, likely, .. } = nodes[at];
        let context = context.clone();
        if most * likely / (far + 1.0) <= best.map_or(least, |(pull, ..)| pull) {
            break;
        }
        looks += repertoire.len() * (1 + context.len());
        if looks > LOOKS_MAX {
            break;
        }
        let outlook = content.evidence.outlook(vocabulary, (body, repertoire), &context, &kinds, &none);
        for (new, prospect) in repertoire.iter().zip(&outlook.prospects) {
            let weight = content.reliability(*new) * prospect.learnable * likely;
            let pull = weight / (far.round() + 1.0);
            if pull > best.map_or(least, |(most, ..)| most) {
                best = Some((pull, at, *new, weight));
            }
        }
        for (action, prospect) in repertoire.iter().zip(outlook.prospects) {
            let reliability = content.reliability(*action);
            let (mut stays, mut leads) = (1.0 - reliability, Vec::new());
            for (after, share) in prospect.outcomes {
                let after = WorldState::new(after);
                let on = content.items.all.iter().map(|item| {
                    let on = context.binary_search(&item.observation(true)).is_ok();
                    item.follow(on, *action, after.observations())
                });
                let next = claims::context(content, &content.items.with(on, &after));
                match next.observations() == &*context {
                    true => stays += share * reliability,
                    false => leads.push((next, share * reliability)),
                }
            }
            let tries = 1.0 / (1.0 - stays).max(LIKELY);
            for (next, share) in leads {
                let (far, likely) = (far + tries, likely * share * tries);
                if likely < LIKELY || !known.insert(next.observations().into()) {
                    continue;
                }
                waiting.push(((likely / (far + 1.0)).to_bits(), Reverse(nodes.len())));
                nodes.push(Node {
                    context: next.observations().into(),
                    far,
                    likely,
                    from: Some((at, *action)),
                });
            }
        }
    }
    let (_, mut at, new, weight) = best?;
    let distance = nodes[at].far.round() as u32 + 1;
    let (mut way, mut first) = (Vec::new(), new);
    while let Some((before, action)) = nodes[at].from {
        way.push((WorldState::new(nodes[at].context.iter().cloned()), first));
        (at, first) = (before, action);
    }
    way.reverse();
    Some(Frontier { first, way, new, distance, weight })
}
