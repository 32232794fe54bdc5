//! Policies: what to do in each context on the way to a goal, by what claims foretell. Contexts are reached in the order of how
//! surely, until none that waits could lead there more surely than what is known; then the value of each is the probability to arrive
//! from there with a little taken off for each action (value iteration), so that retries and dead ends are weighed. What the
//! best way may lead to and was not looked at yet is looked at then, and so on until nothing is left open.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use rustc_hash::FxHashMap;

use crate::cycle::claims;
use crate::cycle::goals::holds;
use crate::cycle::valuation::{
    DISCOUNT, Graph, Move, NEGLIGIBLE, Node, Stop, TOLERANCE, arrivals, tried, visits,
};
use crate::memory::evidence::{Ending, Foresight, Outlook, Prospect};
use crate::memory::{Content, Memory};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::policy::{Lead, POLICY_ROWS_MAX, Policy, PolicyRow, of_kinds};
use crate::nouns::pursuit::{Goal, Patterns};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// Contexts that are reached in one search.
const CONTEXTS_MAX: usize = 16_384;
/// How much is looked at in one search: for each action in each context one more than there are observations.
const LOOKS_MAX: usize = 131_072;
/// Observations in the contexts of a policy that are kept, but for those of the first: the effect that makes it is written to disk.
const OBSERVATIONS_MAX: usize = 4_096;

/// The result of a search for a policy.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PolicySearch {
    /// The best policy; none if nothing known leads to the goal, or brings any of what most is wanted of.
    pub(crate) policy: Option<Policy>,
    /// Whether the search used up its budget, so that there may be more.
    pub(crate) truncated: bool,
}

struct Search<'a> {
    content: &'a Content,
    body: BodyId,
    goal: &'a Patterns,
    /// Whether it is to be brought about though it may hold: where it does, an action does not arrive.
    again: bool,
    foresight: &'a mut Foresight,
    /// The types on which it depends.
    kinds: BTreeSet<TypeId>,
    /// Those of them that are left to chance.
    chance: BTreeSet<TypeId>,
    repertoire: &'a [PrimitiveId],
    /// The highest probability with which one action reaches the goal.
    surest: f64,
    graph: Graph,
    known: FxHashMap<Box<[Observation]>, usize>,
    waiting: BinaryHeap<(u64, Reverse<u32>, Reverse<usize>)>,
    /// The value of the surest way to the goal that was found.
    arrives: f64,
    looks: usize,
    truncated: bool,
}

/// Looks for a policy that brings `goal` about from `world`, where it does not hold or is wanted again.
pub(crate) fn search(
    memory: &Memory,
    body: BodyId,
    world: &WorldState,
    goal: &Goal,
    foresight: &mut Foresight,
) -> PolicySearch {
    let content = memory.content();
    let vocabulary = &content.vocabulary;
    let repertoire = vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |body| &body.repertoire);
    let wanted: BTreeSet<_> = goal.kinds().collect();
    let surest = content.evidence.surest(vocabulary, repertoire, &wanted);
    let kinds = depends_on(content, repertoire, &wanted);
    foresight.begin((body, repertoire), &kinds, &wanted);
    let mut search = Search {
        content,
        body,
        goal: goal.patterns(),
        again: goal.is_again(),
        foresight,
        kinds,
        chance: BTreeSet::new(),
        repertoire,
        surest,
        graph: Graph::default(),
        known: FxHashMap::default(),
        waiting: BinaryHeap::new(),
        arrives: 0.0,
        looks: 0,
        truncated: false,
    };
    let start = search.told(&claims::context(content, world));
    search.offer(start, 1.0, 0);
    search.explore();
    search.settle();
    let policy = (search.graph.nodes[0].value > 0.0).then(|| search.policy());
    PolicySearch { policy, truncated: search.truncated }
}

/// The types on which it depends what comes of these types.
pub(crate) fn depends_on(
    content: &Content,
    repertoire: &[PrimitiveId],
    wanted: &BTreeSet<TypeId>,
) -> BTreeSet<TypeId> {
    let mut kinds = wanted.clone();
    loop {
        let before = kinds.clone();
        let Some(found) = content.evidence.depends_on(&content.vocabulary, repertoire, kinds) else {
            // Nothing depends on a value.
            return content.vocabulary.sensed_types().chain(wanted.iter().copied()).collect();
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
            None if self.graph.nodes.len() == CONTEXTS_MAX => {
                self.truncated = true;
                return None;
            }
            None => {
                self.known.insert(context.clone(), self.graph.nodes.len());
                self.graph.nodes.push(Node { context, moves: None, reached: 0.0, depth, value: 0.0 });
                self.graph.nodes.len() - 1
            }
        };
        let node = &mut self.graph.nodes[at];
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
            if self.graph.nodes[at].moves.is_some() || reached < self.graph.nodes[at].reached {
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
        let context = self.graph.nodes[at].context.clone();
        let looks = self.looks + self.repertoire.len() * (1 + context.len());
        if looks > LOOKS_MAX {
            self.truncated = true;
            return false;
        }
        self.looks = looks;
        let Content { evidence, vocabulary, .. } = self.content;
        let Outlook { prospects, ending, chance } =
            self.foresight.outlook(evidence, vocabulary, (self.body, self.repertoire), &context);
        self.chance.extend(chance);
        let moves = self.repertoire.iter().zip(prospects);
        let moves = moves.filter_map(|(action, prospect)| self.look(at, *action, &prospect, ending));
        let moves: Vec<_> = moves.collect();
        self.graph.nodes[at].moves = Some(moves.into());
        true
    }

    /// An action in a context, with what is foretold of it; none if it neither changes anything nor reaches the goal.
    fn look(&mut self, at: usize, action: PrimitiveId, prospect: &Prospect, ending: Ending) -> Option<Move> {
        let Prospect { outcomes: foretold, open, .. } = prospect;
        let Node { reached, depth, ref context, .. } = self.graph.nodes[at];
        let context = context.clone();
        let reliability = self.content.reliability(action);
        // What holds already is not brought about.
        let holds_here = self.again && holds(self.goal, &WorldState::new(context.iter().cloned()));
        let (mut arrives, mut stays, open) = (0.0, 1.0 - reliability, open * reliability);
        let mut outcomes: Vec<(Box<[Observation]>, f64)> = Vec::new();
        for (after, likely) in foretold {
            let likely = likely * reliability;
            let after = WorldState::new(after.iter().cloned());
            if !holds_here && holds(self.goal, &after) {
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
        // From where an episode has ended nothing leads on.
        let goes_on = 1.0 - ending.probability;
        if goes_on < TOLERANCE {
            return None;
        }
        let (arrives, open) = (arrives * goes_on, open * goes_on);
        let tried = tried(stays + unknown);
        self.arrives = self.arrives.max(reached * arrives * tried);
        let offered = outcomes.into_iter().filter_map(|(next, likely)| {
            let likely = likely * goes_on;
            Some((self.offer(next, reached * likely * tried, depth + 1)?, likely))
        });
        let leads: Box<[_]> = offered.collect();
        let may_change = arrives > 0.0 || open > 0.0 || !leads.is_empty();
        may_change.then_some(Move { action, arrives, stays, unknown, open, leads })
    }

    /// The context that an action leads to, with what is supposed then.
    fn next(&self, before: &[Observation], action: PrimitiveId, after: &WorldState) -> Box<[Observation]> {
        self.told(&claims::context_after(self.content, before, action, after))
    }

    /// Finds the values, and looks at what the best way often comes to, until all of that is known.
    fn settle(&mut self) {
        loop {
            self.graph.values();
            if self.graph.is_spent() {
                self.truncated = true;
                return;
            }
            let open = self.graph.open();
            if open.is_empty() {
                return;
            }
            if !open.into_iter().all(|at| self.expand(at)) {
                return self.graph.values();
            }
        }
    }

    /// The best way as a policy.
    fn policy(&self) -> Policy {
        let way = self.graph.way();
        let (arrive, actions) = arrivals(&way);
        let kinds: Vec<_> = self.kinds.difference(&self.chance).copied().collect();
        let chance: Vec<_> = self.chance.iter().copied().collect();
        let visits = visits(&way);
        let may = |stop: usize| way[stop].best.is_some() && visits[stop] >= NEGLIGIBLE;
        let contexts: Vec<_> =
            way.iter().map(|stop| of_kinds(&self.graph.nodes[stop.at].context, &kinds)).collect();
        let kept = kept_of(self.content, &contexts, &visits, may);
        let places: FxHashMap<usize, u32> = kept.iter().copied().zip(0..).collect();
        let row = |stop: &usize| {
            let Stop { best, leads, .. } = &way[*stop];
            let lead = |(to, probability): &(Option<usize>, f64)| {
                let to = match to {
                    Some(to) => Some(*places.get(to)?),
                    None => None,
                };
                Some(Lead { to, probability: probability.min(1.0) })
            };
            let mut leads: Vec<_> = leads.iter().filter_map(lead).collect();
            leads.sort_by(|a, b| b.probability.total_cmp(&a.probability));
            let (context, action) = (contexts[*stop].clone(), best.as_ref()?.action);
            Some(PolicyRow { context, action, probability: arrive[*stop].min(1.0), leads })
        };
        let rows = kept.iter().filter_map(row).collect();
        let circumstances = of_kinds(&self.graph.nodes[0].context, &chance);
        Policy { kinds, chance, circumstances, rows, yields: Vec::new(), actions, after_actions: 0 }
    }
}

/// Those of the contexts on a way that are kept, of those that `may` be: the first one, then those that are come to most often, and where
/// two differ in what is left to chance the first of them.
pub(crate) fn kept_of(
    content: &Content,
    contexts: &[Vec<Observation>],
    visits: &[f64],
    may: impl Fn(usize) -> bool,
) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..contexts.len()).filter(|stop| may(*stop)).collect();
    kept.sort_by(|a, b| (*b == 0).cmp(&(*a == 0)).then(visits[*b].total_cmp(&visits[*a])));
    let mut told = BTreeSet::new();
    let known = |o: &Observation| content.vocabulary.knows(o);
    kept.retain(|stop| contexts[*stop].iter().all(known) && told.insert(&contexts[*stop]));
    kept.truncate(POLICY_ROWS_MAX);
    let mut observations = 0;
    kept.retain(|stop| {
        observations += contexts[*stop].len();
        *stop == 0 || observations <= OBSERVATIONS_MAX
    });
    kept
}
