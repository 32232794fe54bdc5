//! Experiment 1, scenario 1, on an abstract table: the counts of the paper's table follow from the learner
//! alone.

mod common;

use common::{Table, exp1_s1};
use pschema_learner::parameters::Parameters;

fn run(seed: u64, fields: i64) -> Table {
    let within = 100;
    let mut table = Table::new(seed, fields, within, exp1_s1(within, 8), Parameters::default());
    for _ in 0..5_000 {
        if !table.step() {
            return table;
        }
    }
    panic!("seed {seed}: not finished after 5,000 steps: {:?}", table.learner.memory().content().progress);
}

#[test]
fn scenario_1_learns_to_touch_everywhere_from_two_places() {
    for (seed, fields) in (1..=10).map(|seed| (seed, 224)).chain([(1, 112), (2, 112)]) {
        let table = run(seed, fields);
        let content = table.learner.memory().content();
        let reports = &content.progress.reports;
        assert!(content.progress.finished, "{:?}", content.progress);
        // 224 (112) babbled, two touches, one generalised, and the counter-example out of reach.
        assert_eq!(content.schemas.len() as i64, fields + 4, "seed {seed}: {reports:?}");
        assert_eq!(reports[1].generalised_after_trial, [0, 1], "seed {seed}");
        assert_eq!(reports[2].trials_met_first, 1, "seed {seed}");
        assert_eq!(reports[3].counter_examples_new, 1, "seed {seed}");
        assert_eq!((reports[4].trials, reports[4].trials_met_first), (97, 97), "seed {seed}");
    }
}
