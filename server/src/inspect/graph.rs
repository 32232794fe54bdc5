//! Memory as a graph of schemas and their ties. It takes time in proportion to memory. A limited number of schemas and ties
//! is listed one by one; the other schemas stand together and are counted.

mod around;
mod basis;
mod places;
mod ties;
mod whole;

use std::collections::BTreeMap;

use pschema_inspect::codec::Problem;
use pschema_inspect::{
    Graph, GraphCluster, GraphEdge, GraphNode, GraphQuery, GraphScope, Plan, PlanState, SchemaInUse,
    SchemaSummary,
};
use pschema_learner::schema::SchemaId;

use super::question::{Inspect, no_schema};
use super::{goals, schemas};
use crate::goal::Asked;
use crate::view::View;
use basis::{Basis, Selection, count};
use places::{Cluster, Places};
use ties::{Edges, Ties};

/// Most schemas that are listed one by one.
const SHOWN_MAX: u32 = 5_000;
/// Most ties between a schema and those around it.
const DEPTH_MAX: u32 = 8;

impl Inspect for GraphQuery {
    fn answer(&self, view: &View) -> Result<Graph, Problem> {
        graph(view, self)
    }
}

/// The graph that is asked for.
fn graph(view: &View, query: &GraphQuery) -> Result<Graph, Problem> {
    let limit = if query.limit == 0 { SHOWN_MAX } else { query.limit.min(SHOWN_MAX) };
    let limit = usize::try_from(limit).unwrap_or(usize::MAX);
    let content = &view.content;
    let mut probability = None;
    let mut goal = Vec::new();
    let (scope, picked) = match (query.around, query.goal.is_empty()) {
        (Some(_), false) => {
            return Err(Problem::of(
                "a graph is around a schema, or of the chain to a goal: ask for one of them",
            ));
        }
        (Some(id), true) => {
            content.schema(SchemaId(id)).ok_or_else(|| no_schema(view, id))?;
            let depth = query.depth.clamp(1, DEPTH_MAX);
            (GraphScope::Around, around::around(basis(view), SchemaId(id), depth, limit))
        }
        (None, false) => {
            let plan = goals::plan(view, Asked { goal: &query.goal, again: false, most: None })?;
            probability = plan.probability;
            goal.clone_from(&plan.wanted.goal);
            (GraphScope::Goal, chain(&plan)?)
        }
        (None, true) => (GraphScope::All, whole::pick(content, limit)),
    };
    let Network { clusters, nodes, edges } = network(basis(view), &picked, scope == GraphScope::All);
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
    Basis { content: &view.content, ratio_min: view.setup.learner.parameters.prediction_ratio_min }
}

/// The schemas of a plan, with the carriers of the generalised ones among them.
fn chain(plan: &Plan) -> Result<Selection, Problem> {
    let steps: Vec<_> = plan.steps.iter().map(|step| step.schema.as_ref()).collect();
    if steps.iter().flatten().next().is_none() {
        return Err(match plan.state {
            PlanState::HoldsAlready => Problem::of("the goal holds already, so that there is no chain to it"),
            PlanState::Found => Problem::of(
                "no schema takes part in the plan, for claims alone tell of its actions: ask for it with `pschema plan`",
            ),
            state => Problem::of(format!(
                "{state}: no chain of schemas to that goal is known from what is perceived now"
            )),
        });
    }
    let carriers = steps.iter().flatten().filter_map(|step| step.carrier);
    let mut shown: Vec<_> =
        steps.iter().flatten().map(|step| step.id).chain(carriers).map(SchemaId).collect();
    shown.sort_unstable();
    shown.dedup();
    let id = |step: Option<&Option<&SchemaInUse>>| Some(SchemaId((*step?)?.id));
    let pairs = steps.windows(2).filter_map(|pair| Some((id(pair.first())?, id(pair.get(1))?)));
    let pairs = pairs.filter(|(from, to)| from != to);
    Ok(Selection {
        total: shown.len() as u64,
        shown,
        next: pairs.collect(),
        truncated: plan.search_truncated,
    })
}

/// Nodes in clusters, with their ties.
struct Network {
    clusters: Vec<GraphCluster>,
    nodes: Vec<GraphNode>,
    edges: Edges,
}

fn network(basis: Basis<'_>, picked: &Selection, with_the_rest: bool) -> Network {
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
    let node = |schema: Option<SchemaSummary>, members, kind, cluster: &Cluster| GraphNode {
        schema,
        members,
        kind,
        cluster: number(cluster),
    };
    let single = shown.iter().map(|(id, schema)| {
        let summary = schemas::summary(content, id.0, schema);
        node(Some(summary), 1, schemas::kind(schema), &Cluster::of(basis, schema))
    });
    let several =
        places.together.iter().map(|((cluster, kind), (_, members))| node(None, *members, *kind, cluster));
    let mut ties = Ties::new(basis, &places, &shown);
    ties.follow(&picked.next);
    ties.lineage();
    ties.among_shown();
    if !places.together.is_empty() {
        ties.with_the_rest();
    }
    let edges = ties.edges();
    Network {
        nodes: single.chain(several).collect(),
        clusters: members
            .iter()
            .map(|(cluster, members)| GraphCluster { name: cluster.name(content), members: *members })
            .collect(),
        edges,
    }
}
