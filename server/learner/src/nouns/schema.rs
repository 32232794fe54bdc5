//! Schemas: pre-conditions / action / post-conditions, with what experience says of each (paper, II).

use std::sync::Arc;

use rustc_hash::FxHashSet;

use crate::nouns::observation::{Observation, Pattern, Substitution, TypeId};
use crate::nouns::probability::Count;
use crate::nouns::vocabulary::PrimitiveId;

/// A schema in memory, numbered from 0 in the order of creation. Nothing is ever deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SchemaId(pub u32);

impl SchemaId {
    /// As an index.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// An observation that memory refers to, numbered in the order of first mention.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObservationId(pub u32);

impl ObservationId {
    /// As an index.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A post-condition: what is seen after the action, or no longer seen, and how often (II-A). `T` is an
/// [`ObservationId`] in a concrete schema and a [`Pattern`] in a generalised one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PostCondition<T> {
    /// What is observed.
    pub what: T,
    /// True for "no longer": a pre-condition that the action takes away.
    pub absent: bool,
    /// In how many executions it held, of those in which its sense was not constrained.
    pub count: Count,
}

impl<T> PostCondition<T> {
    /// The same of something else that is observed.
    pub(crate) fn of<U>(&self, what: U) -> PostCondition<U> {
        PostCondition { what, absent: self.absent, count: self.count }
    }
}

/// An associated observation (II-B): seen alongside, neither needed nor caused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Association {
    /// What is observed.
    pub observation: ObservationId,
    /// In how many executions it was there, of those since it was first there.
    pub count: Count,
    /// The step in which it was first there.
    pub since_step: u64,
}

/// What a schema says.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Form {
    /// Observations / a primitive / observations.
    Concrete(Concrete),
    /// Patterns / a target action / patterns.
    Generalised(Box<Generalised>),
}

/// A concrete schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Concrete {
    /// What must hold, in canonical order; empty when the action has this effect in any context. Schemas with the same
    /// pre-conditions share them.
    pub pre: Arc<[ObservationId]>,
    /// What is done.
    pub action: PrimitiveId,
    /// What is then observed: those known at creation in canonical order, later outcomes after them.
    pub post: Vec<PostCondition<ObservationId>>,
    /// The generalised schema whose prediction failed here, if this is a counter-example.
    pub contradicts: Option<SchemaId>,
}

/// A generalised schema (II-E).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Generalised {
    /// What must hold.
    pub pre: Box<[Pattern]>,
    /// The target action: what is to be achieved, by whatever schema does it best.
    pub target: Box<[Pattern]>,
    /// What is then observed.
    pub post: Vec<PostCondition<Pattern>>,
    /// Concrete schemas that this one represents.
    pub examples: Vec<SchemaId>,
    /// Concrete schemas made where it failed.
    pub counter_examples: Vec<SchemaId>,
    /// Taken out of use: its success rate has fallen below the threshold for good. Its history stays.
    pub retired: bool,
}

impl Generalised {
    /// The observations to be achieved under `binding`; none if it leaves a variable unbound.
    pub(crate) fn target_under(&self, binding: &Substitution) -> Option<Vec<Observation>> {
        self.target.iter().map(|pattern| pattern.apply(binding)).collect()
    }
}

/// A schema with its statistics.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schema {
    /// What it says.
    pub form: Form,
    /// Executions (trials) and successes (occurrences): all it predicts happened.
    pub executions: Count,
    /// Associated observations, the oldest first.
    pub associations: Vec<Association>,
    /// The schema whose execution led to this one, if any.
    pub parent: Option<SchemaId>,
    /// The step that made it.
    pub created_step: u64,
}

/// The pre-conditions of schemas that come from elsewhere, to be shared as in a memory that was lived through: most of a
/// million schemas have them in common.
#[derive(Debug, Default)]
pub struct PreConditionInterner(FxHashSet<Arc<[ObservationId]>>);

impl PreConditionInterner {
    /// Has the schema share its pre-conditions with those given before it.
    pub fn share(&mut self, schema: &mut Schema) {
        let Form::Concrete(concrete) = &mut schema.form else { return };
        match self.0.get(&concrete.pre) {
            Some(known) => concrete.pre = known.clone(),
            None => drop(self.0.insert(concrete.pre.clone())),
        }
    }
}

/// Schemas that one memory holds; at the limit nothing more is created, and what is known goes on being scored.
pub const SCHEMAS_MAX: usize = 50_000_000;
/// Associated observations that one schema keeps; beyond it the rarest makes room.
pub const ASSOCIATIONS_MAX: usize = 32;
/// Post-conditions that one schema keeps, alternative outcomes included; later ones are not taken.
pub const POST_CONDITIONS_MAX: usize = 4_096;
/// Examples and counter-examples that a generalised schema lists; more are only counted.
pub const EXAMPLES_MAX: usize = 1_024;

impl Schema {
    /// The concrete form, if it is concrete.
    #[must_use]
    pub fn concrete(&self) -> Option<&Concrete> {
        match &self.form {
            Form::Concrete(concrete) => Some(concrete),
            Form::Generalised(_) => None,
        }
    }

    /// The generalised form, if it is generalised.
    #[must_use]
    pub fn generalised(&self) -> Option<&Generalised> {
        match &self.form {
            Form::Generalised(generalised) => Some(generalised),
            Form::Concrete(_) => None,
        }
    }
}

/// The types of a list of observations, ordered, each as often as it occurs: schemas are similar when
/// they have "the same number of the same type of observations" (II-E).
#[must_use]
pub fn signature(kinds: impl IntoIterator<Item = TypeId>) -> Vec<TypeId> {
    let mut kinds: Vec<_> = kinds.into_iter().collect();
    kinds.sort_unstable();
    kinds
}
