//! Policies: what to do in each context on the way to a goal, by what claims foretell. Contexts are reached in the order of how
//! surely, until none that waits could lead there more surely than what is known; then the value of each is the probability to arrive
//! from there with a little taken off for each action (value iteration), so that retries and dead ends are weighed. What the
//! best way may lead to and was not looked at yet is looked at then, and so on until nothing is left open.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, VecDeque};

use rustc_hash::FxHashMap;

use crate::cycle::claims;
use crate::cycle::goals::holds;
use crate::memory::evidence::{Outlook, Prospect};
use crate::memory::{Content, Memory};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::policy::{Lead, POLICY_ROWS_MAX, Policy, PolicyRow, of_kinds};
use crate::nouns::pursuit::Goal;
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// Contexts that are reached in one search.
const CONTEXTS_MAX: usize = 16_384;
/// Actions that are looked at in one search, each in one context.
const OUTLOOKS_MAX: usize = 65_536;
/// The value that is left after an action: of two ways that lead there as surely the shorter one is taken, and one action less is
/// worth a thousandth of certainty.
const DISCOUNT: f64 = 0.999;
/// Values are known when none changes by more than this in a sweep over all.
const TOLERANCE: f64 = 1e-9;
/// Sweeps, at most.
const SWEEPS_MAX: usize = 1_000;
/// A context that the best way comes to more seldom than this, as expected, is not looked at.
const NEGLIGIBLE: f64 = 1e-2;

/// The result of a search for a policy.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PolicySearch {
    /// The best policy; none if nothing known leads to the goal.
    pub(crate) policy: Option<Policy>,
    /// Whether the search used up its budget, so that there may be more.
    pub(crate) truncated: bool,
}

/// A context, with what can be done there as far as that was looked at.
struct Node {
    context: Box<[Observation]>,
    moves: Option<Box<[Move]>>,
    /// The probability of the surest way there, with what its actions take off.
    reached: f64,
    depth: u32,
    value: f64,
}

/// An action in a context that may change it or reach the goal.
struct Move {
    action: PrimitiveId,
    /// The probability that it reaches the goal.
    arrives: f64,
    /// That nothing changes.
    stays: f64,
    /// That something comes about that never did. The search takes it to change nothing, for what is learnt then makes another policy;
    /// but it counts as not arriving where the probability of a policy is told.
    unknown: f64,
    /// That it is otherwise than foretold, where it was never tried. That is hoped to be the best that another action may make here: so
    /// what was never tried is, before something is done that is known to lead there but badly.
    open: f64,
    /// Of each context that it may lead to.
    leads: Box<[(usize, f64)]>,
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
fn tried(stays: f64) -> f64 {
    DISCOUNT / (1.0 - DISCOUNT * stays.min(1.0))
}

struct Search<'a> {
    content: &'a Content,
    body: BodyId,
    goal: &'a Goal,
    /// The types that the goal speaks of.
    wanted: BTreeSet<TypeId>,
    /// The types on which it depends.
    kinds: BTreeSet<TypeId>,
    /// Those of them that are left to chance.
    chance: BTreeSet<TypeId>,
    repertoire: &'a [PrimitiveId],
    /// The highest probability with which one action reaches the goal.
    surest: f64,
    nodes: Vec<Node>,
    known: FxHashMap<Box<[Observation]>, usize>,
    waiting: BinaryHeap<(u64, Reverse<u32>, Reverse<usize>)>,
    /// The value of the surest way to the goal that was found.
    arrives: f64,
    outlooks: usize,
    truncated: bool,
}

/// Looks for a policy that brings `goal`, which does not hold, about from `world`.
pub(crate) fn search(memory: &Memory, body: BodyId, world: &WorldState, goal: &Goal) -> PolicySearch {
    let content = memory.content();
    let vocabulary = &content.vocabulary;
    let repertoire = vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |body| &body.repertoire);
    let wanted: BTreeSet<_> = goal.iter().map(|pattern| pattern.kind()).collect();
    let surest = content.evidence.surest(vocabulary, repertoire, &wanted);
    let kinds = depends_on(content, repertoire, wanted.clone());
    let mut search = Search {
        content,
        body,
        goal,
        wanted,
        kinds,
        chance: BTreeSet::new(),
        repertoire,
        surest,
        nodes: Vec::new(),
        known: FxHashMap::default(),
        waiting: BinaryHeap::new(),
        arrives: 0.0,
        outlooks: 0,
        truncated: false,
    };
    let start = search.told(&claims::context(content, world));
    search.offer(start, 1.0, 0);
    search.explore();
    search.settle();
    let policy = (search.nodes[0].value > 0.0).then(|| search.policy());
    PolicySearch { policy, truncated: search.truncated }
}

/// The types on which it depends whether a goal about these types is reached.
fn depends_on(
    content: &Content,
    repertoire: &[PrimitiveId],
    mut kinds: BTreeSet<TypeId>,
) -> BTreeSet<TypeId> {
    loop {
        let before = kinds.clone();
        let Some(found) = content.evidence.depends_on(&content.vocabulary, repertoire, kinds) else {
            let all = 0..u16::try_from(content.vocabulary.types().len()).unwrap_or(u16::MAX);
            return all.map(TypeId).collect();
        };
        kinds = found;
        for item in content.items.all.iter().filter(|item| before.contains(&item.kind)) {
            kinds.extend(item.kinds.iter().copied());
        }
        if kinds == before {
            return kinds;
        }
    }
}

impl Search<'_> {
    /// The part of a context that tells it from others.
    fn told(&self, context: &WorldState) -> Box<[Observation]> {
        context.observations().iter().filter(|o| self.kinds.contains(&o.kind())).cloned().collect()
    }

    /// Takes a way to a context into account, and returns the number of the context; none where there is no more room.
    fn offer(&mut self, context: Box<[Observation]>, reached: f64, depth: u32) -> Option<usize> {
        let at = match self.known.get(&context) {
            Some(at) => *at,
            None if self.nodes.len() == CONTEXTS_MAX => {
                self.truncated = true;
                return None;
            }
            None => {
                self.known.insert(context.clone(), self.nodes.len());
                self.nodes.push(Node { context, moves: None, reached: 0.0, depth, value: 0.0 });
                self.nodes.len() - 1
            }
        };
        let node = &mut self.nodes[at];
        if node.moves.is_none() && reached > node.reached {
            (node.reached, node.depth) = (reached, depth);
            self.waiting.push((reached.to_bits(), Reverse(depth), Reverse(at)));
        }
        Some(at)
    }

    /// Reaches contexts, the surest first, until no other may lead to the goal more surely than a way that was found.
    fn explore(&mut self) {
        while let Some((reached, _, Reverse(at))) = self.waiting.pop() {
            let reached = f64::from_bits(reached);
            if self.nodes[at].moves.is_some() || reached < self.nodes[at].reached {
                continue;
            }
            if reached * DISCOUNT * self.surest <= self.arrives {
                return;
            }
            if !self.expand(at) {
                return;
            }
        }
    }

    /// Looks at all that can be done in a context; not if that is more than the search may still look at.
    fn expand(&mut self, at: usize) -> bool {
        if self.outlooks + self.repertoire.len() > OUTLOOKS_MAX {
            self.truncated = true;
            return false;
        }
        self.outlooks += self.repertoire.len();
        let context = self.nodes[at].context.clone();
        let evidence = &self.content.evidence;
        let bodys = (self.body, self.repertoire);
        let Outlook { prospects, chance } =
            evidence.outlook(&self.content.vocabulary, bodys, &context, &self.kinds, &self.wanted);
        self.chance.extend(chance);
        let moves = self.repertoire.iter().zip(prospects);
        let moves = moves.filter_map(|(action, prospect)| self.look(at, *action, prospect));
        let moves: Vec<_> = moves.collect();
        self.nodes[at].moves = Some(moves.into());
        true
    }

    /// An action in a context, with what is foretold of it; none if it neither changes anything nor reaches the goal.
    fn look(&mut self, at: usize, action: PrimitiveId, prospect: Prospect) -> Option<Move> {
        let Prospect { outcomes: foretold, open } = prospect;
        let Node { reached, depth, ref context, .. } = self.nodes[at];
        let context = context.clone();
        let reliability = self.content.reliability(action);
        let (mut arrives, mut stays, open) = (0.0, 1.0 - reliability, open * reliability);
        let mut outcomes: Vec<(Box<[Observation]>, f64)> = Vec::new();
        for (after, likely) in foretold {
            let likely = likely * reliability;
            let after = WorldState::new(after);
            if holds(self.goal, &after) {
                arrives += likely;
                continue;
            }
            let next = self.next(&context, action, &after);
            if next == context {
                stays += likely;
            } else if let Some((_, known)) = outcomes.iter_mut().find(|(known, _)| *known == next) {
                *known += likely;
            } else {
                outcomes.push((next, likely));
            }
        }
        let led: f64 = outcomes.iter().map(|(_, likely)| likely).sum();
        let unknown = (1.0 - arrives - led - stays - open).max(0.0);
        let tried = tried(stays + unknown);
        self.arrives = self.arrives.max(reached * arrives * tried);
        let offered = outcomes.into_iter().filter_map(|(next, likely)| {
            Some((self.offer(next, reached * likely * tried, depth + 1)?, likely))
        });
        let leads: Box<[_]> = offered.collect();
        let may_change = arrives > 0.0 || open > 0.0 || !leads.is_empty();
        may_change.then_some(Move { action, arrives, stays, unknown, open, leads })
    }

    /// The context that an action leads to, with what is supposed then.
    fn next(&self, before: &[Observation], action: PrimitiveId, after: &WorldState) -> Box<[Observation]> {
        let items = &self.content.items;
        let on = items.all.iter().map(|item| {
            let on = before.binary_search(&item.observation(true)).is_ok();
            item.follow(on, action, after.observations())
        });
        self.told(&claims::context(self.content, &items.with(on, after)))
    }

    /// Finds the values, and looks at what the best way often comes to, until all of that is known.
    fn settle(&mut self) {
        loop {
            self.values();
            let open = self.open();
            if open.is_empty() || !open.into_iter().all(|at| self.expand(at)) {
                break;
            }
        }
        self.values();
    }

    /// The value of each context: the highest probability of arriving from there, with what each action takes off; 0
    /// where that was not looked at.
    fn values(&mut self) {
        for node in &mut self.nodes {
            node.value = 0.0;
        }
        for _ in 0..SWEEPS_MAX {
            let mut most: f64 = 0.0;
            // From the goal backwards, as contexts were reached forwards.
            for at in (0..self.nodes.len()).rev() {
                let Some(value) = self.best(at).map(|(_, value)| value) else { continue };
                most = most.max(value - self.nodes[at].value);
                self.nodes[at].value = value;
            }
            if most < TOLERANCE {
                return;
            }
        }
    }

    /// What is hoped for where something was never tried: the best that any action may make there, and its value.
    fn hope(&self, at: usize) -> Option<(Option<usize>, f64)> {
        let moves = self.nodes[at].moves.iter().flatten();
        let arrives = |one: &Move| (one.arrives > 0.0).then_some((None, 1.0));
        let leads = |one: &'_ Move| -> Vec<_> {
            one.leads.iter().map(|(to, _)| (Some(*to), self.nodes[*to].value)).chain(arrives(one)).collect()
        };
        moves.flat_map(leads).fold(None, |best, one| match best {
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
    fn way(&self) -> Vec<Stop<'_>> {
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
    fn open(&self) -> Vec<usize> {
        let way = self.way();
        let is_open = |stop: &Stop<'_>| self.nodes[stop.at].moves.is_none();
        if !way.iter().any(is_open) {
            return Vec::new();
        }
        let visits = visits(&way).into_iter();
        let open = way.iter().zip(visits).filter(|(stop, visits)| is_open(stop) && *visits >= NEGLIGIBLE);
        open.map(|(stop, _)| stop.at).collect()
    }

    /// The best way as a policy.
    fn policy(&self) -> Policy {
        let way = self.way();
        let (arrive, actions) = arrivals(&way);
        let kinds: Vec<_> = self.kinds.difference(&self.chance).copied().collect();
        let chance: Vec<_> = self.chance.iter().copied().collect();
        let visits = visits(&way);
        // Those that are come to most often, and where two differ in what is left to chance the first of them.
        let is_kept = |stop: &usize| way[*stop].best.is_some() && visits[*stop] >= NEGLIGIBLE;
        let mut kept: Vec<usize> = (0..way.len()).filter(is_kept).collect();
        kept.sort_by(|a, b| (*b == 0).cmp(&(*a == 0)).then(visits[*b].total_cmp(&visits[*a])));
        let context = |stop: usize| of_kinds(&self.nodes[way[stop].at].context, &kinds);
        let mut told = BTreeSet::new();
        kept.retain(|stop| told.insert(context(*stop)));
        kept.truncate(POLICY_ROWS_MAX);
        let places: FxHashMap<usize, u32> = kept.iter().copied().zip(0..).collect();
        let row = |stop: &usize| {
            let Stop { best, leads, .. } = &way[*stop];
            let lead = |(to, probability): &(Option<usize>, f64)| {
                let to = match to {
                    Some(to) => Some(*places.get(to)?),
                    None => None,
                };
                Some(Lead { to, probability: *probability })
            };
            let mut leads: Vec<_> = leads.iter().filter_map(lead).collect();
            leads.sort_by(|a, b| b.probability.total_cmp(&a.probability));
            let (context, action) = (context(*stop), best.as_ref()?.action);
            Some(PolicyRow { context, action, probability: arrive[*stop].min(1.0), leads })
        };
        let rows = kept.iter().filter_map(row).collect();
        let circumstances = of_kinds(&self.nodes[0].context, &chance);
        Policy { kinds, chance, circumstances, rows, actions, after_actions: 0 }
    }
}

/// A context on a way.
struct Stop<'a> {
    /// Its number among those that were reached.
    at: usize,
    /// The best move there; none where that was not looked at, or nothing leads on.
    best: Option<&'a Move>,
    /// What the move leads to, by the place on the way; none is the goal.
    leads: Vec<(Option<usize>, f64)>,
}

impl Stop<'_> {
    /// How often an action changes anything.
    fn changes(&self) -> f64 {
        (1.0 - self.best.map_or(0.0, |best| best.stays)).max(TOLERANCE)
    }
}

/// How often each context of a way is come to, as expected.
fn visits(way: &[Stop<'_>]) -> Vec<f64> {
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
fn arrivals(way: &[Stop<'_>]) -> (Vec<f64>, f64) {
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
    (arrive, if first > 0.0 { actions / first } else { 0.0 })
}
