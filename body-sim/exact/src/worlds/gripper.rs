//! The slippery gripper (Pasula, Zettlemoyer & Kaelbling 2007): blocks, one hand, and actions that go wrong.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;
use crate::worlds::towers::{Place, is_clear, scattered};

/// The senses, as they are declared.
const ON: usize = 0;
const ON_TABLE: usize = 1;
const CLEAR: usize = 2;
const IN_HAND: usize = 3;
const HAND_EMPTY: usize = 4;
const WET: usize = 5;
const DRY: usize = 6;
const PAINTED: usize = 7;

/// The actions, as they are declared.
const PICK_UP: usize = 0;
const PUT_ON: usize = 1;
const PUT_ON_TABLE: usize = 2;
const PAINT: usize = 3;

/// Blocks, one hand that may be wet. The table of outcomes stands in [`World::outcomes`].
pub(crate) struct Gripper {
    pub(crate) blocks: usize,
}

#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct State {
    places: Vec<Place>,
    painted: Vec<bool>,
    wet: bool,
}

impl State {
    fn held(&self) -> Option<usize> {
        self.places.iter().position(|place| *place == Place::Hand)
    }

    fn with(&self, block: usize, place: Place) -> Self {
        let mut next = self.clone();
        next.places[block] = place;
        next
    }
}

impl World for Gripper {
    type State = State;

    fn declaration(&self) -> Declaration {
        let block = |name| Property::symbol(name, (0..self.blocks).map(|block| format!("b{block}")));
        let of_block = |name| Sense::state(name, [block("x")]);
        Declaration::sensing([
            Sense::state("on", [block("x"), block("y")]),
            of_block("ontable"),
            of_block("clear"),
            of_block("inhand"),
            Sense::state("inhandnil", []),
            Sense::state("wet", []),
            Sense::state("dry", []),
            of_block("painted"),
        ])
        .action_for_each("pickup", block("x"))
        .action_for_each("puton", block("y"))
        .action("putontable")
        .action_for_each("paint", block("x"))
        .action("dry")
    }

    /// Blocks as they may stand. Wet with probability .5, each block painted with probability .3.
    fn random_state(&self, random: &mut Rng) -> State {
        let places = scattered(self.blocks, random);
        let painted = (0..self.blocks).map(|_| random.f64() < 0.3).collect();
        State { places, painted, wet: random.bool() }
    }

    fn percept(&self, state: &State) -> Percept {
        let mut percept = Percept::new();
        let mut observe = |sense, blocks: &[usize]| {
            let values: Vec<_> = blocks.iter().map(|block| Value::Symbol(*block)).collect();
            percept.insert(Observation::new(sense, values));
        };
        for (block, place) in state.places.iter().enumerate() {
            match place {
                Place::Table => observe(ON_TABLE, &[block]),
                Place::Hand => observe(IN_HAND, &[block]),
                Place::On(under) => observe(ON, &[block, *under]),
            }
            if is_clear(&state.places, block) {
                observe(CLEAR, &[block]);
            }
            if state.painted[block] {
                observe(PAINTED, &[block]);
            }
        }
        if state.held().is_none() {
            observe(HAND_EMPTY, &[]);
        }
        observe(if state.wet { WET } else { DRY }, &[]);
        percept
    }

    fn is_legal(&self, state: &State, primitive: &Primitive) -> bool {
        let block = primitive.number();
        match primitive.action {
            PICK_UP => state.held().is_none() && is_clear(&state.places, block),
            PUT_ON => state.held().is_some() && is_clear(&state.places, block),
            PUT_ON_TABLE => state.held().is_some(),
            PAINT => is_clear(&state.places, block) && !state.painted[block],
            _ => state.wet,
        }
    }

    fn outcomes(&self, state: &State, primitive: &Primitive) -> Distribution<State> {
        let (block, nothing) = (primitive.number(), state.clone());
        let held = state.held().unwrap_or(block);
        let outcomes = match (primitive.action, state.wet) {
            (PICK_UP, wet) if state.places[block] == Place::Table => {
                let taken = if wet { 0.5 } else { 0.8 };
                vec![(state.with(block, Place::Hand), taken), (nothing, 1.0 - taken)]
            }
            (PICK_UP, wet) => {
                let third = 1.0 / 3.0;
                let [taken, fallen, failed] = if wet { [third; 3] } else { [0.7, 0.2, 0.1] };
                let fall = state.with(block, Place::Table);
                vec![(state.with(block, Place::Hand), taken), (fall, fallen), (nothing, failed)]
            }
            (PUT_ON, _) => vec![
                (state.with(held, Place::On(block)), 0.7),
                (state.with(held, Place::Table), 0.2),
                (nothing, 0.1),
            ],
            (PUT_ON_TABLE, _) => vec![(state.with(held, Place::Table), 0.8), (nothing, 0.2)],
            (PAINT, _) => {
                let mut painted = nothing.clone();
                painted.painted[block] = true;
                let spilt = State { wet: true, ..painted.clone() };
                vec![(painted, 0.6), (spilt, 0.1), (nothing, 0.3)]
            }
            _ => vec![(State { wet: false, ..nothing.clone() }, 0.9), (nothing, 0.1)],
        };
        outcomes.into_iter().collect()
    }
}
