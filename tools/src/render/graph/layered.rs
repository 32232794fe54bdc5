//! A small graph: cards in layers, ties going downwards as far as they can (after Sugiyama, Tagawa & Toda 1981: break
//! cycles, longest paths, neighbours near each other).

use pschema_inspect::{Graph, GraphTie};

use super::geometry::Rect;

/// Width and height of a card.
const CARD: (f64, f64) = (286.0, 84.0);
const GAP: f64 = 26.0;
/// The space between layers, for the lines.
const STREET: f64 = 64.0;
/// Cards side by side; the other cards of their layer stand below them.
const SIDE_BY_SIDE_MAX: usize = 5;
/// How often each layer is sorted by the places of its neighbours.
const SWEEPS: usize = 6;

/// The place of each node, with the width and height of the picture.
pub(super) fn place(graph: &Graph) -> (Vec<Rect>, f64, f64) {
    let ties = downwards(graph);
    let mut rows = rows(&layers(graph.nodes.len(), &ties));
    for _ in 0..SWEEPS {
        order(&mut rows, &ties);
    }
    let mut places = vec![Rect::default(); graph.nodes.len()];
    let most = rows.iter().map(|(row, _)| row.len()).max().unwrap_or(1);
    let wide = |cards: usize| f64::from(u32::try_from(cards).unwrap_or(0)) * (CARD.0 + GAP) - GAP;
    let width = wide(most.max(2)) + 2.0 * STREET;
    let mut y = STREET / 2.0;
    for (row, is_last_of_layer) in &rows {
        let mut x = (width - wide(row.len())) / 2.0;
        for node in row {
            if let Some(place) = places.get_mut(*node) {
                *place = Rect { x, y, w: CARD.0, h: CARD.1 };
            }
            x += CARD.0 + GAP;
        }
        y += CARD.1 + if *is_last_of_layer { STREET } else { GAP };
    }
    (places, width, y - STREET / 2.0)
}

/// The ties without cycles. They are taken in the order of their importance, and a tie that would close a cycle is left out.
fn downwards(graph: &Graph) -> Vec<(usize, usize)> {
    let rank = |kind: GraphTie| match kind {
        GraphTie::Next => 0,
        GraphTie::ExampleOf | GraphTie::CounterExampleTo => 1,
        GraphTie::Carries => 2,
        GraphTie::Enables => 3,
        GraphTie::ParentOf => 4,
    };
    let mut edges: Vec<_> = graph.edges.iter().collect();
    edges.sort_by_key(|edge| (rank(edge.kind), edge.from, edge.to));
    let mut after = vec![Vec::new(); graph.nodes.len()];
    let mut kept = Vec::new();
    for edge in edges {
        let (Ok(from), Ok(to)) = (usize::try_from(edge.from), usize::try_from(edge.to)) else { continue };
        let known = from.max(to) < after.len();
        if known && from != to && !kept.contains(&(from, to)) && !leads(&after, to, from) {
            after[from].push(to);
            kept.push((from, to));
        }
    }
    kept
}

/// Whether a way leads from one node to another.
fn leads(after: &[Vec<usize>], from: usize, to: usize) -> bool {
    let mut seen = vec![false; after.len()];
    let mut open = vec![from];
    while let Some(at) = open.pop() {
        if at == to {
            return true;
        }
        if !std::mem::replace(&mut seen[at], true) {
            open.extend(&after[at]);
        }
    }
    false
}

/// The layer of each node: one more than the last of those that are tied to it.
fn layers(nodes: usize, ties: &[(usize, usize)]) -> Vec<usize> {
    let mut layers = vec![0_usize; nodes];
    // No way is longer than there are nodes.
    for _ in 0..nodes {
        let mut changed = false;
        for (from, to) in ties {
            if layers[*to] <= layers[*from] {
                layers[*to] = layers[*from] + 1;
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    // A node to which no tie leads stands right above the first node that it leads to.
    for at in 0..nodes {
        let below = ties.iter().filter(|(from, _)| *from == at).map(|(_, to)| layers[*to]).min();
        let is_first = !ties.iter().any(|(_, to)| *to == at);
        if let (Some(below), true) = (below, is_first) {
            layers[at] = below.saturating_sub(1);
        }
    }
    layers
}

type LayerRow = (Vec<usize>, bool);

/// Nodes side by side, and whether they are the last of their layer.
fn rows(layers: &[usize]) -> Vec<LayerRow> {
    let last = layers.iter().max().copied().unwrap_or(0);
    let mut rows = Vec::new();
    for layer in 0..=last {
        let nodes: Vec<_> = (0..layers.len()).filter(|at| layers[*at] == layer).collect();
        let count = nodes.len().div_ceil(SIDE_BY_SIDE_MAX).max(1);
        let split: Vec<_> = nodes.chunks(nodes.len().div_ceil(count).max(1)).map(<[usize]>::to_vec).collect();
        let ends = split.len();
        rows.extend(split.into_iter().enumerate().map(|(at, row)| (row, at + 1 == ends)));
    }
    rows
}

/// Sorts each row by the mean place of the neighbours of its nodes.
fn order(rows: &mut [LayerRow], ties: &[(usize, usize)]) {
    let nodes = rows.iter().flat_map(|(row, _)| row).max().map_or(0, |most| most + 1);
    let mut places = vec![0.5; nodes];
    let spread = |row: &[usize], places: &mut [f64]| {
        let count = f64::from(u32::try_from(row.len()).unwrap_or(1));
        for (at, node) in row.iter().zip(0_u32..) {
            places[*at] = (f64::from(node) + 0.5) / count;
        }
    };
    rows.iter().for_each(|(row, _)| spread(row, &mut places));
    for (row, _) in rows {
        let middle = |node: usize| {
            let neighbours = ties.iter().filter_map(|(from, to)| match (*from == node, *to == node) {
                (true, _) => Some(places[*to]),
                (_, true) => Some(places[*from]),
                _ => None,
            });
            let (sum, count) = neighbours.fold((0.0, 0.0), |(sum, count), place| (sum + place, count + 1.0));
            if count == 0.0 { places[node] } else { sum / count }
        };
        let mut placed: Vec<_> = row.iter().map(|node| (middle(*node), *node)).collect();
        placed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        *row = placed.into_iter().map(|(_, node)| node).collect();
        spread(row, &mut places);
    }
}
