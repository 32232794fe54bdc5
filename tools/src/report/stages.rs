//! What each stage did: saturation and habituation (II-F, II-G), and its trials.

use std::collections::BTreeMap;

use maud::{Markup, html};

use crate::run::{Outcome, Trial};

use super::section::Section;
use super::table::table;

/// Trials whose actions are listed one by one.
const TRIALS_LISTED_MAX: usize = 24;

/// What the steps of one stage say of it.
#[derive(Clone, Debug, Default, PartialEq)]
struct StageCounts {
    quiet_max: u32,
    habituating: u32,
    /// How often each schema was chosen.
    executions: BTreeMap<u32, u32>,
}

/// The tables, of the first seed of the experiment as it stands.
pub(super) fn tables(section: &Section<'_>) -> Option<Markup> {
    let outcome = section.first()?;
    Some(html! {
        (stages(outcome))
        (trials(outcome))
    })
}

fn stages(outcome: &Outcome) -> Markup {
    let counted = counted(outcome);
    let counts = |name: &str| outcome.trace.stage_index(name).and_then(|stage| counted.get(&stage));
    table(
        &html! {
            b { "Stages." } " Seed " (outcome.results.seed) ". A stage is saturated after so many quiet actions in a \
            row: nothing new, and nothing as exciting as its level. Habituating are the steps after that, in \
            which what is not known well enough is repeated. Executions: of each schema chosen in the stage, \
            fewest, median and most."
        },
        &html! {
            th { "stage" } th.n { "actions" } th.n { "schemas" } th.n { "generalised" }
            th.n { "counter-examples" } th.n { "longest quiet streak" } th.n { "habituating" }
            th.n { "executions" } th { "ended by" }
        },
        &html! {
            @for stage in &outcome.results.stages {
                @let counts = counts(&stage.name);
                tr {
                    td { (stage.name) @if !stage.learning { " (frozen)" } }
                    td.n { (stage.actions) }
                    td.n { (stage.schemas_new) }
                    td.n { (stage.generalised_new) }
                    td.n { (stage.counter_examples_new) }
                    td.n { (counts.map_or(0, |counts| counts.quiet_max)) }
                    td.n { (counts.map_or(0, |counts| counts.habituating)) }
                    td.n { (counts.map_or_else(String::new, |counts| spread(&counts.executions))) }
                    td { (if stage.saturated { "saturation" } else { "its trials" }) }
                }
            }
        },
    )
}

/// What the steps say of each stage, by its index.
fn counted(outcome: &Outcome) -> BTreeMap<u32, StageCounts> {
    let mut stages: BTreeMap<u32, StageCounts> = BTreeMap::new();
    let mut before = 0;
    for record in outcome.trace.steps.iter().map(|step| &step.record) {
        // The last action of a stage is reported by the step that enters the next.
        let acted_in = stages.entry(before).or_default();
        acted_in.quiet_max = acted_in.quiet_max.max(record.quiet_actions);
        before = record.stage;
        let stage = stages.entry(record.stage).or_default();
        stage.habituating += u32::from(record.habituating);
        if let Some(schema) = record.decision.as_ref().and_then(|decision| decision.schema) {
            *stage.executions.entry(schema).or_default() += 1;
        }
    }
    stages
}

/// `1 / 1 / 3`.
fn spread(executions: &BTreeMap<u32, u32>) -> String {
    let mut all: Vec<_> = executions.values().copied().collect();
    all.sort_unstable();
    match (all.first(), all.get(all.len() / 2), all.last()) {
        (Some(fewest), Some(median), Some(most)) => format!("{fewest} / {median} / {most}"),
        _ => String::new(),
    }
}

fn trials(outcome: &Outcome) -> Markup {
    let all = outcome.trace.trials();
    if all.is_empty() {
        return html! {};
    }
    table(
        &html! {
            b { "Trials." } " Seed " (outcome.results.seed) ". A trial ends with what its stage waits for (met), \
            or after so many actions. Bold: met; each figure is the actions of one trial."
        },
        &html! {
            th { "stage" } th.n { "trials" } th.n { "met" } th.n { "at the first try" }
            th { "actions of each trial" }
        },
        &html! {
            @for stage in outcome.results.stages.iter().filter(|stage| stage.trials > 0) {
                tr {
                    td { (stage.name) }
                    td.n { (stage.trials) }
                    td.n { (stage.trials_met) }
                    td.n { (stage.trials_met_first) }
                    td { (listed(outcome, &all, &stage.name)) }
                }
            }
        },
    )
}

fn listed(outcome: &Outcome, trials: &[Trial], stage: &str) -> Markup {
    let own: Vec<_> = trials.iter().filter(|trial| outcome.trace.stage(trial.stage) == stage).collect();
    html! {
        @for trial in own.iter().take(TRIALS_LISTED_MAX) {
            @if trial.met == Some(true) { b { (trial.actions) } } @else { (trial.actions) }
            " "
        }
        @if own.len() > TRIALS_LISTED_MAX { "and " (own.len() - TRIALS_LISTED_MAX) " more" }
    }
}
