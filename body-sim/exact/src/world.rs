//! A world with exact rules, and a world in its present state.

use std::sync::Arc;

use fastrand::Rng;

use crate::declaration::{Declaration, Percept, Primitive};
use crate::distribution::Distribution;

/// A world with exact rules. A state holds everything that decides what comes next and what is perceived, the events of the last
/// action included.
pub trait World {
    /// A state.
    type State: Clone + Ord;

    /// What a body senses and does here.
    fn declaration(&self) -> Declaration;

    /// A state drawn at random, for training and for tests. No event has just happened in it.
    fn random_state(&self, random: &mut Rng) -> Self::State;

    /// Everything that is perceived in `state`.
    fn percept(&self, state: &Self::State) -> Percept;

    /// Whether `primitive` may be carried out in `state`. One that may not changes nothing.
    fn is_legal(&self, _state: &Self::State, _primitive: &Primitive) -> bool {
        true
    }

    /// The states that may follow when a legal `primitive` is carried out in `state`.
    fn outcomes(&self, state: &Self::State, primitive: &Primitive) -> Distribution<Self::State>;

    /// After how many actions others change the world; none when they never do.
    fn spell(&self) -> Option<usize> {
        None
    }

    /// Whether the episode is over in `state`: the world is then renewed, and no action leads further.
    fn is_over(&self, _state: &Self::State) -> bool {
        false
    }

    /// The world after others have changed it, which no action brings about.
    fn renewed(&self, _state: &Self::State, random: &mut Rng) -> Self::State {
        self.random_state(random)
    }

    /// In a world with hidden states: the states that there may be, for those who have perceived nothing yet.
    fn prior(&self) -> Option<Distribution<Self::State>> {
        None
    }
}

/// A world in its present state, whatever its kind.
pub trait Situation {
    /// What a body senses and does here.
    fn declaration(&self) -> &Declaration;

    /// Everything that is perceived now.
    fn percept(&self) -> Percept;

    /// The primitives that may be carried out now.
    fn legal(&self) -> Vec<Primitive>;

    /// What is perceived after `primitive`, with its exact probabilities: of the present state or, in a world with hidden states,
    /// of everything that has been perceived so far. Nobody can foretell better.
    fn outcomes(&self, primitive: &Primitive) -> Distribution<Percept>;

    /// Carries `primitive` out.
    fn act(&mut self, primitive: &Primitive);

    /// Whether there are states that look alike and are not.
    fn is_hidden(&self) -> bool;

    /// After how many actions others change the world; none when they never do.
    fn spell(&self) -> Option<usize>;

    /// Whether the episode is over: the world is then renewed, and no action leads further.
    fn is_over(&self) -> bool;

    /// Has others change the world.
    fn renew(&mut self);

    /// Puts the world into a random state.
    fn scatter(&mut self);

    /// The same world in a random state of its own. `random` decides the state, and everything that happens by chance.
    fn twin(&self, random: Rng) -> Box<dyn Situation>;
}

/// `world` in a random state. `random` decides the state, and everything that happens by chance.
#[must_use]
pub fn situation<W: World + 'static>(world: W, random: Rng) -> Box<dyn Situation> {
    Box::new(Present::new(Arc::new(world), random))
}

/// A world with its state and the generator of its chances.
struct Present<W: World> {
    world: Arc<W>,
    declaration: Declaration,
    state: W::State,
    /// Where states are hidden, those that there may be.
    belief: Option<Distribution<W::State>>,
    random: Rng,
}

impl<W: World> Present<W> {
    fn new(world: Arc<W>, mut random: Rng) -> Self {
        let (declaration, state) = (world.declaration(), world.random_state(&mut random));
        let mut present = Self { belief: None, world, declaration, state, random };
        present.perceive_anew();
        present
    }

    fn perceive_anew(&mut self) {
        let percept = self.world.percept(&self.state);
        let may_be = self.world.prior();
        self.belief = may_be.and_then(|belief| belief.given(|state| self.world.percept(state) == percept));
    }

    fn next(&self, state: &W::State, primitive: &Primitive) -> Distribution<W::State> {
        match self.world.is_legal(state, primitive) {
            true => self.world.outcomes(state, primitive),
            false => Distribution::certain(state.clone()),
        }
    }
}

impl<W: World + 'static> Situation for Present<W> {
    fn declaration(&self) -> &Declaration {
        &self.declaration
    }

    fn percept(&self) -> Percept {
        self.world.percept(&self.state)
    }

    fn legal(&self) -> Vec<Primitive> {
        let legal = |primitive: &&Primitive| self.world.is_legal(&self.state, primitive);
        self.declaration.repertoire.iter().filter(legal).cloned().collect()
    }

    fn outcomes(&self, primitive: &Primitive) -> Distribution<Percept> {
        let next = match &self.belief {
            Some(belief) => belief.then(|state| self.next(state, primitive)),
            None => self.next(&self.state, primitive),
        };
        next.map(|state| self.world.percept(state))
    }

    fn act(&mut self, primitive: &Primitive) {
        let outcomes = self.next(&self.state, primitive);
        if let Some(drawn) = outcomes.draw(&mut self.random) {
            self.state = drawn.clone();
        }
        let percept = self.world.percept(&self.state);
        if let Some(belief) = self.belief.take() {
            let next = belief.then(|state| self.next(state, primitive));
            self.belief = next.given(|state| self.world.percept(state) == percept);
        }
    }

    fn is_hidden(&self) -> bool {
        self.belief.is_some()
    }

    fn spell(&self) -> Option<usize> {
        self.world.spell()
    }

    fn is_over(&self) -> bool {
        self.world.is_over(&self.state)
    }

    fn renew(&mut self) {
        self.state = self.world.renewed(&self.state, &mut self.random);
        self.perceive_anew();
    }

    fn scatter(&mut self) {
        self.state = self.world.random_state(&mut self.random);
        self.perceive_anew();
    }

    fn twin(&self, random: Rng) -> Box<dyn Situation> {
        Box::new(Self::new(Arc::clone(&self.world), random))
    }
}
