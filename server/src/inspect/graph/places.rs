//! The place of each schema in a graph: a node of its own, or a node with others of its cluster.

use std::collections::BTreeMap;

use pschema_inspect::SchemaKind;
use pschema_learner::memory::Content;
use pschema_learner::observation::TypeId;
use pschema_learner::schema::{Form, ObservationId, Schema, SchemaId, signature};

use super::super::schemas;
use super::basis::{Basis, count, numbered};

/// Schemas that belong side by side: all generalised ones; and concrete ones of the same action that need observations of
/// the same types and make observations of the same types.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Cluster {
    Concrete { action: usize, needed: Vec<TypeId>, made: Vec<TypeId> },
    Generalised,
}

impl Cluster {
    pub(super) fn of(basis: Basis<'_>, schema: &Schema) -> Self {
        let Form::Concrete(concrete) = &schema.form else { return Self::Generalised };
        let content = basis.content;
        let primitive = usize::try_from(concrete.action.0).ok();
        let primitive = primitive.and_then(|at| content.vocabulary.primitives().get(at));
        let kind = |id: ObservationId| content.observation(id).kind();
        let needed = signature(concrete.pre.iter().map(|id| kind(*id)));
        let mut made = signature(basis.made(concrete).map(kind));
        made.dedup();
        Self::Concrete { action: primitive.map_or(usize::MAX, |primitive| primitive.action), needed, made }
    }

    pub(super) fn name(&self, content: &Content) -> String {
        let Self::Concrete { action, needed, made } = self else { return "generalised".to_owned() };
        let vocabulary = &content.vocabulary;
        let action = vocabulary.actions().get(*action).map_or("?", |action| action.name.as_str());
        let names = |types: &[TypeId]| {
            let named = types.chunk_by(|a, b| a == b).map(|same| {
                let kind = same.first().and_then(|kind| vocabulary.types().get(usize::from(kind.0)));
                let name = kind.map_or("?", |kind| kind.declared.name.as_str());
                if same.len() > 1 { format!("{} {name}", same.len()) } else { name.to_owned() }
            });
            named.collect::<Vec<_>>().join(" and ")
        };
        let made = if made.is_empty() { "nothing new".to_owned() } else { names(made) };
        let needed = if needed.is_empty() {
            "whatever is perceived".to_owned()
        } else {
            format!("given {}", names(needed))
        };
        format!("{action} for {made}, {needed}")
    }
}

/// The node of each schema.
pub(super) struct Places<'a> {
    basis: Basis<'a>,
    pub(super) shown: &'a [SchemaId],
    /// The nodes that stand for several schemas, by cluster and kind, with their numbers and sizes. They are numbered after
    /// the nodes of single schemas.
    pub(super) together: BTreeMap<(Cluster, SchemaKind), (u32, u64)>,
}

impl<'a> Places<'a> {
    pub(super) fn new(basis: Basis<'a>, shown: &'a [SchemaId], with_the_rest: bool) -> Self {
        let content = basis.content;
        let mut places = Self { basis, shown, together: BTreeMap::new() };
        if with_the_rest && shown.len() < content.schemas.len() {
            for (id, schema) in numbered(content) {
                if shown.binary_search(&id).is_err() {
                    let key = (Cluster::of(basis, schema), schemas::kind(schema));
                    places.together.entry(key).or_default().1 += 1;
                }
            }
            for (at, (place, _)) in places.together.values_mut().enumerate() {
                *place = count(shown.len() + at);
            }
        }
        places
    }

    /// The node of a schema; none when it is left out.
    pub(super) fn of(&self, id: SchemaId, schema: &Schema) -> Option<u32> {
        match self.shown.binary_search(&id) {
            Ok(at) => Some(count(at)),
            Err(_) if self.together.is_empty() => None,
            Err(_) => {
                let key = (Cluster::of(self.basis, schema), schemas::kind(schema));
                self.together.get(&key).map(|(place, _)| *place)
            }
        }
    }
}
