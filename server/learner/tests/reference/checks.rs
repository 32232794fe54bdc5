//! What must hold of any step and of any memory.

use proptest::prelude::*;
use pschema_learner::Frame;
use pschema_learner::decision::{CANDIDATES_KEPT_MAX, Decision, Reason};
use pschema_learner::execution::Execution;
use pschema_learner::memory::Content;
use pschema_learner::observation::{Observation, Substitution};
use pschema_learner::probability::Count;
use pschema_learner::schema::{ASSOCIATIONS_MAX, Form, POST_CONDITIONS_MAX, SchemaId};
use pschema_learner::world_state::WorldState;

/// What a schema refers to under a binding, as far as attention may rise by it.
fn mentions(content: &Content, schema: SchemaId, binding: &Substitution, wanted: &Observation) -> bool {
    let schema = content.schema(schema).unwrap();
    let is = |observation: &Option<Observation>| observation.as_ref() == Some(wanted);
    let condition = match &schema.form {
        Form::Concrete(concrete) => {
            let post = concrete.post.iter().filter(|post| !post.absent).map(|post| &post.what);
            concrete.pre.iter().chain(post).any(|id| content.observation(*id) == wanted)
        }
        Form::Generalised(generalised) => {
            let post = generalised.post.iter().filter(|post| !post.absent).map(|post| &post.what);
            generalised.pre.iter().chain(post).any(|pattern| is(&pattern.apply(binding)))
        }
    };
    condition || schema.associations.iter().any(|a| content.observation(a.observation) == wanted)
}

/// Attention may rise only for what was perceived while a schema that refers to it was executed, or for a
/// schema just made where none was. Everything else is a bystander.
pub(crate) fn only_what_was_attended(
    frame: &Frame,
    execution: &Execution,
    before: &Content,
    after: &Content,
) -> Result<(), TestCaseError> {
    let made = before.schemas.len()..after.schemas.len();
    let seen = WorldState::new(frame.observations.iter().cloned());
    let seen = after.perceived(frame.body, &seen);
    for (at, (observation, n)) in after.observations.iter().zip(after.attention.iter()).enumerate() {
        let earlier = before.attention.get(at).copied().unwrap_or(0);
        prop_assert!(*n == earlier || *n == earlier + 1, "N({observation:?}) from {earlier} to {n}");
        if *n > earlier {
            let perceived = seen.contains(observation) || execution.before.contains(observation);
            let none = Substitution::new();
            let referring = match execution.schema {
                Some(schema) => {
                    mentions(after, schema, &execution.binding, observation)
                        || execution.carrier.is_some_and(|r| mentions(after, r, &none, observation))
                }
                // Another body may have made the schema for this primitive meanwhile.
                None => (0..made.end)
                    .any(|s| mentions(after, SchemaId(u32::try_from(s).unwrap()), &none, observation)),
            };
            prop_assert!(perceived && referring, "{observation:?} was only a bystander of {execution:?}");
        }
    }
    Ok(())
}

/// Every candidate's excitation is what its terms add up to, and the chosen one is among the most exciting.
pub(crate) fn explained(decision: &Decision) -> Result<(), TestCaseError> {
    let Decision { candidates, candidates_total, chosen, ties, reason, .. } = decision;
    prop_assert!(candidates.len() <= CANDIDATES_KEPT_MAX && candidates.len() <= *candidates_total);
    let top = candidates.iter().map(|c| c.excitation).fold(f64::NEG_INFINITY, f64::max);
    for candidate in candidates {
        let sum: f64 = candidate.terms.iter().map(|term| term.value).sum();
        let expected = sum / f64::from(candidate.distance);
        let error = (candidate.excitation - expected).abs();
        prop_assert!(error <= 1e-12 * expected.abs().max(1.0), "{candidate:?}: the terms give {expected}");
        for term in candidate.terms.iter().filter(|term| term.pair.is_some()) {
            let value = f64::from(term.shared) * term.probability * term.weight;
            let value = value / (1.0 + f64::from(term.attention));
            prop_assert!((term.value - value).abs() <= 1e-12, "{term:?}: equation 1 gives {value}");
        }
    }
    if decision.goal.is_some() || *reason == Reason::Goal {
        let goal = decision.goal.as_ref().filter(|_| *reason == Reason::Goal);
        let goal = goal.ok_or_else(|| TestCaseError::fail("a goal is a reason of its own"))?;
        // A chain has the schema in it; a policy begins with what is done.
        let follows = match goal.course.first() {
            Some(first) => goal.chain.is_empty() && *first == decision.action,
            None => goal.at < goal.chain.len(),
        };
        prop_assert!(follows && !goal.goal.patterns().is_empty(), "{goal:?}");
        // Where an episode ended nothing leads on, and anything is done for the next to begin.
        let waits = goal.probability == 0.0 && goal.course.len() == 1;
        prop_assert!(waits || goal.probability > 0.0 && goal.probability <= 1.0, "{goal:?}");
    } else if *reason != Reason::Chain {
        prop_assert_eq!(candidates[*chosen].excitation, top, "less exciting than another");
        let equal = candidates.iter().filter(|c| c.excitation == top).count();
        let all_kept = candidates.len() == *candidates_total;
        prop_assert!(equal == *ties || (!all_kept && equal <= *ties), "{equal} tie, not {ties}");
        prop_assert_eq!(*reason == Reason::Tie, *ties > 1);
    }
    Ok(())
}

/// Nothing happened more often than it was tried, and the limits hold.
pub(crate) fn counted(content: &Content) -> Result<(), TestCaseError> {
    let possible = |count: Count| count.occurrences <= count.trials;
    for schema in content.schemas.iter() {
        let (counts, post): (Vec<_>, _) = match &schema.form {
            Form::Concrete(c) => (c.post.iter().map(|p| p.count).collect(), c.post.len()),
            Form::Generalised(g) => (g.post.iter().map(|p| p.count).collect(), g.post.len()),
        };
        let associated = schema.associations.iter().map(|a| a.count);
        let all = counts.into_iter().chain(associated).chain([schema.executions]);
        prop_assert!(all.into_iter().all(possible), "more occurrences than trials: {schema:?}");
        prop_assert!(schema.associations.len() <= ASSOCIATIONS_MAX && post <= POST_CONDITIONS_MAX);
    }
    prop_assert!(content.attempts.iter().copied().all(possible));
    Ok(())
}
