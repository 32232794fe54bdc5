//! The frontier: what may be learnt in contexts that are not here and can be reached by what claims foretell. Something new to do draws
//! the learner there, by as much as curiosity would if it were there, times the probability of coming there, over the number of actions
//! until then: equation 1's own d. So it does not wait until chance leads it on. Where actions have chances, a way goes on from wherever
//! they lead: it says what to do in each context, and of all ways that is taken on which most is learnt an action.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use rustc_hash::FxHashMap;

use crate::cycle::claims;
use crate::cycle::curiosity::{Curiosity, quiet};
use crate::memory::evidence::Foresight;
use crate::memory::{Content, Memory};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// How much is looked at in one search: for each action in each context one more than there are observations.
const LOOKS_MAX: usize = 4_096;
/// An outcome that is less likely than this is not followed.
const LIKELY: f64 = 0.02;
/// An outcome that is less likely than this is waited for before it is known what to do next.
const SURE: f64 = 0.95;
/// Ways are compared until none is better by more than this share.
const TOLERANCE: f64 = 1e-3;
/// Sweeps over all contexts in which a way is weighed, at most.
const SWEEPS_MAX: usize = 64;
/// Ways that are compared, at most.
const WAYS_MAX: usize = 16;

/// What may be learnt elsewhere, and how to get there.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frontier {
    /// The first action of the way.
    pub(crate) first: PrimitiveId,
    /// The contexts that follow on the way for certain, each with what is done there, as far as the new primitive.
    pub(crate) way: Vec<(WorldState, PrimitiveId)>,
    /// The primitive that is new at its end.
    pub(crate) new: PrimitiveId,
    /// The actions until then, as many as are expected, the new one included.
    pub(crate) distance: u32,
    /// How much may be learnt there, from 0 to 1, times the probability of getting there.
    pub(crate) weight: f64,
}

/// A context that can be reached.
struct Node {
    context: WorldState,
    /// The fewest actions to it.
    depth: u32,
    /// The primitive of which most may be learnt there, and how much; none where that was not looked at.
    new: Option<(PrimitiveId, f64)>,
    moves: Vec<Move>,
    /// What a way from here is worth: what is learnt at its end, less what each action costs.
    value: f64,
}

/// An action that leads on.
struct Move {
    action: PrimitiveId,
    /// How often it is carried out, as expected, until something changes.
    tries: f64,
    /// The contexts that it leads to then, each with its probability; less than 1 together where it was never tried.
    leads: Vec<(usize, f64)>,
}

/// What to do in a context.
#[derive(Clone, Copy)]
enum Turn {
    /// Do there what is new.
    End,
    /// Go on by the move of this number.
    On(usize),
}

struct Search<'a> {
    content: &'a Content,
    body: BodyId,
    repertoire: &'a [PrimitiveId],
    foresight: &'a mut Foresight,
    curiosity: &'a Curiosity,
    memory: &'a Memory,
    nodes: Vec<Node>,
    /// Those that were looked at, in this order.
    looked_at: Vec<usize>,
    known: FxHashMap<WorldState, usize>,
    /// What waits to be looked at: how much draws there by the likeliest way, for each unit that may be learnt; the number of the context
    /// and the probability of that way with the actions that it takes.
    waiting: BinaryHeap<(u64, Reverse<usize>, [u64; 2])>,
    /// How much is learnt an action on the best way that was found.
    rate: f64,
    /// How much may be learnt where the next episode begins.
    beginning: f64,
}

/// Looks for what draws more than `least`, in what is learnt an action. None if there is nothing in reach that does.
pub(crate) fn search(
    memory: &Memory,
    body: BodyId,
    world: &WorldState,
    curiosity: &Curiosity,
    least: f64,
    foresight: &mut Foresight,
) -> Option<Frontier> {
    let content = memory.content();
    let vocabulary = &content.vocabulary;
    let repertoire = vocabulary.bodies().get(usize::from(body.0)).map_or(&[][..], |body| &body.repertoire);
    let most = curiosity.most()?;
    if most <= least {
        return None;
    }
    // Where noise alone differs nothing else is to be learnt.
    let kinds = vocabulary.sensed_types().filter(|kind| !curiosity.noise.contains(kind)).collect();
    // All of them are asked for, so that none is left to chance where little was tried.
    foresight.begin((body, repertoire), &kinds, &kinds);
    let mut search = Search {
        content,
        body,
        repertoire,
        foresight,
        curiosity,
        memory,
        nodes: Vec::new(),
        looked_at: Vec::new(),
        known: FxHashMap::default(),
        waiting: BinaryHeap::new(),
        rate: least,
        beginning: content.evidence.beginning(body),
    };
    search.offer(search.told(claims::context(content, world)), 1.0, 0.0, 0);
    search.explore(most);
    search.best(least)
}

impl Search<'_> {
    /// The part of a context that tells it from others.
    fn told(&self, context: WorldState) -> WorldState {
        quiet(context, &self.curiosity.noise)
    }

    /// The number of a context that is come to in this way.
    fn offer(&mut self, context: WorldState, likely: f64, far: f64, depth: u32) -> usize {
        let at = *self.known.entry(context.clone()).or_insert(self.nodes.len());
        if at == self.nodes.len() {
            self.nodes.push(Node { context, depth, new: None, moves: Vec::new(), value: 0.0 });
            let draws = likely / (far + 1.0);
            self.waiting.push((draws.to_bits(), Reverse(at), [likely.to_bits(), far.to_bits()]));
        }
        at
    }

    /// Looks at contexts, first at those that draw most by the likeliest way there, as long as so much may be learnt of one action.
    fn explore(&mut self, most: f64) {
        let mut looks = 0;
        while let Some((_, Reverse(at), way)) = self.waiting.pop() {
            let (context, depth) = (self.nodes[at].context.clone(), self.nodes[at].depth);
            if most / f64::from(depth + 1) <= self.rate {
                continue;
            }
            looks += self.repertoire.len() * (1 + context.observations().len());
            if looks > LOOKS_MAX {
                break;
            }
            self.look(at, &context, way.map(f64::from_bits), depth);
        }
    }

    /// Looks at what can be done in a context, which is come to with this probability in so many actions.
    fn look(&mut self, at: usize, context: &WorldState, [likely, far]: [f64; 2], depth: u32) {
        let Self { content, body, repertoire, .. } = *self;
        let about = context.observations();
        let outlook =
            self.foresight.outlook(&content.evidence, &content.vocabulary, (body, repertoire), about);
        // Where something is that was never there when anything was done, nobody knows what leads on; and the more often it was perceived,
        // the less is it there for long enough to do anything, for others see to that.
        let mut unmet = about.iter().filter(|o| depth > 0 && !content.evidence.is_met(o)).peekable();
        let is_met = unmet.peek().is_none();
        let lasts =
            unmet.fold(1.0, |lasts: f64, o| lasts.min(1.0 / (1.0 + f64::from(self.memory.attention(o)))));
        let goes_on = 1.0 - outlook.ending.probability;
        let mut new: Option<(PrimitiveId, f64)> = None;
        let mut moves = Vec::with_capacity(repertoire.len());
        for (action, prospect) in repertoire.iter().zip(outlook.prospects) {
            let reliability = content.reliability(*action);
            let trust = self.curiosity.trust(self.memory, *action);
            let learnable = trust * prospect.learnable * lasts * goes_on + self.beginning * (1.0 - goes_on);
            let learnable = learnable.max(outlook.ending.learnable);
            if new.is_none_or(|(_, most)| learnable > most) {
                new = Some((*action, learnable));
            }
            // What may come about that never did is taken to change nothing: it is not known to end a way.
            let (mut changes, mut outcomes) = (prospect.open * reliability, Vec::new());
            for (after, share) in &prospect.outcomes {
                let after = WorldState::new(after.iter().cloned());
                let next = self.told(claims::context_after(content, about, *action, &after));
                if next != *context && share * reliability >= LIKELY {
                    outcomes.push((next, share * reliability));
                    changes += share * reliability;
                }
            }
            if !is_met || goes_on < LIKELY {
                continue;
            }
            let tries = 1.0 / changes.max(LIKELY);
            let offer = |(next, share): (WorldState, f64)| {
                let led = share * tries * goes_on;
                (self.offer(next, likely * led, far + tries, depth + 1), led)
            };
            let leads: Vec<_> = outcomes.into_iter().map(offer).collect();
            if !leads.is_empty() {
                moves.push(Move { action: *action, tries, leads });
            }
        }
        // The likeliest way is one way.
        self.rate = new.map_or(self.rate, |(_, most)| self.rate.max(most * likely / (far + 1.0)));
        (self.nodes[at].new, self.nodes[at].moves) = (new, moves);
        self.looked_at.push(at);
    }

    /// What is best to do in a context when each action costs the present rate, and its worth; none where nothing is worth it.
    fn turn(&self, at: usize) -> Option<(Turn, f64)> {
        let Node { new, moves, .. } = &self.nodes[at];
        let end = new.map(|(_, most)| (Turn::End, most - self.rate)).into_iter();
        let led = |one: &Move| -> f64 { one.leads.iter().map(|(to, p)| p * self.nodes[*to].value).sum() };
        let on = moves.iter().enumerate();
        let on = on.map(|(number, one)| (Turn::On(number), led(one) - one.tries * self.rate));
        end.chain(on).filter(|(_, value)| *value > 0.0).fold(None, |best, one| match best {
            Some((_, most)) if one.1 <= most => best,
            _ => Some(one),
        })
    }

    /// The worth of ways from each context, when each action costs the present rate.
    fn weigh(&mut self) {
        for _ in 0..SWEEPS_MAX {
            let mut most: f64 = 0.0;
            // From the end backwards, as contexts were reached forwards.
            for at in self.looked_at.iter().copied().rev() {
                let value = self.turn(at).map_or(0.0, |(_, value)| value);
                most = most.max((value - self.nodes[at].value).abs());
                self.nodes[at].value = value;
            }
            if most <= TOLERANCE * self.rate {
                return;
            }
        }
    }

    /// What is learnt on the best way at the present rate, and the actions that it takes, as expected.
    fn expected(&self, turns: &[Option<Turn>]) -> (f64, f64) {
        let mut expected = vec![(0.0, 0.0); self.nodes.len()];
        for _ in 0..SWEEPS_MAX {
            let mut most: f64 = 0.0;
            for at in self.looked_at.iter().copied().rev() {
                let node = &self.nodes[at];
                let of = match turns[at] {
                    None => (0.0, 0.0),
                    Some(Turn::End) => (node.new.map_or(0.0, |(_, learnable)| learnable), 1.0),
                    Some(Turn::On(number)) => {
                        let Move { tries, ref leads, .. } = node.moves[number];
                        leads.iter().fold((0.0, tries), |(learnt, taken), (to, p)| {
                            let (further, more): (f64, f64) = expected[*to];
                            (learnt + p * further, taken + p * more)
                        })
                    }
                };
                most = most.max((of.1 - expected[at].1).abs());
                expected[at] = of;
            }
            if most <= TOLERANCE {
                break;
            }
        }
        expected[0]
    }

    /// The way on which most is learnt an action, if that is more than `least`. With each action at the cost of a rate, the best way is
    /// worth nothing just when no way has a higher one (Dinkelbach's method for the best of ratios).
    fn best(mut self, least: f64) -> Option<Frontier> {
        let mut found = None;
        // At a little less than the rate of the likeliest way that was found, this way is worth something.
        self.rate = least.max(self.rate * (1.0 - TOLERANCE));
        for _ in 0..WAYS_MAX {
            self.weigh();
            let turns: Vec<_> = (0..self.nodes.len()).map(|at| self.turn(at).map(|(turn, _)| turn)).collect();
            let (learnt, actions) = self.expected(&turns);
            let rate = if actions > 0.0 { learnt / actions } else { 0.0 };
            if rate <= least || (found.is_some() && rate <= self.rate) {
                break;
            }
            let is_settled = rate <= self.rate * (1.0 + TOLERANCE);
            self.rate = rate;
            found = Some((turns, rate, actions));
            if is_settled {
                break;
            }
        }
        let (turns, rate, actions) = found?;
        self.way(&turns, rate, actions)
    }

    /// The way to what is new when all comes about that is most likely.
    fn way(&self, turns: &[Option<Turn>], rate: f64, actions: f64) -> Option<Frontier> {
        let (mut at, mut course, mut come) = (0, Vec::new(), BTreeSet::from([0]));
        let (mut is_sure, mut sure) = (true, 0);
        let new = loop {
            match turns[at]? {
                Turn::End => break self.nodes[at].new?.0,
                Turn::On(number) => {
                    let Move { action, tries, ref leads } = self.nodes[at].moves[number];
                    course.push((at, action));
                    // Another outcome, where the likeliest leads back: it is come to in the end.
                    let leads = leads.iter().filter(|(to, _)| turns[*to].is_some() && !come.contains(to));
                    let next = leads.fold(None, |best: Option<&(usize, f64)>, one| match best {
                        Some((_, most)) if one.1 <= *most => best,
                        _ => Some(one),
                    })?;
                    is_sure &= next.1 >= SURE * tries;
                    sure += usize::from(is_sure);
                    at = next.0;
                    come.insert(at);
                }
            }
        };
        course.push((at, new));
        let first = course.first()?.1;
        let way =
            course.iter().skip(1).take(sure).map(|(at, action)| (self.nodes[*at].context.clone(), *action));
        let distance = (actions.round() as u32).max(1);
        Some(Frontier { first, way: way.collect(), new, distance, weight: rate * f64::from(distance) })
    }
}
