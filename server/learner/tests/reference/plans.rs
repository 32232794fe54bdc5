//! Random plans, curricula and parameters.

use proptest::collection::vec;
use proptest::option::weighted;
use proptest::prelude::*;
use pschema_learner::curriculum::{
    Afterwards, Argument, Curriculum, Habituation, Lift, Pool, Saturation, SceneCommand, Stage, Until,
};
use pschema_learner::parameters::{Parameters, TypeOverride};

use super::worlds::{Chances, Kind, PROPERTIES, Plan, Rule, Thing, kind_name};

/// One run: a world, what leads the learner through it, and how it learns.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) plan: Plan,
    pub(crate) curriculum: Curriculum,
    pub(crate) parameters: Parameters,
    /// How often, of 256, an operator interferes before a frame.
    pub(crate) commands: u8,
    pub(crate) steps: usize,
}

/// Mostly never, sometimes seldom.
fn seldom(most: u8) -> impl Strategy<Value = u8> {
    prop_oneof![3 => Just(0), 1 => 0..=most]
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
            (any::<u64>(), rules, weighted(0.3, 0..primitives), chances()).prop_map(
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

/// The paper's table: a finger (own), one or two blocks, touch, words; each primitive brings the finger to
/// a place; some push what lies there.
fn table_plan() -> impl Strategy<Value = Plan> {
    let kind = |own, transient, heard, properties| Kind { own, transient, heard, properties };
    let kinds = vec![
        kind(true, false, false, 1),
        kind(false, false, false, 2),
        kind(false, true, false, 0),
        kind(false, true, true, 1),
    ];
    let places = 3..=6_i64;
    (places, 1..=2_usize, any::<u64>(), weighted(0.2, 0..3_usize), chances(), prop::bool::weighted(0.3))
        .prop_flat_map(move |(places, blocks, seed, second_body_from, chances, seen)| {
            let kinds = kinds.clone();
            (vec(any::<bool>(), places as usize), vec((0..places, 0..2_i64), blocks)).prop_map(
                move |(pushing, blocks)| {
                    let finger = Thing { kind: 0, values: [0; 3], there: seen };
                    let block = |(place, colour): &(i64, i64)| Thing {
                        kind: 1,
                        values: [*place, *colour, 0],
                        there: true,
                    };
                    let things: Vec<_> = std::iter::once(finger).chain(blocks.iter().map(block)).collect();
                    let reach = |place: i64, pushes: bool| {
                        let mut rules = vec![Rule::Set { thing: 0, property: 0, value: place }];
                        if !seen && place == 0 {
                            rules.push(Rule::Toggle { thing: 0 });
                        }
                        rules.extend((1..things.len()).map(|other| Rule::Meet { one: 0, other, event: 2 }));
                        if pushes {
                            let to = (place + 1) % places;
                            rules.push(Rule::Push { property: 0, from: place, to });
                        }
                        rules
                    };
                    let primitives = (0..places).zip(&pushing).map(|(place, push)| reach(place, *push));
                    Plan {
                        seed,
                        kinds: kinds.clone(),
                        values: places,
                        primitives: primitives.collect(),
                        things: things.clone(),
                        second_body_from,
                        chances: chances.clone(),
                    }
                },
            )
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

fn stage(kinds: usize) -> impl Strategy<Value = Stage> {
    let lift = prop_oneof![
        Just(Lift::All),
        vec(0..kinds, 1..=kinds).prop_map(|k| Lift::Types(k.into_iter().map(kind_name).collect())),
    ];
    let place = |pool: usize| SceneCommand {
        command: "place".into(),
        arguments: vec![("at".into(), Argument::Draw(format!("pool{pool}")))],
    };
    let value = (0..PROPERTIES.len(), 0..4_i64)
        .prop_map(|(at, value)| (PROPERTIES[at].to_owned(), Argument::Integer(value)));
    let until = (0..kinds, vec(value, 0..=1))
        .prop_map(|(kind, properties)| Until { kind: kind_name(kind), properties });
    let saturation = (0..=30_u8, 1..=4_u32)
        .prop_map(|(level, actions)| Saturation { excitation_below: f64::from(level) / 10.0, actions });
    let habituation = (0..=3_u32, 0..=10_u8)
        .prop_map(|(executions_min, i)| Habituation { executions_min, interval_max: f64::from(i) / 10.0 });
    (
        lift,
        prop::bool::weighted(0.85),
        prop_oneof![1 => Just(0), 2 => 1..=3_u32],
        vec((0..2_usize).prop_map(place), 0..=2),
        weighted(0.6, until),
        0..=6_u32,
        weighted(0.5, saturation),
        weighted(0.4, habituation),
    )
        .prop_map(|(lift, learning, trials, arrange, until, most, saturation, habituation)| {
            let endless = trials > 0 && until.is_none() && saturation.is_none();
            let trial_actions_max = if endless { most.max(1) } else { most };
            let name = String::new();
            Stage { name, lift, learning, trials, arrange, until, trial_actions_max, saturation, habituation }
        })
}

fn curriculum(kinds: usize) -> impl Strategy<Value = Curriculum> {
    let pool = |name: &'static str| {
        (0..3_i64, 0..8_i64).prop_map(move |(from, more)| Pool { name: name.into(), from, to: from + more })
    };
    let hold = prop::bool::weighted(0.2);
    let staged = (vec(stage(kinds), 1..=4), [pool("pool0"), pool("pool1")], hold).prop_map(
        |(mut stages, pools, hold)| {
            for (at, stage) in stages.iter_mut().enumerate() {
                stage.name = format!("stage{at}");
            }
            let afterwards = if hold { Afterwards::Hold } else { Afterwards::Continue };
            Curriculum { name: "random".into(), pools: pools.into(), stages, afterwards }
        },
    );
    let free = Stage {
        name: "free".into(),
        lift: Lift::All,
        learning: true,
        trials: 0,
        arrange: Vec::new(),
        until: None,
        trial_actions_max: 0,
        saturation: None,
        habituation: None,
    };
    let free = Curriculum {
        name: "free".into(),
        pools: Vec::new(),
        stages: vec![free],
        afterwards: Afterwards::Continue,
    };
    prop_oneof![Just(free), staged]
}

fn parameters(kinds: usize) -> impl Strategy<Value = Parameters> {
    let overridden = (0..kinds, any::<Option<bool>>(), any::<Option<bool>>()).prop_map(
        |(kind, precondition, postcondition)| TypeOverride {
            name: kind_name(kind),
            precondition,
            postcondition,
        },
    );
    let tenths = |range: std::ops::RangeInclusive<u8>| range.prop_map(|tenths| f64::from(tenths) / 10.0);
    (
        (prop_oneof![Just(0.8), tenths(0..=10)], prop::bool::weighted(0.85), prop::bool::weighted(0.9)),
        prop_oneof![2 => Just(1.0), 1 => tenths(0..=30)],
        (prop::bool::weighted(0.85), prop_oneof![Just(0.75), tenths(0..=10)], 2..=3_usize),
        (prop_oneof![2 => Just(0.5), 1 => tenths(0..=10)], prop_oneof![Just(0.5), tenths(0..=10)]),
        (prop_oneof![Just(8), 1..=4_u32], prop_oneof![Just(16), 1..=12_u32]),
        vec(overridden, 0..=1),
    )
        .prop_map(|(first, babbling, generalising, ratios, chains, type_overrides)| Parameters {
            association_weight: first.0,
            excite_by_post_conditions: first.1,
            attention: first.2,
            babbling_excitation: babbling,
            generalisation: generalising.0,
            generalisation_share_min: generalising.1,
            generalisation_support_min: generalising.2,
            prediction_ratio_min: ratios.0,
            association_low_min: ratios.1,
            chain_length_max: chains.0,
            chain_expansions_max: chains.1,
            type_overrides,
        })
}

/// Any run of at most `steps` steps.
pub(crate) fn setup(steps: usize) -> impl Strategy<Value = Setup> {
    let plan = prop_oneof![any_plan(), table_plan(), shelf_plan()];
    plan.prop_flat_map(move |plan| {
        let kinds = plan.kinds.len();
        (Just(plan), curriculum(kinds), parameters(kinds), seldom(20), steps / 4..=steps).prop_map(
            |(plan, curriculum, parameters, commands, steps)| Setup {
                plan,
                curriculum,
                parameters,
                commands,
                steps,
            },
        )
    })
}
