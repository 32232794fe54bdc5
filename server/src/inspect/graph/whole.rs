//! The choice of the schemas that are listed one by one when memory has more than can be listed.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use pschema_learner::memory::Content;
use pschema_learner::schema::SchemaId;

use super::basis::{Selection, numbered};

/// At most `limit` schemas. Laws come first, the most executed of them, up to half of the limit; then, in turn, their
/// counter-examples and examples, up to three quarters; then the concrete schemas that were executed most.
pub(super) fn pick(content: &Content, limit: usize) -> Selection {
    let total = content.schemas.len();
    let (shown, truncated) = if total <= limit {
        (numbered(content).map(|(id, _)| id).collect(), false)
    } else {
        (most_telling(content, limit), true)
    };
    Selection { shown, total: total as u64, next: Vec::new(), truncated }
}

fn most_telling(content: &Content, limit: usize) -> Vec<SchemaId> {
    let mut laws = Vec::new();
    // The most executed schemas so far; the least executed of them is at the top and leaves first.
    let mut used: BinaryHeap<Reverse<(u32, Reverse<SchemaId>)>> = BinaryHeap::new();
    for (id, schema) in numbered(content) {
        let executions = schema.executions.trials;
        if let Some(law) = schema.generalised() {
            laws.push((law.retired, Reverse(executions), id));
            continue;
        }
        if used.len() < limit {
            used.push(Reverse((executions, Reverse(id))));
        } else if used.peek().is_some_and(|least| least.0 < (executions, Reverse(id))) {
            used.pop();
            used.push(Reverse((executions, Reverse(id))));
        }
    }
    laws.sort_unstable();
    laws.truncate((limit / 2).max(1));
    let mut shown: BTreeSet<SchemaId> = laws.iter().map(|(.., id)| *id).collect();
    for id in evidence(content, &laws.iter().map(|(.., id)| *id).collect::<Vec<_>>()) {
        if shown.len() >= limit * 3 / 4 {
            break;
        }
        shown.insert(id);
    }
    let mut used: Vec<_> = used.into_iter().map(|Reverse(one)| one).collect();
    used.sort_unstable_by(|a, b| b.cmp(a));
    for (_, Reverse(id)) in used {
        if shown.len() >= limit {
            break;
        }
        shown.insert(id);
    }
    shown.into_iter().collect()
}

/// Counter-examples and examples of these laws: the first of each law, then the second of each, and so on.
fn evidence(content: &Content, laws: &[SchemaId]) -> Vec<SchemaId> {
    let known = laws.iter().filter_map(|id| content.generalised(*id));
    let lists: Vec<Vec<SchemaId>> =
        known.map(|law| law.counter_examples.iter().chain(&law.examples).copied().collect()).collect();
    let longest = lists.iter().map(Vec::len).max().unwrap_or(0);
    let turns = (0..longest).flat_map(|turn| lists.iter().filter_map(move |list| list.get(turn)));
    turns.copied().collect()
}
