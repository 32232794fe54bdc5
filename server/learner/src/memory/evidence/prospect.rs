//! What actions may make of a context, as far as anybody knows; and the same as it was found before.

use std::sync::{Arc, Weak};

use crate::memory::evidence::foretold::Foretold;
use crate::memory::evidence::pool::Pool;
use crate::nouns::observation::{Observation, TypeId};

/// What the actions of a body may make of a context.
pub(crate) struct Outlook {
    /// What is foretold of each primitive.
    pub(crate) prospects: Vec<Arc<Prospect>>,
    /// What is foretold of whether an episode has ended there: then nothing leads on, whatever is done.
    pub(crate) ending: Ending,
    /// The types that are left to chance: they change by themselves, nobody can say how, and the goal does not speak of them. They are
    /// taken to stay as they are.
    pub(crate) chance: Vec<TypeId>,
}

/// What is foretold of whether an episode has ended where something is there.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Ending {
    /// The probability that it has.
    pub(crate) probability: f64,
    /// How much may be learnt of that by being there, from 0 to 1.
    pub(crate) learnable: f64,
}

/// What a primitive may make of a context.
#[derive(Debug)]
pub(crate) struct Prospect {
    /// The observations of the types that were looked at, each with its probability. They may add up to less than 1: what never came
    /// may come.
    pub(crate) outcomes: Vec<(Vec<Observation>, f64)>,
    /// The probability that it is otherwise than foretold because it was never carried out where such things are: as often as what is new
    /// surprised.
    pub(crate) open: f64,
    /// How much may be learnt by it there, from 0 to 1: how often its action surprised of late, times how new it is there. Pairs of
    /// observations that are all familiar may be together for the first time, which counts for less.
    pub(crate) learnable: f64,
}

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
