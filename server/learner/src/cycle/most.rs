//! Policies for most of a value: what to do in each context, by what claims foretell, so that as much as can be of a number comes. All
//! contexts are reached that actions are foretold to lead to, the surest first; then the worth of each is what comes with the best action
//! there and the worth of what follows, which counts a little less (value iteration). There is nowhere to arrive at, and an action that
//! changes nothing may be the best.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, VecDeque};

use rustc_hash::FxHashMap;

use crate::cycle::claims;
use crate::cycle::policy::{self, PolicySearch, depends_on, kept_of};
use crate::memory::evidence::{Foresight, Outlook, Prospect};
use crate::memory::{Content, Memory};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::policy::{Lead, Policy, PolicyRow, Yield, of_kinds};
use crate::nouns::pursuit::Goal;
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// What comes one action later counts so much: what is a hundred actions away still counts for a third.
pub(crate) const DISCOUNT: f64 = 0.99;
/// Contexts that are reached in one search.
const CONTEXTS_MAX: usize = 8_192;
/// How much is looked at in one search: for each action in each context one more than there are observations.
const LOOKS_MAX: usize = 65_536;
/// Moves that are weighed in one search.
const WEIGHED_MAX: usize = 1 << 24;
/// Worths are known when none changes by more than this, as a share of the greatest number that came.
const TOLERANCE: f64 = 1e-9;
/// How often the worths by what is done now are gone through before it is asked again what is best to do.
const SWEEPS: usize = 16;
/// A policy is made anew after so many actions, though all came about as expected: by then more is known, and what seldom comes may come
/// more seldom still.
const ANEW: f64 = 32.0;
/// A context that the best way comes to more seldom than this, as expected, is not kept.
const NEGLIGIBLE: f64 = 1e-2;

/// An action in a context.
struct Move {
    action: PrimitiveId,
    /// What comes with it, as expected.
    brings: f64,
    /// What comes with it most likely, where it leads to most likely.
    likely: f64,
    /// Of each context that it may lead to, the same one included, the most probable first. They may add up to less than 1: what was never
    /// tried may lead anywhere, and an episode may have ended; neither is hoped to bring anything.
    leads: Box<[(usize, f64)]>,
}

/// A context, with what can be done there if that was looked at.
struct Node {
    context: Box<[Observation]>,
    moves: Box<[Move]>,
    /// The probability of the surest way there, with what its actions take off.
    reached: f64,
    /// Whether it was looked at.
    is_known: bool,
    worth: f64,
    /// Which of its moves is the best.
    best: usize,
}

struct Search<'a> {
    content: &'a Content,
    body: BodyId,
    value: TypeId,
    foresight: &'a mut Foresight,
    /// The types on which it depends.
    kinds: BTreeSet<TypeId>,
    /// Those of them that are left to chance.
    chance: BTreeSet<TypeId>,
    repertoire: &'a [PrimitiveId],
    nodes: Vec<Node>,
    known: FxHashMap<Box<[Observation]>, usize>,
    waiting: BinaryHeap<(u64, Reverse<usize>)>,
    /// The greatest number that came of anything, without its sign.
    scale: f64,
    truncated: bool,
}

/// Looks for the policy for a goal from `world`: that which brings it about, or that which brings most of a value.
pub(crate) fn policy_for(
    memory: &Memory,
    body: BodyId,
    world: &WorldState,
    goal: &Goal,
    foresight: &mut Foresight,
) -> PolicySearch {
    match goal.most() {
        Some(value) => search(memory, body, world, value, foresight),
        None => policy::search(memory, body, world, goal, foresight),
    }
}

/// Looks for the policy that brings most of `value` from `world`; none if nothing known brings any.
fn search(
    memory: &Memory,
    body: BodyId,
    world: &WorldState,
    value: TypeId,
    foresight: &mut Foresight,
) -> PolicySearch {
    let content = memory.content();
    let repertoire = content.vocabulary.bodies().get(usize::from(body.0));
    let repertoire = repertoire.map_or(&[][..], |body| &body.repertoire);
    let wanted = BTreeSet::from([value]);
    // Nothing comes after the end of an episode, so that it matters where that is.
    let of_ends = content.evidence.ends_depend_on();
    let of_ends = of_ends.unwrap_or_else(|| content.vocabulary.sensed_types().collect());
    let kinds = depends_on(content, repertoire, &wanted.union(&of_ends).copied().collect());
    foresight.begin((body, repertoire), &kinds, &wanted);
    let mut search = Search {
        content,
        body,
        value,
        foresight,
        kinds,
        chance: BTreeSet::new(),
        repertoire,
        nodes: Vec::new(),
        known: FxHashMap::default(),
        waiting: BinaryHeap::new(),
        scale: 0.0,
        truncated: false,
    };
    let start = search.told(&claims::context(content, world));
    search.offer(start, 1.0);
    search.explore();
    if search.scale == 0.0 {
        return PolicySearch { policy: None, truncated: search.truncated };
    }
    search.weigh();
    PolicySearch { policy: Some(search.policy()), truncated: search.truncated }
}

impl Search<'_> {
    /// The part of a context that tells it from others.
    fn told(&self, context: &WorldState) -> Box<[Observation]> {
        context.observations().iter().filter(|o| self.kinds.contains(&o.kind())).cloned().collect()
    }

    /// Takes a way to a context into account, and returns the number of the context; none where there is no more room.
    fn offer(&mut self, context: Box<[Observation]>, reached: f64) -> Option<usize> {
        let at = match self.known.get(&context) {
            Some(at) => *at,
            None if self.nodes.len() == CONTEXTS_MAX => {
                self.truncated = true;
                return None;
            }
            None => {
                self.known.insert(context.clone(), self.nodes.len());
                let moves = Box::default();
                self.nodes.push(Node { context, moves, reached: 0.0, is_known: false, worth: 0.0, best: 0 });
                self.nodes.len() - 1
            }
        };
        let node = &mut self.nodes[at];
        if !node.is_known && reached > node.reached {
            node.reached = reached;
            self.waiting.push((reached.to_bits(), Reverse(at)));
        }
        Some(at)
    }

    /// Reaches contexts, the surest first, until there are no others or as much was looked at as may be.
    fn explore(&mut self) {
        let mut looks = 0;
        while let Some((_, Reverse(at))) = self.waiting.pop() {
            if self.nodes[at].is_known {
                continue;
            }
            looks += self.repertoire.len() * (1 + self.nodes[at].context.len());
            if looks > LOOKS_MAX {
                self.truncated = true;
                return;
            }
            self.expand(at);
        }
    }

    /// Looks at all that can be done in a context.
    fn expand(&mut self, at: usize) {
        let context = self.nodes[at].context.clone();
        let Content { evidence, vocabulary, .. } = self.content;
        let Outlook { prospects, ending, chance } =
            self.foresight.outlook(evidence, vocabulary, (self.body, self.repertoire), &context);
        self.chance.extend(chance);
        self.nodes[at].is_known = true;
        let goes_on = (1.0 - ending.probability).max(0.0);
        let moves = self.repertoire.iter().zip(prospects);
        let moves: Vec<_> =
            moves.map(|(action, prospect)| self.look(at, *action, &prospect, goes_on)).collect();
        self.nodes[at].moves = moves.into();
    }

    /// An action in a context, with what is foretold of it, if the episode has not ended there. Where nobody knows what comes, nothing comes
    /// and nothing changes.
    fn look(&mut self, at: usize, action: PrimitiveId, prospect: &Prospect, goes_on: f64) -> Move {
        let (context, reached) = (self.nodes[at].context.clone(), self.nodes[at].reached);
        let reliability = self.content.reliability(action);
        let mut ways: Vec<(Box<[Observation]>, f64, f64)> = Vec::new();
        let mut told = 0.0;
        for (after, likely) in &prospect.outcomes {
            let likely = likely * reliability;
            told += likely;
            let brings = self.content.vocabulary.sum_of(self.value, after);
            self.scale = self.scale.max(brings.abs());
            let after = WorldState::new(after.iter().cloned());
            let next = self.told(&claims::context_after(self.content, &context, action, &after));
            match ways.iter_mut().find(|(known, more, _)| *known == next && *more == brings) {
                Some((.., known)) => *known += likely,
                None => ways.push((next, brings, likely)),
            }
        }
        let unknown = (1.0 - told - prospect.open * reliability).max(0.0);
        let brings: f64 = ways.iter().map(|(_, brings, likely)| brings * likely).sum();
        let mut leads: Vec<(Box<[Observation]>, f64)> = Vec::new();
        for (next, likely) in
            ways.iter().map(|(next, _, likely)| (next, *likely)).chain([(&context, unknown)])
        {
            match leads.iter_mut().find(|(known, _)| known == next) {
                Some((_, known)) => *known += likely,
                None => leads.push((next.clone(), likely)),
            }
        }
        leads.retain(|(_, likely)| *likely > 0.0);
        leads.sort_by(|a, b| b.1.total_cmp(&a.1));
        let first = leads.first().map(|(next, _)| next.clone());
        let to_first = ways.iter().filter(|(next, ..)| Some(next) == first.as_ref());
        let likely = to_first.fold(None, |best: Option<(f64, f64)>, (_, brings, likely)| match best {
            Some((_, most)) if *likely <= most => best,
            _ => Some((*brings, *likely)),
        });
        let leads = leads.into_iter().filter_map(|(next, likely)| {
            let likely = likely * goes_on;
            Some((self.offer(next, reached * likely * DISCOUNT)?, likely))
        });
        let leads = leads.collect();
        let likely = likely.map_or(0.0, |(brings, _)| brings);
        Move { action, brings: brings * goes_on, likely, leads }
    }

    /// What a move is worth.
    fn worth(&self, one: &Move) -> f64 {
        let led: f64 = one.leads.iter().map(|(to, p)| p * self.nodes[*to].worth).sum();
        one.brings + DISCOUNT * led
    }

    /// The best move in a context, with its worth; of equals the first.
    fn best(&self, at: usize) -> Option<(usize, f64)> {
        let margin = TOLERANCE * self.scale;
        let moves = self.nodes[at].moves.iter().enumerate().map(|(number, one)| (number, self.worth(one)));
        moves.fold(None, |best, one| match best {
            Some((_, most)) if one.1 <= most + margin => best,
            _ => Some(one),
        })
    }

    /// Finds the worth of each context, and what is best to do there; the worth of what was not looked at is 0.
    fn weigh(&mut self) {
        let (mut weighed, mut most) = (0, f64::INFINITY);
        let moves: usize = self.nodes.iter().map(|node| node.moves.len()).sum();
        while most > TOLERANCE * self.scale {
            if weighed >= WEIGHED_MAX {
                self.truncated = true;
                return;
            }
            weighed += moves + SWEEPS * self.nodes.len();
            most = 0.0;
            for at in (0..self.nodes.len()).rev() {
                let Some((best, worth)) = self.best(at) else { continue };
                most = most.max((worth - self.nodes[at].worth).abs());
                (self.nodes[at].best, self.nodes[at].worth) = (best, worth);
            }
            for _ in 0..SWEEPS {
                for at in (0..self.nodes.len()).rev() {
                    let node = &self.nodes[at];
                    let Some(worth) = node.moves.get(node.best).map(|one| self.worth(one)) else { continue };
                    self.nodes[at].worth = worth;
                }
            }
        }
    }

    /// The contexts that the best way comes to, that in which it begins first, each with how often, as expected; what comes later
    /// counts less.
    fn way(&self) -> Vec<(usize, f64)> {
        let (mut way, mut places) = (vec![0], FxHashMap::from_iter([(0, 0)]));
        let mut next = VecDeque::from([0]);
        while let Some(at) = next.pop_front() {
            for (to, _) in self.leads(at) {
                places.entry(*to).or_insert_with(|| {
                    next.push_back(*to);
                    way.push(*to);
                    way.len() - 1
                });
            }
        }
        let (mut visits, mut come) = (vec![0.0; way.len()], vec![0.0; way.len()]);
        come[0] = 1.0;
        while come.iter().sum::<f64>() > NEGLIGIBLE {
            let mut then = vec![0.0; way.len()];
            for (place, at) in way.iter().enumerate() {
                visits[place] += come[place];
                for (to, p) in self.leads(*at) {
                    then[places[to]] += DISCOUNT * p * come[place];
                }
            }
            come = then;
        }
        way.into_iter().zip(visits).collect()
    }

    /// Where the best move in a context leads.
    fn leads(&self, at: usize) -> &[(usize, f64)] {
        let node = &self.nodes[at];
        node.moves.get(node.best).map_or(&[], |one| &one.leads)
    }

    /// The best way as a policy.
    fn policy(&self) -> Policy {
        let way = self.way();
        let kinds: Vec<_> = self.kinds.difference(&self.chance).copied().collect();
        let chance: Vec<_> = self.chance.iter().copied().collect();
        let contexts: Vec<_> = way.iter().map(|(at, _)| of_kinds(&self.nodes[*at].context, &kinds)).collect();
        let visits: Vec<_> = way.iter().map(|(_, visits)| *visits).collect();
        let may = |stop: usize| self.nodes[way[stop].0].is_known && visits[stop] >= NEGLIGIBLE;
        let kept = kept_of(self.content, &contexts, &visits, may);
        let places: FxHashMap<usize, u32> = kept.iter().map(|stop| way[*stop].0).zip(0..).collect();
        let best = |stop: &usize| {
            let node = &self.nodes[way[*stop].0];
            Some((node, node.moves.get(node.best)?))
        };
        let row = |stop: &usize| {
            let (_, best) = best(stop)?;
            let lead =
                |(to, p): &(usize, f64)| Some(Lead { to: Some(*places.get(to)?), probability: p.min(1.0) });
            let leads = best.leads.iter().filter_map(lead).collect();
            Some(PolicyRow { context: contexts[*stop].clone(), action: best.action, probability: 0.0, leads })
        };
        let yields = kept.iter().filter_map(best);
        let yields = yields.map(|(node, best)| Yield { worth: node.worth, brings: best.likely }).collect();
        let rows = kept.iter().filter_map(row).collect();
        let circumstances = of_kinds(&self.nodes[0].context, &chance);
        Policy { kinds, chance, circumstances, rows, yields, actions: ANEW, after_actions: 0 }
    }
}
