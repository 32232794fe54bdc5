//! A large graph: a panel for each cluster, with a cell for each of its nodes, and the panels side by side.

use pschema_inspect::{Graph, GraphTie};

use super::geometry::{Panel, Rect};
use crate::render::words::{count, plain};

/// Width and height of the cell of one schema.
const CELL: (f64, f64) = (58.0, 26.0);
/// Width and height of a cell that stands for several schemas.
const SEVERAL: (f64, f64) = (128.0, 40.0);
const GAP: f64 = 8.0;
const TITLE: f64 = 26.0;
/// The space between panels, for the lines.
const STREET: f64 = 70.0;
/// The wanted ratio of width to height.
const WIDER: f64 = 1.5;

/// The places of nodes and panels, with the width and height of the picture.
pub(super) fn place(graph: &Graph) -> (Vec<Rect>, Vec<Panel>, f64, f64) {
    let mut nodes = vec![Rect::default(); graph.nodes.len()];
    let mut panels: Vec<_> =
        (0..graph.clusters.len()).map(|cluster| fill(graph, cluster, &mut nodes)).collect();
    let (offsets, width, height) = shelves(&panels);
    let moved = |rect: &mut Rect, (x, y): (f64, f64)| {
        rect.x += x;
        rect.y += y;
    };
    for (node, rect) in graph.nodes.iter().zip(&mut nodes) {
        let offset = usize::try_from(node.cluster).ok().and_then(|at| offsets.get(at)).copied();
        moved(rect, offset.unwrap_or_default());
    }
    panels.iter_mut().zip(&offsets).for_each(|(panel, offset)| moved(&mut panel.rect, *offset));
    (nodes, panels, width, height)
}

/// A panel at the origin with its cells in rows, and the place of each of them in `nodes`.
fn fill(graph: &Graph, cluster: usize, nodes: &mut [Rect]) -> Panel {
    let of = |several: bool| {
        let inside = graph.nodes.iter().enumerate().filter(move |(_, node)| {
            usize::try_from(node.cluster) == Ok(cluster) && node.schema.is_none() == several
        });
        inside.map(|(at, _)| at).collect::<Vec<_>>()
    };
    let title = title(graph, cluster);
    let (single, several) = (of(false), of(true));
    #[expect(clippy::cast_precision_loss, reason = "a few thousand at most")]
    let area = single.len() as f64 * (CELL.0 + GAP) * (CELL.1 + GAP);
    let widest = title.chars().count().min(60);
    #[expect(clippy::cast_precision_loss, reason = "60 at most")]
    let inner = (area * WIDER).sqrt().max(widest as f64 * 8.2).max(SEVERAL.0);
    let mut at = (GAP, TITLE + GAP);
    let mut right: f64 = 0.0;
    let mut rows = |list: &[usize], size: (f64, f64), at: &mut (f64, f64)| {
        for node in list {
            if at.0 > GAP && at.0 + size.0 > inner + GAP {
                *at = (GAP, at.1 + size.1 + GAP);
            }
            if let Some(rect) = nodes.get_mut(*node) {
                *rect = Rect { x: at.0, y: at.1, w: size.0, h: size.1 };
            }
            right = right.max(at.0 + size.0);
            at.0 += size.0 + GAP;
        }
        if !list.is_empty() {
            *at = (GAP, at.1 + size.1 + GAP);
        }
    };
    rows(&single, CELL, &mut at);
    rows(&several, SEVERAL, &mut at);
    let w = (right + GAP).max(inner + 2.0 * GAP);
    Panel { rect: Rect { x: 0.0, y: 0.0, w, h: at.1 }, title }
}

fn title(graph: &Graph, cluster: usize) -> String {
    let Some(known) = graph.clusters.get(cluster) else { return String::new() };
    let inside = |at: u32| {
        let node = usize::try_from(at).ok().and_then(|at| graph.nodes.get(at));
        node.is_some_and(|node| usize::try_from(node.cluster) == Ok(cluster))
    };
    let within = |kind: GraphTie| {
        let ties = graph.edges.iter().filter(|e| e.kind == kind && inside(e.from) && inside(e.to));
        ties.map(|edge| edge.count).sum::<u64>()
    };
    let mut title = format!("{}: {}", plain(&known.name), count(known.members, "schema"));
    for (kind, what) in [(GraphTie::Enables, "enabled"), (GraphTie::ParentOf, "descended")] {
        let ties = within(kind);
        if ties > 0 {
            title.push_str(&format!(", {ties} {what} from within"));
        }
    }
    title
}

/// The places of panels in rows, the highest first, with the width and height of the picture.
fn shelves(panels: &[Panel]) -> (Vec<(f64, f64)>, f64, f64) {
    let area: f64 = panels.iter().map(|panel| (panel.rect.w + STREET) * (panel.rect.h + STREET)).sum();
    let widest = panels.iter().map(|panel| panel.rect.w).fold(0.0, f64::max);
    let wanted = (area * WIDER).sqrt().max(widest + STREET);
    let mut order: Vec<_> = (0..panels.len()).collect();
    let height = |at: &usize| panels.get(*at).map_or(0.0, |panel| panel.rect.h);
    order.sort_by(|a, b| height(b).total_cmp(&height(a)).then(a.cmp(b)));
    let mut offsets = vec![(0.0, 0.0); panels.len()];
    let (mut x, mut y, mut shelf) = (STREET / 2.0, STREET / 2.0, 0.0_f64);
    let mut right: f64 = 0.0;
    for at in order {
        let Some(Panel { rect, .. }) = panels.get(at) else { continue };
        if x > STREET / 2.0 && x + rect.w > wanted {
            (x, y, shelf) = (STREET / 2.0, y + shelf + STREET, 0.0);
        }
        if let Some(offset) = offsets.get_mut(at) {
            *offset = (x, y);
        }
        right = right.max(x + rect.w);
        x += rect.w + STREET;
        shelf = shelf.max(rect.h);
    }
    (offsets, right + STREET / 2.0, y + shelf + STREET / 2.0)
}
