//! The observations that schemas need and make, from which their ties follow.

use pschema_learner::memory::Content;
use pschema_learner::observation::{Observation, Pattern, Term};
use pschema_learner::schema::{Concrete, Generalised, ObservationId, Schema, SchemaId};

/// Most comparisons of a pattern with an observation, and most ties counted, in one graph: some tenths of a second.
pub(super) const COMPARISONS_MAX: usize = 20_000_000;

/// Schemas in the scope of a graph.
#[derive(Debug, Default)]
pub(super) struct Selection {
    /// Schemas that are listed one by one, by number.
    pub(super) shown: Vec<SchemaId>,
    /// How many schemas are in the scope.
    pub(super) total: u64,
    /// Pairs of schemas that follow each other in a chain.
    pub(super) next: Vec<(SchemaId, SchemaId)>,
    /// Whether schemas of the scope were left out.
    pub(super) truncated: bool,
}

/// The memory and the threshold from which ties follow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Basis<'a> {
    pub(super) content: &'a Content,
    /// The share of the executions from which on an outcome is predicted.
    pub(super) ratio_min: f64,
}

impl Basis<'_> {
    /// The observations that the schema predicts and does not need itself.
    pub(super) fn made<'c>(self, concrete: &'c Concrete) -> impl Iterator<Item = ObservationId> + use<'c> {
        let predicted = concrete.post.iter().filter(move |p| !p.absent && p.count.ratio() >= self.ratio_min);
        predicted.map(|post| post.what).filter(|what| !concrete.pre.contains(what))
    }
}

/// As [`Basis::made`], for a law: it predicts all of its outcomes.
pub(super) fn made_by_law(law: &Generalised) -> impl Iterator<Item = &Pattern> {
    law.post.iter().filter(|post| !post.absent).map(|post| &post.what).filter(|what| !law.pre.contains(what))
}

/// Whether the pattern matches the observation by itself.
pub(super) fn may_be(pattern: &Pattern, observation: &Observation) -> bool {
    let (terms, properties) = (pattern.terms(), observation.properties());
    let agree = |(property, term): &(_, Term), (seen, value): &(_, _)| {
        property == seen && !matches!(term, Term::Constant(constant) if constant != value)
    };
    pattern.kind() == observation.kind()
        && terms.len() == properties.len()
        && terms.iter().zip(properties).all(|(wanted, seen)| agree(wanted, seen))
}

/// Whether both patterns match some observation, each by itself.
pub(super) fn may_both_be(a: &Pattern, b: &Pattern) -> bool {
    let constant = |term: &Term| matches!(term, Term::Constant(_));
    a.kind() == b.kind()
        && a.terms().len() == b.terms().len()
        && a.terms().iter().zip(b.terms()).all(|((property, one), (other_property, other))| {
            property == other_property && (!constant(one) || !constant(other) || one == other)
        })
}

/// A number of nodes or schemas, as it travels.
pub(super) fn count(len: usize) -> u32 {
    u32::try_from(len).unwrap_or(u32::MAX)
}

/// The schemas of memory with their numbers.
pub(super) fn numbered(content: &Content) -> impl Iterator<Item = (SchemaId, &Schema)> {
    content.schemas.iter().zip(0..).map(|(schema, at)| (SchemaId(at), schema))
}
