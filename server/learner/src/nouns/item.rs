//! Synthetic items: what the learner supposes to be so, though no sense shows it (Drescher, *Made-Up Minds*, 1991), kept by what is done
//! and what comes of it (Holmes & Isbell, 2005).

use std::collections::VecDeque;
use std::sync::Arc;

use crate::nouns::experience::{Experience, NOTHING_DONE};
use crate::nouns::observation::{Observation, PropertyId, TypeId, Value};
use crate::nouns::vocabulary::PrimitiveId;
use crate::nouns::world_state::WorldState;

/// Items that are made in a life; those that were dropped count.
pub const ITEMS_MAX: usize = 64;
/// Events that one item goes by.
pub const EVENTS_MAX: usize = 24;
/// Experiences of a body in which items are sought: the latest.
pub const EXPERIENCES_MAX: usize = 400;

/// What becomes of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Update {
    /// It is supposed from then on.
    On,
    /// It is not, from then on.
    Off,
    /// It is supposed if it was not, and the other way round.
    Turn,
}

impl Update {
    /// What it makes of an item.
    #[must_use]
    pub fn of(self, on: bool) -> bool {
        match self {
            Self::On => true,
            Self::Off => false,
            Self::Turn => !on,
        }
    }
}

/// What was done, and what was there afterwards of the types that an item is about.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Event {
    /// The action.
    pub primitive: PrimitiveId,
    /// The observations of those types, in canonical order.
    pub after: Box<[Observation]>,
}

/// Something that is supposed to be so or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// The type of the observation by which it is perceived.
    pub kind: TypeId,
    /// The property of that observation which says whether it is supposed to be so.
    pub property: PropertyId,
    /// The action whose outcomes it was found to tell apart.
    pub primitive: PrimitiveId,
    /// The types of these outcomes, in order.
    pub kinds: Box<[TypeId]>,
    /// What becomes of it at each of these events, in their order, each once; at others it stays as it is.
    pub updates: Box<[(Event, Update)]>,
    /// Whether no claim asked for it, so that it is kept no longer.
    pub dropped: bool,
}

impl Event {
    /// Whether it is that a new episode begins.
    #[must_use]
    pub fn is_beginning(&self) -> bool {
        self.primitive == NOTHING_DONE && self.after.is_empty()
    }
}

impl Item {
    /// Whether it is supposed after `primitive` was carried out and came to `after`, if it was supposed before or not.
    #[must_use]
    pub fn follow(&self, on: bool, primitive: PrimitiveId, after: &[Observation]) -> bool {
        let part = after.iter().filter(|o| self.kinds.binary_search(&o.kind()).is_ok());
        let is = |(event, _): &&(Event, Update)| {
            event.primitive == primitive && part.clone().eq(event.after.iter())
        };
        self.updates.iter().find(is).map_or(on, |(_, update)| update.of(on))
    }

    /// The observation by which it is perceived.
    #[must_use]
    pub fn observation(&self, on: bool) -> Observation {
        Observation::new(self.kind, [(self.property, Value::Boolean(on))])
    }
}

/// What a body lived through of late.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// For each item whether it is supposed to be so.
    pub on: Vec<bool>,
    /// Its experiences since an item was made, the oldest first; the latest of them are kept.
    pub recent: VecDeque<Arc<Experience>>,
    /// How many these were in all.
    pub taken: u64,
}

/// The items, and for each body what it lived through.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Items {
    /// The items, in the order in which they were made; shared, for they seldom change.
    pub all: Arc<Vec<Item>>,
    /// By the bodies' numbers; none of those of which nothing is known.
    pub lines: Vec<Line>,
}

impl Items {
    /// Whether there is nothing in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty() && self.lines.is_empty()
    }

    /// The item that is perceived by observations of this type.
    #[must_use]
    pub fn of_kind(&self, kind: TypeId) -> Option<&Item> {
        self.all.iter().find(|item| item.kind == kind)
    }

    /// For each item whether the body of this number supposes it.
    pub fn on(&self, body: usize) -> impl Iterator<Item = bool> + '_ {
        let line = self.lines.get(body);
        (0..self.all.len()).map(move |at| line.and_then(|line| line.on.get(at)).copied().unwrap_or(false))
    }

    /// `seen` with the observations of the items when they are supposed so, in place of those that it has; without those of which
    /// nothing is said.
    pub(crate) fn with(&self, on: impl Iterator<Item = bool>, seen: &WorldState) -> WorldState {
        if self.all.is_empty() {
            return seen.clone();
        }
        let kept = self.all.iter().zip(on).filter(|(item, _)| !item.dropped);
        let shown = kept.map(|(item, on)| item.observation(on));
        let others = seen.observations().iter().filter(|o| self.of_kind(o.kind()).is_none());
        WorldState::new(others.cloned().chain(shown))
    }
}
