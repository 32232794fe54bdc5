//! The file of budgets: what each work may cost, and what the comparison with it says.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::ErrorKind;
use std::path::Path;

use serde::Deserialize;

use crate::counted::Tally;
use crate::failure::CountFailure;
use crate::work::Work;

/// By how much a cost may differ from its budget, in either direction, as a share of the budget.
const TOLERANCE: f64 = 0.03;
/// Below this a figure is too small for a share of it to mean anything.
const SMALLEST: f64 = 0.5;

const HEADING: &str = "\
# What each work costs: for one round of it, the instructions in this project's own program (those of the C library left out),
# the allocations, and their bytes. Written by
#
#     cargo run --release -p pschema-counts -- --rewrite
#
# and compared by the same command without `--rewrite`. A change that brings a figure more than 3 % above or below its budget writes the
# new budget here, in the same commit.
";

/// What one round of a work costs.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cost {
    /// None where they were not counted.
    instructions: Option<f64>,
    allocations: f64,
    allocated_bytes: f64,
}

impl Cost {
    /// The cost of a round, from the tally of all rounds and the instructions of all rounds.
    pub(crate) fn of(tally: &Tally, instructions: Option<u64>) -> Self {
        let rounds = tally.rounds.max(1) as f64;
        let a_round = |all: u64| all as f64 / rounds;
        Self {
            instructions: instructions.map(a_round),
            allocations: a_round(tally.allocations),
            allocated_bytes: a_round(tally.allocated_bytes),
        }
    }

    /// Its figures by name.
    fn figures(&self) -> [(&'static str, Option<f64>); 3] {
        let Self { instructions, allocations, allocated_bytes } = *self;
        [
            ("instructions", instructions),
            ("allocations", Some(allocations)),
            ("allocated_bytes", Some(allocated_bytes)),
        ]
    }
}

/// The budgets of all works.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Budgets {
    /// The compiler with which they were counted, as `rustc --version` has it: another compiles other instructions.
    rustc: String,
    work: BTreeMap<String, Cost>,
}

/// What the comparison of costs with their budgets says.
#[derive(Debug)]
pub(crate) struct Comparison {
    pub(crate) is_kept: bool,
    pub(crate) text: String,
}

impl Budgets {
    /// Reads the file.
    pub(crate) fn read(path: &Path) -> Result<Self, CountFailure> {
        let text = std::fs::read_to_string(path).map_err(|error| match error.kind() {
            ErrorKind::NotFound => CountFailure::NoBudgets(path.to_owned()),
            _ => CountFailure::file(path)(error),
        })?;
        toml::from_str(&text).map_err(CountFailure::file(path))
    }

    /// Budgets of what was counted just now.
    pub(crate) fn of(counted: &[(Work, Cost)]) -> Self {
        let work = counted.iter().map(|(work, cost)| (work.name(), *cost)).collect();
        Self { rustc: compiler(), work }
    }

    /// Writes the file.
    pub(crate) fn write(&self, path: &Path) -> Result<(), CountFailure> {
        std::fs::write(path, self.text()).map_err(CountFailure::file(path))
    }

    fn text(&self) -> String {
        let mut text = format!("{HEADING}rustc = {:?}\n\n[work]\n", self.rustc);
        for (name, cost) in &self.work {
            let figures = cost.figures().into_iter().filter_map(|(figure, value)| {
                let value = value?;
                Some(format!("{figure} = {value:.*}", usize::from(value < 1_000.0)))
            });
            let figures: Vec<String> = figures.collect();
            writeln!(text, "{name:?} = {{ {} }}", figures.join(", "))
                .unwrap_or_else(|error| unreachable!("{error}"));
        }
        text
    }

    /// Compares what was counted; where `all` is set a budget of which nothing was counted is a fault.
    pub(crate) fn compare(&self, counted: &[(Work, Cost)], all: bool) -> Comparison {
        let mut text = String::new();
        let (mut faults, mut changes) = (Vec::new(), Vec::new());
        for (work, cost) in counted {
            let name = work.name();
            let Some(budget) = self.work.get(&name) else {
                faults.push(format!("{name} has no budget"));
                continue;
            };
            let mut line = format!("{name:<28}");
            for ((figure, now), (_, allowed)) in cost.figures().into_iter().zip(budget.figures()) {
                let (Some(now), Some(allowed)) = (now, allowed) else { continue };
                let change = (now - allowed) / allowed.max(SMALLEST);
                line.push_str(&format!("  {figure} {now:.1} ({:+.1} %)", change * 100.0));
                if change.abs() > TOLERANCE {
                    changes.push(format!(
                        "{name}: {figure} {now:.1}, and its budget is {allowed:.1} ({:+.1} %)",
                        change * 100.0
                    ));
                }
            }
            text.push_str(&line);
            text.push('\n');
        }
        let known = |name: &&String| !counted.iter().any(|(work, _)| work.name() == **name);
        faults.extend(
            self.work
                .keys()
                .filter(known)
                .filter(|_| all)
                .map(|name| format!("{name} has a budget and is no work")),
        );
        let compiler = compiler();
        let is_same_compiler = compiler == self.rustc;
        for told in faults.iter().chain(&changes) {
            text.push_str(&format!("{told}\n"));
        }
        let is_kept = faults.is_empty() && (changes.is_empty() || !is_same_compiler);
        if !is_kept {
            text.push_str(BEYOND);
        } else if !changes.is_empty() {
            text.push_str(&format!("{ELSEWHERE}Budgets: {}. Here: {compiler}.\n", self.rustc));
        }
        Comparison { is_kept, text }
    }
}

/// What to do when a budget is not kept.
const BEYOND: &str = "\
Budgets are kept within 3 %, in both directions. If the change is meant, write the new budgets with
    cargo run --release -p pschema-counts -- --rewrite
and say in the message of the same commit what costs more or less, and why. If it is not meant, find what it is that the change
made dearer: `callgrind_annotate` shows the instructions by function.
";

/// What to do when budgets are not kept and the compiler is another.
const ELSEWHERE: &str = "\
The budgets were counted with another compiler, so nothing follows from the differences. Rewrite them on a commit that changes
nothing else, with
    cargo run --release -p pschema-counts -- --rewrite
";

/// What `rustc --version` says of the compiler that compiled this program.
fn compiler() -> String {
    env!("PSCHEMA_COUNTS_RUSTC").to_owned()
}

#[cfg(test)]
mod tests {
    use super::{Budgets, Cost};
    use crate::work::Work;

    fn counted(instructions: f64, allocations: f64) -> Vec<(Work, Cost)> {
        let cost = Cost { instructions: Some(instructions), allocations, allocated_bytes: 5_000.0 };
        vec![(Work::Frame, cost)]
    }

    #[test]
    fn what_is_written_is_read_back() {
        let text = Budgets::of(&counted(12_345.0, 2.5)).text();
        let back: Budgets = toml::from_str(&text).unwrap();
        assert!(back.compare(&counted(12_345.0, 2.5), true).is_kept, "{text}");
    }

    #[test]
    fn a_change_beyond_three_percent_fails_in_either_direction_and_says_what_to_do() {
        let budgets = Budgets::of(&counted(100_000.0, 10.0));
        for (kept, instructions, allocations) in [
            (true, 102_900.0, 10.0),
            (true, 97_100.0, 9.8),
            (false, 103_100.0, 10.0),
            (false, 96_900.0, 10.0),
            (false, 100_000.0, 11.0),
        ] {
            let comparison = budgets.compare(&counted(instructions, allocations), true);
            assert_eq!(comparison.is_kept, kept, "{}", comparison.text);
            assert_eq!(comparison.text.contains("--rewrite"), !kept, "{}", comparison.text);
        }
    }

    #[test]
    fn where_nothing_was_allocated_one_allocation_is_a_change() {
        let budgets = Budgets::of(&counted(100.0, 0.0));
        assert!(budgets.compare(&counted(100.0, 0.0), true).is_kept);
        assert!(!budgets.compare(&counted(100.0, 1.0), true).is_kept);
    }

    #[test]
    fn works_and_budgets_are_the_same() {
        let budgets = Budgets::of(&[]);
        assert!(budgets.compare(&counted(1.0, 1.0), true).text.contains("has no budget"));
        let budgets = Budgets::of(&counted(1.0, 1.0));
        assert!(budgets.compare(&[], true).text.contains("is no work"));
        assert!(budgets.compare(&[], false).is_kept);
    }

    #[test]
    fn under_another_compiler_differences_are_only_told() {
        let mut budgets = Budgets::of(&counted(100_000.0, 10.0));
        budgets.rustc = "rustc 1.0.0".to_owned();
        let comparison = budgets.compare(&counted(200_000.0, 10.0), true);
        assert!(comparison.is_kept && comparison.text.contains("another compiler"), "{}", comparison.text);
    }
}
