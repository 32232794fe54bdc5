//! Schema excitation (paper, II-C, equation 1): how interesting a schema is in this world state.

use rustc_hash::FxHashMap;

use crate::cycle::association::is_associated;
use crate::memory::Memory;
use crate::memory::index::PairId;
use crate::memory::outline::Outline;
use crate::nouns::observation::{Observation, Pattern, PropertyId, Substitution, Value};
use crate::nouns::schema::{Form, ObservationId, PostCondition, SchemaId, among};
use crate::nouns::terms::Role;
use crate::nouns::terms::{Recollection, Weight, value};
use crate::nouns::world_state::WorldState;

/// How often each (property, value) pair is perceived: what an observation shares with all that is perceived is
/// the sum over its pairs, so that a crowded world costs no more for each remembered observation.
#[derive(Debug)]
pub(crate) struct PairCounts(FxHashMap<(PropertyId, Value), u32>);

impl PairCounts {
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
    fn value(&self, id: ObservationId, probability: f64, weight: Weight) -> f64 {
        match self.shared(id) {
            0 => 0.0,
            shared => {
                let attention = attention(self.memory, id);
                value(shared, attention, probability, weight.at(attention))
            }
        }
    }

    /// What pre-conditions that many schemas have in common add to the sum of each whose terms have this weight.
    pub(crate) fn of_pre(&self, pre: &[ObservationId], weight: Weight) -> f64 {
        pre.iter().fold(0.0, |sum, id| sum + self.value(*id, 1.0, weight))
    }

    /// The sum of equation (1) of a concrete schema, as [`sum`] gives it; `pre` is what its pre-conditions add.
    pub(crate) fn sum(&self, id: SchemaId, outline: &Outline, pre: f64, weight: Weight) -> f64 {
        let parameters = self.memory.parameters();
        let mut sum = pre;
        if parameters.excite_by_post_conditions {
            for (what, probability) in outline.post() {
                sum += self.value(what, probability, weight);
            }
        }
        if outline.associated != 0
            && let Some(schema) = self.memory.content().schema(id)
        {
            let weight = weight.times(parameters.association_weight);
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
pub(crate) struct LawExcitation<'a> {
    memory: &'a Memory,
    pub(crate) id: SchemaId,
    world: &'a WorldState,
    seen: &'a Percepts<'a>,
    /// Those of its post-conditions that may excite and are no pre-conditions under every binding.
    post: Vec<&'a PostCondition<Pattern>>,
    /// What it is associated with, under every binding.
    associated: Vec<ObservationId>,
}

/// What is perceived, by place: its number, how many values all that is perceived shares with it, and N(x).
#[derive(Debug)]
pub(crate) struct Percepts<'a> {
    perceived: &'a PairCounts,
    known: Vec<(Option<ObservationId>, u32, u32)>,
}

impl<'a> Percepts<'a> {
    pub(crate) fn new(memory: &Memory, world: &WorldState, perceived: &'a PairCounts) -> Self {
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

impl<'a> LawExcitation<'a> {
    pub(crate) fn new(
        memory: &'a Memory,
        id: SchemaId,
        world: &'a WorldState,
        seen: &'a Percepts<'a>,
    ) -> Option<Self> {
        let schema = memory.content().schema(id)?;
        let known = schema.generalised()?;
        let with_post = memory.parameters().excite_by_post_conditions;
        // What has no property shares none.
        let excites = |what: &Pattern| !what.terms().is_empty() && !known.pre.contains(what);
        let post = known.post.iter().filter(|p| with_post && !p.absent && excites(&p.what));
        let associated = schema.associations.iter().filter(|a| is_associated(memory, id, a));
        let associated = associated.map(|association| association.observation).collect();
        Some(Self { memory, id, world, seen, post: post.collect(), associated })
    }

    /// Its post-conditions under a binding, where they are no pre-conditions.
    fn post(&self, binding: &Substitution, places: &[usize]) -> impl Iterator<Item = (Observation, f64)> {
        let seen = self.world.observations();
        let is_pre = move |what: &Observation| places.iter().any(|at| seen.get(*at) == Some(what));
        let bound = self.post.iter().filter_map(|post| Some((post.what.apply(binding)?, post.count.ratio())));
        bound.filter(move |(what, _)| !is_pre(what))
    }

    /// The sum of equation (1), as [`sum`] gives it, under a binding by which its pre-conditions are what is perceived at
    /// `places`, which are ordered.
    pub(crate) fn sum(&self, binding: &Substitution, places: &[usize], weight: Weight) -> f64 {
        let mut sum = 0.0;
        let mut add = |shared: u32, attention: u32, probability: f64, weight: Weight| {
            if shared > 0 {
                sum += value(shared, attention, probability, weight.at(attention));
            }
        };
        for (_, shared, attention) in places.iter().filter_map(|at| self.seen.known.get(*at)) {
            add(*shared, *attention, 1.0, weight);
        }
        for (what, probability) in self.post(binding, places) {
            let shared = self.seen.perceived.shared(&what);
            let attention = if shared > 0 { self.memory.attention(&what) } else { 0 };
            add(shared, attention, probability, weight);
        }
        let weight = weight.times(self.memory.parameters().association_weight);
        for id in &self.associated {
            let observation = self.memory.content().observation(*id);
            add(self.seen.perceived.shared(observation), attention(self.memory, *id), 1.0, weight);
        }
        sum
    }

    /// What the sum is over, as [`remember`] lists it.
    pub(crate) fn remember(
        &self,
        binding: &Substitution,
        places: &[usize],
        weight: Weight,
        list: &mut Vec<Recollection>,
    ) {
        let mut add = |role, observation, attention, probability, weight: Weight| {
            let weight = weight.at(attention);
            list.push(Recollection { role, observation, attention, probability, weight });
        };
        for at in places {
            if let (Some(what), Some(seen)) = (self.world.observations().get(*at), self.seen.known.get(*at)) {
                add(Role::PreCondition, what.clone(), seen.2, 1.0, weight);
            }
        }
        for (what, probability) in self.post(binding, places) {
            let attention = self.memory.attention(&what);
            add(Role::PostCondition, what, attention, probability, weight);
        }
        let weight = weight.times(self.memory.parameters().association_weight);
        for id in &self.associated {
            let observation = self.memory.content().observation(*id).clone();
            add(Role::Association, observation, attention(self.memory, *id), 1.0, weight);
        }
    }
}

/// N of an observation that memory knows.
fn attention(memory: &Memory, id: ObservationId) -> u32 {
    memory.content().attention.get(id.index()).copied().unwrap_or(0)
}

/// Lists what a schema remembers, as it lists it: pre-conditions, then other post-conditions, then associated ones.
pub(crate) fn remember(
    memory: &Memory,
    schema: SchemaId,
    binding: &Substitution,
    weight: Weight,
    list: &mut Vec<Recollection>,
) {
    let content = memory.content();
    let Some(known) = content.schema(schema) else { return };
    let with_post = memory.parameters().excite_by_post_conditions;
    let mut add = |role, observation, attention, probability, weight: Weight| {
        let weight = weight.at(attention);
        list.push(Recollection { role, observation, attention, probability, weight });
    };
    match &known.form {
        Form::Concrete(concrete) => {
            let mut add = |role, id: ObservationId, probability| {
                add(role, content.observation(id).clone(), attention(memory, id), probability, weight);
            };
            concrete.pre.iter().for_each(|id| add(Role::PreCondition, *id, 1.0));
            // An observation that is both is one observation of the schema: it counts once.
            let is_pre = among(&concrete.pre);
            let post = concrete.post.iter().filter(|p| with_post && !p.absent && !is_pre(p.what));
            post.for_each(|p| add(Role::PostCondition, p.what, p.count.ratio()));
        }
        Form::Generalised(generalised) => {
            let mut pre: Vec<_> = generalised.pre.iter().filter_map(|what| what.apply(binding)).collect();
            pre.sort_unstable();
            let mut add = |role, observation: Observation, probability| {
                let attention = memory.attention(&observation);
                add(role, observation, attention, probability, weight);
            };
            // What is a pre-condition as a pattern is one under every binding, and needs no putting in.
            let post = generalised.post.iter().filter(|p| with_post && !p.absent);
            let post = post.filter(|p| !generalised.pre.contains(&p.what));
            let post = post.filter_map(|p| Some((p.what.apply(binding)?, p.count.ratio())));
            let post: Vec<_> = post.filter(|(what, _)| !pre.contains(what)).collect();
            pre.into_iter().for_each(|what| add(Role::PreCondition, what, 1.0));
            post.into_iter().for_each(|(what, probability)| add(Role::PostCondition, what, probability));
        }
    }
    let weight = weight.times(memory.parameters().association_weight);
    for association in known.associations.iter().filter(|a| is_associated(memory, schema, a)) {
        let id = association.observation;
        let observation = content.observation(id).clone();
        add(Role::Association, observation, attention(memory, id), 1.0, weight);
    }
}

/// The sum of equation (1), before it is divided by d.
pub(crate) fn sum(
    memory: &Memory,
    schema: SchemaId,
    binding: &Substitution,
    perceived: &PairCounts,
    weight: Weight,
) -> f64 {
    let mut remembered = Vec::new();
    remember(memory, schema, binding, weight, &mut remembered);
    let mut sum = 0.0;
    for known in &remembered {
        let shared = perceived.shared(&known.observation);
        if shared > 0 {
            sum += known.value(shared);
        }
    }
    sum
}
