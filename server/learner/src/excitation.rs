//! Schema excitation (paper, II-C, equation 1): how interesting a schema is in this world state.

use crate::association::is_associated;
use crate::bound::Bound;
use crate::decision::{Role, Term};
use crate::memory::Memory;
use crate::observation::{Observation, Substitution};
use crate::schema::SchemaId;
use crate::world_state::WorldState;

/// Calls `visit` with each term of equation (1)'s sum, in a fixed order: remembered observations as the
/// schema lists them (pre-conditions, then other post-conditions, then associated ones), and for each the
/// perceived ones in canonical order.
fn visit_terms(
    memory: &Memory,
    schema: SchemaId,
    binding: &Substitution,
    world: &WorldState,
    reliability: f64,
    mut visit: impl FnMut(&Observation, &Observation, Term),
) {
    let content = memory.content();
    let Some(bound) = Bound::new(content, schema, binding) else { return };
    let omega = memory.parameters().association_weight;
    let mut remembered: Vec<(Role, &Observation, f64, f64)> =
        bound.pre.iter().map(|o| (Role::PreCondition, o, 1.0, reliability)).collect();
    if memory.parameters().excite_by_post_conditions {
        // An observation that is both is one observation of the schema: it counts once.
        let post = bound.post.iter().filter(|post| !post.absent && !bound.pre.contains(&post.what));
        remembered.extend(post.map(|p| (Role::PostCondition, &p.what, p.count.ratio(), reliability)));
    }
    let associations = content.schema(schema).map_or(&[][..], |s| &s.associations);
    remembered.extend(
        associations
            .iter()
            .filter(|a| is_associated(memory, a))
            .map(|a| (Role::Association, content.observation(a.observation), 1.0, omega * reliability)),
    );
    for (role, observation, probability, weight) in remembered {
        let attention = memory.attention(observation);
        for seen in world.observations() {
            let shared = observation.shared(seen);
            if shared > 0 {
                let value = f64::from(shared) * probability * weight / (1.0 + f64::from(attention));
                let term = Term { role, pair: None, shared, attention, probability, weight, value };
                visit(observation, seen, term);
            }
        }
    }
}

/// The sum of equation (1), before it is divided by d.
pub(crate) fn sum(
    memory: &Memory,
    schema: SchemaId,
    binding: &Substitution,
    world: &WorldState,
    reliability: f64,
) -> f64 {
    let mut sum = 0.0;
    visit_terms(memory, schema, binding, world, reliability, |_, _, term| sum += term.value);
    sum
}

/// The terms of the sum, for explanation.
pub(crate) fn terms(
    memory: &Memory,
    schema: SchemaId,
    binding: &Substitution,
    world: &WorldState,
    reliability: f64,
) -> Vec<Term> {
    let mut terms = Vec::new();
    visit_terms(memory, schema, binding, world, reliability, |remembered, seen, term| {
        terms.push(Term { pair: Some((remembered.clone(), seen.clone())), ..term });
    });
    terms
}
