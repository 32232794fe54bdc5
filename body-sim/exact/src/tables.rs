//! Environments that everybody uses, state by state, as gymnasium and minigrid define them. `tables/make.py` writes the tables from their
//! own code.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Range, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// A table by its name, as text.
type Source = (&'static str, &'static str);

/// The tables, in the order in which they are listed.
const SOURCES: &[Source] = &[
    ("lake-4", include_str!("../tables/lake-4.txt")),
    ("lake-8", include_str!("../tables/lake-8.txt")),
    ("lake-4-slippery", include_str!("../tables/lake-4-slippery.txt")),
    ("lake-8-slippery", include_str!("../tables/lake-8-slippery.txt")),
    ("cliff", include_str!("../tables/cliff.txt")),
    ("taxi", include_str!("../tables/taxi.txt")),
    ("empty-8", include_str!("../tables/empty-8.txt")),
    ("door-key-5", include_str!("../tables/door-key-5.txt")),
    ("empty-5-seen", include_str!("../tables/empty-5-seen.txt")),
    ("door-key-5-seen", include_str!("../tables/door-key-5-seen.txt")),
];

/// An environment as a table: what is perceived in each of its states, and what follows.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// The environment, and the package it is taken from.
    pub source: String,
    declaration: Declaration,
    goal: (usize, Wanted),
    /// The states in which an episode begins, each as probable.
    pub starts: Vec<usize>,
    /// All states.
    pub states: Vec<TableState>,
}

/// The values of the sense that an episode is about.
#[derive(Clone, Debug)]
enum Wanted {
    /// These.
    Values(Vec<Value>),
    /// Those of another sense, which tell what this episode is about.
    Of(usize),
}

impl Default for Wanted {
    fn default() -> Self {
        Self::Values(Vec::new())
    }
}

/// A state of an environment.
#[derive(Clone, Debug, Default)]
pub struct TableState {
    /// Everything that is perceived.
    pub percept: Percept,
    /// Of each action, the states that may follow; none when the episode is over.
    pub next: Option<Vec<Distribution<usize>>>,
}

impl Table {
    /// The names of all tables.
    pub fn names() -> impl Iterator<Item = &'static str> {
        SOURCES.iter().map(|(name, _)| *name)
    }

    /// The table of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let (_, text) = SOURCES.iter().find(|(known, _)| *known == name)?;
        parsed(text)
    }

    /// The observation in which an episode that came to `state` succeeds.
    #[must_use]
    pub fn goal(&self, state: usize) -> Observation {
        let (sense, wanted) = &self.goal;
        let percept = self.states.get(state).map(|state| &state.percept);
        let of = |sense: usize| percept.and_then(|percept| percept.iter().find(|o| o.sense == sense));
        let values = match wanted {
            Wanted::Values(values) => values.clone(),
            Wanted::Of(other) => of(*other).map_or_else(Vec::new, |o| o.values.clone()),
        };
        Observation::new(*sense, values)
    }

    /// Whether an episode that is over in `state` has succeeded.
    #[must_use]
    pub fn succeeds(&self, state: usize) -> bool {
        let over = self.states.get(state).filter(|state| state.next.is_none());
        over.is_some_and(|over| over.percept.contains(&self.goal(state)))
    }

    /// What `action`, by its place, may lead to from `state`; none when the episode is over.
    #[must_use]
    pub fn next(&self, state: usize, action: usize) -> Option<&Distribution<usize>> {
        self.states.get(state)?.next.as_ref()?.get(action)
    }
}

/// The table that a text tells; none when it is no such text.
fn parsed(text: &str) -> Option<Table> {
    let mut table = Table::default();
    let mut properties: Vec<Vec<&str>> = Vec::new();
    let (mut names, mut goal) = (Vec::new(), None);
    for line in text.lines() {
        let (key, told) = line.split_once(' ')?;
        let mut words = told.split(' ');
        match key {
            "from" => told.clone_into(&mut table.source),
            "sense" => {
                names.push(words.next()?);
                properties.push(words.collect());
            }
            "actions" => {
                let declaration = Declaration::default();
                table.declaration = words.fold(declaration, Declaration::action);
            }
            "goal" => goal = Some((words.next()?, words.next()?)),
            "starts" => table.starts = words.map(|word| word.parse().ok()).collect::<Option<_>>()?,
            "state" => {
                let perceived = words.enumerate().filter(|(_, word)| *word != "-");
                let each = perceived.flat_map(|(sense, word)| word.split(';').map(move |one| (sense, one)));
                let observed = each.map(|(sense, one)| Some(Observation::new(sense, values(one)?)));
                let percept = observed.collect::<Option<_>>()?;
                table.states.push(TableState { percept, next: None });
            }
            "next" if told == "end" => (),
            "next" => {
                let next = words.map(outcomes).collect::<Option<_>>()?;
                table.states.last_mut()?.next = Some(next);
            }
            _ => return None,
        }
    }
    let (sense, wanted) = goal?;
    let sense = names.iter().position(|name| *name == sense)?;
    let wanted = match wanted.strip_prefix("*:") {
        Some(other) => Wanted::Of(names.iter().position(|name| other.split('.').next() == Some(*name))?),
        None => Wanted::Values(values(wanted)?),
    };
    table.goal = (sense, wanted);
    let property = |sense: usize, at: usize, name: &str| {
        let observed = table.states.iter().flat_map(|state| &state.percept).filter(|o| o.sense == sense);
        let values = observed.filter_map(|o| match o.values.get(at) {
            Some(Value::Integer(number)) => Some(*number),
            _ => None,
        });
        let (least, most) = values.fold((i64::MAX, i64::MIN), |(least, most), n| (least.min(n), most.max(n)));
        Property { name: name.to_owned(), range: Range::Integer(least, most) }
    };
    let senses = names.iter().zip(&properties).enumerate().map(|(sense, (name, properties))| {
        let properties: Vec<_> =
            properties.iter().enumerate().map(|(at, name)| property(sense, at, name)).collect();
        Sense::state(name, properties)
    });
    table.declaration.senses = senses.collect();
    Some(table)
}

/// Numbers with commas between them; `+` for none.
fn values(word: &str) -> Option<Vec<Value>> {
    if word == "+" {
        return Some(Vec::new());
    }
    word.split(',').map(|number| number.parse().ok().map(Value::Integer)).collect()
}

/// States with their chances: `3`, or `3*2/3,7*1/3`.
fn outcomes(word: &str) -> Option<Distribution<usize>> {
    let outcome = |each: &str| {
        let (state, chance) = each.split_once('*').unwrap_or((each, "1/1"));
        let (part, whole) = chance.split_once('/')?;
        let share = part.parse::<f64>().ok()? / whole.parse::<f64>().ok()?;
        Some((state.parse().ok()?, share))
    };
    word.split(',').map(outcome).collect()
}

impl World for Table {
    type State = usize;

    fn declaration(&self) -> Declaration {
        self.declaration.clone()
    }

    /// A state in which an episode begins.
    fn random_state(&self, random: &mut Rng) -> usize {
        random.choice(&self.starts).copied().unwrap_or(0)
    }

    fn percept(&self, state: &usize) -> Percept {
        self.states.get(*state).map(|state| state.percept.clone()).unwrap_or_default()
    }

    fn is_over(&self, state: &usize) -> bool {
        self.states.get(*state).is_none_or(|state| state.next.is_none())
    }

    fn outcomes(&self, state: &usize, primitive: &Primitive) -> Distribution<usize> {
        self.next(*state, primitive.action).cloned().unwrap_or_else(|| Distribution::certain(*state))
    }
}
