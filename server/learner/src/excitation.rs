//! Schema excitation (paper, II-C, equation 1): how interesting a schema is in this world state.

use crate::association::is_associated;
use crate::bound::Bound;
use crate::decision::{Role, Term};
use crate::memory::Memory;
use crate::observation::{Observation, Substitution};
use crate::schema::{Form, ObservationId, SchemaId};
use crate::world_state::WorldState;

/// A remembered observation, as equation (1) weighs it.
struct Remembered<'a> {
    role: Role,
    observation: &'a Observation,
    attention: u32,
    probability: f64,
    weight: f64,
}

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
    let Some(known) = content.schema(schema) else { return };
    let mut each = |remembered: Remembered<'_>| {
        let Remembered { role, observation, attention, probability, weight } = remembered;
        for seen in world.observations() {
            let shared = observation.shared(seen);
            if shared > 0 {
                let value = f64::from(shared) * probability * weight / (1.0 + f64::from(attention));
                let term = Term { role, pair: None, shared, attention, probability, weight, value };
                visit(observation, seen, term);
            }
        }
    };
    let with_post = memory.parameters().excite_by_post_conditions;
    let attention = |id: ObservationId| content.attention.get(id.index()).copied().unwrap_or(0);
    match &known.form {
        // By number, without a copy: there may be very many of these.
        Form::Concrete(concrete) => {
            let mut known = |role, id, probability| {
                let observation = content.observation(id);
                each(Remembered {
                    role,
                    observation,
                    attention: attention(id),
                    probability,
                    weight: reliability,
                });
            };
            concrete.pre.iter().for_each(|id| known(Role::PreCondition, *id, 1.0));
            // An observation that is both is one observation of the schema: it counts once.
            let post =
                concrete.post.iter().filter(|p| with_post && !p.absent && !concrete.pre.contains(&p.what));
            post.for_each(|p| known(Role::PostCondition, p.what, p.count.ratio()));
        }
        Form::Generalised(_) => {
            let Some(bound) = Bound::new(content, schema, binding) else { return };
            let mut known = |role, observation, probability| {
                let attention = memory.attention(observation);
                each(Remembered { role, observation, attention, probability, weight: reliability });
            };
            bound.pre.iter().for_each(|observation| known(Role::PreCondition, observation, 1.0));
            let post = bound.post.iter().filter(|p| with_post && !p.absent && !bound.pre.contains(&p.what));
            post.for_each(|p| known(Role::PostCondition, &p.what, p.count.ratio()));
        }
    }
    let weight = memory.parameters().association_weight * reliability;
    for association in known.associations.iter().filter(|a| is_associated(memory, a)) {
        let id = association.observation;
        let observation = content.observation(id);
        let attention = attention(id);
        each(Remembered { role: Role::Association, observation, attention, probability: 1.0, weight });
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

/// The terms of the sum, for explanation: at most `room` of them, and the rest as one.
pub(crate) fn terms(
    memory: &Memory,
    schema: SchemaId,
    binding: &Substitution,
    world: &WorldState,
    reliability: f64,
    room: usize,
) -> Vec<Term> {
    let mut terms = Vec::new();
    let mut rest: Option<f64> = None;
    visit_terms(memory, schema, binding, world, reliability, |remembered, seen, term| {
        if terms.len() < room {
            terms.push(Term { pair: Some((remembered.clone(), seen.clone())), ..term });
        } else {
            *rest.get_or_insert(0.0) += term.value;
        }
    });
    terms.extend(rest.map(|value| Term {
        role: Role::Rest,
        pair: None,
        shared: 0,
        attention: 0,
        probability: 1.0,
        weight: 1.0,
        value,
    }));
    terms
}
