//! A hand and an eye over a board, after the microworld of Drescher (*Made-Up Minds*, 1991).

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// The senses, as they are declared.
const HAND: usize = 0;
const GLANCE: usize = 1;
const SEEN: usize = 2;
const FOVEA: usize = 3;
const TOUCH: usize = 4;

/// Cells of the board along each side.
const SIDE: i64 = 5;
/// Hand and glance keep to the cells from the first to the last of these, along both axes.
const INNER: (i64, i64) = (1, 3);
/// The directions, as they are declared: to the front, to the back, to the left, to the right.
const DIRECTIONS: [(i64, i64); 4] = [(0, 1), (0, -1), (-1, 0), (1, 0)];

/// A board of 5 x 5 cells, of which the inner 3 x 3 are the positions of the hand and of the glance. Objects stand in cells of their own, where
/// the hand can't be. The rules, in this order:
///
/// 1. `hand` moves the hand by one cell in a direction, `look` the glance. Neither leaves the 3 x 3 positions, and the hand does not
///    enter a cell with an object; then nothing changes.
/// 2. After each action, with probability `restless`, one of the objects, each as likely, moves by one cell in a direction, each as likely.
///    It stays if it would leave the board, or come to a cell with the hand or another object.
///
/// What is perceived: the positions of hand and glance; for each of the 3 x 3 cells around the glance in which there is anything, that
/// there is (`seen`, with the place of the cell relative to the glance); in the cell of the glance itself, whether it is the hand or which object
/// (`fovea`); and for each side of the hand on which an object stands, that it is felt (`touch`).
pub(crate) struct HandEye {
    pub(crate) objects: usize,
    pub(crate) restless: f64,
}

type Cell = (i64, i64);

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct State {
    hand: Cell,
    glance: Cell,
    objects: Vec<Cell>,
}

fn beside((x, y): Cell, direction: usize) -> Cell {
    let (dx, dy) = DIRECTIONS[direction];
    (x + dx, y + dy)
}

fn is_inner((x, y): Cell) -> bool {
    (INNER.0..=INNER.1).contains(&x) && (INNER.0..=INNER.1).contains(&y)
}

impl State {
    fn is_free(&self, cell: Cell) -> bool {
        self.hand != cell && !self.objects.contains(&cell)
    }

    /// With an object moved by one cell, where it can be.
    fn with_moved(&self, object: usize, direction: usize) -> Self {
        let mut next = self.clone();
        let to = beside(self.objects[object], direction);
        if (0..SIDE).contains(&to.0) && (0..SIDE).contains(&to.1) && self.is_free(to) {
            next.objects[object] = to;
        }
        next
    }
}

impl World for HandEye {
    type State = State;

    fn declaration(&self) -> Declaration {
        let range = |name: &str, first, last| Property {
            name: name.to_owned(),
            range: crate::declaration::Range::Integer(first, last),
        };
        let position = || [range("x", INNER.0, INNER.1), range("y", INNER.0, INNER.1)];
        let things = (0..self.objects).map(|object| format!("object-{object}"));
        let things = ["hand".to_owned()].into_iter().chain(things);
        let side = || Property::symbol("side", ["front", "back", "left", "right"]);
        Declaration::sensing([
            // Not the body's own: what a move does depends on them.
            Sense::state("hand", position()),
            Sense::state("glance", position()),
            Sense::state("seen", [range("dx", -1, 1), range("dy", -1, 1)]),
            Sense::state("fovea", [Property::symbol("thing", things)]),
            Sense::state("touch", [side()]),
        ])
        .action_for_each("hand", side())
        .action_for_each("look", side())
    }

    fn random_state(&self, random: &mut Rng) -> State {
        let mut inner = || (random.i64(INNER.0..=INNER.1), random.i64(INNER.0..=INNER.1));
        let (hand, glance) = (inner(), inner());
        let mut free: Vec<Cell> = (0..SIDE * SIDE).map(|cell| (cell % SIDE, cell / SIDE)).collect();
        free.retain(|cell| *cell != hand);
        random.shuffle(&mut free);
        free.truncate(self.objects);
        State { hand, glance, objects: free }
    }

    fn percept(&self, state: &State) -> Percept {
        let numbers = |sense, x, y| Observation::new(sense, [Value::Integer(x), Value::Integer(y)]);
        let mut percept = Percept::from([
            numbers(HAND, state.hand.0, state.hand.1),
            numbers(GLANCE, state.glance.0, state.glance.1),
        ]);
        for (thing, (x, y)) in [&state.hand].into_iter().chain(&state.objects).enumerate() {
            let (dx, dy) = (x - state.glance.0, y - state.glance.1);
            if dx.abs() <= 1 && dy.abs() <= 1 {
                percept.insert(numbers(SEEN, dx, dy));
            }
            if (dx, dy) == (0, 0) {
                percept.insert(Observation::new(FOVEA, [Value::Symbol(thing)]));
            }
        }
        for side in 0..DIRECTIONS.len() {
            if state.objects.contains(&beside(state.hand, side)) {
                percept.insert(Observation::new(TOUCH, [Value::Symbol(side)]));
            }
        }
        percept
    }

    fn outcomes(&self, state: &State, primitive: &Primitive) -> Distribution<State> {
        let mut moved = state.clone();
        if primitive.action == 0 {
            let to = beside(state.hand, primitive.number());
            if is_inner(to) && state.is_free(to) {
                moved.hand = to;
            }
        } else {
            let to = beside(state.glance, primitive.number());
            if is_inner(to) {
                moved.glance = to;
            }
        }
        let ways = self.objects * DIRECTIONS.len();
        let each = self.restless / ways as f64;
        let rest = (moved.clone(), 1.0 - self.restless);
        let moves =
            (0..ways).map(|way| (moved.with_moved(way / DIRECTIONS.len(), way % DIRECTIONS.len()), each));
        [rest].into_iter().chain(moves).collect()
    }
}
