//! A graph as a picture that a browser shows: it can be moved and zoomed, each node says what it is when it is pointed at,
//! and small print appears when there is room for it. What a thing is shows in its shape as well as in its colour.

use pschema_inspect::{Graph, GraphNode, GraphTie, SchemaKind};

use super::geometry::Rect;
use super::layout::{Layout, layout};
use super::lines::{LineEnd, TieLine};
use super::{NodeLook, TIES, heading, looks, parts, tie, told};
use crate::render::words::capitalised;

/// The height of the heading and the legend.
const HEAD: f64 = 92.0;
/// The smallest width of a picture, so that the legend fits.
const WIDTH_MIN: f64 = 1_240.0;

/// The picture, with its style and its script.
#[must_use]
pub fn svg(graph: &Graph) -> String {
    drawn(graph, &format!("<style>{STYLE}</style>\n"), &format!("<script>{SCRIPT}</script>\n"))
}

/// The picture without its style and its script, for a page that brings both.
pub(crate) fn bare(graph: &Graph) -> String {
    drawn(graph, "", "")
}

fn drawn(graph: &Graph, style: &str, script: &str) -> String {
    let layout = layout(graph);
    let looks = looks(graph);
    let (width, height) = (layout.width.max(WIDTH_MIN), layout.height + HEAD);
    let (title, arrows) = (escaped(&heading(graph)), arrows());
    let mut to = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\">\n\
         <title>{title}</title>\n{style}{arrows}\
         <rect class=\"paper\" width=\"{width:.0}\" height=\"{height:.0}\"/>\n"
    );
    head(&mut to, graph, &looks);
    let aside = (width - layout.width) / 2.0;
    to += &format!("<g transform=\"translate({aside:.1} {HEAD:.0})\">\n");
    for panel in &layout.panels {
        rect(&mut to, "panel", panel.rect, 8);
        text(
            &mut to,
            "panel-title",
            panel.rect.x + 10.0,
            panel.rect.y + 20.0,
            &escaped(&cut(&panel.title, 90)),
        );
    }
    for (at, line) in layout.lines.iter().enumerate() {
        draw_line(&mut to, &layout, line, at);
    }
    for (at, ((node, rect), look)) in graph.nodes.iter().zip(&layout.nodes).zip(&looks).enumerate() {
        draw_node(&mut to, graph, at, node, *rect, *look, layout.cards);
    }
    to + "</g>\n" + script + "</svg>\n"
}

/// Adds a text, which must be escaped.
fn text(to: &mut String, class: &str, x: f64, y: f64, escaped: &str) {
    *to += &format!("<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{escaped}</text>\n");
}

/// Adds a rectangle whose corners are rounded with this radius.
fn rect(to: &mut String, class: &str, Rect { x, y, w, h }: Rect, corner: u32) {
    *to += &format!(
        "<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" rx=\"{corner}\"/>\n"
    );
}

/// Adds an outline; `attributes` stand between its class and its path.
fn path(to: &mut String, class: &str, attributes: &str, path: &str) {
    *to += &format!("<path class=\"{class}\"{attributes} d=\"{path}\"/>\n");
}

/// Text of others, escaped so that it is no markup.
pub(crate) fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\n' => safe.push('\n'),
            c if c.is_control() => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}

/// The text, cut to at most this many letters.
fn cut(text: &str, most: usize) -> String {
    match text.chars().count() > most {
        true => text.chars().take(most.saturating_sub(1)).chain(['…']).collect(),
        false => text.to_owned(),
    }
}

fn class(kind: GraphTie) -> &'static str {
    match kind {
        GraphTie::Next => "next",
        GraphTie::Enables => "enables",
        GraphTie::Carries => "carries",
        GraphTie::ExampleOf => "is-example",
        GraphTie::CounterExampleTo => "is-counter",
        GraphTie::ParentOf => "parent",
    }
}

fn arrows() -> String {
    let arrow = |kind: GraphTie| {
        format!(
            "<marker id=\"to-{0}\" viewBox=\"0 0 8 8\" refX=\"7.5\" refY=\"4\" markerWidth=\"7\" markerHeight=\"7\" \
             orient=\"auto-start-reverse\" markerUnits=\"userSpaceOnUse\"><path class=\"tip {0}\" d=\"M0 0L8 4L0 8z\"/></marker>",
            class(kind)
        )
    };
    format!("<defs>{}</defs>\n", TIES.map(arrow).concat())
}

/// The heading and the legend, of those looks and ties that are in the picture.
fn head(to: &mut String, graph: &Graph, looks: &[NodeLook]) {
    text(to, "heading", 24.0, 30.0, &escaped(&capitalised(&heading(graph))));
    let mut x = 24.0;
    for look in NodeLook::ALL.into_iter().filter(|look| looks.contains(look)) {
        shape(to, Rect { x, y: 42.0, w: 26.0, h: 16.0 }, look, false);
        text(to, "legend", x + 33.0, 55.0, look.name());
        x += 52.0 + width_of(look.name());
    }
    if graph.nodes.iter().any(|node| node.schema.is_none()) {
        shape(to, Rect { x, y: 42.0, w: 26.0, h: 14.0 }, NodeLook::Concrete, true);
        text(to, "legend", x + 35.0, 55.0, "several that stand together");
    }
    let mut x = 24.0;
    for kind in TIES.into_iter().filter(|kind| graph.edges.iter().any(|edge| edge.kind == *kind)) {
        let (class, name) = (class(kind), tie(kind));
        let arrow = format!(" marker-end=\"url(#to-{class})\"");
        path(to, &format!("line {class}"), &arrow, &format!("M{x:.1} 74H{:.1}", x + 34.0));
        text(to, "legend", x + 41.0, 78.0, name);
        x += 60.0 + width_of(name);
    }
}

/// About how wide a text of the legend is.
fn width_of(text: &str) -> f64 {
    f64::from(u32::try_from(text.chars().count()).unwrap_or(0)) * 7.0
}

fn rect_of(layout: &Layout, end: LineEnd) -> Option<Rect> {
    match end {
        LineEnd::Node(at) => layout.nodes.get(at).copied(),
        LineEnd::Cluster(at) => layout.panels.get(at).map(|panel| panel.rect),
    }
}

fn draw_line(to: &mut String, layout: &Layout, line: &TieLine, at: usize) {
    let (Some(from), Some(end)) = (rect_of(layout, line.from), rect_of(layout, line.to)) else { return };
    let class = class(line.kind);
    let near = |end: LineEnd, name: &str| match end {
        LineEnd::Node(node) => format!(" {name}{node}"),
        LineEnd::Cluster(_) => String::new(),
    };
    let classes = format!("line {class}{}{}", near(line.from, "f"), near(line.to, "t"));
    let way = if layout.cards { downwards(from, end, at) } else { straight(from, end) };
    let wide = match line.count {
        0..=1 => 1.3,
        2..=8 => 2.0,
        9..=99 => 3.0,
        _ => 4.5,
    };
    path(to, &classes, &format!(" stroke-width=\"{wide}\" marker-end=\"url(#to-{class})\""), &way);
    if line.count > 1 {
        let ((x1, y1), (x2, y2)) = (from.border(end.middle()), end.border(from.middle()));
        let (x, y) = (x1 + (x2 - x1) * 0.55, y1 + (y2 - y1) * 0.55);
        text(to, &format!("count {class}"), x, y, &line.count.to_string());
    }
}

fn straight(from: Rect, to: Rect) -> String {
    let (start, end) = (from.border(to.middle()), to.border(from.middle()));
    // A little bent, so that lines there and back lie side by side.
    let (dx, dy) = (end.0 - start.0, end.1 - start.1);
    let (cx, cy) = (start.0 + dx / 2.0 - dy * 0.06, start.1 + dy / 2.0 + dx * 0.06);
    format!("M{:.1} {:.1}Q{cx:.1} {cy:.1} {:.1} {:.1}", start.0, start.1, end.0, end.1)
}

/// From the lower edge of a card to the upper edge of one below it; sideways and upwards round the outside.
fn downwards(from: Rect, to: Rect, at: usize) -> String {
    // Ties of the same two cards leave at places of their own.
    let shift = f64::from(u32::try_from(at % 5).unwrap_or(0)) * 9.0 - 18.0;
    if from.y + from.h < to.y {
        let (x1, y1) = (from.x + from.w / 2.0 + shift, from.y + from.h);
        let (x2, y2) = (to.x + to.w / 2.0 + shift, to.y);
        let bend = ((y2 - y1) / 2.0).clamp(20.0, 90.0);
        return format!("M{x1:.1} {y1:.1}C{x1:.1} {:.1} {x2:.1} {:.1} {x2:.1} {y2:.1}", y1 + bend, y2 - bend);
    }
    let right = from.x + from.w / 2.0 <= to.x + to.w / 2.0;
    let side = |rect: Rect| if right { rect.x + rect.w } else { rect.x };
    let out = if right { 34.0 + shift / 2.0 } else { -34.0 - shift / 2.0 };
    let (x1, y1) = (side(from), from.y + from.h / 2.0 + shift / 2.0);
    let (x2, y2) = (side(to), to.y + to.h / 2.0 + shift / 2.0);
    format!("M{x1:.1} {y1:.1}C{:.1} {y1:.1} {:.1} {y2:.1} {x2:.1} {y2:.1}", x1 + out, x2 + out)
}

fn draw_node(
    to: &mut String,
    graph: &Graph,
    at: usize,
    node: &GraphNode,
    rect: Rect,
    look: NodeLook,
    card: bool,
) {
    *to += &format!("<g class=\"node\" id=\"n{at}\"><title>{}</title>\n", escaped(&told(graph, node)));
    shape(to, rect, look, node.schema.is_none());
    let Rect { x, y, w, h } = rect;
    let (mx, my) = rect.middle();
    match (&node.schema, parts(node)) {
        (Some(schema), Some([pre, action, post])) if card => {
            let share = match schema.executions {
                0 => "not tried yet".to_owned(),
                _ => format!("{} of {}", schema.successes, schema.executions),
            };
            text(to, "name", x + 14.0, y + 19.0, &format!("{} {}", node.kind, schema.id));
            text(to, "share", x + w - 14.0, y + 19.0, &share);
            for (part, row) in [pre, format!("/ {action}"), format!("/ {post}")].iter().zip(0_u8..) {
                text(to, "part", x + 14.0, y + 38.0 + f64::from(row) * 17.0, &escaped(&cut(part, 38)));
            }
        }
        (Some(schema), Some([pre, action, post])) => {
            text(to, "id", mx, my + 1.0, &schema.id.to_string());
            for (part, row) in [pre, format!("/ {action}"), format!("/ {post}")].iter().zip(0_u8..) {
                text(to, "fine", mx, y + h - 8.2 + f64::from(row) * 2.6, &escaped(&cut(part, 44)));
            }
        }
        _ => {
            let others = if node.kind == SchemaKind::CounterExample { "exceptions" } else { "more" };
            text(to, "id", mx, my + 4.0, &format!("{} {others}", node.members));
        }
    }
    *to += "</g>\n";
}

/// The outline of a node: a shape of its own for each look.
fn shape(to: &mut String, place: Rect, look: NodeLook, several: bool) {
    let Rect { x, y, w, h } = place;
    let class = format!("shape {}", look.class());
    let corner = (h / 3.0).min(14.0);
    // The corners of a hexagon or an octagon that lie between those of the rectangle.
    let (left, right, top, bottom) = (x + corner, x + w - corner, y + corner, y + h - corner);
    let (end, middle, low) = (x + w, y + h / 2.0, y + h);
    if several {
        for behind in [6.0, 3.0] {
            rect(to, &class, Rect { x: x + behind, y: y + behind, ..place }, 4);
        }
    }
    match look {
        NodeLook::Concrete | NodeLook::Example => rect(to, &class, place, 4),
        NodeLook::Generalised | NodeLook::Retired => {
            let hexagon = format!(
                "M{left:.1} {y:.1}H{right:.1}L{end:.1} {middle:.1}L{right:.1} {low:.1}H{left:.1}L{x:.1} {middle:.1}z"
            );
            path(to, &class, "", &hexagon);
        }
        NodeLook::CounterExample => {
            let octagon = format!(
                "M{left:.1} {y:.1}H{right:.1}L{end:.1} {top:.1}V{bottom:.1}L{right:.1} {low:.1}H{left:.1}L{x:.1} {bottom:.1}V{top:.1}z"
            );
            path(to, &class, "", &octagon);
        }
    }
    if look == NodeLook::Example {
        // A corner turned down.
        path(to, "fold", "", &format!("M{right:.1} {y:.1}H{end:.1}V{top:.1}z"));
    }
}

/// The style sheet of a picture.
pub(crate) const STYLE: &str = include_str!("picture.css");

/// Wheel: zoom; drag: move; double click: whole. Pointing at a node leaves its own lines alone in full colour.
const SCRIPT: &str = include_str!("picture.js");
