//! Random worlds, and runs through them.

use proptest::collection::vec;
use proptest::option::weighted;
use proptest::prelude::*;
use pschema_learner::curriculum::Curriculum;
use pschema_learner::observation::{Pattern, PropertyId, Term, TypeId, Value, Variable};
use pschema_learner::parameters::Parameters;
use pschema_learner::progress::StageCommand;
use pschema_learner::pursuit::Goal;
use pschema_learner::vocabulary::BodyId;

use super::curricula::{curriculum, paper, parameters};
use super::worlds::{Chances, Kind, Plan, Rule, Thing, World};

/// One run: a world, what leads the learner through it, and how it learns.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) plan: Plan,
    pub(crate) curriculum: Curriculum,
    pub(crate) parameters: Parameters,
    /// How often, of 256, an operator interferes before a frame.
    pub(crate) commands: u8,
    /// How often, of 256, a goal is given, or called off, before a frame.
    pub(crate) goals: u8,
    pub(crate) steps: usize,
}

/// A goal for a body, with the actions that it may take; none to call off what is pursued.
pub(crate) type GoalOrder = Option<(BodyId, Goal, u32)>;

impl Setup {
    /// What an operator commands before the next frame: mostly nothing.
    pub(crate) fn operator(&self, world: &mut World) -> Vec<StageCommand> {
        if !world.happens(self.commands) {
            return Vec::new();
        }
        let stages = &self.curriculum.stages;
        let command = match world.random.below(5) {
            0 => StageCommand::Hold,
            1 => StageCommand::Next,
            2 => StageCommand::Set(stages[world.random.below(stages.len())].name.clone()),
            3 => StageCommand::Set("nowhere".into()),
            _ => StageCommand::Resume,
        };
        // So that a hold does not last to the end.
        let resume = world.happens(128).then_some(StageCommand::Resume);
        std::iter::once(command).chain(resume).collect()
    }
}

impl Setup {
    /// Whether memory comes to its limit before the next frame, or has room again: mostly neither.
    pub(crate) fn limit(&self, world: &mut World) -> Option<bool> {
        (self.commands > 0 && world.happens(3)).then(|| world.happens(100))
    }

    /// What is asked of the learner before the next frame: mostly nothing.
    pub(crate) fn goal(&self, world: &mut World) -> Option<GoalOrder> {
        if self.goals == 0 || !world.happens(self.goals) {
            return None;
        }
        if world.happens(40) {
            return Some(None);
        }
        let bodies = self.plan.declarations().len();
        let body = BodyId(u16::try_from(world.random.below(bodies)).unwrap());
        let patterns = 1 + usize::from(world.happens(60));
        let wanted = (0..patterns).map(|_| self.pattern(world)).collect();
        let goal = if world.happens(80) { Goal::Again(wanted) } else { Goal::Observed(wanted) };
        Some(Some((body, goal, 1 + u32::try_from(world.random.below(8)).unwrap())))
    }

    fn pattern(&self, world: &mut World) -> Pattern {
        let kind = world.random.below(self.plan.kinds.len());
        let mut terms = Vec::new();
        for property in 0..self.plan.kinds[kind].properties {
            let term = match world.random.below(4) {
                0 => continue,
                1 => Term::Variable(Variable(u8::try_from(world.random.below(2)).unwrap())),
                _ => Term::Constant(Value::Integer(world.random.below(self.plan.values as usize) as i64)),
            };
            terms.push((PropertyId(u16::try_from(property).unwrap()), term));
        }
        Pattern::new(TypeId(u16::try_from(kind).unwrap()), terms)
    }
}

/// Mostly never, sometimes seldom.
fn seldom(most: u8) -> impl Strategy<Value = u8> {
    prop_oneof![3 => Just(0), 1 => 0..=most]
}

fn goals() -> impl Strategy<Value = u8> {
    prop_oneof![1 => Just(0), 1 => 5..=60_u8]
}

fn chances() -> impl Strategy<Value = Chances> {
    (seldom(60), seldom(60), seldom(90), seldom(60), seldom(20)).prop_map(
        |(displaced, hidden, noise, refused, unarranged)| Chances {
            displaced,
            hidden,
            noise,
            refused,
            unarranged,
        },
    )
}

/// Types and primitives without any order in them.
fn any_plan() -> impl Strategy<Value = Plan> {
    let kind = (any::<[bool; 2]>(), prop::bool::weighted(0.15), 0..4_usize)
        .prop_map(|([own, transient], heard, properties)| Kind { own, transient, heard, properties });
    (vec(kind, 1..=4), 2..5_i64, 2..=8_usize)
        .prop_flat_map(|(kinds, values, primitives)| {
            let thing = (0..kinds.len(), [0..values, 0..values, 0..values], prop::bool::weighted(0.8));
            let things = vec(thing.prop_map(|(kind, values, there)| Thing { kind, values, there }), 1..=4);
            (Just(kinds), Just(values), things, Just(primitives))
        })
        .prop_flat_map(|(kinds, values, things, primitives)| {
            let thing = 0..things.len();
            let rule = prop_oneof![
                (thing.clone(), 0..3_usize, 0..values).prop_map(|(thing, property, value)| Rule::Set {
                    thing,
                    property,
                    value
                }),
                (0..3_usize, 0..values, 0..values).prop_map(|(property, from, to)| Rule::Push {
                    property,
                    from,
                    to
                }),
                thing.clone().prop_map(|thing| Rule::Toggle { thing }),
                (thing.clone(), thing, 0..kinds.len()).prop_map(|(one, other, event)| Rule::Meet {
                    one,
                    other,
                    event
                }),
            ];
            let rules = vec(vec(rule, 0..=3), primitives);
            (any::<u64>(), rules, weighted(0.3, 0..=primitives), chances()).prop_map(
                move |(seed, primitives, second_body_from, chances)| Plan {
                    seed,
                    kinds: kinds.clone(),
                    values,
                    things: things.clone(),
                    primitives,
                    second_body_from,
                    chances,
                },
            )
        })
}

/// What happens to what lies where the finger goes.
#[derive(Clone, Copy, Debug)]
enum Contact {
    Felt,
    Pushed,
    Taken,
}

/// The paper's table: a finger (own), up to four blocks, touch, words; each primitive brings the finger to
/// a place, and blocks that lie there are felt, and perhaps pushed or taken.
fn table_plan() -> impl Strategy<Value = Plan> {
    let kind = |own, transient, heard, properties| Kind { own, transient, heard, properties };
    let kinds = vec![
        kind(true, false, false, 1),
        kind(false, false, false, 2),
        kind(false, true, false, 0),
        kind(false, true, true, 1),
    ];
    let contact = || prop::sample::select(vec![Contact::Felt, Contact::Pushed, Contact::Taken]);
    (3..=7_i64, 1..=4_usize).prop_flat_map(move |(places, blocks)| {
        let kinds = kinds.clone();
        let contacts = prop_oneof![
            vec(contact(), places as usize),
            contact().prop_map(move |contact| vec![contact; places as usize]),
        ];
        let blocks = vec((0..places, 0..2_i64), blocks);
        (contacts, blocks, any::<u64>(), weighted(0.2, 0..3_usize), chances(), prop::bool::weighted(0.3))
            .prop_map(move |(contacts, blocks, seed, second_body_from, chances, seen)| {
                let finger = Thing { kind: 0, values: [0; 3], there: seen };
                let block =
                    |(at, colour): &(i64, i64)| Thing { kind: 1, values: [*at, *colour, 0], there: true };
                let reach = |(contact, place): (&Contact, i64)| {
                    let mut rules = vec![Rule::Set { thing: 0, property: 0, value: place }];
                    rules.extend((1..=blocks.len()).map(|other| Rule::Meet { one: 0, other, event: 2 }));
                    match contact {
                        Contact::Felt => {}
                        Contact::Pushed => {
                            rules.push(Rule::Push { property: 0, from: place, to: (place + 1) % places });
                        }
                        Contact::Taken => rules.push(Rule::Take { place }),
                    }
                    rules
                };
                Plan {
                    seed,
                    kinds: kinds.clone(),
                    values: places,
                    primitives: contacts.iter().zip(0..).map(reach).collect(),
                    things: std::iter::once(finger).chain(blocks.iter().map(block)).collect(),
                    second_body_from,
                    chances,
                }
            })
    })
}

/// A shelf: blocks that are pushed from place to place, so that schemas lead to one another in chains.
fn shelf_plan() -> impl Strategy<Value = Plan> {
    let kinds = vec![
        Kind { own: false, transient: false, heard: false, properties: 2 },
        Kind { own: false, transient: true, heard: false, properties: 0 },
    ];
    (2..=5_i64, 1..=2_usize, any::<u64>(), weighted(0.2, 0..2_usize), chances()).prop_flat_map(
        move |(places, blocks, seed, second_body_from, chances)| {
            let kinds = kinds.clone();
            let push = prop_oneof![
                6 => (0..places, 0..places)
                    .prop_map(|(from, to)| vec![Rule::Push { property: 0, from, to }]),
                1 => (0..blocks).prop_map(|thing| vec![Rule::Toggle { thing }]),
                1 => Just(vec![Rule::Meet { one: 0, other: blocks - 1, event: 1 }]),
            ];
            (vec(push, 3..=8), vec(0..places, blocks)).prop_map(move |(primitives, at)| {
                let block = |(colour, place): (usize, &i64)| Thing {
                    kind: 0,
                    values: [*place, colour as i64, 0],
                    there: true,
                };
                Plan {
                    seed,
                    kinds: kinds.clone(),
                    values: places,
                    things: at.iter().enumerate().map(block).collect(),
                    primitives,
                    second_body_from,
                    chances: chances.clone(),
                }
            })
        },
    )
}

/// So many words at once that associations must make room for one another.
fn crowd_plan() -> impl Strategy<Value = Plan> {
    let word = Kind { own: false, transient: false, heard: true, properties: 3 };
    let block = Kind { own: false, transient: false, heard: false, properties: 1 };
    (any::<u64>(), 3..=5_i64, 200..=235_u8, any::<bool>()).prop_map(move |(seed, values, noise, lasting)| {
        Plan {
            seed,
            kinds: vec![Kind { transient: !lasting, ..word.clone() }, block.clone()],
            values,
            things: vec![Thing { kind: 1, values: [0; 3], there: true }],
            primitives: vec![
                vec![],
                vec![Rule::Toggle { thing: 0 }],
                vec![Rule::Push { property: 0, from: 0, to: 1 }],
            ],
            second_body_from: None,
            chances: Chances { displaced: 10, hidden: 0, noise, refused: 0, unarranged: 0 },
        }
    })
}

/// Any run of at most `steps` steps.
pub(crate) fn setup(steps: usize) -> impl Strategy<Value = Setup> {
    let led = |plan: Plan| {
        let kinds = plan.kinds.len();
        (Just(plan), curriculum(kinds), parameters(kinds), seldom(20))
    };
    let world = prop_oneof![
        3 => any_plan().prop_flat_map(led),
        2 => table_plan().prop_flat_map(led),
        2 => shelf_plan().prop_flat_map(led),
        1 => crowd_plan().prop_flat_map(led),
        3 => (table_plan(), 0..=80_u8, 0..=80_u8).prop_flat_map(|(mut plan, displaced, hidden)| {
            // Blocks come and go, so that there is something to generalise, and to be wrong about.
            plan.chances = Chances { displaced, hidden, ..plan.chances };
            (Just(plan), paper(), parameters(4), Just(0))
        }),
    ];
    (world, goals(), steps / 4..=steps).prop_map(
        |((plan, curriculum, parameters, commands), goals, steps)| Setup {
            plan,
            curriculum,
            parameters,
            commands,
            goals,
            steps,
        },
    )
}
