//! Schema excitation (paper, II-C, equation 1): how interesting a schema is in this world state.

use rustc_hash::FxHashMap;

use crate::association::is_associated;
use crate::bound::Bound;
use crate::decision::{Role, Term};
use crate::index::PairId;
use crate::memory::Memory;
use crate::observation::{Observation, PropertyId, Substitution, Value};
use crate::outline::Outline;
use crate::schema::{Form, ObservationId, SchemaId};
use crate::world_state::WorldState;

/// A remembered observation, as equation (1) weighs it.
#[derive(Clone, Copy)]
struct Remembered<'a> {
    role: Role,
    observation: &'a Observation,
    attention: u32,
    probability: f64,
    weight: f64,
}

impl Remembered<'_> {
    /// What it adds to the sum when it shares so many values with what is perceived.
    fn value(&self, shared: f64) -> f64 {
        shared * self.probability * self.weight / (1.0 + f64::from(self.attention))
    }
}

/// How often each (property, value) pair is perceived: what an observation shares with all that is perceived is
/// the sum over its pairs, so that a crowded world costs no more for each remembered observation.
#[derive(Debug)]
pub(crate) struct Perceived(FxHashMap<(PropertyId, Value), u32>);

impl Perceived {
    pub(crate) fn new(world: &WorldState) -> Self {
        let mut pairs = FxHashMap::default();
        for pair in world.observations().iter().flat_map(|observation| observation.properties()) {
            *pairs.entry(*pair).or_insert(0) += 1;
        }
        Self(pairs)
    }

    fn shared(&self, observation: &Observation) -> u32 {
        observation.properties().iter().filter_map(|pair| self.0.get(pair)).sum()
    }
}

/// What remembered observations share with what is perceived, looked up for those that are asked for: what a memory
/// knows besides costs nothing.
#[derive(Debug)]
pub(crate) struct Resemblance<'a> {
    memory: &'a Memory,
    /// Pairs that are perceived and that anything remembered has, each with how often.
    pairs: Vec<(PairId, u32)>,
}

impl<'a> Resemblance<'a> {
    pub(crate) fn new(memory: &'a Memory, world: &WorldState) -> Self {
        let all = world.observations().iter().flat_map(|o| o.properties());
        let mut all: Vec<_> = all.filter_map(|(p, value)| memory.index().pair(*p, *value)).collect();
        all.sort_unstable();
        let counted = all
            .chunk_by(|a, b| a == b)
            .filter_map(|equal| Some((*equal.first()?, u32::try_from(equal.len()).unwrap_or(u32::MAX))));
        Self { memory, pairs: counted.collect() }
    }

    /// How many values it shares.
    fn shared(&self, id: ObservationId) -> u32 {
        let mut shared = 0;
        for pair in self.memory.index().pairs_of(id) {
            for (perceived, times) in &self.pairs {
                shared += if perceived == pair { *times } else { 0 };
            }
        }
        shared
    }

    /// What `id` adds to the sum of equation (1).
    fn value(&self, id: ObservationId, probability: f64, weight: f64) -> f64 {
        match self.shared(id) {
            0 => 0.0,
            shared => {
                let attention = self.memory.content().attention.get(id.index()).copied().unwrap_or(0);
                f64::from(shared) * probability * weight / (1.0 + f64::from(attention))
            }
        }
    }

    /// What pre-conditions that many schemas have in common add to the sum of each whose action has this reliability.
    pub(crate) fn of_pre(&self, pre: &[ObservationId], reliability: f64) -> f64 {
        pre.iter().fold(0.0, |sum, id| sum + self.value(*id, 1.0, reliability))
    }

    /// The sum of equation (1) of a concrete schema, as [`sum`] gives it; `pre` is what its pre-conditions add.
    pub(crate) fn sum(&self, id: SchemaId, outline: &Outline, pre: f64, reliability: f64) -> f64 {
        let parameters = self.memory.parameters();
        let mut sum = pre;
        if parameters.excite_by_post_conditions {
            for (what, probability) in outline.post() {
                sum += self.value(what, probability, reliability);
            }
        }
        if outline.associated
            && let Some(schema) = self.memory.content().schema(id)
        {
            let weight = parameters.association_weight * reliability;
            for association in &schema.associations {
                let what = association.observation;
                if self.shared(what) > 0 && is_associated(self.memory, id, association) {
                    sum += self.value(what, 1.0, weight);
                }
            }
        }
        sum
    }
}

/// Calls `each` with the remembered observations as the schema lists them: pre-conditions, then other
/// post-conditions, then associated ones.
fn visit(
    memory: &Memory,
    schema: SchemaId,
    binding: &Substitution,
    reliability: f64,
    mut each: impl FnMut(Remembered<'_>),
) {
    let content = memory.content();
    let Some(known) = content.schema(schema) else { return };
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
    for association in known.associations.iter().filter(|a| is_associated(memory, schema, a)) {
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
    perceived: &Perceived,
    reliability: f64,
) -> f64 {
    let mut sum = 0.0;
    visit(memory, schema, binding, reliability, |remembered| {
        let shared = perceived.shared(remembered.observation);
        if shared > 0 {
            sum += remembered.value(f64::from(shared));
        }
    });
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
    visit(memory, schema, binding, reliability, |remembered| {
        for seen in world.observations() {
            let shared = remembered.observation.shared(seen);
            if shared == 0 {
                continue;
            }
            let value = remembered.value(f64::from(shared));
            if terms.len() < room {
                let Remembered { role, observation, attention, probability, weight } = remembered;
                let pair = Some((observation.clone(), seen.clone()));
                terms.push(Term { role, pair, shared, attention, probability, weight, value });
            } else {
                *rest.get_or_insert(0.0) += value;
            }
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
