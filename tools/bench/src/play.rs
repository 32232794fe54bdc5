//! How soon the learner's own choices lead to a true model, and how much of its time goes to what can't be learnt; beside R-max, which
//! knows each state as a whole, and random actions.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use clap::Args;
use fastrand::Rng;
use pschema_exact::declaration::Primitive;
use pschema_exact::{Distribution, Situation, chances, open};
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::vocabulary::PrimitiveId;
use pschema_learner::world_state::WorldState;
use pschema_process::say;
use pschema_tools::kit::{Columns, Failure, interval, show, summary};
use serde::Serialize;

use crate::tasks::foretelling::Foretelling;
use crate::tasks::student::Student;
use crate::tasks::{FigureSummary, LivesAsked};

/// Random states among which all those are looked for that there are.
const STATES: usize = 4_000;
/// A model is looked at after so many actions, and again.
const EVERY: usize = 20;
/// A model is true when it is no further from the truth than this, on average over all that may be done in all states.
const TRUE: f64 = 0.01;
/// An action is mastered when so many of its last executions were foretold.
const MASTERED: (usize, usize) = (18, 20);

/// What is asked of a life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Question {
    /// After how many actions the model is true.
    Truth,
    /// After how many actions as many of the first sense are observed as there ever may be.
    Most,
    /// Which part of the actions goes where, and when each is mastered.
    Shares,
}

/// The worlds, each with the question and the actions of a life at most, in the order in which they are shown.
const PLAYS: &[(&str, Question, usize)] = &[
    ("blocks", Question::Truth, 5_000),
    ("puzzle", Question::Most, 5_000),
    ("puzzle:lamps=0", Question::Most, 5_000),
    ("toys", Question::Shares, 2_000),
    ("toys:pictures=100", Question::Shares, 2_000),
];

/// The worlds to play in.
#[derive(Debug, Args)]
pub(crate) struct PlayArgs {
    /// Only this world
    #[arg(long, value_name = "WORLD", value_parser = known)]
    world: Option<String>,
    #[command(flatten)]
    lives: LivesAsked,
}

/// A world that is played in.
fn known(text: &str) -> Result<String, String> {
    let names = || PLAYS.iter().map(|(name, ..)| *name).collect::<Vec<_>>().join(", ");
    let known = PLAYS.iter().any(|(name, ..)| *name == text);
    known.then(|| text.to_owned()).ok_or_else(|| format!("nobody plays there; the worlds are {}", names()))
}

/// The actions until something was so, over all seeds; lives that never came to it count as one action more than a life has.
#[derive(Debug, Serialize)]
struct TruthFigures {
    world: String,
    /// What may be done in all states, each counted.
    pairs: usize,
    actions_max: usize,
    ours: FigureSummary,
    /// The lives that came to it.
    came: usize,
    /// The same learner, led by random actions.
    led: FigureSummary,
    /// R-max, on the number of each state; until it has tried all where the model is asked for.
    r_max: FigureSummary,
}

/// What became of one action.
#[derive(Debug, Serialize)]
struct ActionFigures {
    action: String,
    /// The part of all actions.
    share: FigureSummary,
    /// The lives in which it was mastered, and after how many actions.
    mastered: usize,
    after: Option<FigureSummary>,
    /// The part of all actions of R-max, on the number of each state.
    r_max_share: FigureSummary,
}

/// The shares of one world, over all seeds.
#[derive(Debug, Serialize)]
struct ShareFigures {
    world: String,
    actions: usize,
    each: Vec<ActionFigures>,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct PlayMeasurement {
    seeds: usize,
    /// The mechanisms that are on in `ours`.
    mechanisms: Vec<&'static str>,
    truth: Vec<TruthFigures>,
    solved: Vec<TruthFigures>,
    shares: Vec<ShareFigures>,
}

pub(crate) fn run(args: &PlayArgs, quiet: bool) -> Result<(), Failure> {
    let seeds: Vec<u64> = args.lives.seeds.iter().collect();
    let ours = args.lives.mechanisms();
    let (mut truth, mut solved, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    let chosen = PLAYS.iter().filter(|(name, ..)| args.world.as_deref().is_none_or(|only| only == *name));
    for (name, question, actions) in chosen {
        if !quiet {
            say(&format!("{name}: {} lives of {actions} actions at most", seeds.len()));
        }
        match question {
            Question::Truth => truth.extend(until(name, *question, &seeds, *actions, ours)?),
            Question::Most => solved.extend(until(name, *question, &seeds, *actions, ours)?),
            Question::Shares => shares.push(all_shares(name, &seeds, *actions, ours)?),
        }
    }
    let mechanisms = ours.named().into_iter().filter_map(|(name, on)| on.then_some(name)).collect();
    show(args.lives.json, &PlayMeasurement { seeds: seeds.len(), mechanisms, truth, solved, shares }, text)
}

/// What may be done in a world, with what comes of it.
struct Pairs(Vec<(WorldState, PrimitiveId, Distribution<WorldState>)>);

impl Pairs {
    /// All that may be done in all states of a world.
    fn all(world: &dyn Situation, student: &Student) -> Self {
        let mut twin = world.twin(chances(1));
        let mut known = BTreeSet::new();
        let mut pairs = Vec::new();
        for _ in 0..STATES {
            twin.scatter();
            let before = student.lexicon.world_state(&twin.percept());
            if !known.insert(before.clone()) {
                continue;
            }
            for primitive in twin.legal() {
                let Some(number) = student.lexicon.number(&primitive) else { continue };
                let came = twin.outcomes(&primitive);
                let came = came.map(|p| student.lexicon.measured(&student.lexicon.world_state(p)));
                pairs.push((before.clone(), number, came));
            }
        }
        Self(pairs)
    }

    /// How far a learner is from the truth, on average.
    fn distance(&self, student: &Student) -> f64 {
        let distance = |(before, primitive, truth): &(WorldState, PrimitiveId, Distribution<WorldState>)| {
            let foretold = student.foretell(before, *primitive);
            truth.distance(&foretold.map(|world| student.lexicon.measured(world)))
        };
        self.0.iter().map(distance).sum::<f64>() / self.0.len().max(1) as f64
    }
}

/// How many of the first sense are observed at once, at most.
fn most(world: &dyn Situation) -> usize {
    let mut twin = world.twin(chances(1));
    let count = |_| {
        twin.scatter();
        observed(&*twin)
    };
    (0..STATES).map(count).max().unwrap_or(0)
}

/// How many of the first sense are observed.
fn observed(world: &dyn Situation) -> usize {
    world.percept().iter().filter(|o| o.sense == 0).count()
}

/// The actions after which what is asked is so; none if that never came.
fn taken_until(
    name: &str,
    question: Question,
    seed: u64,
    actions: usize,
    mechanisms: Mechanisms,
    led: bool,
) -> Result<Option<usize>, Failure> {
    let mut world = open(name, seed).map_err(Failure::of)?;
    let mut student = Student::new(&world.declaration().clone(), seed, led, mechanisms)?;
    let (pairs, most) = (Pairs::all(&*world, &student), most(&*world));
    let mut random = chances(!seed);
    while question == Question::Most && observed(&*world) > 0 {
        world.scatter();
    }
    for taken in 1..=actions {
        let before = student.lexicon.world_state(&world.percept());
        let chosen = student.step(&before, taken > 1);
        let primitive = match led {
            true => random.choice(&world.declaration().repertoire).cloned(),
            false => chosen.and_then(|number| student.lexicon.primitive(number)).cloned(),
        };
        let Some(primitive) = primitive else { return Err(still(name)) };
        if let Some(number) = student.lexicon.number(&primitive).filter(|_| led) {
            student = student.led_to(number, &before)?;
        }
        world.act(&primitive);
        if question == Question::Most && observed(&*world) == most {
            return Ok(Some(taken));
        }
        if question == Question::Truth && taken % EVERY == 0 {
            let mut seen = student.twin()?;
            seen.step(&seen.lexicon.world_state(&world.percept()), true);
            if pairs.distance(&seen) <= TRUE {
                return Ok(Some(taken));
            }
        }
    }
    Ok(None)
}

fn still(name: &str) -> Failure {
    Failure::Failed(format!("{name}: the learner holds still"))
}

fn until(
    name: &str,
    question: Question,
    seeds: &[u64],
    actions: usize,
    mechanisms: Mechanisms,
) -> Result<Option<TruthFigures>, Failure> {
    let world = open(name, 0).map_err(Failure::of)?;
    let student = Student::new(&world.declaration().clone(), 0, false, mechanisms)?;
    let pairs = Pairs::all(&*world, &student).0.len();
    let all = |led| -> Result<Vec<Option<usize>>, Failure> {
        seeds.iter().map(|seed| taken_until(name, question, *seed, actions, mechanisms, led)).collect()
    };
    let (ours, led) = (all(false)?, all(true)?);
    let figure = |lives: &[Option<usize>]| {
        let taken = lives.iter().map(|taken| taken.unwrap_or(actions + 1) as f64);
        summary(taken.collect()).map(FigureSummary::from)
    };
    let r_max = seeds.iter().map(|seed| {
        let life = RMax::live(name, *seed, actions)?;
        Ok(if question == Question::Most { life.most_after } else { life.known_after })
    });
    let r_max: Vec<_> = r_max.collect::<Result<_, Failure>>()?;
    let came = ours.iter().flatten().count();
    let figures = || {
        let (ours, led, r_max) = (figure(&ours)?, figure(&led)?, figure(&r_max)?);
        Some(TruthFigures { world: name.to_owned(), pairs, actions_max: actions, ours, came, led, r_max })
    };
    Ok(figures())
}

/// What became of each action in one life.
struct Shares {
    share: Vec<f64>,
    mastered: Vec<Option<usize>>,
}

/// A life of own choices.
fn shares(name: &str, seed: u64, actions: usize, mechanisms: Mechanisms) -> Result<Shares, Failure> {
    let mut world = open(name, seed).map_err(Failure::of)?;
    let mut student = Student::new(&world.declaration().clone(), seed, false, mechanisms)?;
    let count = world.declaration().actions.len();
    let (mut times, mut mastered) = (vec![0; count], vec![None; count]);
    let mut foretold: Vec<VecDeque<bool>> = vec![VecDeque::new(); count];
    for taken in 1..=actions {
        let before = student.lexicon.world_state(&world.percept());
        let chosen = student.step(&before, taken > 1);
        let chosen = chosen.and_then(|number| Some((number, student.lexicon.primitive(number)?.clone())));
        let Some((number, primitive)) = chosen else { return Err(still(name)) };
        let expected = student.foretell(&before, number).most_probable().cloned();
        world.act(&primitive);
        let came = student.lexicon.world_state(&world.percept());
        let last = &mut foretold[primitive.action];
        last.push_back(expected == Some(came));
        if last.len() > MASTERED.1 {
            last.pop_front();
        }
        times[primitive.action] += 1;
        let right = last.iter().filter(|right| **right).count();
        if last.len() == MASTERED.1 && right >= MASTERED.0 && mastered[primitive.action].is_none() {
            mastered[primitive.action] = Some(taken);
        }
    }
    let share = times.into_iter().map(|times| f64::from(times) / actions as f64).collect();
    Ok(Shares { share, mastered })
}

fn all_shares(
    name: &str,
    seeds: &[u64],
    actions: usize,
    mechanisms: Mechanisms,
) -> Result<ShareFigures, Failure> {
    let world = open(name, 0).map_err(Failure::of)?;
    let lives: Vec<_> =
        seeds.iter().map(|seed| shares(name, *seed, actions, mechanisms)).collect::<Result<_, _>>()?;
    let r_max: Vec<_> =
        seeds.iter().map(|seed| RMax::live(name, *seed, actions)).collect::<Result<_, _>>()?;
    let figures = world.declaration().actions.iter().enumerate().filter_map(|(at, action)| {
        let after: Vec<_> = lives.iter().filter_map(|life| life.mastered[at]).collect();
        let (mastered, after) = (after.len(), after.into_iter().map(|taken| taken as f64).collect());
        Some(ActionFigures {
            action: action.name.clone(),
            share: summary(lives.iter().map(|life| life.share[at]).collect())?.into(),
            mastered,
            after: summary(after).map(FigureSummary::from),
            r_max_share: summary(r_max.iter().map(|life| life.share[at]).collect())?.into(),
        })
    });
    Ok(ShareFigures { world: name.to_owned(), actions, each: figures.collect() })
}

/// R-max on the number of each state as it is perceived: what was never tried there is the best that there is.
struct RMax {
    /// When it had tried all that it has ever found, for the last time.
    known_after: Option<usize>,
    /// When most of the first sense was observed first.
    most_after: Option<usize>,
    /// The part of its actions.
    share: Vec<f64>,
}

/// What R-max knows of a state: where each thing that was done leads.
type Known = BTreeMap<usize, WorldState>;

impl RMax {
    fn live(name: &str, seed: u64, actions: usize) -> Result<Self, Failure> {
        let mut world = open(name, seed).map_err(Failure::of)?;
        let student = Student::new(&world.declaration().clone(), seed, false, Mechanisms::PAPER)?;
        let repertoire = world.declaration().repertoire.clone();
        let mut random = chances(!seed);
        let mut known: BTreeMap<WorldState, Known> = BTreeMap::new();
        let mut times = vec![0; world.declaration().actions.len()];
        let (mut known_after, mut most_after, most) = (None, None, most(&*world));
        if most > 1 {
            while observed(&*world) > 0 {
                world.scatter();
            }
        }
        for taken in 1..=actions {
            let here = student.lexicon.world_state(&world.percept());
            let at = Self::choose(&known, &here, repertoire.len(), &mut random);
            let primitive: &Primitive = &repertoire[at];
            times[primitive.action] += 1;
            world.act(primitive);
            let came = student.lexicon.world_state(&world.percept());
            if observed(&*world) == most {
                most_after.get_or_insert(taken);
            }
            if known.entry(here).or_default().insert(at, came).is_none() {
                known_after = Some(taken);
            }
        }
        Ok(Self {
            known_after,
            most_after,
            share: times.into_iter().map(|n| f64::from(n) / actions as f64).collect(),
        })
    }

    /// The first action of the shortest way to what was never tried; a random one where none is known.
    fn choose(
        known: &BTreeMap<WorldState, Known>,
        here: &WorldState,
        count: usize,
        random: &mut Rng,
    ) -> usize {
        let untried = |world: &WorldState| -> Vec<usize> {
            let tried = known.get(world);
            (0..count).filter(|at| tried.is_none_or(|tried| !tried.contains_key(at))).collect()
        };
        if let Some(at) = random.choice(untried(here)) {
            return at;
        }
        let mut seen = BTreeSet::from([here]);
        let mut waiting: VecDeque<(&WorldState, Option<usize>)> = VecDeque::from([(here, None)]);
        while let Some((world, first)) = waiting.pop_front() {
            if let Some(first) = first.filter(|_| !untried(world).is_empty()) {
                return first;
            }
            for (at, next) in known.get(world).into_iter().flatten() {
                if seen.insert(next) {
                    waiting.push_back((next, first.or(Some(*at))));
                }
            }
        }
        random.usize(..count)
    }
}

fn text(measurement: &PlayMeasurement) -> String {
    let mut told = String::new();
    let asked = [
        (
            &measurement.truth,
            "the model is true: what it foretells is within .01 of the truth, on average over all pairs of a state and what may be done there",
        ),
        (&measurement.solved, "all switches are on"),
    ];
    for (rows, asked) in asked.iter().filter(|(rows, _)| !rows.is_empty()) {
        let mut table = Columns::new(&["world", "pairs", "ours", "interval", "came", "random", "r-max"])
            .figures(&[1, 2, 4, 5, 6]);
        for row in *rows {
            let last = |figure: f64| match figure > row.actions_max as f64 {
                true => format!("> {}", row.actions_max),
                false => format!("{figure:.0}"),
            };
            table.row([
                row.world.clone(),
                row.pairs.to_string(),
                last(row.ours.median),
                format!("{}-{}", last(row.ours.low), last(row.ours.high)),
                format!("{} of {}", row.came, measurement.seeds),
                last(row.led.median),
                last(row.r_max.median),
            ]);
        }
        told += &table.text(&[1, 2, 4, 5, 6]);
        told += &format!(
            "Actions until {asked}.\n\
            random: the same learner, led by random actions; r-max: on the number of each state (for the model, until it had tried all)\n"
        );
    }
    if !measurement.shares.is_empty() {
        let mut table = Columns::new(&["world", "action", "share", "interval", "mastered", "after", "r-max"])
            .figures(&[2, 5, 6]);
        for row in &measurement.shares {
            for action in &row.each {
                let percent = |share: f64| format!("{:.1} %", share * 100.0);
                table.row([
                    row.world.clone(),
                    action.action.clone(),
                    percent(action.share.median),
                    format!("{}-{}", percent(action.share.low), percent(action.share.high)),
                    format!("{} of {}", action.mastered, measurement.seeds),
                    action.after.as_ref().map_or(String::new(), |after| format!("{:.0}", after.median)),
                    percent(action.r_max_share.median),
                ]);
            }
        }
        told += &table.text(&[2, 5, 6]);
        told += "share: the part of all actions; mastered: the lives in which 18 of the last 20 executions were foretold, and after how many actions of all\n\
            r-max: the part of its actions, where it tries all in each state\n";
    }
    format!(
        "{told}ours: the learner with {}, median of {} seeds, with {}\n",
        measurement.mechanisms.join(", "),
        measurement.seeds,
        interval(measurement.seeds)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_blocks_have_42_pairs_and_r_max_comes_to_know_a_puzzle() {
        let world = open("blocks", 1).unwrap();
        let student = Student::new(&world.declaration().clone(), 1, false, Mechanisms::FULL).unwrap();
        assert_eq!(Pairs::all(&*world, &student).0.len(), 42);
        let life = RMax::live("puzzle:lamps=0", 1, 500).unwrap();
        assert!(life.most_after < life.known_after && life.known_after.is_some_and(|after| after < 300));
    }
}
