//! The costs of a growing memory: the time of steps and the resident memory of the process, by the number of schemas.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use pschema_inspect::GrowthStatus;

use crate::latency::Times;
use crate::resident;

/// The costs since the process began to step the learner: one entry for each doubling of the number of schemas. A clone
/// shares them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Growth {
    /// By the logarithm of the number of schemas, rounded down.
    sizes: BTreeMap<u32, Arc<Size>>,
}

#[derive(Clone, Debug, Default)]
struct Size {
    times: Times,
    /// Resident memory of the process when the first of these steps was counted.
    memory_bytes: u64,
}

impl Growth {
    /// Counts a step that took `time` with `schemas` schemas in memory.
    pub(crate) fn count(&mut self, schemas: usize, time: Duration) {
        let size = self.sizes.entry(schemas.max(1).ilog2()).or_insert_with(|| {
            // Asked of the kernel once for each doubling.
            Arc::new(Size { times: Times::default(), memory_bytes: resident::bytes() })
        });
        Arc::make_mut(size).times.count(time);
    }

    /// The costs for tools, the smallest memory first.
    pub(crate) fn rows(&self) -> Vec<GrowthStatus> {
        let row = |(log, size): (&u32, &Arc<Size>)| GrowthStatus {
            schemas: if *log == 0 { 0 } else { 1_u32.checked_shl(*log).unwrap_or(u32::MAX) },
            steps: size.times.total(),
            step_latency_us_p50: size.times.quantile_us(0.5),
            step_latency_us_p99: size.times.quantile_us(0.99),
            memory_bytes: size.memory_bytes,
        };
        self.sizes.iter().map(row).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_told_by_the_size_that_memory_had() {
        let mut growth = Growth::default();
        for (schemas, microseconds) in [(0, 10), (1, 10), (2, 20), (3, 20), (4, 40), (7, 40), (1_000_000, 80)]
        {
            growth.count(schemas, Duration::from_micros(microseconds));
        }
        let seen: Vec<_> = growth.rows().iter().map(|row| (row.schemas, row.steps)).collect();
        assert_eq!(seen, [(0, 2), (2, 2), (4, 2), (524_288, 1)]);
        for (row, microseconds) in growth.rows().iter().zip([10.0, 20.0, 40.0, 80.0]) {
            assert!((microseconds..=microseconds * 1.07).contains(&row.step_latency_us_p50), "{row:?}");
            assert!(row.memory_bytes > 0, "{row:?}");
        }
        let shared = growth.clone();
        growth.count(5, Duration::from_micros(1));
        assert_eq!((shared.rows()[2].steps, growth.rows()[2].steps), (2, 3), "a clone keeps what it saw");
    }
}
