//! Whether the learner arrives where it is sent after a life of its own choices, in environments that everybody uses; beside the best
//! that there is, R-max, Q-learning and random actions on the same states.

mod ours;
mod tabular;
mod walk;

use clap::Args;
use fastrand::Rng;
use pschema_exact::chances;
use pschema_exact::tables::Table;
use pschema_learner::mechanisms::Mechanisms;
use pschema_process::say;
use pschema_tools::kit::{Columns, Failure, interval, show, summary};
use serde::Serialize;

use crate::tasks::{FigureSummary, LivesAsked};
use tabular::{AtRandom, QLearning, RMax, Tabular, truth};
use walk::Walk;

/// Episodes of a test.
const EPISODES: usize = 100;
/// Actions of an episode, at most.
const ACTIONS_MAX: usize = 200;
/// The seed of the tests: they are the same for all.
const TESTS_SEED: u64 = 999;
/// How often R-max tries an action in a state: where there is no chance, and where there is.
const TRIES: [u32; 2] = [1, 10];

/// The environments, each with the actions of a life, in the order in which they are shown.
const LIVES: &[(&str, usize)] = &[
    ("lake-4", 500),
    ("lake-8", 2_000),
    ("lake-4-slippery", 10_000),
    ("lake-8-slippery", 40_000),
    ("cliff", 500),
    ("taxi", 4_000),
    ("empty-8", 2_000),
    ("door-key-5", 2_000),
    ("empty-5-seen", 2_000),
    ("door-key-5-seen", 10_000),
];

/// The environments to measure.
#[derive(Debug, Args)]
pub(crate) struct GoalsArgs {
    /// Only this environment
    #[arg(long, value_name = "NAME", value_parser = known)]
    environment: Option<String>,
    /// Actions of a life, instead of those of each environment
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    actions: Option<u32>,
    #[command(flatten)]
    lives: LivesAsked,
}

/// An environment that there is.
fn known(text: &str) -> Result<String, String> {
    let names = || Table::names().collect::<Vec<_>>().join(", ");
    let known = Table::names().any(|name| name == text);
    known
        .then(|| text.to_owned())
        .ok_or_else(|| format!("there is no such environment; there are {}", names()))
}

/// The share of episodes that succeed as a part of the best, and how long those that succeed are as a multiple of the shortest way.
#[derive(Debug, Serialize)]
struct Arrival {
    success: FigureSummary,
    longer: Option<FigureSummary>,
}

/// An environment, over all seeds.
#[derive(Debug, Serialize)]
struct EnvironmentFigures {
    environment: String,
    source: String,
    actions: usize,
    /// The share of episodes in which the best policy succeeds.
    best: f64,
    ours: Arrival,
    paper: Arrival,
    r_max: Arrival,
    random_counts: Arrival,
    q_learning: Arrival,
    random: Arrival,
    step_us: f64,
    schemas: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct GoalsMeasurement {
    seeds: usize,
    /// The mechanisms that are on in `ours`.
    mechanisms: Vec<&'static str>,
    rows: Vec<EnvironmentFigures>,
}

/// What came of one life: the share of its test's episodes that succeeded, and their length beside the shortest.
#[derive(Clone, Copy, Debug)]
struct Test {
    success: f64,
    longer: Option<f64>,
}

pub(crate) fn run(args: &GoalsArgs, quiet: bool) -> Result<(), Failure> {
    let seeds: Vec<u64> = args.lives.seeds.iter().collect();
    let ours = args.lives.mechanisms();
    let chosen =
        LIVES.iter().filter(|(name, _)| args.environment.as_deref().is_none_or(|only| only == *name));
    let mut rows = Vec::new();
    for (name, actions) in chosen {
        let actions = args.actions.map_or(*actions, |actions| actions as usize);
        if !quiet {
            say(&format!("{name}: {} lives of {actions} actions", seeds.len()));
        }
        let Some(environment) = Environment::new(name, actions) else {
            return Err(Failure::Failed(format!("{name}: no such table")));
        };
        rows.extend(environment.figures(&seeds, ours)?);
    }
    let mechanisms = ours.named().into_iter().filter_map(|(name, on)| on.then_some(name)).collect();
    show(args.lives.json, &GoalsMeasurement { seeds: seeds.len(), mechanisms, rows }, text)
}

struct Environment {
    name: String,
    table: Table,
    /// The number of actions in its repertoire.
    repertoire: usize,
    /// The actions of a life.
    actions: usize,
    best: Vec<(f64, Option<f64>)>,
}

impl Environment {
    fn new(name: &str, actions: usize) -> Option<Self> {
        let table = Table::named(name)?;
        let repertoire = table.states.iter().find_map(|state| state.next.as_ref()).map_or(0, Vec::len);
        let best = truth(&table, repertoire, ACTIONS_MAX);
        Some(Self { name: name.to_owned(), table, repertoire, actions, best })
    }

    fn is_by_chance(&self) -> bool {
        let next = self.table.states.iter().flat_map(|state| state.next.iter().flatten());
        next.into_iter().any(|outcomes| outcomes.iter().count() > 1)
    }

    /// Has `episode` go through the episodes of a test. It returns how many actions it took, if it succeeded.
    fn test(
        &self,
        mut episode: impl FnMut(&mut Walk<'_>) -> Result<Option<usize>, Failure>,
    ) -> Result<Test, Failure> {
        let mut walk = Walk::begin(&self.table, TESTS_SEED);
        let (mut succeeded, mut best, mut taken, mut shortest) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..EPISODES {
            walk.again();
            let (likely, far) = self.best[walk.state];
            best += likely;
            if let Some(actions) = episode(&mut walk)? {
                succeeded += 1.0;
                taken += actions as f64;
                shortest += far.unwrap_or(0.0);
            }
        }
        let longer = (succeeded > 0.0 && !self.is_by_chance()).then(|| taken / shortest);
        Ok(Test { success: succeeded / best, longer })
    }

    fn ours(&self, seed: u64, mechanisms: Mechanisms) -> Result<(Test, f64, usize), Failure> {
        let student = ours::live(&self.table, seed, self.actions, mechanisms)?;
        let test = self.test(|walk| {
            let goal = self.table.goal(walk.state);
            ours::pursue(&student, walk, &goal, ACTIONS_MAX)
        })?;
        Ok((test, student.step_us(), student.schemas()))
    }

    fn tabular(&self, seed: u64, mut agent: impl Tabular) -> Result<Test, Failure> {
        let (mut walk, mut random) = (Walk::begin(&self.table, seed), chances(!seed));
        for _ in 0..self.actions {
            let (state, action) = (walk.state, agent.act(walk.state, &mut random));
            walk.act(action);
            agent.learn(&self.table, state, action, walk.state);
            if walk.is_over() {
                walk.again();
            }
        }
        let policy = agent.policy(&self.table);
        let next = |state: usize, random: &mut Rng| {
            policy.as_ref().map_or_else(|| random.usize(..self.repertoire), |policy| policy[state])
        };
        self.test(|walk| {
            for taken in 1..=ACTIONS_MAX {
                walk.act(next(walk.state, &mut random));
                if walk.is_over() {
                    return Ok(self.table.succeeds(walk.state).then_some(taken));
                }
            }
            Ok(None)
        })
    }

    fn figures(&self, seeds: &[u64], mechanisms: Mechanisms) -> Result<Option<EnvironmentFigures>, Failure> {
        let (table, repertoire) = (&self.table, self.repertoire);
        let lives = |mechanisms| -> Result<Vec<_>, Failure> {
            seeds.iter().map(|seed| self.ours(*seed, mechanisms)).collect()
        };
        let (full, paper) = (lives(mechanisms)?, lives(Mechanisms::PAPER)?);
        let tests = |lives: &[(Test, f64, usize)]| arrival(lives.iter().map(|(test, ..)| *test).collect());
        let tries = TRIES[usize::from(self.is_by_chance())];
        let all = |live: &dyn Fn(u64) -> Result<Test, Failure>| -> Result<Option<Arrival>, Failure> {
            Ok(arrival(seeds.iter().map(|seed| live(*seed)).collect::<Result<_, _>>()?))
        };
        let r_max = all(&|seed| self.tabular(seed, RMax::new(table, repertoire, tries)))?;
        let q_learning = all(&|seed| self.tabular(seed, QLearning::new(table, repertoire)))?;
        let random_counts = all(&|seed| self.tabular(seed, AtRandom::new(table, repertoire, true)))?;
        let random = all(&|seed| self.tabular(seed, AtRandom::new(table, repertoire, false)))?;
        let best = table.starts.iter().map(|start| self.best[*start].0).sum::<f64>();
        let median = |figures: Vec<f64>| summary(figures).map_or(0.0, |figure| figure.median);
        let figures = || {
            Some(EnvironmentFigures {
                environment: self.name.clone(),
                source: table.source.clone(),
                actions: self.actions,
                best: best / table.starts.len() as f64,
                ours: tests(&full)?,
                paper: tests(&paper)?,
                r_max: r_max?,
                random_counts: random_counts?,
                q_learning: q_learning?,
                random: random?,
                step_us: median(full.iter().map(|(_, step_us, _)| *step_us).collect()),
                schemas: median(full.iter().map(|(.., schemas)| *schemas as f64).collect()),
            })
        };
        Ok(figures())
    }
}

/// The figures of lives; none when there was none.
fn arrival(tests: Vec<Test>) -> Option<Arrival> {
    let success = summary(tests.iter().map(|test| test.success).collect())?.into();
    let longer = summary(tests.iter().filter_map(|test| test.longer).collect()).map(FigureSummary::from);
    Some(Arrival { success, longer })
}

fn text(measurement: &GoalsMeasurement) -> String {
    let headings =
        ["environment", "ours", "interval", "longer", "paper", "r-max", "counts", "q", "random", "us"];
    let figures = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    let mut table = Columns::new(&headings).figures(&figures);
    for row in &measurement.rows {
        let ours = &row.ours.success;
        let others = [&row.paper, &row.r_max, &row.random_counts, &row.q_learning, &row.random];
        let others = others.map(|other| format!("{:.2}", other.success.median));
        let longer = row.ours.longer.as_ref().map_or(String::new(), |longer| format!("{:.2}", longer.median));
        let cells = [
            row.environment.clone(),
            format!("{:.2}", ours.median),
            format!("{:.2}-{:.2}", ours.low, ours.high),
            longer,
        ];
        let last = format!("{:.0}", row.step_us);
        table.row(cells.into_iter().chain(others).chain([last]));
    }
    format!(
        "{}Share of {EPISODES} episodes that succeed after a life of own choices, as a part of what the best policy reaches: 1 is perfect.\n\
        ours: the learner with {}, median of {} seeds, with {}; paper: under the paper's profile\n\
        longer: the actions of episodes that succeed, as a multiple of the shortest way; us: the time of a step\n\
        r-max, q: R-max and Q-learning, which know the number of each state; counts: the best by what random actions taught; random: random actions\n",
        table.text(&figures),
        measurement.mechanisms.join(", "),
        measurement.seeds,
        interval(measurement.seeds)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is published of these environments, or follows from their maps.
    #[test]
    fn the_best_is_as_published() {
        let best = |name: &str| {
            let environment = Environment::new(name, 0).unwrap();
            environment.best[environment.table.starts[0]]
        };
        for (name, actions) in [("lake-4", 6.0), ("lake-8", 14.0), ("cliff", 13.0), ("empty-8", 11.0)] {
            assert_eq!(best(name), (1.0, Some(actions)), "{name}");
        }
        assert!((best("lake-4-slippery").0 - 0.817).abs() < 0.001, "{:?}", best("lake-4-slippery"));
        assert!((best("lake-8-slippery").0 - 0.913).abs() < 0.001, "{:?}", best("lake-8-slippery"));
    }

    #[test]
    fn r_max_knows_a_lake_after_500_actions_and_random_actions_do_not() {
        let environment = Environment::new("lake-4", 500).unwrap();
        let r_max = environment.tabular(1, RMax::new(&environment.table, 4, 1)).unwrap();
        assert_eq!((r_max.success, r_max.longer), (1.0, Some(1.0)));
        let random = environment.tabular(1, AtRandom::new(&environment.table, 4, false)).unwrap();
        assert!(random.success < 0.1, "{random:?}");
    }
}
