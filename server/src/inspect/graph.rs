//! Memory as a graph: schemas, and what ties them together. Takes time in proportion to memory, and no more than a
//! limited number of schemas and ties is told one by one; the others stand together, counted.

mod around;
mod ties;
mod whole;

use std::collections::BTreeMap;

use pschema_inspect::{
    Graph, GraphCluster, GraphEdge, GraphNode, GraphQuery, GraphScope, Plan, SchemaSummary,
};
use pschema_learner::memory::Content;
use pschema_learner::observation::TypeId;
use pschema_learner::schema::{Form, ObservationId, Schema, SchemaId, signature};

use super::{goals, no_schema, schemas};
use crate::mind::View;
use ties::{Basis, Edges, Ties};

/// Schemas told one by one, at most.
const SHOWN_MAX: u32 = 5_000;
/// Ties away from a schema, at most.
const DEPTH_MAX: u32 = 8;

/// What belongs to a graph.
#[derive(Debug, Default)]
struct Picked {
    /// Schemas to be told one by one, by number.
    shown: Vec<SchemaId>,
    /// Schemas in its scope.
    total: u64,
    /// One after the other, in a chain.
    next: Vec<(SchemaId, SchemaId)>,
    /// Whether something was left out.
    truncated: bool,
}

/// The graph that is asked for.
///
/// # Errors
/// When there is no such schema, or no way to the goal is known or can be looked for: what to do instead.
pub(super) fn graph(view: &View, query: &GraphQuery) -> Result<Graph, String> {
    let limit = if query.limit == 0 { SHOWN_MAX } else { query.limit.min(SHOWN_MAX) };
    let limit = usize::try_from(limit).unwrap_or(usize::MAX);
    let content = &view.content;
    let mut probability = None;
    let mut goal = Vec::new();
    let (scope, picked) = match (query.around, query.goal.is_empty()) {
        (Some(_), false) => {
            return Err(
                "a graph is around a schema, or of the chain to a goal: ask for one of them".to_owned()
            );
        }
        (Some(id), true) => {
            content.schema(SchemaId(id)).ok_or_else(|| no_schema(view, id))?;
            let depth = query.depth.clamp(1, DEPTH_MAX);
            (GraphScope::Around, around::around(basis(view), SchemaId(id), depth, limit))
        }
        (None, false) => {
            let plan = goals::plan(view, &query.goal)?;
            probability = plan.probability;
            goal.clone_from(&plan.goal);
            (GraphScope::Goal, chain(&plan)?)
        }
        (None, true) => (GraphScope::All, whole::pick(content, limit)),
    };
    let Told { clusters, nodes, edges } = told(basis(view), &picked, scope == GraphScope::All);
    Ok(Graph {
        step: content.step,
        scope,
        around: query.around,
        goal,
        probability,
        nodes_total: picked.total,
        shown: count(picked.shown.len()),
        truncated: picked.truncated || edges.is_cut(),
        clusters,
        nodes,
        edges_total: edges.total,
        edges: edges.listed().map(|((from, to, kind), count)| GraphEdge { from, to, kind, count }).collect(),
    })
}

fn basis(view: &View) -> Basis<'_> {
    Basis { content: &view.content, ratio_min: view.parameters.prediction_ratio_min }
}

fn count(len: usize) -> u32 {
    u32::try_from(len).unwrap_or(u32::MAX)
}

/// The schemas of a plan, with what carries out the generalised ones among them.
fn chain(plan: &Plan) -> Result<Picked, String> {
    let steps: Vec<_> = plan.steps.iter().map(|step| &step.schema).collect();
    if steps.is_empty() {
        return Err(match plan.state.as_str() {
            "holds already" => "the goal holds already, so that there is no chain to it".to_owned(),
            state => format!("{state}: no chain of schemas to that goal is known from what is perceived now"),
        });
    }
    let carriers = steps.iter().filter_map(|step| step.carrier);
    let mut shown: Vec<_> = steps.iter().map(|step| step.id).chain(carriers).map(SchemaId).collect();
    shown.sort_unstable();
    shown.dedup();
    let pairs =
        steps.windows(2).filter_map(|pair| Some((SchemaId(pair.first()?.id), SchemaId(pair.get(1)?.id))));
    Ok(Picked { total: shown.len() as u64, shown, next: pairs.collect(), truncated: plan.search_truncated })
}

/// What belongs side by side: those with variables, and concrete ones by action, by the types of what they need and by those
/// of what they make.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Cluster {
    Concrete { action: usize, needed: Vec<TypeId>, made: Vec<TypeId> },
    Generalised,
}

impl Cluster {
    fn of(basis: Basis<'_>, schema: &Schema) -> Self {
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

    fn name(&self, content: &Content) -> String {
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

/// Where each schema is told: by itself, or with others.
struct Places<'a> {
    basis: Basis<'a>,
    shown: &'a [SchemaId],
    /// Those that stand together, by cluster and kind; the first is numbered after all that are shown.
    together: BTreeMap<(Cluster, &'static str), (u32, u64)>,
}

impl<'a> Places<'a> {
    fn new(basis: Basis<'a>, shown: &'a [SchemaId], with_the_rest: bool) -> Self {
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
    fn of(&self, id: SchemaId, schema: &Schema) -> Option<u32> {
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

fn numbered(content: &Content) -> impl Iterator<Item = (SchemaId, &Schema)> {
    content.schemas.iter().zip(0..).map(|(schema, at)| (SchemaId(at), schema))
}

struct Told {
    clusters: Vec<GraphCluster>,
    nodes: Vec<GraphNode>,
    edges: Edges,
}

/// Nodes in clusters, and what ties them.
fn told(basis: Basis<'_>, picked: &Picked, with_the_rest: bool) -> Told {
    let content = basis.content;
    let places = Places::new(basis, &picked.shown, with_the_rest);
    let shown: Vec<_> = picked.shown.iter().filter_map(|id| Some((*id, content.schema(*id)?))).collect();
    let mut members: BTreeMap<Cluster, u64> = BTreeMap::new();
    for (_, schema) in &shown {
        *members.entry(Cluster::of(basis, schema)).or_default() += 1;
    }
    for ((cluster, _), (_, count)) in &places.together {
        *members.entry(cluster.clone()).or_default() += count;
    }
    let number = |wanted: &Cluster| count(members.keys().take_while(|cluster| *cluster != wanted).count());
    let node = |schema: Option<SchemaSummary>, members, kind: &str, cluster: &Cluster| GraphNode {
        schema,
        members,
        kind: kind.to_owned(),
        cluster: number(cluster),
    };
    let single = shown.iter().map(|(id, schema)| {
        let summary = schemas::summary(content, id.0, schema);
        node(Some(summary), 1, schemas::kind(schema), &Cluster::of(basis, schema))
    });
    let several =
        places.together.iter().map(|((cluster, kind), (_, members))| node(None, *members, kind, cluster));
    let mut ties = Ties::new(basis, &places, &shown);
    ties.follow(&picked.next);
    ties.lineage();
    ties.among_shown();
    if !places.together.is_empty() {
        ties.with_the_rest();
    }
    let edges = ties.edges();
    Told {
        nodes: single.chain(several).collect(),
        clusters: members
            .iter()
            .map(|(cluster, members)| GraphCluster { name: cluster.name(content), members: *members })
            .collect(),
        edges,
    }
}
