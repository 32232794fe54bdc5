//! Blocks on a table and a hand that never fails: the four operators of pddlgym's blocks world.

use fastrand::Rng;

use crate::declaration::{Declaration, Observation, Percept, Primitive, Property, Sense, Value};
use crate::distribution::Distribution;
use crate::world::World;
use crate::worlds::towers::{Place, is_clear, scattered};

/// The senses, as they are declared.
const ON: usize = 0;
const ON_TABLE: usize = 1;
const CLEAR: usize = 2;
const HAND_EMPTY: usize = 3;
const HOLDING: usize = 4;

/// The actions, as they are declared.
const PICK: usize = 0;
const PUT: usize = 1;
const STACK: usize = 2;
const UNSTACK: usize = 3;

/// Blocks and one hand: `pick` takes a block from the table, `put` puts it there, `stack` puts it on another, `unstack` takes it from one.
/// An action that is not legal changes nothing.
pub(crate) struct Blocks {
    pub(crate) blocks: usize,
}

/// The place of each block.
pub(crate) type State = Vec<Place>;

fn number(values: &[Value], at: usize) -> usize {
    match values.get(at) {
        Some(Value::Symbol(block)) => *block,
        _ => 0,
    }
}

impl World for Blocks {
    type State = State;

    fn declaration(&self) -> Declaration {
        let block = |name| Property::symbol(name, (0..self.blocks).map(|block| format!("b{block}")));
        let of_block = |name| Sense::state(name, [block("x")]);
        let mut declaration = Declaration::sensing([
            Sense::state("on", [block("x"), block("y")]),
            of_block("ontable"),
            of_block("clear"),
            Sense::state("handempty", []),
            of_block("holding"),
        ])
        .action_for_each("pick", block("x"))
        .action_for_each("put", block("x"))
        .action_for_each("stack", block("x"))
        .action_for_each("unstack", block("x"));
        if let Some(stack) = declaration.actions.get_mut(STACK) {
            stack.parameters.push(block("y"));
        }
        let pairs = (0..self.blocks).flat_map(|x| (0..self.blocks).map(move |y| (x, y)));
        let stacks = pairs
            .filter(|(x, y)| x != y)
            .map(|(x, y)| Primitive { action: STACK, parameters: vec![Value::Symbol(x), Value::Symbol(y)] });
        let at = declaration.repertoire.iter().position(|primitive| primitive.action == STACK).unwrap_or(0);
        declaration.repertoire.retain(|primitive| primitive.action != STACK);
        declaration.repertoire.splice(at..at, stacks);
        declaration
    }

    fn random_state(&self, random: &mut Rng) -> State {
        scattered(self.blocks, random)
    }

    fn percept(&self, state: &State) -> Percept {
        let mut percept = Percept::new();
        let mut observe = |sense, blocks: &[usize]| {
            let values: Vec<_> = blocks.iter().map(|block| Value::Symbol(*block)).collect();
            percept.insert(Observation::new(sense, values));
        };
        for (block, place) in state.iter().enumerate() {
            match place {
                Place::Table => observe(ON_TABLE, &[block]),
                Place::Hand => observe(HOLDING, &[block]),
                Place::On(under) => observe(ON, &[block, *under]),
            }
            if is_clear(state, block) {
                observe(CLEAR, &[block]);
            }
        }
        if !state.contains(&Place::Hand) {
            observe(HAND_EMPTY, &[]);
        }
        percept
    }

    fn is_legal(&self, state: &State, primitive: &Primitive) -> bool {
        let block = number(&primitive.parameters, 0);
        let is_free = !state.contains(&Place::Hand) && is_clear(state, block);
        let place = state.get(block);
        match primitive.action {
            PICK => is_free && place == Some(&Place::Table),
            UNSTACK => is_free && place != Some(&Place::Table),
            STACK => place == Some(&Place::Hand) && is_clear(state, number(&primitive.parameters, 1)),
            _ => place == Some(&Place::Hand),
        }
    }

    fn outcomes(&self, state: &State, primitive: &Primitive) -> Distribution<State> {
        let mut next = state.clone();
        let place = match primitive.action {
            PICK | UNSTACK => Place::Hand,
            PUT => Place::Table,
            _ => Place::On(number(&primitive.parameters, 1)),
        };
        if let Some(block) = next.get_mut(number(&primitive.parameters, 0)) {
            *block = place;
        }
        Distribution::certain(next)
    }
}
