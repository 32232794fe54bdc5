//! Schemas as the reference learner keeps them: both forms alike, observations in full.

use pschema_learner::observation::{Observation, Pattern, Substitution};
use pschema_learner::probability::Count;
use pschema_learner::schema::SchemaId;
use pschema_learner::vocabulary::PrimitiveId;

/// A post-condition; in a concrete schema the pattern has no variables.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Post {
    pub(crate) what: Pattern,
    pub(crate) absent: bool,
    pub(crate) count: Count,
}

/// A schema of either form: concrete if it has a primitive, generalised if it has a target.
#[derive(Clone, Debug)]
pub(crate) struct Schema {
    pub(crate) id: SchemaId,
    pub(crate) pre: Vec<Pattern>,
    pub(crate) action: Option<PrimitiveId>,
    pub(crate) target: Vec<Pattern>,
    pub(crate) post: Vec<Post>,
    pub(crate) executions: Count,
    /// With how often it was there, and the step in which it first was.
    pub(crate) associations: Vec<(Observation, Count, u64)>,
    pub(crate) examples: Vec<SchemaId>,
    pub(crate) counter_examples: Vec<SchemaId>,
    pub(crate) retired: bool,
    pub(crate) created_step: u64,
}

/// All variables replaced; every variable of a schema occurs in its pre-conditions, so all are bound.
pub(crate) fn put_in(pattern: &Pattern, binding: &Substitution) -> Observation {
    pattern.apply(binding).expect("a binding binds every variable of its schema")
}

impl Schema {
    /// The pre-conditions, in canonical order also where a binding puts another value first.
    pub(crate) fn pre(&self, binding: &Substitution) -> Vec<Observation> {
        let mut pre: Vec<_> = self.pre.iter().map(|pattern| put_in(pattern, binding)).collect();
        pre.sort();
        pre
    }

    /// The post-conditions that are observed, or with `absent` those no longer observed.
    pub(crate) fn outcomes(&self, binding: &Substitution, absent: bool) -> Vec<(Observation, Count)> {
        let chosen = self.post.iter().filter(|post| post.absent == absent);
        chosen.map(|post| (put_in(&post.what, binding), post.count)).collect()
    }

    /// Whether a post-condition is predicted: in a concrete schema, one that held in at least this share of
    /// trials; in a generalised schema, every one.
    pub(crate) fn predicts(&self, count: Count, ratio_min: f64) -> bool {
        self.action.is_none() || count.ratio() >= ratio_min
    }

    /// As [`Schema::outcomes`], but only those predicted.
    pub(crate) fn predicted(
        &self,
        binding: &Substitution,
        absent: bool,
        ratio_min: f64,
    ) -> Vec<(Observation, Count)> {
        let mut outcomes = self.outcomes(binding, absent);
        outcomes.retain(|(_, count)| self.predicts(*count, ratio_min));
        outcomes
    }
}
