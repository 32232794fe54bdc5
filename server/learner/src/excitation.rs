//! Schema excitation (paper, II-C, equation 1): how interesting a schema is in this world state.

use rustc_hash::FxHashMap;

use crate::association::is_associated;
use crate::decision::{Role, Term};
use crate::index::PairId;
use crate::memory::Memory;
use crate::observation::{Observation, Pattern, PropertyId, Substitution, Value};
use crate::outline::Outline;
use crate::schema::{Form, ObservationId, PostCondition, Schema, SchemaId};
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
    pairs: FxHashMap<PairId, u32>,
}

impl<'a> Resemblance<'a> {
    pub(crate) fn new(memory: &'a Memory, world: &WorldState) -> Self {
        let mut pairs = FxHashMap::default();
        for (property, value) in world.observations().iter().flat_map(|o| o.properties()) {
            if let Some(pair) = memory.index().pair(*property, *value) {
                *pairs.entry(pair).or_insert(0) += 1;
            }
        }
        Self { memory, pairs }
    }

    /// How many values it shares.
    fn shared(&self, id: ObservationId) -> u32 {
        self.memory.index().pairs_of(id).iter().filter_map(|pair| self.pairs.get(pair)).sum()
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
        if outline.associated != 0
            && let Some(schema) = self.memory.content().schema(id)
        {
            let weight = parameters.association_weight * reliability;
            let may =
                schema.associations.iter().enumerate().filter(|(at, _)| outline.associated >> at & 1 == 1);
            for (_, association) in may {
                let what = association.observation;
                if self.shared(what) > 0 && is_associated(self.memory, id, association) {
                    sum += self.value(what, 1.0, weight);
                }
            }
        }
        sum
    }
}

/// A generalised schema where it is to be weighed under one binding after another: what it refers to are mostly observations
/// that are perceived, and these are looked up once.
pub(crate) struct Generally<'a> {
    memory: &'a Memory,
    id: SchemaId,
    schema: &'a Schema,
    world: &'a WorldState,
    seen: &'a Seen<'a>,
    /// Those of its post-conditions that may excite and are no pre-conditions under every binding.
    post: Vec<&'a PostCondition<Pattern>>,
}

/// What is perceived, by place: its number, how many values all that is perceived shares with it, and N(x).
#[derive(Debug)]
pub(crate) struct Seen<'a> {
    perceived: &'a Perceived,
    known: Vec<(Option<ObservationId>, u32, u32)>,
}

impl<'a> Seen<'a> {
    pub(crate) fn new(memory: &Memory, world: &WorldState, perceived: &'a Perceived) -> Self {
        let known = world.observations().iter().map(|observation| {
            let id = memory.index().id(observation);
            let attention = id.and_then(|id| memory.content().attention.get(id.index())).copied();
            (id, perceived.shared(observation), attention.unwrap_or(0))
        });
        Self { perceived, known: known.collect() }
    }

    /// The numbers of what is at these places; none if one has none.
    pub(crate) fn ids(&self, places: &[usize]) -> Option<Vec<ObservationId>> {
        places.iter().map(|at| self.known.get(*at)?.0).collect()
    }
}

impl<'a> Generally<'a> {
    pub(crate) fn new(
        memory: &'a Memory,
        id: SchemaId,
        world: &'a WorldState,
        seen: &'a Seen<'a>,
    ) -> Option<Self> {
        let schema = memory.content().schema(id)?;
        let known = schema.generalised()?;
        let with_post = memory.parameters().excite_by_post_conditions;
        let post = known.post.iter().filter(|p| with_post && !p.absent && !known.pre.contains(&p.what));
        Some(Self { memory, id, schema, world, seen, post: post.collect() })
    }

    /// The sum of equation (1), as [`sum`] gives it, under a binding by which its pre-conditions are what is perceived at
    /// `places`, which are ordered.
    pub(crate) fn sum(&self, binding: &Substitution, places: &[usize], reliability: f64) -> f64 {
        let mut sum = 0.0;
        let mut add = |shared: u32, attention: u32, probability: f64, weight: f64| {
            if shared > 0 {
                sum += f64::from(shared) * probability * weight / (1.0 + f64::from(attention));
            }
        };
        for (_, shared, attention) in places.iter().filter_map(|at| self.seen.known.get(*at)) {
            add(*shared, *attention, 1.0, reliability);
        }
        for post in &self.post {
            let Some(what) = post.what.apply(binding) else { continue };
            let mut pre = places.iter().filter_map(|at| self.world.observations().get(*at));
            if !pre.any(|known| *known == what) {
                let shared = self.seen.perceived.shared(&what);
                add(shared, self.memory.attention(&what), post.count.ratio(), reliability);
            }
        }
        let weight = self.memory.parameters().association_weight * reliability;
        let associations = self.schema.associations.iter();
        for association in associations.filter(|a| is_associated(self.memory, self.id, a)) {
            let observation = self.memory.content().observation(association.observation);
            let attention = self.memory.content().attention.get(association.observation.index());
            add(self.seen.perceived.shared(observation), attention.copied().unwrap_or(0), 1.0, weight);
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
        Form::Generalised(generalised) => {
            let mut pre: Vec<_> = generalised.pre.iter().filter_map(|what| what.apply(binding)).collect();
            pre.sort_unstable();
            let mut known = |role, observation: &Observation, probability| {
                let attention = memory.attention(observation);
                each(Remembered { role, observation, attention, probability, weight: reliability });
            };
            pre.iter().for_each(|observation| known(Role::PreCondition, observation, 1.0));
            // What is a pre-condition as a pattern is one under every binding, and needs no putting in.
            let post = generalised.post.iter().filter(|p| with_post && !p.absent);
            for p in post.filter(|p| !generalised.pre.contains(&p.what)) {
                if let Some(what) = p.what.apply(binding).filter(|what| !pre.contains(what)) {
                    known(Role::PostCondition, &what, p.count.ratio());
                }
            }
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
