//! What a question costs the thread that steps the learner: taking a view allocates a few pages at most, and no more when
//! more has been learnt; all else is worked out by the thread that answers.

#![allow(clippy::unwrap_used)] // A test panics to fail.

mod common;

use std::hint::black_box;

use allocation_counter::{AllocationInfo, measure};
use common::{Row, free, setup};
use pschema_server::in_process::{InProcess, RunState};
use pschema_server::view::View;

/// Schemas of the large memory. Each field of the row is a place that the finger can be brought to.
const SCHEMAS: usize = 1_000;

/// A view of memory is a handful of lists of pointers: no list has more than one pointer for 8,192 items. It took 232 bytes
/// when this limit was set.
const VIEW_BYTES_MAX: u64 = 512;
/// The first step after a view copies what it changes: chunks of 64 or 256 items of each list, and a histogram. It copied 32 KiB
/// of the small memory and 42 KiB of the large one when this limit was set.
const COPIED_BYTES_MAX: u64 = 56 * 1_024;

fn view(run: &InProcess<Row>) -> (AllocationInfo, View) {
    let mut view = None;
    let cost = measure(|| view = Some(black_box(run.view())));
    (cost, view.unwrap())
}

/// The bytes that a step allocates after a view, beyond those of a step without one: the mean of several of each.
fn copied_after_a_view(run: &mut InProcess<Row>) -> u64 {
    const STEPS: u64 = 16;
    let (mut plain, mut viewed) = (0, 0);
    for _ in 0..STEPS {
        plain += measure(|| assert_eq!(run.advance().unwrap(), RunState::Running)).bytes_total;
        let view = run.view();
        viewed += measure(|| assert_eq!(run.advance().unwrap(), RunState::Running)).bytes_total;
        drop(view);
    }
    viewed.saturating_sub(plain) / STEPS
}

#[test]
fn a_view_costs_as_little_of_a_large_memory_as_of_a_small_one() {
    let mut costs = Vec::new();
    let mut run = InProcess::new(Row::with_fields("row", 3 * SCHEMAS as i64 / 2), setup(1, free())).unwrap();
    for schemas in [10, SCHEMAS] {
        while run.learner().memory().content().schemas.len() < schemas {
            run.advance().unwrap();
        }
        let (cost, view) = view(&run);
        drop(view);
        let copied = copied_after_a_view(&mut run);
        println!(
            "{schemas} schemas: a view allocates {} bytes in {} pieces, the step after it {copied} bytes more",
            cost.bytes_total, cost.count_total
        );
        assert!(cost.bytes_total <= VIEW_BYTES_MAX, "{schemas} schemas: {cost:?}");
        assert!(copied <= COPIED_BYTES_MAX, "{schemas} schemas: {copied} bytes");
        costs.push((cost.bytes_total, cost.count_total));
    }
    assert_eq!(costs[0], costs[1], "the cost of a view depends on how much has been learnt");
}
