//! Probabilities of outcomes, by how often they came.

use crate::memory::evidence::foretold::Foretold;
use crate::nouns::observation::Observation;

/// The probability of an outcome that came so often in so many trials, beside so many outcomes, with room for one that never came
/// (Krichevsky and Trofimov's estimate): so one lucky trial makes nothing certain.
pub(super) fn probability(count: u32, trials: u32, outcomes: usize) -> f64 {
    if count == 0 {
        return 0.0;
    }
    (f64::from(count) + 1.0 / (outcomes + 1) as f64) / (f64::from(trials) + 1.0)
}

/// An outcome of a facet, the observations of its types, with its probability.
pub(super) type Share = (Vec<Observation>, f64);

/// The probabilities of the outcomes of a facet, as claims give them.
pub(super) fn told_shares(facet: &Foretold) -> Vec<Share> {
    let ways = facet.outcomes.len();
    let told = facet.outcomes.iter();
    told.map(|(after, count)| (after.clone(), probability(*count, facet.trials, ways))).collect()
}

/// The probability of what a claim never saw come.
pub(super) fn untold(facet: &Foretold) -> f64 {
    1.0 / (facet.outcomes.len() + 1) as f64 / (f64::from(facet.trials) + 1.0)
}

/// How probable all is that came of the very same context, as ln: by what is told, which gives these `shares` and so much to what it does not
/// name, and by what came of that context alone.
pub(super) fn odds(shares: &[Share], untold: f64, alike: &[(Vec<Observation>, u32)]) -> (f64, f64) {
    let (mut by_claim, mut by_itself, mut met) = (0.0, 0.0, 0);
    for (after, count) in alike {
        let share = shares.iter().find(|(known, _)| known == after).map_or(untold, |(_, share)| *share);
        let share = share.max(untold);
        by_claim += f64::from(*count) * libm::log(share);
        for came in 0..*count {
            by_itself += libm::log((f64::from(came) + share) / f64::from(met + 1));
            met += 1;
        }
    }
    (by_claim, by_itself)
}

/// The probabilities of the outcomes of a facet. Where the very same context was met before, it may be an exception to the claim: so the
/// claim and what came of this context alone are weighed, each by how probable it makes all that came. At first both are as likely.
pub(super) fn shares(facet: &Foretold, alike: Vec<(Vec<Observation>, u32)>) -> Vec<Share> {
    let mut shares = told_shares(facet);
    if alike.is_empty() {
        return shares;
    }
    let untold = untold(facet);
    let (by_claim, by_itself) = odds(&shares, untold, &alike);
    let met: u32 = alike.iter().map(|(_, count)| count).sum();
    let itself = 1.0 / (1.0 + libm::exp(by_claim - by_itself));
    let all = f64::from(met) + 1.0;
    shares.iter_mut().for_each(|(_, share)| *share *= 1.0 - itself + itself / all);
    for (after, count) in alike {
        let came = itself * f64::from(count) / all;
        match shares.iter_mut().find(|(known, _)| *known == after) {
            Some((_, share)) => *share += came,
            None => shares.push((after, came + (1.0 - itself + itself / all) * untold)),
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::evidence::pool::CERTAIN;
    use crate::nouns::observation::TypeId;

    /// One context is an exception to what claims say as soon as it is certain, and not by one accident.
    #[test]
    fn what_came_three_times_of_one_context_alone_is_no_accident() {
        let [told, other] = [0, 1].map(|kind| vec![Observation::new(TypeId(kind), [])]);
        let shares = vec![(told, 0.95)];
        let is_certain = |times: u32| {
            let (by_claim, by_itself) = odds(&shares, 0.01, &[(other.clone(), times)]);
            by_itself > by_claim + CERTAIN
        };
        assert_eq!([1, 3].map(is_certain), [false, true]);
    }
}
