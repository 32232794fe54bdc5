//! A graph of schemas as a picture or for Graphviz. The same graph always gives the same text.
//!
//! The layout is our own: layout-rs, the one library that is kept up, knows no clusters and takes quadratic time, and
//! what is to be drawn is either small and layered or large and clustered.

pub(crate) mod dot;
mod geometry;
mod layered;
pub(crate) mod layout;
mod lines;
mod panels;
pub(crate) mod svg;
#[cfg(test)]
mod tests;

use pschema_inspect::{Graph, GraphNode, GraphScope, GraphTie, SchemaKind};
use pschema_learner::notation::{outcomes, side};

use super::words::{count, figure, plain, summary_text};

/// How a node is drawn: by its kind, or as an example of a generalised schema that is in the picture too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeLook {
    Concrete,
    Example,
    CounterExample,
    Generalised,
    Retired,
}

impl NodeLook {
    pub(crate) const ALL: [Self; 5] =
        [Self::Concrete, Self::Example, Self::CounterExample, Self::Generalised, Self::Retired];

    /// The class in style sheets.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Concrete => "concrete",
            Self::Example => "example",
            Self::CounterExample => "counter",
            Self::Generalised => "general",
            Self::Retired => "retired",
        }
    }

    /// The name in the legend.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Concrete => "concrete schema",
            Self::Example => "example of a generalised one",
            Self::CounterExample => "counter-example",
            Self::Generalised => "generalised schema",
            Self::Retired => "retired: it failed too often",
        }
    }
}

/// The look of each node.
pub(crate) fn looks(graph: &Graph) -> Vec<NodeLook> {
    let mut looks: Vec<_> = graph
        .nodes
        .iter()
        .map(|node| match node.kind {
            SchemaKind::Generalised => NodeLook::Generalised,
            SchemaKind::Retired => NodeLook::Retired,
            SchemaKind::CounterExample => NodeLook::CounterExample,
            SchemaKind::Concrete => NodeLook::Concrete,
        })
        .collect();
    for edge in graph.edges.iter().filter(|edge| edge.kind == GraphTie::ExampleOf) {
        if let Some(look) = at(&mut looks, edge.from).filter(|look| **look == NodeLook::Concrete) {
            *look = NodeLook::Example;
        }
    }
    looks
}

fn at<T>(list: &mut [T], at: u32) -> Option<&mut T> {
    list.get_mut(usize::try_from(at).ok()?)
}

/// A tie in words, to be read from the first schema to the second.
pub(crate) fn tie(kind: GraphTie) -> &'static str {
    match kind {
        GraphTie::Next => "then",
        GraphTie::Enables => "enables",
        GraphTie::Carries => "carries out the target of",
        GraphTie::ExampleOf => "is an example of",
        GraphTie::CounterExampleTo => "is a counter-example to",
        GraphTie::ParentOf => "led to",
    }
}

/// All kinds of ties, the most important first.
pub(crate) const TIES: [GraphTie; 6] = [
    GraphTie::Next,
    GraphTie::CounterExampleTo,
    GraphTie::ExampleOf,
    GraphTie::Carries,
    GraphTie::Enables,
    GraphTie::ParentOf,
];

/// The three parts of a schema as they print.
pub(crate) fn parts(node: &GraphNode) -> Option<[String; 3]> {
    let schema = node.schema.as_ref()?;
    let text = summary_text(schema);
    let shares = text.post_shares.into_iter().chain(std::iter::repeat(None));
    Some([side(text.pre), text.action, outcomes(text.post.into_iter().zip(shares))])
}

/// Everything about a node, over some lines.
pub(crate) fn told(graph: &Graph, node: &GraphNode) -> String {
    let cluster = usize::try_from(node.cluster).ok().and_then(|at| graph.clusters.get(at));
    let cluster = cluster.map_or_else(String::new, |cluster| plain(&cluster.name));
    match (&node.schema, parts(node)) {
        (Some(schema), Some([pre, action, post])) => {
            let succeeded = super::words::probability(
                schema.probability,
                schema.successes,
                schema.executions,
                schema.low,
                schema.high,
            );
            format!("schema {}, {}\n{pre}\n/ {action}\n/ {post}\nsucceeds: {succeeded}", schema.id, node.kind)
        }
        _ => format!("{} ({}): {cluster}", count(node.members, "schema"), node.kind),
    }
}

/// The heading of the picture.
pub(crate) fn heading(graph: &Graph) -> String {
    let shown = match u64::from(graph.shown) == graph.nodes_total {
        true => count(graph.nodes_total, "schema"),
        false => format!("{} of {}", graph.shown, count(graph.nodes_total, "schema")),
    };
    let cut = if (graph.edges.iter().map(|edge| edge.count).sum::<u64>()) < graph.edges_total {
        format!(", more ties than are drawn ({})", graph.edges_total)
    } else {
        String::new()
    };
    let what = match (graph.scope, graph.around) {
        (GraphScope::Around, Some(id)) => format!("around schema {id}"),
        (GraphScope::Goal, _) => {
            let goal: Vec<_> = graph.goal.iter().map(|one| plain(one)).collect();
            let sure =
                graph.probability.map_or_else(String::new, |p| format!(", probability {}", figure(p, 2)));
            format!("the chain to {}{sure}", goal.join(" and "))
        }
        _ => "all that is known".to_owned(),
    };
    format!("{what} after step {}: {shown}{cut}", graph.step)
}
