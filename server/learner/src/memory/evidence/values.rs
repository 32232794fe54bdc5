//! What comes of values: numbers that come with frames and may be wanted. They are foretold like all else, each type in a facet of its
//! own. But the learner does not live by them: what it learns of all else, and when, is the same with them and without them. So their
//! facets stand apart from the others, which never see them.

use std::sync::Arc;

use crate::memory::evidence::facet::Facet;
use crate::nouns::observation::TypeId;
use crate::nouns::vocabulary::Vocabulary;

/// The types that are values, and what is known of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Values {
    /// In order.
    kinds: Arc<[TypeId]>,
    /// A facet for each that was met.
    pub(super) facets: Vec<Facet>,
}

impl Values {
    /// Of these types nothing is known yet.
    pub(super) fn of(kinds: &Arc<[TypeId]>) -> Self {
        Self { kinds: Arc::clone(kinds), facets: Vec::new() }
    }

    /// Takes note of which types are values: bodies declare them in the course of a life.
    pub(super) fn know(&mut self, vocabulary: &Vocabulary) {
        if !vocabulary.values().eq(self.kinds.iter().copied()) {
            self.kinds = vocabulary.values().collect();
        }
    }

    /// The types that are values.
    pub(super) fn kinds(&self) -> &Arc<[TypeId]> {
        &self.kinds
    }

    /// Whether a type is one of them.
    pub(super) fn has(&self, kind: TypeId) -> bool {
        self.kinds.binary_search(&kind).is_ok()
    }
}
