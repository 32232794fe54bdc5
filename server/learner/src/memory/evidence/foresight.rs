//! What was foretold of contexts in earlier searches. With a step only what is known of one action changes, so most of it is the same in
//! the next search, and need not be found again.

use std::collections::BTreeSet;
use std::sync::{Arc, Weak};

use rustc_hash::FxHashMap;

use crate::memory::evidence::Evidence;
use crate::memory::evidence::foretold::Foretold;
use crate::memory::evidence::outlook::{Outlook, Prospect};
use crate::memory::evidence::pool::Pool;
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::{BodyId, PrimitiveId, Vocabulary};

/// What is foretold of one primitive in one context, for as long as its pool is the same.
#[derive(Clone, Debug, Default)]
pub(super) struct Foreseen {
    /// The pool, by where it is: what is known of an action is never changed in place while this refers to it.
    pool: Weak<Pool>,
    pub(super) foretold: Arc<[Foretold]>,
    /// What follows from that, and the types that are left to chance then.
    prospect: Option<(Vec<TypeId>, Arc<Prospect>)>,
}

impl Foreseen {
    pub(super) fn new(pool: Option<&Arc<Pool>>, foretold: Vec<Foretold>) -> Self {
        // Where it depends on what a body recalls, it is so this time only.
        let lasts = pool.filter(|pool| pool.key().is_none());
        Self {
            pool: lasts.map(Arc::downgrade).unwrap_or_default(),
            foretold: foretold.into(),
            prospect: None,
        }
    }

    /// Whether this is what a pool foretells.
    pub(super) fn is_of(&self, pool: Option<&Arc<Pool>>) -> bool {
        pool.is_some_and(|pool| std::ptr::eq(self.pool.as_ptr(), Arc::as_ptr(pool)))
    }

    /// What follows when these types are left to chance.
    pub(super) fn prospect(
        &mut self,
        chance: &[TypeId],
        find: impl FnOnce(&[Foretold]) -> Prospect,
    ) -> Arc<Prospect> {
        let known = self.prospect.take().filter(|(of, _)| of == chance).map(|(_, prospect)| prospect);
        let prospect = known.unwrap_or_else(|| Arc::new(find(&self.foretold)));
        self.prospect = Some((chance.to_vec(), Arc::clone(&prospect)));
        prospect
    }
}

/// What was foretold of contexts that a search looked at, for the next. It follows from what is known, and is no part of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Foresight {
    /// Whose search it was; none before the first.
    body: Option<BodyId>,
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
    pub(crate) fn begin(&mut self, body: BodyId, kinds: &BTreeSet<TypeId>, goal: &BTreeSet<TypeId>) {
        if self.body != Some(body) || self.kinds != *kinds || self.goal != *goal {
            *self = Self { body: Some(body), kinds: kinds.clone(), goal: goal.clone(), ..Self::default() };
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
