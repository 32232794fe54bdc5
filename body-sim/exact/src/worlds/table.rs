//! A touching world in small: a finger, an object among fields, and what stands or blinks beside it.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;

/// The senses, as they are declared.
const FINGER: usize = 0;
const OBJECT: usize = 1;
const TOUCH: usize = 2;
const LAMP: usize = 3;

/// The colours of objects, as they are declared: solid, not solid where that makes a difference, and of bystanders.
const BLUE: usize = 0;
const RED: usize = 1;
const GREY: usize = 2;

/// Fields in a row, and for each a posture that brings the finger there. One object stands in a field; every four actions others put it into
/// a field where neither it nor the finger was. There is a touch when an action brings the finger to the field of a solid object.
pub(crate) struct Table {
    pub(crate) fields: usize,
    /// Lamps that each action turns on or off at random.
    pub(crate) lamps: usize,
    /// Grey objects in fields beyond reach, which never change.
    pub(crate) bystanders: usize,
    /// Whether the object is red as often as blue, and then not solid.
    pub(crate) red: bool,
    /// The probability that a touch is felt.
    pub(crate) felt: f64,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct State {
    finger: usize,
    colour: usize,
    object: usize,
    touched: bool,
    lit: Vec<bool>,
}

impl World for Table {
    type State = State;

    fn declaration(&self) -> Declaration {
        let field = || Property::below("field", self.fields + self.bystanders);
        let colour = Property::symbol("colour", ["blue", "red", "grey"]);
        let mut senses = vec![
            Sense::state("finger", [field()]).own(),
            Sense::state("object", [colour, field()]),
            Sense::event("touch", []),
        ];
        if self.lamps > 0 {
            let lamp = [Property::below("lamp", self.lamps), Property::boolean("lit")];
            senses.push(Sense::state("lamp", lamp).noise());
        }
        Declaration::sensing(senses).action_for_each("move", Property::below("posture", self.fields))
    }

    fn random_state(&self, random: &mut Rng) -> State {
        let colour = if self.red && random.bool() { RED } else { BLUE };
        let lit = (0..self.lamps).map(|_| random.bool()).collect();
        let (finger, object) = (random.usize(..self.fields), random.usize(..self.fields));
        State { finger, colour, object, touched: false, lit }
    }

    fn percept(&self, state: &State) -> Percept {
        let field = |field: usize| Value::Integer(i64::try_from(field).unwrap_or(i64::MAX));
        let object = |colour, at| Observation::new(OBJECT, [Value::Symbol(colour), field(at)]);
        let mut percept = Percept::from([object(state.colour, state.object)]);
        percept.insert(Observation::new(FINGER, [field(state.finger)]));
        percept.extend((0..self.bystanders).map(|number| object(GREY, self.fields + number)));
        let lamps = state.lit.iter().enumerate();
        percept.extend(lamps.map(|(lamp, lit)| Observation::new(LAMP, [field(lamp), Value::Boolean(*lit)])));
        if state.touched {
            percept.insert(Observation::new(TOUCH, []));
        }
        percept
    }

    fn outcomes(&self, state: &State, primitive: &Primitive) -> Distribution<State> {
        let finger = primitive.number();
        let felt = if finger == state.object && state.colour == BLUE { self.felt } else { 0.0 };
        let moved = |touched| State { finger, touched, ..state.clone() };
        let moved = Distribution::from_iter([(moved(true), felt), (moved(false), 1.0 - felt)]);
        (0..self.lamps).fold(moved, |all, lamp| {
            all.then(|state| {
                Distribution::even([false, true].map(|lit| {
                    let mut next = state.clone();
                    next.lit[lamp] = lit;
                    next
                }))
            })
        })
    }

    fn spell(&self) -> Option<usize> {
        Some(4)
    }

    fn renewed(&self, state: &State, random: &mut Rng) -> State {
        let free: Vec<_> = (0..self.fields).filter(|at| ![state.finger, state.object].contains(at)).collect();
        let object = random.choice(free).unwrap_or(state.object);
        let colour = if self.red && random.bool() { RED } else { BLUE };
        State { colour, object, touched: false, ..state.clone() }
    }
}
