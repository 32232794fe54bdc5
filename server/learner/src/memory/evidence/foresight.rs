//! What was foretold of contexts in earlier searches. With a step only what is known of one action changes, so most of it is the same in
//! the next search, and need not be found again.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::memory::evidence::Evidence;
use crate::memory::evidence::prospect::{Foreseen, Outlook};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId, Vocabulary};

/// What was foretold of contexts that a search looked at, for the next. It follows from what is known, and is no part of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Foresight {
    /// Whose search it was; none before the first.
    body: Option<BodyId>,
    /// What that body can do: what is foretold is kept by the place in it.
    repertoire: Vec<PrimitiveId>,
    /// The types that were looked at.
    kinds: BTreeSet<TypeId>,
    /// The types that the goal speaks of.
    goal: BTreeSet<TypeId>,
    /// Of each context the number of the search that asked for it last, and what is foretold of each primitive of the body.
    contexts: FxHashMap<Box<[Observation]>, (u64, Vec<Foreseen>)>,
    /// The number of the search.
    search: u64,
    /// How much is foretold by it.
    size: usize,
}

impl Foresight {
    /// What is kept from one search to the next, at most: primitives in contexts.
    const SIZE_MAX: usize = 8_192;

    /// Another search begins, by a body that is sent to a goal which speaks of types `goal`, and depends on `kinds`.
    pub(crate) fn begin(
        &mut self,
        (body, repertoire): (BodyId, &[PrimitiveId]),
        kinds: &BTreeSet<TypeId>,
        goal: &BTreeSet<TypeId>,
    ) {
        let is_same = self.body == Some(body) && self.repertoire == repertoire;
        if !is_same || self.kinds != *kinds || self.goal != *goal {
            let (kinds, goal, repertoire) = (kinds.clone(), goal.clone(), repertoire.to_vec());
            *self = Self { body: Some(body), repertoire, kinds, goal, ..Self::default() };
        }
        if self.size > Self::SIZE_MAX {
            // What the last search looked at is looked at again most likely.
            let last = self.search;
            self.contexts.retain(|_, (search, _)| *search == last);
            self.size = self.contexts.values().map(|(_, foreseen)| foreseen.len()).sum();
            if self.size > Self::SIZE_MAX {
                (self.contexts, self.size) = (FxHashMap::default(), 0);
            }
        }
        self.search += 1;
    }

    /// What each of the body's primitives makes of a context of lasting observations in canonical order.
    pub(crate) fn outlook(
        &mut self,
        evidence: &Evidence,
        vocabulary: &Vocabulary,
        (body, primitives): (BodyId, &[PrimitiveId]),
        context: &[Observation],
    ) -> Outlook {
        let Self { kinds, goal, contexts, search, size, .. } = self;
        if !contexts.contains_key(context) {
            *size += primitives.len();
            contexts.insert(context.into(), (0, Vec::new()));
        }
        let mut none = Vec::new();
        let foreseen = match contexts.get_mut(context) {
            Some((last, foreseen)) => {
                *last = *search;
                foreseen
            }
            None => &mut none,
        };
        evidence.outlook(vocabulary, (body, primitives), context, (kinds, goal), foreseen)
    }
}
