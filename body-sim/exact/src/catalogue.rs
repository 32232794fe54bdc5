//! The worlds by their names, with the numbers that can be set in each.

use fastrand::Rng;
use thiserror::Error;

use crate::distribution::chances;
use crate::tables;
use crate::world::{Situation, situation};
use crate::worlds::blocks::Blocks;
use crate::worlds::cart::Cart;
use crate::worlds::grid::Grid;
use crate::worlds::gripper::Gripper;
use crate::worlds::hand_eye::HandEye;
use crate::worlds::hidden::{Flip, FloatReset};
use crate::worlds::posture::Posture;
use crate::worlds::push::Push;
use crate::worlds::puzzle::Puzzle;
use crate::worlds::table::Table;
use crate::worlds::toys::Toys;

/// A number that can be set in a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Number {
    /// Its name.
    pub name: &'static str,
    /// Its value unless another is given.
    pub default: usize,
    /// The smallest value.
    pub min: usize,
    /// The largest value.
    pub max: usize,
}

const fn number(name: &'static str, default: usize, min: usize, max: usize) -> Number {
    Number { name, default, min, max }
}

/// A kind of world.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// The name of the world.
    pub name: &'static str,
    /// Its rules, in a line.
    pub rules: &'static str,
    /// The numbers that can be set.
    pub numbers: &'static [Number],
    /// Makes the world with these numbers, one for each of `numbers`.
    open: fn(&[usize], Rng) -> Box<dyn Situation>,
}

/// All worlds, in the order in which they are listed.
pub const WORLDS: &[Entry] = &[
    Entry {
        name: "flip",
        rules: "two hidden states; a sensor says whether the last action changed the state",
        numbers: &[],
        open: |_, random| situation(Flip, random),
    },
    Entry {
        name: "float-reset",
        rules: "five hidden states in a row; float moves by chance, reset to the right end, where it is sensed",
        numbers: &[],
        open: |_, random| situation(FloatReset { modified: false }, random),
    },
    Entry {
        name: "modified-float-reset",
        rules: "the same, but float in the two rightmost states always moves left",
        numbers: &[],
        open: |_, random| situation(FloatReset { modified: true }, random),
    },
    Entry {
        name: "gripper",
        rules: "blocks and a slippery hand that may be wet",
        numbers: &[number("blocks", 4, 1, 9)],
        open: |numbers, random| situation(Gripper { blocks: numbers[0] }, random),
    },
    Entry {
        name: "grid",
        rules: "places with labels that say nothing; four directions, now and then without effect",
        numbers: &[number("width", 5, 1, 22), number("height", 5, 1, 22), number("slip_percent", 10, 0, 90)],
        open: |numbers, mut random| {
            let grid = Grid::new(numbers[0], numbers[1], share(numbers[2]), &mut random);
            situation(grid, random)
        },
    },
    Entry {
        name: "cart",
        rules: "a cart on a line moves by .1, its position known in bins; sensors beside it only make noise",
        numbers: &[number("bins_per_move", 100, 1, 100_000), number("sensors", 0, 0, 3)],
        open: |numbers, random| {
            let bins = i64::try_from(numbers[0] * 10).unwrap_or(i64::MAX);
            situation(Cart { bins, sensors: numbers[1] }, random)
        },
    },
    Entry {
        name: "lamps",
        rules: "a finger touches an object, beside lamps that blink and bystanders beyond reach",
        numbers: &[number("fields", 9, 2, 200), number("lamps", 2, 0, 8), number("bystanders", 0, 0, 20)],
        open: |numbers, random| {
            let [fields, lamps, bystanders] = [numbers[0], numbers[1], numbers[2]];
            situation(Table { fields, lamps, bystanders, red: false, felt: 1.0 }, random)
        },
    },
    Entry {
        name: "one-kind",
        rules: "a finger touches blue objects and passes through red ones; a touch may not be felt",
        numbers: &[number("fields", 9, 2, 200), number("felt_percent", 100, 0, 100)],
        open: |numbers, random| {
            let (fields, felt) = (numbers[0], share(numbers[1]));
            situation(Table { fields, lamps: 0, bystanders: 0, red: true, felt }, random)
        },
    },
    Entry {
        name: "push",
        rules: "a push at the field of an object moves it one field on",
        numbers: &[number("fields", 10, 1, 1_000)],
        open: |numbers, random| situation(Push { fields: numbers[0] }, random),
    },
    Entry {
        name: "posture",
        rules: "a switch that is pressed from one of the arm's own heights only",
        numbers: &[number("heights", 3, 1, 100)],
        open: |numbers, random| situation(Posture { heights: numbers[0] }, random),
    },
    Entry {
        name: "hand-eye",
        rules: "a hand and a glance over a board with objects that move now and then",
        numbers: &[number("objects", 2, 1, 4), number("restless_percent", 5, 0, 100)],
        open: |numbers, random| {
            situation(HandEye { objects: numbers[0], restless: share(numbers[1]) }, random)
        },
    },
    Entry {
        name: "blocks",
        rules: "blocks on a table and a hand that never fails",
        numbers: &[number("blocks", 3, 1, 6)],
        open: |numbers, random| situation(Blocks { blocks: numbers[0] }, random),
    },
    Entry {
        name: "puzzle",
        rules: "switches that turn on in one order only, beside lamps that blink",
        numbers: &[number("switches", 6, 1, 12), number("lamps", 1, 0, 4)],
        open: |numbers, mut random| {
            let puzzle = Puzzle::new(numbers[0], numbers[1], &mut random);
            situation(puzzle, random)
        },
    },
    Entry {
        name: "toys",
        rules: "a wheel to learn, a button without effect, pictures at random, a drawer that needs the wheel",
        numbers: &[number("pictures", 10, 2, 1_000)],
        open: |numbers, random| situation(Toys { pictures: numbers[0] }, random),
    },
    Entry { name: "lake-4", rules: LAKE, numbers: &[], open: |_, random| table("lake-4", random) },
    Entry { name: "lake-8", rules: LAKE, numbers: &[], open: |_, random| table("lake-8", random) },
    Entry {
        name: "lake-4-slippery",
        rules: SLIPPERY,
        numbers: &[],
        open: |_, random| table("lake-4-slippery", random),
    },
    Entry {
        name: "lake-8-slippery",
        rules: SLIPPERY,
        numbers: &[],
        open: |_, random| table("lake-8-slippery", random),
    },
    Entry {
        name: "cliff",
        rules: "CliffWalking of gymnasium",
        numbers: &[],
        open: |_, random| table("cliff", random),
    },
    Entry { name: "taxi", rules: "Taxi of gymnasium", numbers: &[], open: |_, random| table("taxi", random) },
    Entry {
        name: "empty-8",
        rules: "Empty-8x8 of minigrid, the whole state",
        numbers: &[],
        open: |_, random| table("empty-8", random),
    },
    Entry {
        name: "door-key-5",
        rules: "a layout of DoorKey-5x5 of minigrid, the whole state",
        numbers: &[],
        open: |_, random| table("door-key-5", random),
    },
    Entry {
        name: "empty-5-seen",
        rules: "Empty-5x5 of minigrid, what the agent sees",
        numbers: &[],
        open: |_, random| table("empty-5-seen", random),
    },
    Entry {
        name: "door-key-5-seen",
        rules: "all layouts of DoorKey-5x5 of minigrid, what the agent sees",
        numbers: &[],
        open: |_, random| table("door-key-5-seen", random),
    },
];

const LAKE: &str = "FrozenLake of gymnasium, where nothing slips";
const SLIPPERY: &str = "FrozenLake of gymnasium, where an action may slip to either side";

/// The environment of this table.
fn table(name: &str, random: Rng) -> Box<dyn Situation> {
    situation(tables::Table::named(name).unwrap_or_default(), random)
}

fn share(percent: usize) -> f64 {
    percent as f64 / 100.0
}

/// Why there is no such world.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum WorldError {
    /// Its name is unknown.
    #[error("there is no exact world {name:?}; there are: {}", names())]
    World {
        /// The name.
        name: String,
    },
    /// It has no such number.
    #[error("world {world} has no number {name:?}; {}", settable(world))]
    Number {
        /// The world.
        world: &'static str,
        /// The name that was given.
        name: String,
    },
    /// The value of a number is none, or out of range.
    #[error("{name} of world {world} is {value:?}; it must be {min} to {max}", name = number.name, min = number.min, max = number.max)]
    Value {
        /// The world.
        world: &'static str,
        /// The number.
        number: Number,
        /// The value that was given.
        value: String,
    },
}

/// The names of all worlds.
#[must_use]
pub fn names() -> String {
    WORLDS.iter().map(|entry| entry.name).collect::<Vec<_>>().join(", ")
}

fn settable(world: &str) -> String {
    let numbers = WORLDS.iter().filter(|entry| entry.name == world).flat_map(|entry| entry.numbers);
    let numbers: Vec<_> = numbers.map(|number| format!("{}={}", number.name, number.default)).collect();
    match numbers.is_empty() {
        true => "nothing can be set in it".to_owned(),
        false => format!("it has: {}", numbers.join(",")),
    }
}

/// The kind of world that `text` names, whatever numbers follow.
#[must_use]
pub fn kind(text: &str) -> Option<&'static Entry> {
    let name = text.split_once(':').map_or(text, |(name, _)| name);
    WORLDS.iter().find(|entry| entry.name == name)
}

/// Opens the world that `text` names, in a state that `seed` decides: `flip`, or with numbers `gripper:blocks=7` and
/// `grid:width=3,height=3`.
///
/// # Errors
/// When there is no such world, or it has no such number.
pub fn open(text: &str, seed: u64) -> Result<Box<dyn Situation>, WorldError> {
    let (entry, numbers) = read(text)?;
    Ok((entry.open)(&numbers, chances(seed)))
}

/// What tells the world that `text` names from all others, however it was written: `flip`, or `gripper:7` with each number.
///
/// # Errors
/// As [`open`].
pub(crate) fn identity(text: &str) -> Result<String, WorldError> {
    let (entry, numbers) = read(text)?;
    let numbers: Vec<_> = numbers.iter().map(ToString::to_string).collect();
    let mark = if numbers.is_empty() { "" } else { ":" };
    Ok(format!("{}{mark}{}", entry.name, numbers.join(",")))
}

/// The kind of world that `text` names, with its numbers.
fn read(text: &str) -> Result<(&'static Entry, Vec<usize>), WorldError> {
    let (name, settings) = text.split_once(':').unwrap_or((text, ""));
    let entry = kind(text).ok_or_else(|| WorldError::World { name: name.to_owned() })?;
    let world = entry.name;
    let mut numbers: Vec<_> = entry.numbers.iter().map(|number| number.default).collect();
    for setting in settings.split(',').filter(|setting| !setting.is_empty()) {
        let (name, value) = setting.split_once('=').unwrap_or((setting, ""));
        let at = entry.numbers.iter().position(|number| number.name == name);
        let at = at.ok_or_else(|| WorldError::Number { world, name: name.to_owned() })?;
        let number = entry.numbers[at];
        let allowed = value.parse().ok().filter(|value| (number.min..=number.max).contains(value));
        numbers[at] = allowed.ok_or_else(|| WorldError::Value { world, number, value: value.to_owned() })?;
    }
    Ok((entry, numbers))
}
