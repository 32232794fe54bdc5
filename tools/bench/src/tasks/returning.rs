//! Whether what was there is expected to be there still, when a sense shows again what it showed before the last action.

use std::collections::BTreeSet;

use pschema_exact::Distribution;
use pschema_learner::observation::{Observation, TypeId};
use pschema_learner::world_state::WorldState;

/// What was expected at returns: after one action that changed the sense, and one that changes it back.
pub(crate) struct Returning {
    /// The type of the sense.
    kind: TypeId,
    /// The world before the last action, and the one before that.
    earlier: [Option<WorldState>; 2],
    /// All that was ever there.
    met: BTreeSet<Observation>,
    /// The sum of the probabilities with which it was expected that something is there, and how many there were: of what was there
    /// before the first action and is out of sight after it, and of what was not there.
    there: (f64, usize),
    elsewhere: (f64, usize),
}

impl Returning {
    pub(crate) fn to(kind: TypeId) -> Self {
        let nothing = (0.0, 0);
        Self { kind, earlier: [None, None], met: BTreeSet::new(), there: nothing, elsewhere: nothing }
    }

    /// Notes the next world, after what was `foretold` of it; none if this one does not follow from the last.
    pub(crate) fn note(&mut self, world: &WorldState, foretold: Option<&Distribution<WorldState>>) {
        if let (Some(foretold), [Some(last), Some(before)]) = (foretold, &self.earlier) {
            let of = |world: &WorldState| -> Vec<Observation> {
                world.observations().iter().filter(|o| o.kind() == self.kind).cloned().collect()
            };
            if of(world) == of(before) && of(world) != of(last) {
                for one in self.met.iter().filter(|one| one.kind() != self.kind && !last.contains(one)) {
                    let expected = foretold.iter().filter(|(world, _)| world.contains(one));
                    let expected: f64 = expected.map(|(_, probability)| probability).sum();
                    let sum = if before.contains(one) { &mut self.there } else { &mut self.elsewhere };
                    sum.0 += expected;
                    sum.1 += 1;
                }
            }
        }
        self.met.extend(world.observations().iter().cloned());
        let [last, _] = std::mem::take(&mut self.earlier);
        let last = last.filter(|_| foretold.is_some());
        self.earlier = [Some(world.clone()), last];
    }

    /// The mean probability that was given to what was there, and to what was not; none where there was no return.
    pub(crate) fn means(&self) -> Option<[f64; 2]> {
        let mean = |(sum, count): (f64, usize)| (count > 0).then(|| sum / count as f64);
        Some([mean(self.there)?, mean(self.elsewhere)?])
    }
}

#[cfg(test)]
mod tests {
    use pschema_learner::observation::{PropertyId, Value};

    use super::*;

    #[test]
    fn what_is_out_of_sight_for_one_action_is_asked_for_when_it_comes_back() {
        let place = |at: i64| Observation::new(TypeId(0), [(PropertyId(0), Value::Integer(at))]);
        let (lamp, cup) = (Observation::new(TypeId(1), []), Observation::new(TypeId(2), []));
        let [with_lamp, away] = [WorldState::new([place(1), lamp]), WorldState::new([place(2), cup])];
        let mut returning = Returning::to(TypeId(0));
        let told = |probability: f64| -> Distribution<WorldState> {
            let outcomes =
                [(with_lamp.clone(), probability), (WorldState::new([place(1)]), 1.0 - probability)];
            outcomes.into_iter().collect()
        };
        returning.note(&with_lamp, None);
        returning.note(&away, Some(&told(0.1)));
        assert_eq!(returning.means(), None, "it was away only once");
        returning.note(&with_lamp, Some(&told(0.75)));
        assert_eq!(returning.means(), None, "nothing was asked for that was not there");
        // The place changes back once more, and nobody expects the cup that was there.
        returning.note(&away, Some(&told(0.0)));
        assert_eq!(returning.there, (0.75, 2));
        // A world that does not follow is no return.
        returning.note(&with_lamp, None);
        assert_eq!(returning.there.1, 2);
    }
}
