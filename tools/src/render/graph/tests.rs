//! Pictures compared with files in `tests/golden`, and what any picture must be like.

use std::collections::BTreeSet;

use pschema_inspect::*;

use super::geometry::Rect;
use super::layout::{Layout, layout};
use super::lines::{LineEnd, gathered};
use super::{dot, svg};
use crate::golden::{check, check_json};

fn schema(id: u32, pre: &[&str], action: &str, post: &[&str], kind: SchemaKind) -> GraphNode {
    let texts = |list: &[&str]| list.iter().map(|one| (*one).to_owned()).collect::<Vec<_>>();
    let schema = SchemaSummary {
        id,
        kind,
        pre: texts(pre),
        action: action.to_owned(),
        post: texts(post),
        post_shares: vec![Some(1.0); post.len()],
        executions: 4,
        successes: 3,
        probability: 0.75,
        low: 0.3,
        high: 0.95,
    };
    let cluster = if pre.is_empty() {
        0
    } else {
        1 + u32::from(kind == SchemaKind::Generalised || kind == SchemaKind::Retired)
    };
    GraphNode { schema: Some(schema), members: 1, kind, cluster }
}

/// Touching, as it is learnt in the paper's first experiment: two moves, two touches, the law made of them, and where it
/// does not hold.
fn touching() -> Graph {
    let nodes = vec![
        schema(0, &[], "move(j1=0.43, j2=0.84)", &["finger{field=17}"], SchemaKind::Concrete),
        schema(1, &[], "move(j1=0.10, j2=0.20)", &["finger{field=4}"], SchemaKind::Concrete),
        schema(
            2,
            &["object{field=17}"],
            "move(j1=0.43, j2=0.84)",
            &["finger{field=17}", "touch{}"],
            SchemaKind::Concrete,
        ),
        schema(
            3,
            &["object{field=4}"],
            "move(j1=0.10, j2=0.20)",
            &["finger{field=4}", "touch{}"],
            SchemaKind::Concrete,
        ),
        schema(
            4,
            &["object{field=$a}"],
            "achieve finger{field=$a}",
            &["finger{field=$a}", "touch{}"],
            SchemaKind::Generalised,
        ),
        schema(
            5,
            &["object{field=9}"],
            "move(j1=0.90, j2=0.90)",
            &["finger{field=9}"],
            SchemaKind::CounterExample,
        ),
        schema(6, &["object{field=$a}"], "achieve finger{field=$b}", &["touch{}"], SchemaKind::Retired),
    ];
    let edge = |from, to, kind| GraphEdge { from, to, kind, count: 1 };
    let cluster = |name: &str, members| GraphCluster { name: name.to_owned(), members };
    let edges = vec![
        edge(0, 2, GraphTie::ParentOf),
        edge(0, 4, GraphTie::Carries),
        edge(1, 3, GraphTie::ParentOf),
        edge(1, 4, GraphTie::Carries),
        edge(2, 4, GraphTie::ExampleOf),
        edge(3, 4, GraphTie::ExampleOf),
        edge(4, 5, GraphTie::ParentOf),
        edge(5, 4, GraphTie::CounterExampleTo),
    ];
    Graph {
        step: 231,
        scope: GraphScope::All,
        around: None,
        goal: Vec::new(),
        probability: None,
        nodes_total: 7,
        shown: 7,
        truncated: false,
        clusters: vec![
            cluster("move, whatever is perceived", 2),
            cluster("move, given object", 3),
            cluster("generalised", 2),
        ],
        nodes,
        edges_total: edges.len() as u64,
        edges,
    }
}

/// So many moves, the touches of every third, one law of them all, and others that stand together.
fn many(moves: u32) -> Graph {
    let mut graph = touching();
    graph.nodes.clear();
    graph.edges.clear();
    let place = |at: u32| format!("finger{{field={at}}}");
    for at in 0..moves {
        graph.nodes.push(schema(at, &[], &format!("move(to={at})"), &[&place(at)], SchemaKind::Concrete));
    }
    for at in (0..moves).step_by(3) {
        let pre = format!("object{{field={at}}}");
        let id = moves + at / 3;
        graph.nodes.push(schema(id, &[&pre], &format!("move(to={at})"), &["touch{}"], SchemaKind::Concrete));
        graph.edges.push(GraphEdge { from: at, to: id, kind: GraphTie::ParentOf, count: 1 });
    }
    let law = u32::try_from(graph.nodes.len()).unwrap();
    graph.nodes.push(schema(
        law,
        &["object{field=$a}"],
        "achieve finger{field=$a}",
        &["touch{}"],
        SchemaKind::Generalised,
    ));
    let several = |members, kind| GraphNode { schema: None, members, kind, cluster: 1 };
    graph.nodes.push(several(98_765, SchemaKind::Concrete));
    graph.nodes.push(several(4_321, SchemaKind::CounterExample));
    for at in 0..moves {
        graph.edges.push(GraphEdge { from: at, to: law, kind: GraphTie::Carries, count: 1 });
    }
    for at in moves..law {
        graph.edges.push(GraphEdge { from: at, to: law, kind: GraphTie::ExampleOf, count: 1 });
    }
    graph.edges.push(GraphEdge { from: law + 2, to: law, kind: GraphTie::CounterExampleTo, count: 4_321 });
    graph.shown = law + 1;
    graph.nodes_total = u64::from(law) + 1 + 98_765 + 4_321;
    graph.edges_total = graph.edges.iter().map(|edge| edge.count).sum();
    graph.truncated = true;
    graph
}

#[test]
fn a_small_graph_as_picture_text_and_data() {
    let graph = touching();
    check("graph.svg", &svg::svg(&graph));
    check("graph.dot", &dot::dot(&graph));
    check_json("graph.json", &graph);
}

#[test]
fn a_large_graph_as_picture() {
    check("graph-many.svg", &svg::svg(&many(90)));
}

#[test]
fn a_chain_reads_downwards() {
    let mut graph = touching();
    graph.scope = GraphScope::Goal;
    let tie = |from, to| GraphEdge { from, to, kind: GraphTie::Next, count: 1 };
    graph.edges.extend([tie(4, 0), tie(0, 3), tie(3, 2)]);
    let placed = layout(&graph);
    let y = |at: usize| placed.nodes[at].y;
    assert!(y(4) < y(0) && y(0) < y(3) && y(3) < y(2), "{:?}", placed.nodes);
}

fn inside(inner: Rect, outer: Rect) -> bool {
    let within = |at: f64, length: f64, from: f64, room: f64| at >= from && at + length <= from + room + 1e-6;
    within(inner.x, inner.w, outer.x, outer.w) && within(inner.y, inner.h, outer.y, outer.h)
}

fn apart(a: Rect, b: Rect) -> bool {
    a.x + a.w <= b.x || b.x + b.w <= a.x || a.y + a.h <= b.y || b.y + b.h <= a.y
}

#[test]
fn nothing_lies_on_anything_else_and_all_of_it_is_in_the_picture() {
    let mut alone = touching();
    alone.edges.clear();
    let mut empty = touching();
    (empty.nodes, empty.edges, empty.clusters) = Default::default();
    for graph in [touching(), alone, empty, many(20), many(45), many(90), many(1_500)] {
        let Layout { width, height, nodes, panels, .. } = layout(&graph);
        let all = Rect { x: 0.0, y: 0.0, w: width, h: height };
        assert!(nodes.iter().all(|rect| inside(*rect, all) && rect.w > 0.0), "{width} x {height}");
        for (at, rect) in nodes.iter().enumerate().step_by(1 + nodes.len() / 100) {
            assert!(
                nodes.iter().skip(at + 1).all(|other| apart(*rect, *other)),
                "node {at} of {}",
                nodes.len()
            );
        }
        for (at, panel) in panels.iter().enumerate() {
            assert!(panels.iter().skip(at + 1).all(|other| apart(panel.rect, other.rect)), "panel {at}");
        }
        for (node, rect) in graph.nodes.iter().zip(&nodes).filter(|_| !panels.is_empty()) {
            assert!(inside(*rect, panels[node.cluster as usize].rect));
        }
    }
}

#[test]
fn lines_that_go_the_same_way_become_one_and_none_is_lost() {
    let graph = many(300);
    let lines = gathered(&graph);
    assert!(lines.len() < 20, "{lines:?}");
    assert_eq!(lines.iter().map(|line| line.count).sum::<u64>(), graph.edges_total);
    let law = graph.nodes.iter().position(|node| node.kind == SchemaKind::Generalised).unwrap();
    let carried = lines.iter().find(|line| line.kind == GraphTie::Carries).unwrap();
    assert_eq!((carried.from, carried.to, carried.count), (LineEnd::Cluster(0), LineEnd::Node(law), 300));
}

/// Names of bodies and words heard come from others.
#[test]
fn what_others_named_is_text_and_never_markup() {
    let evil = "</title><script>alert(1)</script>\"'\\\u{1b}[2J\n";
    let mut graph = touching();
    for node in &mut graph.nodes {
        let schema = node.schema.as_mut().unwrap();
        evil.clone_into(&mut schema.action);
        schema.pre = vec![evil.to_owned()];
    }
    evil.clone_into(&mut graph.clusters[0].name);
    graph.goal = vec![evil.to_owned()];
    graph.scope = GraphScope::Goal;
    let mut large = many(90);
    large.clusters.iter_mut().for_each(|cluster| evil.clone_into(&mut cluster.name));
    for picture in [svg::svg(&graph), svg::svg(&large)] {
        assert_eq!(picture.matches("<script>").count(), 1, "our own alone");
        assert!(!picture.chars().any(|c| c.is_control() && c != '\n'));
    }
    let text = dot::dot(&graph);
    assert!(text.contains("\\\"'\\\\") && !text.contains('\u{1b}'), "{text}");
}

#[test]
fn kinds_differ_in_shape_as_well_as_in_colour() {
    let picture = svg::svg(&touching());
    let shape = |class: &str| {
        let at = picture.find(&format!("class=\"shape {class}\"")).unwrap();
        let element = &picture[picture[..at].rfind('<').unwrap()..at];
        let path = picture[at..].split("d=\"").nth(1).unwrap_or_default();
        let corners = path[..path.find('"').unwrap_or(0)].chars().filter(char::is_ascii_alphabetic).count();
        if element.starts_with("<rect") { 0 } else { corners }
    };
    let corners: BTreeSet<_> = ["concrete", "general", "counter"].map(shape).into();
    assert_eq!(corners.len(), 3, "{corners:?}");
    assert!(picture.contains("class=\"fold\""), "an example has a corner turned down");
    for named in
        ["generalised schema", "counter-example", "example of a generalised one", "retired", "led to"]
    {
        assert!(picture.contains(named), "{named} is not in the legend");
    }
}
