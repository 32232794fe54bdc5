//! Those beside whom the learner stands: they know an environment state by state, by the number of each state.

use fastrand::Rng;
use pschema_exact::Distribution;
use pschema_exact::tables::Table;

/// What is left of a value after an action.
const DISCOUNT: f64 = 0.99;
/// Values are known when none changes by more than this in a sweep.
const TOLERANCE: f64 = 1e-6;
/// Actions of Q-learning that are drawn at random.
const RANDOM_SHARE: f64 = 0.1;
/// How far one experience moves a value of Q-learning.
const RATE: f64 = 0.5;

/// Who chooses the actions of a life, and of the tests after it.
pub(crate) trait Tabular {
    /// The next action in `state`.
    fn act(&mut self, state: usize, random: &mut Rng) -> usize;

    /// Learns what came of `action`.
    fn learn(&mut self, table: &Table, state: usize, action: usize, after: usize);

    /// What it does in each state when it is to succeed; none: it draws.
    fn policy(&self, table: &Table) -> Option<Vec<usize>>;
}

/// How often each state came of each action in each state.
struct Counts(Vec<Vec<Vec<(usize, u32)>>>);

impl Counts {
    fn new(table: &Table, actions: usize) -> Self {
        Self(vec![vec![Vec::new(); actions]; table.states.len()])
    }

    fn add(&mut self, state: usize, action: usize, after: usize) {
        let known = &mut self.0[state][action];
        match known.iter_mut().find(|(to, _)| *to == after) {
            Some((_, count)) => *count += 1,
            None => known.push((after, 1)),
        }
    }

    fn of(&self, state: usize, action: usize) -> (u32, impl Iterator<Item = (usize, f64)> + '_) {
        let known = &self.0[state][action];
        let total: u32 = known.iter().map(|(_, count)| count).sum();
        (total, known.iter().map(move |(to, count)| (*to, f64::from(*count) / f64::from(total))))
    }
}

/// What each state is worth to who acts best, when `worth` is what an action in a state is worth by the values so far; `values` is where it
/// begins.
fn settle(values: &mut [f64], actions: usize, worth: impl Fn(usize, usize, &[f64]) -> f64) {
    for _ in 0..10_000 {
        let mut most: f64 = 0.0;
        for state in 0..values.len() {
            let best = (0..actions).map(|action| worth(state, action, values)).fold(0.0, f64::max);
            most = most.max((best - values[state]).abs());
            values[state] = best;
        }
        if most < TOLERANCE {
            return;
        }
    }
}

/// The best action of each state by `worth`; of equals the first.
fn best(values: &[f64], actions: usize, worth: impl Fn(usize, usize, &[f64]) -> f64) -> Vec<usize> {
    let of = |state| {
        (0..actions).fold((0, f64::NEG_INFINITY), |(best, most), action| {
            let worth = worth(state, action, values);
            if worth > most { (action, worth) } else { (best, most) }
        })
    };
    (0..values.len()).map(|state| of(state).0).collect()
}

/// The policy that succeeds most surely, and of equals soonest, by what was counted.
fn most_successful(table: &Table, counts: &Counts, actions: usize) -> Vec<usize> {
    let mut values = vec![0.0; table.states.len()];
    let worth = |state: usize, action: usize, values: &[f64]| {
        let arrives = |to: usize| if table.succeeds(to) { 1.0 } else { values[to] };
        let (_, outcomes) = counts.of(state, action);
        0.999 * outcomes.map(|(to, share)| share * arrives(to)).sum::<f64>()
    };
    settle(&mut values, actions, worth);
    best(&values, actions, worth)
}

/// R-max: what was tried less than so often is taken for the best that there is.
pub(crate) struct RMax {
    counts: Counts,
    actions: usize,
    /// How often an action must have been tried in a state to be known there.
    tries: u32,
    values: Vec<f64>,
    policy: Vec<usize>,
    starts: Vec<usize>,
}

impl RMax {
    pub(crate) fn new(table: &Table, actions: usize, tries: u32) -> Self {
        let states = table.states.len();
        let (counts, starts) = (Counts::new(table, actions), table.starts.clone());
        Self { counts, actions, tries, values: vec![1.0; states], policy: vec![0; states], starts }
    }
}

impl Tabular for RMax {
    fn act(&mut self, state: usize, random: &mut Rng) -> usize {
        let untried = (0..self.actions).filter(|action| self.counts.of(state, *action).0 < self.tries);
        random.choice(untried.collect::<Vec<_>>()).unwrap_or(self.policy[state])
    }

    fn learn(&mut self, table: &Table, state: usize, action: usize, after: usize) {
        self.counts.add(state, action, after);
        // Plans change when something becomes known.
        if self.counts.of(state, action).0 != self.tries {
            return;
        }
        let Self { counts, actions, tries, values, policy, starts } = self;
        let worth = |state: usize, action: usize, values: &[f64]| {
            if table.states[state].next.is_none() {
                let start = starts.iter().map(|start| values[*start]).fold(0.0, f64::max);
                return DISCOUNT * start;
            }
            match counts.of(state, action) {
                (count, _) if count < *tries => 1.0,
                (_, outcomes) => DISCOUNT * outcomes.map(|(to, share)| share * values[to]).sum::<f64>(),
            }
        };
        settle(values, *actions, worth);
        *policy = best(values, *actions, worth);
    }

    fn policy(&self, table: &Table) -> Option<Vec<usize>> {
        Some(most_successful(table, &self.counts, self.actions))
    }
}

/// Q-learning, with a reward for success.
pub(crate) struct QLearning(Vec<Vec<f64>>);

impl QLearning {
    pub(crate) fn new(table: &Table, actions: usize) -> Self {
        Self(vec![vec![0.0; actions]; table.states.len()])
    }

    fn most(&self, state: usize) -> f64 {
        self.0[state].iter().copied().fold(0.0, f64::max)
    }
}

impl Tabular for QLearning {
    fn act(&mut self, state: usize, random: &mut Rng) -> usize {
        let values = &self.0[state];
        if random.f64() < RANDOM_SHARE {
            return random.usize(..values.len());
        }
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let best: Vec<_> = (0..values.len()).filter(|action| values[*action] >= most).collect();
        random.choice(best).unwrap_or(0)
    }

    fn learn(&mut self, table: &Table, state: usize, action: usize, after: usize) {
        let gained = match (table.succeeds(after), &table.states[after].next) {
            (true, _) => 1.0,
            (false, None) => 0.0,
            (false, Some(_)) => DISCOUNT * self.most(after),
        };
        self.0[state][action] += RATE * (gained - self.0[state][action]);
    }

    fn policy(&self, _: &Table) -> Option<Vec<usize>> {
        let best = |values: &Vec<f64>| {
            (0..values.len())
                .fold(0, |best, action| if values[action] > values[best] { action } else { best })
        };
        Some(self.0.iter().map(best).collect())
    }
}

/// Random actions. After a life of them it does what its counts say is best, or goes on drawing.
pub(crate) struct AtRandom {
    counts: Counts,
    actions: usize,
    learns: bool,
}

impl AtRandom {
    pub(crate) fn new(table: &Table, actions: usize, learns: bool) -> Self {
        Self { counts: Counts::new(table, actions), actions, learns }
    }
}

impl Tabular for AtRandom {
    fn act(&mut self, _: usize, random: &mut Rng) -> usize {
        random.usize(..self.actions)
    }

    fn learn(&mut self, _: &Table, state: usize, action: usize, after: usize) {
        self.counts.add(state, action, after);
    }

    fn policy(&self, table: &Table) -> Option<Vec<usize>> {
        self.learns.then(|| most_successful(table, &self.counts, self.actions))
    }
}

/// The best that there is: of each state the probability of success in so many actions, and the number of actions of the shortest way;
/// none where no way leads.
pub(crate) fn truth(table: &Table, actions: usize, most: usize) -> Vec<(f64, Option<f64>)> {
    let states = table.states.len();
    let outcomes = |state: usize| {
        let arrives = move |to: &usize| if table.succeeds(*to) { 1.0 } else { 0.0 };
        (0..actions).filter_map(move |action| Some((table.next(state, action)?, arrives)))
    };
    let (mut success, mut far) = (vec![0.0_f64; states], vec![None; states]);
    for depth in 1..=most {
        let (before, reached) = (success.clone(), far.clone());
        for state in 0..states {
            for (next, arrives) in outcomes(state) {
                let next: &Distribution<usize> = next;
                let succeeds: f64 = next.iter().map(|(to, p)| p * (arrives(to) + before[*to])).sum();
                success[state] = success[state].max(succeeds);
                let leads = next.iter().any(|(to, _)| arrives(to) > 0.0 || reached[*to].is_some());
                if leads && far[state].is_none() {
                    far[state] = Some(depth as f64);
                }
            }
        }
    }
    success.into_iter().zip(far).collect()
}
