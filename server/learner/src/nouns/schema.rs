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

/// A post-condition: an observation that is made after the action, or no longer made, and how often (II-A). `T` is an
/// [`ObservationId`] in a concrete schema and a [`Pattern`] in a generalised one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PostCondition<T> {
    /// The observation.
    pub what: T,
    /// True for "no longer": a pre-condition that the action takes away, called an absence.
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

/// An associated observation (II-B): made alongside the schema, neither needed nor caused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Association {
    /// The observation.
    pub observation: ObservationId,
    /// In how many executions it was there, of those since it was first there.
    pub count: Count,
    /// The step in which it was first there.
    pub since_step: u64,
}

/// So many numbers are gone through; more are put in order first.
const FEW: usize = 16;

/// Whether numbers are in a list, to be asked many times.
pub(crate) fn among(list: &[ObservationId]) -> impl Fn(ObservationId) -> bool + Clone + '_ {
    let ordered = (list.len() > FEW).then(|| {
        let mut ordered = list.to_vec();
        ordered.sort_unstable();
        ordered
    });
    move |id| match &ordered {
        Some(ordered) => ordered.binary_search(&id).is_ok(),
        None => list.contains(&id),
    }
}

/// The two forms of a schema.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Form {
    /// Observations / a primitive / observations.
    Concrete(Concrete),
    /// Patterns / a target action / patterns.
    Generalised(Box<Generalised>),
}

/// A concrete schema (II-D).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Concrete {
    /// The pre-conditions, in canonical order; none when the action has this effect in any context. Schemas with the same
    /// pre-conditions share the list.
    pub pre: Arc<[ObservationId]>,
    /// The primitive that is carried out.
    pub action: PrimitiveId,
    /// The post-conditions: those known at creation in canonical order, later ones after them; at most
    /// [`POST_CONDITIONS_MAX`].
    pub post: Vec<PostCondition<ObservationId>>,
    /// The generalised schema whose prediction failed here, if this is a counter-example.
    pub contradicts: Option<SchemaId>,
}

/// A generalised schema (II-E).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Generalised {
    /// The pre-conditions.
    pub pre: Box<[Pattern]>,
    /// The target action (II-E): the observations that are to be achieved, by whichever schema achieves them most surely.
    pub target: Box<[Pattern]>,
    /// The post-conditions.
    pub post: Vec<PostCondition<Pattern>>,
    /// The concrete schemas that this one represents, the first [`EXAMPLES_MAX`] of them.
    pub examples: Vec<SchemaId>,
    /// The concrete schemas that were made where it failed (IV-A), the first [`EXAMPLES_MAX`] of them.
    pub counter_examples: Vec<SchemaId>,
    /// Whether it is taken out of use, because its success rate has fallen below `Parameters::generalisation_share_min` for good.
    /// Its history stays.
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
    /// Its conditions and its action.
    pub form: Form,
    /// How often it was executed (trials), and how often all that it predicts happened (occurrences).
    pub executions: Count,
    /// The associated observations, the oldest first; at most [`ASSOCIATIONS_MAX`].
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
