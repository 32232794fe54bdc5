//! Random curricula and parameters.

use proptest::collection::vec;
use proptest::option::weighted;
use proptest::prelude::*;
use pschema_learner::curriculum::{
    Absence, Afterwards, Argument, Curriculum, Habituation, Lift, NamedObservation, Pool, Saturation,
    SceneCommand, Stage, Utterance,
};
use pschema_learner::parameters::{Parameters, TypeOverride};

use super::worlds::{PROPERTIES, kind_name};

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
        .prop_map(|(kind, properties)| NamedObservation { kind: kind_name(kind), properties });
    let saturation = (0..=30_u8, 1..=4_u32)
        .prop_map(|(level, actions)| Saturation { excitation_below: f64::from(level) / 10.0, actions });
    let habituation = (0..=3_u32, 0..=10_u8)
        .prop_map(|(executions_min, i)| Habituation { executions_min, interval_max: f64::from(i) / 10.0 });
    let word = (0..kinds, 0..4_i64).prop_map(|(kind, value)| {
        let properties = vec![(PROPERTIES[0].to_owned(), Argument::Integer(value))];
        NamedObservation { kind: kind_name(kind), properties }
    });
    let occasion =
        (0..kinds).prop_map(|kind| NamedObservation { kind: kind_name(kind), properties: Vec::new() });
    let utterance = (
        vec(word, 1..=2),
        weighted(0.7, occasion.clone()),
        weighted(0.2, occasion.clone()),
        0..=4_u8,
        1..=3_u32,
    )
        .prop_map(|(heard, when, unless, quarters, times_max)| Utterance {
            heard,
            when,
            unless,
            probability: f64::from(quarters) / 4.0,
            times_max,
        });
    let absence = (occasion, 1..=3_u32).prop_map(|(observation, actions)| Absence { observation, actions });
    let said = (weighted(0.2, absence), vec(utterance, 0..=2));
    (
        lift,
        prop::bool::weighted(0.85),
        prop_oneof![1 => Just(0), 2 => 1..=3_u32],
        vec((0..2_usize).prop_map(place), 0..=2),
        weighted(0.6, until),
        0..=6_u32,
        weighted(0.5, saturation),
        weighted(0.4, habituation),
        said,
    )
        .prop_map(|(lift, learning, trials, arrange, until, most, saturation, habituation, said)| {
            let (until_absent, say) = said;
            let endless = trials > 0 && until.is_none() && until_absent.is_none() && saturation.is_none();
            let trial_actions_max = if endless { most.max(1) } else { most };
            let name = String::new();
            Stage {
                name,
                lift,
                learning,
                trials,
                arrange,
                until,
                until_absent,
                trial_actions_max,
                saturation,
                habituation,
                say,
            }
        })
}

/// Any curriculum for a world with so many types.
pub(crate) fn curriculum(kinds: usize) -> impl Strategy<Value = Curriculum> {
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
    let free = Curriculum {
        name: "free".into(),
        pools: Vec::new(),
        stages: vec![Stage::free("free")],
        afterwards: Afterwards::Continue,
    };
    prop_oneof![Just(free), staged]
}

/// First the body by itself, then everything, as the paper's experiment does; then on its own.
pub(crate) fn paper() -> impl Strategy<Value = Curriculum> {
    (1..=3_u32, 1..=4_u32, 0..=2_u32, any::<bool>()).prop_map(|(quiet, trials, executions_min, alone)| {
        let babbling = Stage {
            lift: Lift::Types(vec![kind_name(0)]),
            saturation: Some(Saturation { excitation_below: 1.0, actions: quiet }),
            habituation: Some(Habituation { executions_min, interval_max: 0.0 }),
            ..Stage::free("babbling")
        };
        let place = SceneCommand {
            command: "place".into(),
            arguments: vec![("at".into(), Argument::Draw("pool0".into()))],
        };
        let touching = Stage {
            trials,
            arrange: vec![place],
            until: Some(NamedObservation { kind: kind_name(2), properties: Vec::new() }),
            trial_actions_max: 12,
            ..Stage::free("touching")
        };
        let stages = if alone {
            vec![babbling, Stage::free("alone")]
        } else {
            vec![babbling, touching, Stage::free("alone")]
        };
        let pools = vec![Pool { name: "pool0".into(), from: 0, to: 5 }];
        Curriculum { name: "paper".into(), pools, stages, afterwards: Afterwards::Continue }
    })
}

/// Any parameters.
pub(crate) fn parameters(kinds: usize) -> impl Strategy<Value = Parameters> {
    let overridden = (0..kinds, any::<Option<bool>>(), any::<Option<bool>>()).prop_map(
        |(kind, precondition, postcondition)| TypeOverride {
            name: kind_name(kind),
            precondition,
            postcondition,
        },
    );
    let tenths = |range: std::ops::RangeInclusive<u8>| range.prop_map(|tenths| f64::from(tenths) / 10.0);
    (
        (
            prop_oneof![Just(0.8), tenths(0..=10)],
            prop::bool::weighted(0.85),
            prop::bool::weighted(0.9),
            prop::bool::weighted(0.8),
        ),
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
            heard_decays: first.3,
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
