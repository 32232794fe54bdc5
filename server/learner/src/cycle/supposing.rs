//! Supposing: items for what no sense shows. Where an action's outcomes differ and no claim tells why, a bit is sought that is turned on and
//! off by what is done and what comes of it, and that would have told. The test is that of claims; what it finds is perceived from
//! then on like anything else, and claims may ask for it.

use std::collections::BTreeMap;

use crate::memory::Memory;
use crate::memory::evidence::price::Likelihood;
use crate::nouns::effect::Effect;
use crate::nouns::experience::Experience;
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
    for question in &questions {
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
struct Question {
    primitive: PrimitiveId,
    kinds: Box<[TypeId]>,
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

/// What the items of a life may be about: for each action that came to different things of late, and each facet, a question.
fn questions(memory: &Memory, line: &Line) -> Vec<Question> {
    let content = memory.content();
    let mut tried: BTreeMap<PrimitiveId, usize> = BTreeMap::new();
    line.recent.iter().for_each(|experience| *tried.entry(experience.primitive).or_default() += 1);
    let mut questions = Vec::new();
    for primitive in tried.into_iter().filter(|(_, times)| *times > 1).map(|(primitive, _)| primitive) {
        for kinds in content.evidence.facets(&content.vocabulary, primitive) {
            // What items are about is what senses show.
            if kinds.iter().all(|kind| content.items.of_kind(*kind).is_none()) {
                questions.extend(Question::new(memory, line, primitive, kinds));
            }
        }
    }
    questions
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

impl Question {
    /// The question, if it may be worth an item.
    fn new(memory: &Memory, line: &Line, primitive: PrimitiveId, kinds: &[TypeId]) -> Option<Self> {
        let content = memory.content();
        let (mut claims, mut outcomes) = (BTreeMap::new(), BTreeMap::new());
        let mut trials = Vec::new();
        for (at, experience) in line.recent.iter().enumerate() {
            if experience.primitive == primitive {
                let (claim, outcome) = content.evidence.in_force(&content.vocabulary, experience, kinds)?;
                trials.push((at, numbered(&mut claims, claim), numbered(&mut outcomes, outcome)));
            }
        }
        let event = |experience: &Experience| Event {
            primitive: experience.primitive,
            after: part(&experience.after, kinds),
        };
        let (claims, outcomes) = (claims.len(), outcomes.len());
        let likelihood = Likelihood::new(trials.len(), outcomes + 1);
        let mut question = Self {
            primitive,
            kinds: kinds.into(),
            events: Vec::new(),
            line: Vec::new(),
            trials,
            claims,
            outcomes,
            likelihood,
            untold: 0.0,
        };
        question.untold = question.told(&[]);
        // However well an item told them, it would not pay for so much as one event at which it changes.
        if outcomes < 2 || -question.untold <= libm::log(UPDATES.len() as f64) {
            return None;
        }
        let mut times: BTreeMap<Event, usize> = BTreeMap::new();
        line.recent.iter().for_each(|experience| *times.entry(event(experience)).or_default() += 1);
        let mut frequent: Vec<_> = times.into_iter().collect();
        frequent.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        question.events = frequent.into_iter().take(EVENTS_MAX).map(|(event, _)| event).collect();
        let number = |experience: &Experience| {
            let event = event(experience);
            question.events.iter().position(|known| *known == event).unwrap_or(question.events.len())
        };
        question.line = line.recent.iter().map(|experience| number(experience)).collect();
        Some(question)
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
        let (primitive, kinds) = (self.primitive, self.kinds.clone());
        Effect::Supposed { body, on, primitive, kinds, updates: updates.into() }
    }
}
