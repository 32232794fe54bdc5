//! Supposing: items for what no sense shows. Where an action's outcomes differ and no claim tells why, a bit is sought that is turned on and
//! off by what is done and what comes of it, and that would have told. The test is that of claims; what it finds is perceived from
//! then on like anything else, and claims may ask for it.

use std::collections::BTreeMap;

use crate::memory::Memory;
use crate::memory::evidence::InForce;
use crate::memory::evidence::price::Likelihood;
use crate::nouns::claim::Change;
use crate::nouns::effect::Effect;
use crate::nouns::item::{EVENTS_MAX, Event, ITEMS_MAX, Item, Line, Update};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::random::Random;
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// Items are sought after so many experiences, and then whenever there are half as many more.
const FIRST_SEARCH: u64 = 40;
/// But not more seldom than this.
const SEARCH_EVERY: u64 = 2_000;
/// After so many experiences an item that no claim asks for is dropped.
const TRIAL: u64 = 135;
/// Beginnings of one search.
const BEGINNINGS: usize = 6;
/// Outcomes of actions that one search looks into: those that claims tell worst.
const QUESTIONS_MAX: usize = 8;
/// An update may be one of so many: on, off, turn, or none.
const UPDATES: [Option<Update>; 4] = [None, Some(Update::On), Some(Update::Off), Some(Update::Turn)];

/// Which items `body` supposes after `primitive` was carried out and came to `after`.
pub(crate) fn follow(memory: &Memory, body: BodyId, primitive: PrimitiveId, after: &WorldState) -> Vec<bool> {
    let items = &memory.content().items;
    let on = items.on(usize::from(body.0));
    items.all.iter().zip(on).map(|(item, on)| item.follow(on, primitive, after.observations())).collect()
}

/// Whether items are sought after so many experiences.
fn is_due(taken: u64) -> bool {
    let mut at = FIRST_SEARCH;
    while at < taken && at / 2 < SEARCH_EVERY {
        at += at / 2;
    }
    taken >= at && (taken - at).is_multiple_of(SEARCH_EVERY)
}

/// The effects by which items are dropped that no claim asks for, and one is made if one is found.
pub(crate) fn suppose(memory: &Memory, body: BodyId) -> Vec<Effect> {
    let content = memory.content();
    let Some(line) = content.items.lines.get(usize::from(body.0)) else { return Vec::new() };
    if !is_due(line.taken) {
        return Vec::new();
    }
    let unasked = |(_, item): &(u32, &Item)| !item.dropped && !content.evidence.asks_for(item.kind);
    let all = (0..).zip(content.items.all.iter());
    let unasked = all.filter(|_| line.taken >= TRIAL).filter(unasked);
    let mut effects: Vec<_> = unasked.map(|(item, _)| Effect::Dropped { item }).collect();
    if content.items.all.len() < ITEMS_MAX && content.vocabulary.may_suppose(content.items.all.len()) {
        effects.extend(find(memory, body, line));
    }
    effects
}

/// The item that tells outcomes apart best, if it pays for itself.
fn find(memory: &Memory, body: BodyId, line: &Line) -> Option<Effect> {
    let mut questions = questions(memory, line);
    questions.sort_by(|a, b| a.untold.total_cmp(&b.untold));
    questions.truncate(QUESTIONS_MAX);
    let among = libm::log(questions.len().max(1) as f64);
    let mut best: Option<(f64, Effect)> = None;
    for question in &mut questions {
        question.look(line);
        let mut random = Random::from_seed(line.taken ^ u64::from(question.primitive.0) << 32);
        let (told, table) = question.search(&mut random);
        let price = question.events.len() as f64 * libm::log(UPDATES.len() as f64) + among;
        let gain = told - question.untold - price;
        if gain > best.as_ref().map_or(0.0, |(best, _)| *best) {
            best = Some((gain, question.item(body, &table)));
        }
    }
    best.map(|(_, effect)| effect)
}

/// Outcomes of an action that differ where the same claim is in force.
struct Question<'a> {
    primitive: PrimitiveId,
    kinds: &'a [TypeId],
    /// The events that an item may go by: the most frequent ones.
    events: Vec<Event>,
    /// Which event each experience was; as many as there are events for any other.
    line: Vec<usize>,
    /// Where the action was carried out: the place in the line, the claim in force and the outcome, by numbers.
    trials: Vec<(usize, usize, usize)>,
    claims: usize,
    outcomes: usize,
    likelihood: Likelihood,
    /// ln of the probability of the outcomes, told by the claims alone.
    untold: f64,
}

/// How an action came out, of one facet.
#[derive(Default)]
struct Trials<'a> {
    claims: BTreeMap<Vec<usize>, usize>,
    outcomes: BTreeMap<Option<&'a Change>, usize>,
    /// The place in the line, the claim in force and the outcome, by numbers.
    all: Vec<(usize, usize, usize)>,
}

/// What items may be about: of each action, and each facet, whether it came to different things of late though the same claim was in
/// force.
fn questions<'a>(memory: &'a Memory, line: &Line) -> Vec<Question<'a>> {
    let content = memory.content();
    let mut found: BTreeMap<(PrimitiveId, &[TypeId]), Trials<'a>> = BTreeMap::new();
    for (at, experience) in line.recent.iter().enumerate() {
        for InForce { kinds, claim, came } in content.evidence.in_force(&content.vocabulary, experience) {
            let trials = found.entry((experience.primitive, kinds)).or_default();
            let claim = numbered(&mut trials.claims, claim);
            let outcome = numbered(&mut trials.outcomes, came);
            trials.all.push((at, claim, outcome));
        }
    }
    let questions =
        found.into_iter().map(|((primitive, kinds), trials)| Question::new(primitive, kinds, trials));
    // However well an item told them, it would not pay for so much as one event at which it changes.
    let worth =
        |question: &Question<'_>| question.outcomes > 1 && -question.untold > libm::log(UPDATES.len() as f64);
    questions.filter(worth).collect()
}

/// What of `after` is of these types.
fn part(after: &[Observation], kinds: &[TypeId]) -> Box<[Observation]> {
    after.iter().filter(|o| kinds.binary_search(&o.kind()).is_ok()).cloned().collect()
}

/// Numbers things as they are first met.
fn numbered<T: Ord>(known: &mut BTreeMap<T, usize>, one: T) -> usize {
    let next = known.len();
    *known.entry(one).or_insert(next)
}

impl<'a> Question<'a> {
    fn new(primitive: PrimitiveId, kinds: &'a [TypeId], trials: Trials<'_>) -> Self {
        let (claims, outcomes) = (trials.claims.len(), trials.outcomes.len());
        let likelihood = Likelihood::new(trials.all.len(), outcomes + 1);
        let mut question = Self {
            primitive,
            kinds,
            events: Vec::new(),
            line: Vec::new(),
            trials: trials.all,
            claims,
            outcomes,
            likelihood,
            untold: 0.0,
        };
        question.untold = question.told(&[]);
        question
    }

    /// Looks which events an item may go by.
    fn look(&mut self, line: &Line) {
        let parts =
            line.recent.iter().map(|experience| (experience.primitive, part(&experience.after, self.kinds)));
        let parts: Vec<_> = parts.collect();
        let mut times: BTreeMap<&(PrimitiveId, Box<[Observation]>), usize> = BTreeMap::new();
        parts.iter().for_each(|part| *times.entry(part).or_default() += 1);
        let mut frequent: Vec<_> = times.into_iter().collect();
        frequent.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(b.0)));
        frequent.truncate(EVENTS_MAX);
        let number = |part| frequent.iter().position(|(known, _)| *known == part).unwrap_or(frequent.len());
        self.line = parts.iter().map(number).collect();
        let event = |((primitive, after), _): &(&(PrimitiveId, Box<[Observation]>), usize)| Event {
            primitive: *primitive,
            after: after.clone(),
        };
        self.events = frequent.iter().map(event).collect();
    }

    /// ln of the probability of the outcomes, told by the claims and by an item with these updates.
    fn told(&self, table: &[Option<Update>]) -> f64 {
        let mut counts = vec![0_usize; self.claims * 2 * self.outcomes];
        let (mut on, mut next) = (true, 0);
        for (at, claim, outcome) in &self.trials {
            while next < *at {
                if let Some(Some(update)) = self.line.get(next).and_then(|event| table.get(*event)) {
                    on = update.of(on);
                }
                next += 1;
            }
            counts[(claim * 2 + usize::from(on)) * self.outcomes + outcome] += 1;
        }
        let cell = |counts: &[usize]| {
            let told: f64 = counts.iter().map(|count| self.likelihood.rising(*count)).sum();
            told - self.likelihood.factorial(counts.iter().sum())
        };
        counts.chunks(self.outcomes.max(1)).map(cell).sum()
    }

    /// The best updates that a greedy search finds, with how well they tell the outcomes.
    fn search(&self, random: &mut Random) -> (f64, Vec<Option<Update>>) {
        let mut best = (f64::NEG_INFINITY, Vec::new());
        for _ in 0..BEGINNINGS {
            let drawn = (0..self.events.len()).map(|_| UPDATES[random.below(UPDATES.len())]);
            let mut table: Vec<_> = drawn.collect();
            let mut told = self.told(&table);
            loop {
                let before = told;
                for at in 0..table.len() {
                    for update in UPDATES {
                        let kept = std::mem::replace(&mut table[at], update);
                        let now = self.told(&table);
                        // Of equals, that by which the item stays as it is.
                        if now > told + 1e-9 || (update.is_none() && now >= told - 1e-9) {
                            told = now;
                        } else {
                            table[at] = kept;
                        }
                    }
                }
                if told <= before + 1e-9 {
                    break;
                }
            }
            if told > best.0 {
                best = (told, table);
            }
        }
        best
    }

    /// The effect that makes the item with these updates.
    fn item(&self, body: BodyId, table: &[Option<Update>]) -> Effect {
        let updates = self.events.iter().zip(table);
        let mut updates: Vec<_> =
            updates.filter_map(|(event, update)| Some((event.clone(), (*update)?))).collect();
        updates.sort_unstable();
        let update = |event: &usize| table.get(*event).copied().flatten();
        let on = self.line.iter().filter_map(update).fold(true, |on, update| update.of(on));
        let (primitive, kinds) = (self.primitive, self.kinds.into());
        Effect::Supposed { body, on, primitive, kinds, updates: updates.into() }
    }
}
