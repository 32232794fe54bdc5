//! The frontier: what may be learnt in contexts that are not here and can be reached by what claims foretell. Something new to do draws
//! the learner there, by as much as curiosity would if it were there, times the probability of the way, over its length: equation 1's own
//! d. So it does not wait until chance leads it on.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use rustc_hash::FxHashSet;

use crate::cycle::claims;
use crate::cycle::curiosity::Curiosity;
use crate::memory::Memory;
use crate::nouns::observation::TypeId;
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

/// A context that can be reached.
struct Node {
    context: WorldState,
    /// The actions to it, as many as are expected.
    far: f64,
    /// The probability of coming there.
    likely: f64,
    /// The node from which it is reached, and by which action; none of where the search begins.
    from: Option<(usize, PrimitiveId)>,
}

impl Node {
    /// The actions until something was done there, in whole numbers as a decision tells them.
    fn distance(&self) -> u32 {
        self.far.round() as u32 + 1
    }

    /// How much draws there that would draw so much here.
    fn pull(&self, here: f64) -> f64 {
        here * self.likely / f64::from(self.distance())
    }
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
    let start = claims::context(content, world);
    let mut known = FxHashSet::from_iter([start.clone()]);
    let mut nodes = vec![Node { context: start, far: 0.0, likely: 1.0, from: None }];
    let mut waiting = BinaryHeap::from([(nodes[0].pull(1.0).to_bits(), Reverse(0))]);
    let mut best: Option<(f64, usize, PrimitiveId, f64)> = None;
    let mut looks = 0;
    while let Some((_, Reverse(at))) = waiting.pop() {
        if nodes[at].pull(most) <= best.map_or(least, |(pull, ..)| pull) {
            break;
        }
        let Node { ref context, far, likely, .. } = nodes[at];
        let context = context.clone();
        looks += repertoire.len() * (1 + context.observations().len());
        if looks > LOOKS_MAX {
            break;
        }
        let about = context.observations();
        let outlook = content.evidence.outlook(vocabulary, (body, repertoire), about, &kinds, &none);
        for (new, prospect) in repertoire.iter().zip(&outlook.prospects) {
            let here = content.reliability(*new) * prospect.learnable;
            let pull = nodes[at].pull(here);
            if pull > best.map_or(least, |(most, ..)| most) {
                best = Some((pull, at, *new, here * likely));
            }
        }
        for (action, prospect) in repertoire.iter().zip(outlook.prospects) {
            let reliability = content.reliability(*action);
            let (mut stays, mut leads) = (1.0 - reliability, Vec::new());
            for (after, share) in prospect.outcomes {
                let next = claims::context_after(content, about, *action, &WorldState::new(after));
                match next == context {
                    true => stays += share * reliability,
                    false => leads.push((next, share * reliability)),
                }
            }
            let tries = 1.0 / (1.0 - stays).max(LIKELY);
            for (next, share) in leads {
                let (far, likely) = (far + tries, likely * share * tries);
                if likely < LIKELY || !known.insert(next.clone()) {
                    continue;
                }
                let node = Node { context: next, far, likely, from: Some((at, *action)) };
                waiting.push((node.pull(1.0).to_bits(), Reverse(nodes.len())));
                nodes.push(node);
            }
        }
    }
    let (_, mut at, new, weight) = best?;
    let distance = nodes[at].distance();
    let (mut way, mut first) = (Vec::new(), new);
    while let Some((before, action)) = nodes[at].from {
        way.push((nodes[at].context.clone(), first));
        (at, first) = (before, action);
    }
    way.reverse();
    Some(Frontier { first, way, new, distance, weight })
}
