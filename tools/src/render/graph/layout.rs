//! The places of nodes, panels and lines. Lengths are in units of the picture, about a pixel each.

use pschema_inspect::Graph;

use super::geometry::{Panel, Rect};
use super::layered;
use super::lines::{TieLine, each, gathered};
use super::panels;

/// Up to so many nodes are drawn as cards with the text of their schema; more are drawn as cells with their number.
const CARDS_MAX: usize = 60;

/// A whole picture.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// Whether nodes are drawn as cards; else as cells.
    pub(crate) cards: bool,
    /// The place of each node.
    pub(crate) nodes: Vec<Rect>,
    /// The panel of each cluster; empty when nodes are cards.
    pub(crate) panels: Vec<Panel>,
    pub(crate) lines: Vec<TieLine>,
}

/// Finds a place for everything.
pub(crate) fn layout(graph: &Graph) -> Layout {
    if graph.nodes.len() <= CARDS_MAX {
        let (nodes, width, height) = layered::place(graph);
        let lines = each(graph);
        return Layout { width, height, cards: true, nodes, panels: Vec::new(), lines };
    }
    let (nodes, panels, width, height) = panels::place(graph);
    Layout { width, height, cards: false, nodes, panels, lines: gathered(graph) }
}
