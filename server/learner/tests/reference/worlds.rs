//! Little worlds for learners to live in: things with properties, and primitives that change them. What is
//! random in them is drawn from a seed that is part of the plan.

use pschema_learner::curriculum::{Argument, SceneCommand};
use pschema_learner::observation::{Observation, PropertyId, TypeId, Value};
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{
    Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};
use pschema_learner::{ActionOutcome, Output};

/// Property names, shared by all types: type `t` has the first so many of them.
pub(crate) const PROPERTIES: [&str; 3] = ["place", "colour", "size"];

/// An observation type of a plan.
#[derive(Clone, Debug)]
pub(crate) struct Kind {
    pub(crate) own: bool,
    pub(crate) transient: bool,
    pub(crate) heard: bool,
    pub(crate) properties: usize,
}

/// A thing in a world: seen as an observation of its type while it is there.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    pub(crate) kind: usize,
    pub(crate) values: [i64; 3],
    pub(crate) there: bool,
}

/// A part of what a primitive does.
#[derive(Clone, Debug)]
pub(crate) enum Rule {
    /// This thing's property becomes the value, and it is there.
    Set { thing: usize, property: usize, value: i64 },
    /// Every thing that is not the body's own, with the property at `from`, gets `to`.
    Push { property: usize, from: i64, to: i64 },
    /// Every thing that is not the body's own and is at this place is taken away, until something puts it
    /// somewhere else.
    Take { place: i64 },
    /// The thing comes or goes.
    Toggle { thing: usize },
    /// An event is perceived once, if two things agree in their first property.
    Meet { one: usize, other: usize, event: usize },
}

/// How often, of 256, something happens by chance before a frame.
#[derive(Clone, Debug)]
pub(crate) struct Chances {
    /// A thing is displaced.
    pub(crate) displaced: u8,
    /// An observation is not perceived.
    pub(crate) hidden: u8,
    /// Something unrelated is perceived.
    pub(crate) noise: u8,
    /// An action is refused, fails or is not answered.
    pub(crate) refused: u8,
    /// The surroundings can't be arranged.
    pub(crate) unarranged: u8,
}

/// Everything that defines a world.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) seed: u64,
    pub(crate) kinds: Vec<Kind>,
    /// Values go from 0 to below this.
    pub(crate) values: i64,
    pub(crate) things: Vec<Thing>,
    pub(crate) primitives: Vec<Vec<Rule>>,
    /// For a second body: the first primitive that it has; it may have none.
    pub(crate) second_body_from: Option<usize>,
    pub(crate) chances: Chances,
}

/// The name of a type.
pub(crate) fn kind_name(kind: usize) -> String {
    format!("kind{kind}")
}

impl Plan {
    fn declared(&self, name: &str, primitives: std::ops::Range<usize>) -> Declaration {
        let integer = |name: &str| DeclaredProperty {
            name: name.into(),
            unit: String::new(),
            kind: ValueKind::Integer,
        };
        let kinds = self.kinds.iter().enumerate().map(|(at, kind)| DeclaredType {
            name: kind_name(at),
            own: kind.own,
            transient: kind.transient,
            heard: kind.heard,
            value: false,
            properties: PROPERTIES[..kind.properties].iter().map(|name| integer(name)).collect(),
        });
        Declaration {
            body: name.into(),
            observation_types: kinds.collect(),
            actions: vec![DeclaredAction { name: "do".into(), parameters: vec![integer("what")] }],
            repertoire: primitives.map(|p| (0, vec![Parameter::Integer(p as i64)])).collect(),
        }
    }

    pub(crate) fn declarations(&self) -> Vec<Declaration> {
        let count = self.primitives.len();
        let second = self.second_body_from.map(|from| self.declared("second", from.min(count)..count));
        std::iter::once(self.declared("first", 0..count)).chain(second).collect()
    }

    fn observation(&self, kind: usize, values: &[i64; 3]) -> Observation {
        // Properties are numbered as first declared, which is not the order of their names here when the
        // first type has fewer of them than a later one; but it is a prefix of the same list.
        // A type that nobody declared may come with any properties.
        let known = self.kinds.get(kind).map_or(2, |kind| kind.properties);
        let values = values[..known].iter().enumerate();
        let id = TypeId(u16::try_from(kind).unwrap());
        Observation::new(id, values.map(|(p, v)| (PropertyId(u16::try_from(p).unwrap()), Value::Integer(*v))))
    }
}

/// A world under way.
pub(crate) struct World {
    pub(crate) plan: Plan,
    pub(crate) random: Random,
    things: Vec<Thing>,
    events: Vec<usize>,
    asked: Vec<Option<bool>>,
}

impl World {
    pub(crate) fn new(plan: Plan) -> Self {
        let random = Random::from_seed(plan.seed);
        Self { random, things: plan.things.clone(), events: Vec::new(), asked: vec![None; 2], plan }
    }

    /// Whether something happens that has this chance of 256.
    pub(crate) fn happens(&mut self, chance: u8) -> bool {
        self.random.below(256) < usize::from(chance)
    }

    fn value(&mut self) -> i64 {
        self.random.below(self.plan.values as usize) as i64
    }

    /// What a body perceives next, and how what it was asked went.
    pub(crate) fn perceive(&mut self, body: usize) -> (Option<ActionOutcome>, Vec<Observation>) {
        let chances = self.plan.chances.clone();
        let asked = self.asked[body].take();
        let failed =
            asked.map(|arranging| self.happens(if arranging { chances.unarranged } else { chances.refused }));
        let outcome = match failed {
            None => None,
            Some(false) => Some(ActionOutcome::Done),
            Some(true) => [
                None,
                Some(ActionOutcome::Refused),
                Some(ActionOutcome::Failed),
                Some(ActionOutcome::EpisodeEnded),
                Some(ActionOutcome::EpisodeCut),
            ][self.random.below(5)]
            .or((self.random.below(2) == 0).then_some(ActionOutcome::TimedOut)),
        };
        if self.happens(chances.displaced) {
            let value = self.value();
            let (thing, property) = (self.random.below(self.things.len()), self.random.below(3));
            self.things[thing].values[property] = value;
            self.things[thing].there = true;
        }
        let mut perceived = Vec::new();
        for thing in self.things.clone() {
            if thing.there && !self.happens(chances.hidden) {
                perceived.push(self.plan.observation(thing.kind, &thing.values));
            }
        }
        for event in std::mem::take(&mut self.events) {
            if !self.happens(chances.hidden) {
                perceived.push(self.plan.observation(event, &[0; 3]));
            }
        }
        while self.happens(chances.noise) {
            let kind = self.random.below(self.plan.kinds.len() + 1);
            let values = [self.value(), self.value(), self.value()];
            perceived.push(self.plan.observation(kind, &values));
        }
        (outcome, perceived)
    }

    /// Carries out what a learner asks of a body.
    pub(crate) fn follow(&mut self, body: usize, output: &Output) {
        match output {
            Output::Hold => {}
            Output::Act(primitive) => {
                self.act(*primitive);
                self.asked[body] = Some(false);
            }
            Output::Arrange(commands) => {
                self.arrange(commands);
                self.asked[body] = Some(true);
            }
        }
    }

    fn act(&mut self, primitive: PrimitiveId) {
        for rule in self.plan.primitives[primitive.0 as usize].clone() {
            match rule {
                Rule::Set { thing, property, value } => {
                    self.things[thing].values[property] = value;
                    self.things[thing].there = true;
                }
                Rule::Push { property, from, to } => {
                    for thing in &mut self.things {
                        if thing.values[property] == from && !self.plan.kinds[thing.kind].own {
                            thing.values[property] = to;
                        }
                    }
                }
                Rule::Take { place } => {
                    for thing in &mut self.things {
                        thing.there &= thing.values[0] != place || self.plan.kinds[thing.kind].own;
                    }
                }
                Rule::Toggle { thing } => self.things[thing].there ^= true,
                Rule::Meet { one, other, event } => {
                    let (one, other) = (&self.things[one], &self.things[other]);
                    if one.there && other.there && one.values[0] == other.values[0] {
                        self.events.push(event);
                    }
                }
            }
        }
    }

    fn arrange(&mut self, commands: &[SceneCommand]) {
        for (at, command) in commands.iter().enumerate() {
            for (_, argument) in &command.arguments {
                if let Argument::Integer(number) = argument {
                    let thing = (self.things.len() - 1).saturating_sub(at);
                    self.things[thing].there = true;
                    self.things[thing].values[0] = number % self.plan.values;
                }
            }
        }
    }
}
