//! What contexts are worth on the way to a goal: the probability of arriving from each by the best moves, found by value iteration, and
//! the way that these make.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;

use crate::nouns::observation::Observation;
use crate::nouns::vocabulary::PrimitiveId;

/// The value that is left after an action: of two ways that lead there as surely the shorter one is taken, and one action less is
/// worth a thousandth of certainty.
pub(crate) const DISCOUNT: f64 = 0.999;
/// Values are known when none changes by more than this in a sweep over all.
pub(crate) const TOLERANCE: f64 = 1e-9;
/// Sweeps, at most.
const SWEEPS_MAX: usize = 1_000;
/// Moves that are weighed in one search.
const WEIGHED_MAX: usize = 1 << 24;
/// A context that the best way comes to more seldom than this, as expected, is not looked at.
pub(crate) const NEGLIGIBLE: f64 = 1e-2;

/// A context, with what can be done there as far as that was looked at.
pub(crate) struct Node {
    pub(crate) context: Box<[Observation]>,
    pub(crate) moves: Option<Box<[Move]>>,
    /// The probability of the surest way there, with what its actions take off.
    pub(crate) reached: f64,
    pub(crate) depth: u32,
    pub(crate) value: f64,
}

/// An action in a context that may change it or reach the goal.
pub(crate) struct Move {
    pub(crate) action: PrimitiveId,
    /// The probability that it reaches the goal.
    pub(crate) arrives: f64,
    /// That nothing changes.
    pub(crate) stays: f64,
    /// That something comes about that never did. The search takes it to change nothing, for what is learnt then makes another policy;
    /// but it counts as not arriving where the probability of a policy is told.
    pub(crate) unknown: f64,
    /// That it is otherwise than foretold, where it was never tried. That is hoped to be the best that another action may make here: so
    /// what was never tried is, before something is done that is known to lead there but badly.
    pub(crate) open: f64,
    /// Of each context that it may lead to.
    pub(crate) leads: Box<[(usize, f64)]>,
}

impl Move {
    /// The probability of arriving by it when it is repeated where nothing changes, by those of the contexts.
    /// A context that was not looked at counts as none that anything leads to.
    fn value(&self, nodes: &[Node], hope: f64) -> f64 {
        let (mut led, mut stays) = (0.0, self.stays + self.unknown);
        for (to, p) in &self.leads {
            match nodes[*to].moves {
                Some(_) => led += p * nodes[*to].value,
                None => stays += p,
            }
        }
        tried(stays) * (self.arrives + led + self.open * hope)
    }
}

/// The value of an action for what it does change, when it is repeated where nothing changes, with this probability.
pub(crate) fn tried(stays: f64) -> f64 {
    DISCOUNT / (1.0 - DISCOUNT * stays.min(1.0))
}

/// The contexts that were reached, and where they lead.
#[derive(Default)]
pub(crate) struct Graph {
    pub(crate) nodes: Vec<Node>,
    /// How many moves were weighed.
    weighed: usize,
}

impl Graph {
    /// The value of each context: the highest probability of arriving from there, with what each action takes off; 0
    /// where that was not looked at.
    pub(crate) fn values(&mut self) {
        for node in &mut self.nodes {
            node.value = 0.0;
        }
        let moves = self.nodes.iter().filter_map(|node| node.moves.as_ref()).map(|moves| moves.len());
        let moves: usize = moves.sum();
        for _ in 0..SWEEPS_MAX {
            let mut most: f64 = 0.0;
            self.weighed += moves;
            // From the goal backwards, as contexts were reached forwards.
            for at in (0..self.nodes.len()).rev() {
                let Some(value) = self.best(at).map(|(_, value)| value) else { continue };
                most = most.max(value - self.nodes[at].value);
                self.nodes[at].value = value;
            }
            if most < TOLERANCE || self.is_spent() {
                return;
            }
        }
    }

    /// Whether as many moves were weighed as may be; values are no higher than they would come to be.
    pub(crate) fn is_spent(&self) -> bool {
        self.weighed >= WEIGHED_MAX
    }

    /// What is hoped for where something was never tried: the best that any action may make there, and its value.
    fn hope(&self, at: usize) -> Option<(Option<usize>, f64)> {
        let moves = || self.nodes[at].moves.iter().flatten();
        if moves().all(|one| one.open == 0.0) {
            return None;
        }
        let arrives = moves().filter(|one| one.arrives > 0.0).map(|_| (None, 1.0));
        let leads = moves().flat_map(|one| one.leads.iter());
        let leads = leads.map(|(to, _)| (Some(*to), self.nodes[*to].value));
        arrives.chain(leads).fold(None, |best, one| match best {
            Some((_, most)) if one.1 <= most => best,
            _ => Some(one),
        })
    }

    /// Where a move leads, each with the probability; none is the goal. What is hoped for counts.
    fn leads(&self, at: usize, best: &Move) -> Vec<(Option<usize>, f64)> {
        let goal = (best.arrives > 0.0).then_some((None, best.arrives));
        let mut leads: Vec<_> = best.leads.iter().map(|(to, p)| (Some(*to), *p)).chain(goal).collect();
        if let Some((hope, _)) = self.hope(at).filter(|(_, value)| best.open > 0.0 && *value > 0.0) {
            match leads.iter_mut().find(|(to, _)| *to == hope) {
                Some((_, p)) => *p += best.open,
                None => leads.push((hope, best.open)),
            }
        }
        leads
    }

    /// The best move in a context with its value; of equals the first.
    fn best(&self, at: usize) -> Option<(&Move, f64)> {
        let moves = self.nodes[at].moves.iter().flatten();
        let hope = self.hope(at).map_or(0.0, |(_, value)| value);
        moves.map(|one| (one, one.value(&self.nodes, hope))).fold(None, |best, one| match best {
            Some((_, most)) if one.1 <= most => best,
            _ => Some(one),
        })
    }

    /// The contexts that the best way may come to, that in which it begins first and those that follow it in turn; each with its best
    /// move, if it was looked at.
    pub(crate) fn way(&self) -> Vec<Stop<'_>> {
        let mut way: Vec<Stop<'_>> = Vec::new();
        let mut known = FxHashMap::from_iter([(0, 0)]);
        let mut next = VecDeque::from([0]);
        while let Some(at) = next.pop_front() {
            let best = self.best(at).filter(|(_, value)| *value > 0.0).map(|(best, _)| best);
            let mut leads = Vec::new();
            for (to, p) in best.map_or_else(Vec::new, |best| self.leads(at, best)) {
                let to = to.map(|to| {
                    let number = known.len();
                    *known.entry(to).or_insert_with(|| {
                        next.push_back(to);
                        number
                    })
                });
                leads.push((to, p));
            }
            way.push(Stop { at, best, leads });
        }
        way
    }

    /// The contexts that the best way often comes to and that were not looked at.
    pub(crate) fn open(&self) -> Vec<usize> {
        let way = self.way();
        let is_open = |stop: &Stop<'_>| self.nodes[stop.at].moves.is_none();
        if !way.iter().any(is_open) {
            return Vec::new();
        }
        let visits = visits(&way).into_iter();
        let open = way.iter().zip(visits).filter(|(stop, visits)| is_open(stop) && *visits >= NEGLIGIBLE);
        open.map(|(stop, _)| stop.at).collect()
    }
}

/// A context on a way.
pub(crate) struct Stop<'a> {
    /// Its number among those that were reached.
    pub(crate) at: usize,
    /// The best move there; none where that was not looked at, or nothing leads on.
    pub(crate) best: Option<&'a Move>,
    /// What the move leads to, by the place on the way; none is the goal.
    pub(crate) leads: Vec<(Option<usize>, f64)>,
}

impl Stop<'_> {
    /// How often an action changes anything.
    fn changes(&self) -> f64 {
        (1.0 - self.best.map_or(0.0, |best| best.stays)).max(TOLERANCE)
    }
}

/// How often each context of a way is come to, as expected.
pub(crate) fn visits(way: &[Stop<'_>]) -> Vec<f64> {
    let mut into: Vec<Vec<(usize, f64)>> = vec![Vec::new(); way.len()];
    for (from, stop) in way.iter().enumerate() {
        for (to, p) in &stop.leads {
            to.iter().for_each(|to| into[*to].push((from, p / stop.changes())));
        }
    }
    let mut visits = vec![0.0_f64; way.len()];
    for _ in 0..SWEEPS_MAX {
        let mut most: f64 = 0.0;
        for stop in 0..way.len() {
            let come: f64 = into[stop].iter().map(|(from, p)| visits[*from] * p).sum();
            let come = come + f64::from(u8::from(stop == 0));
            most = most.max(come - visits[stop]);
            visits[stop] = come;
        }
        if most < NEGLIGIBLE {
            break;
        }
    }
    visits
}

/// The probability of arriving from each context of a way, and the number of actions that it takes from the first where it arrives.
pub(crate) fn arrivals(way: &[Stop<'_>]) -> (Vec<f64>, f64) {
    let (mut arrive, mut actions) = (vec![0.0_f64; way.len()], vec![0.0_f64; way.len()]);
    for _ in 0..SWEEPS_MAX {
        let mut most: f64 = 0.0;
        for (at, stop) in way.iter().enumerate().rev() {
            let led = |values: &[f64], goal: f64| -> f64 {
                stop.leads.iter().map(|(to, p)| p * to.map_or(goal, |to| values[to])).sum()
            };
            let likely = led(&arrive, 1.0) / stop.changes();
            let taken = (likely + led(&actions, 0.0)) / stop.changes();
            most = most.max(likely - arrive[at]).max(taken - actions[at]);
            (arrive[at], actions[at]) = (likely, taken);
        }
        if most < TOLERANCE {
            break;
        }
    }
    let first = arrive.first().copied().unwrap_or(0.0);
    let actions = actions.first().copied().unwrap_or(0.0);
    let actions = if first > 0.0 { (actions / first).min(f64::from(u32::MAX)) } else { 0.0 };
    (arrive, actions)
}
