//! A memory whose last decision can't be made again, as if another release had taken its last step.

use std::path::Path;

use pschema_learner::parameters::Parameters;
use pschema_learner::vocabulary::BodyId;
use pschema_learner::{ActionOutcome, Frame};
use pschema_server::config;
use pschema_store::{Cause, Change, Options};

/// Takes steps in the memory in `data` up to one that decides, and writes down more for it than it learnt; gives the
/// number of that step.
pub(crate) fn unlike(data: &Path) -> u64 {
    const TRIES: u32 = 20;
    let (parameters, curriculum) = (Parameters::default(), config::curriculum("free").unwrap());
    let options = Options::new("default", 7, &parameters, &curriculum);
    let options = Options { setting_given: false, ..options };
    let opened = pschema_store::open(data, options, || ()).unwrap();
    let (mut learner, mut store) = (opened.learner, opened.store);
    for _ in 0..TRIES {
        let frame = Frame { body: BodyId(0), outcome: Some(ActionOutcome::Done), observations: Vec::new() };
        let step = learner.step(&frame);
        let mut effects = step.effects;
        let decided = step.decision.is_some();
        if decided {
            effects.extend(learner.symbol("forged").1);
        }
        let change = Change { cause: Cause::Step(&frame), at_unix_ms: 0, effects: &effects };
        store.append(&change, learner.memory().content()).unwrap();
        if decided {
            let last = learner.memory().content().step;
            store.finish(learner.memory()).unwrap();
            return last;
        }
    }
    panic!("none of {TRIES} steps decided anything");
}
