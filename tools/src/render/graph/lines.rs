//! Lines between nodes. Where there are too many to follow, those that go the same way become one, with their number.

use std::collections::BTreeMap;

use pschema_inspect::{Graph, GraphTie};

/// Lines of one kind between a cluster and one node that are drawn one by one.
const TO_ONE_MAX: usize = 8;
/// Lines of one kind between two clusters that are drawn one by one.
const BETWEEN_MAX: usize = 40;

/// An end of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum LineEnd {
    /// At a node.
    Node(usize),
    /// At a cluster.
    Cluster(usize),
}

/// A line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TieLine {
    pub(crate) from: LineEnd,
    pub(crate) to: LineEnd,
    pub(crate) kind: GraphTie,
    /// How many ties between schemas it stands for.
    pub(crate) count: u64,
}

/// A line for each tie.
pub(crate) fn each(graph: &Graph) -> Vec<TieLine> {
    let index = |at: u32| usize::try_from(at).ok().filter(|at| *at < graph.nodes.len()).map(LineEnd::Node);
    let line = |edge: &pschema_inspect::GraphEdge| {
        Some(TieLine { from: index(edge.from)?, to: index(edge.to)?, kind: edge.kind, count: edge.count })
    };
    graph.edges.iter().filter_map(line).collect()
}

/// Lines that can be followed.
pub(super) fn gathered(graph: &Graph) -> Vec<TieLine> {
    let cluster = |end: LineEnd| match end {
        LineEnd::Node(at) => {
            let cluster = graph.nodes.get(at).and_then(|node| usize::try_from(node.cluster).ok());
            LineEnd::Cluster(cluster.unwrap_or(usize::MAX))
        }
        whole => whole,
    };
    let lines = each(graph);
    let lines = together(lines, TO_ONE_MAX, |line| (cluster(line.from), line.to));
    let lines = together(lines, TO_ONE_MAX, |line| (line.from, cluster(line.to)));
    let lines = together(lines, BETWEEN_MAX, |line| (cluster(line.from), cluster(line.to)));
    // Ties within one panel are counted in its title.
    lines.into_iter().filter(|line| line.from != line.to).collect()
}

/// Makes one line of each group with more than `max` of one kind. `ends` says from where to where that line goes.
fn together(lines: Vec<TieLine>, max: usize, ends: impl Fn(&TieLine) -> (LineEnd, LineEnd)) -> Vec<TieLine> {
    let mut groups: BTreeMap<(LineEnd, LineEnd, GraphTie), Vec<TieLine>> = BTreeMap::new();
    for line in lines {
        let (from, to) = ends(&line);
        groups.entry((from, to, line.kind)).or_default().push(line);
    }
    let mut found = Vec::new();
    for ((from, to, kind), group) in groups {
        if group.len() > max {
            let count = group.iter().map(|line| line.count).sum();
            found.push(TieLine { from, to, kind, count });
        } else {
            found.extend(group);
        }
    }
    found
}
