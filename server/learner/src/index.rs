//! What makes memory fast to ask. Everything here follows from the content and is never part of a digest.

use rustc_hash::FxHashMap;

use crate::memory::Content;
use crate::observation::{Observation, PropertyId, TypeId, Value};
use crate::parameters::TypeRules;
use crate::schema::{Form, ObservationId, SchemaId, signature};
use crate::vocabulary::PrimitiveId;

/// Inverted indexes over memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Index {
    ids: FxHashMap<Observation, ObservationId>,
    /// Observations that have this property with this value.
    by_value: FxHashMap<(PropertyId, Value), Vec<ObservationId>>,
    /// Concrete schemas that refer to an observation: as pre-condition, as post-condition, or either way
    /// or by association.
    by_observation: Vec<References>,
    /// Concrete schemas by exact pre-conditions and action.
    exact: FxHashMap<(Box<[ObservationId]>, PrimitiveId), SchemaId>,
    /// Concrete schemas by action.
    by_action: FxHashMap<PrimitiveId, Vec<SchemaId>>,
    /// Concrete schemas by the types of their pre-conditions.
    by_pre_types: FxHashMap<Vec<TypeId>, Vec<SchemaId>>,
    /// Concrete schemas without pre-conditions.
    unconditional: Vec<SchemaId>,
    /// Concrete schemas whose effect changes what may be a pre-condition: the edges of chains.
    context_changing: Vec<SchemaId>,
    /// Generalised schemas in use.
    generalised: Vec<SchemaId>,
    /// Generalised schemas taken out of use.
    retired: Vec<SchemaId>,
    /// Counts changes of the edges of chains, so that a search can be kept while nothing changed.
    edges_version: u64,
}

#[derive(Clone, Debug, Default)]
struct References {
    pre: Vec<SchemaId>,
    post: Vec<SchemaId>,
    any: Vec<SchemaId>,
}

fn insert(list: &mut Vec<SchemaId>, id: SchemaId) {
    if let Err(at) = list.binary_search(&id) {
        list.insert(at, id);
    }
}

impl Index {
    /// The indexes of `content`.
    pub(crate) fn build(content: &Content, rules: &TypeRules) -> Self {
        let mut index = Self::default();
        for (at, observation) in content.observations.iter().enumerate() {
            index.add_observation(observation, ObservationId(u32::try_from(at).unwrap_or(u32::MAX)));
        }
        for (at, schema) in content.schemas.iter().enumerate() {
            let id = SchemaId(u32::try_from(at).unwrap_or(u32::MAX));
            index.add_schema(id, content, rules);
            for association in &schema.associations {
                index.add_association(id, association.observation);
            }
            if schema.generalised().is_some_and(|generalised| generalised.retired) {
                index.retire(id);
            }
        }
        index
    }

    pub(crate) fn id(&self, observation: &Observation) -> Option<ObservationId> {
        self.ids.get(observation).copied()
    }

    pub(crate) fn add_observation(&mut self, observation: &Observation, id: ObservationId) {
        self.ids.insert(observation.clone(), id);
        for pair in observation.properties() {
            self.by_value.entry(*pair).or_default().push(id);
        }
        self.by_observation.push(References::default());
    }

    pub(crate) fn add_schema(&mut self, id: SchemaId, content: &Content, rules: &TypeRules) {
        let Some(schema) = content.schema(id) else { return };
        let Form::Concrete(concrete) = &schema.form else {
            insert(&mut self.generalised, id);
            self.edges_version += 1;
            return;
        };
        for observation in &concrete.pre {
            let references = &mut self.by_observation[observation.index()];
            insert(&mut references.pre, id);
            insert(&mut references.any, id);
        }
        self.exact.insert((concrete.pre.clone(), concrete.action), id);
        insert(self.by_action.entry(concrete.action).or_default(), id);
        let types = signature(concrete.pre.iter().map(|o| content.observation(*o).kind()));
        insert(self.by_pre_types.entry(types).or_default(), id);
        if concrete.pre.is_empty() {
            insert(&mut self.unconditional, id);
        }
        self.reindex_post(id, content, rules);
    }

    /// Takes over post-conditions that a schema has gained.
    pub(crate) fn reindex_post(&mut self, id: SchemaId, content: &Content, rules: &TypeRules) {
        let Some(concrete) = content.schema(id).and_then(|schema| schema.concrete()) else { return };
        let mut changes_context = false;
        for post in &concrete.post {
            let references = &mut self.by_observation[post.what.index()];
            if !post.absent {
                insert(&mut references.post, id);
                insert(&mut references.any, id);
            }
            let kind = content.observation(post.what).kind();
            changes_context |=
                rules.precondition(kind) && (post.absent || !concrete.pre.contains(&post.what));
        }
        if changes_context {
            insert(&mut self.context_changing, id);
            self.edges_version += 1;
        }
    }

    pub(crate) fn add_association(&mut self, id: SchemaId, observation: ObservationId) {
        insert(&mut self.by_observation[observation.index()].any, id);
    }

    pub(crate) fn forget_association(&mut self, id: SchemaId, observation: ObservationId) {
        let references = &mut self.by_observation[observation.index()];
        if references.pre.binary_search(&id).is_err()
            && references.post.binary_search(&id).is_err()
            && let Ok(at) = references.any.binary_search(&id)
        {
            references.any.remove(at);
        }
    }

    pub(crate) fn retire(&mut self, id: SchemaId) {
        if let Ok(at) = self.generalised.binary_search(&id) {
            self.generalised.remove(at);
            insert(&mut self.retired, id);
            self.edges_version += 1;
        }
    }

    /// Observations in memory that have this property with this value.
    pub(crate) fn with_value(&self, property: PropertyId, value: Value) -> &[ObservationId] {
        self.by_value.get(&(property, value)).map_or(&[], Vec::as_slice)
    }

    /// Concrete schemas that have the observation as a pre-condition.
    pub(crate) fn requiring(&self, observation: ObservationId) -> &[SchemaId] {
        self.by_observation.get(observation.index()).map_or(&[], |references| &references.pre)
    }

    /// Concrete schemas that have the observation as a post-condition (not as an absence).
    pub(crate) fn causing(&self, observation: ObservationId) -> &[SchemaId] {
        self.by_observation.get(observation.index()).map_or(&[], |references| &references.post)
    }

    /// Schemas of either form that refer to the observation in any way.
    pub(crate) fn referring(&self, observation: ObservationId) -> &[SchemaId] {
        self.by_observation.get(observation.index()).map_or(&[], |references| &references.any)
    }

    /// The concrete schema with just these pre-conditions (in canonical order) and this action.
    pub(crate) fn exact(&self, pre: &[&Observation], action: PrimitiveId) -> Option<SchemaId> {
        let ids: Option<Box<[_]>> = pre.iter().map(|observation| self.id(observation)).collect();
        self.exact.get(&(ids?, action)).copied()
    }

    /// Concrete schemas with this action.
    pub(crate) fn with_action(&self, action: PrimitiveId) -> &[SchemaId] {
        self.by_action.get(&action).map_or(&[], Vec::as_slice)
    }

    /// Concrete schemas whose pre-conditions are of these types.
    pub(crate) fn with_pre_types(&self, types: &[TypeId]) -> &[SchemaId] {
        self.by_pre_types.get(types).map_or(&[], Vec::as_slice)
    }

    pub(crate) fn unconditional(&self) -> &[SchemaId] {
        &self.unconditional
    }

    pub(crate) fn context_changing(&self) -> &[SchemaId] {
        &self.context_changing
    }

    pub(crate) fn generalised(&self) -> &[SchemaId] {
        &self.generalised
    }

    pub(crate) fn retired(&self) -> &[SchemaId] {
        &self.retired
    }

    /// Whether any schema may change a context.
    pub(crate) fn has_edges(&self) -> bool {
        !self.context_changing.is_empty() || !self.generalised.is_empty()
    }

    pub(crate) fn edges_version(&self) -> u64 {
        self.edges_version
    }
}
