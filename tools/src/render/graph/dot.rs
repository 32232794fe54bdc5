//! A graph in the language of Graphviz.

use pschema_inspect::{Graph, GraphTie};

use super::{NodeLook, heading, looks, parts, tie, told};

/// The graph as a text for Graphviz.
pub(crate) fn dot(graph: &Graph) -> String {
    let mut to = format!(
        "digraph schemas {{\n  label={};\n  labelloc=t;\n  node [fontname=\"monospace\", fontsize=10, style=filled];\n",
        quoted(&heading(graph))
    );
    let looks = looks(graph);
    for (at, cluster) in graph.clusters.iter().enumerate() {
        to += &format!("  subgraph cluster_{at} {{\n    label={};\n", quoted(&cluster.name));
        let inside = graph.nodes.iter().zip(&looks).enumerate();
        for (number, (node, look)) in inside.filter(|(_, (node, _))| usize::try_from(node.cluster) == Ok(at))
        {
            let label = match (&node.schema, parts(node)) {
                (Some(schema), Some([pre, action, post])) => {
                    format!("{} {}\n{pre}\n/ {action}\n/ {post}", node.kind, schema.id)
                }
                _ => format!("{} {}", node.members, node.kind),
            };
            let (label, tooltip) = (quoted(&label), quoted(&told(graph, node)));
            let appearance = appearance(*look, node.schema.is_none());
            to += &format!("    n{number} [label={label}, tooltip={tooltip}, {appearance}];\n");
        }
        to += "  }\n";
    }
    for edge in &graph.edges {
        let times = if edge.count > 1 { format!(" ({})", edge.count) } else { String::new() };
        let tooltip = quoted(&format!("{}{times}", tie(edge.kind)));
        to += &format!("  n{} -> n{} [tooltip={tooltip}, {}];\n", edge.from, edge.to, line(edge.kind));
    }
    to + "}\n"
}

fn quoted(text: &str) -> String {
    let mut safe = "\"".to_owned();
    for c in text.chars() {
        match c {
            '"' | '\\' => safe.extend(['\\', c]),
            '\n' => safe.push_str("\\n"),
            c if c.is_control() => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe + "\""
}

fn appearance(look: NodeLook, several: bool) -> &'static str {
    match (look, several) {
        (_, true) => "shape=box3d, fillcolor=\"#e8f0fa\"",
        (NodeLook::Concrete, _) => "shape=box, fillcolor=\"#e8f0fa\"",
        (NodeLook::Example, _) => "shape=note, fillcolor=\"#dff0df\"",
        (NodeLook::CounterExample, _) => "shape=octagon, style=\"filled,dashed\", fillcolor=\"#fde3de\"",
        (NodeLook::Generalised, _) => "shape=hexagon, penwidth=2, fillcolor=\"#fff0c2\"",
        (NodeLook::Retired, _) => "shape=hexagon, style=\"filled,dotted\", fillcolor=\"#eceae4\"",
    }
}

fn line(kind: GraphTie) -> &'static str {
    match kind {
        GraphTie::Next => "penwidth=3",
        GraphTie::Enables => "color=\"#1c5fb8\"",
        GraphTie::Carries => "color=\"#00796b\", style=dashed",
        GraphTie::ExampleOf => "color=\"#2e7d32\", style=dashed, arrowhead=empty",
        GraphTie::CounterExampleTo => "color=\"#b3261e\", style=dashed, arrowhead=tee",
        GraphTie::ParentOf => "color=\"#8d8a80\", style=dotted, constraint=false",
    }
}
