//! Effects that no learner makes: of numbers in and out of range, of lists too short, too long and out of order.

use std::sync::Arc;

use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use pschema_learner::effect::{Effect, Score};
use pschema_learner::execution::{ChainLink, Execution};
use pschema_learner::experience::Experience;
use pschema_learner::item::{Event, Update};
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::Content;
use pschema_learner::observation::{
    Observation, Pattern, PropertyId, Substitution, SymbolId, Term, TypeId, Value, Variable,
};
use pschema_learner::policy::{Lead, Policy, PolicyRow};
use pschema_learner::progress::StageEffect;
use pschema_learner::pursuit::{Ending, Goal, PlanCause, PlanRecord, PursuitEffect};
use pschema_learner::schema::{Form, SchemaId};
use pschema_learner::vocabulary::{
    BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
};
use pschema_learner::world_state::WorldState;

fn value() -> impl Strategy<Value = Value> {
    prop_oneof![
        6 => (0..4_i64).prop_map(Value::Integer),
        1 => any::<i64>().prop_map(Value::Integer),
        1 => prop_oneof![0..3_u32, any::<u32>()].prop_map(|symbol| Value::Symbol(SymbolId(symbol))),
        1 => any::<bool>().prop_map(Value::Boolean),
        1 => any::<i64>().prop_map(Value::Bin),
    ]
}

fn kind() -> impl Strategy<Value = TypeId> {
    prop_oneof![12 => 0..4_u16, 1 => any::<u16>()].prop_map(TypeId)
}

fn property() -> impl Strategy<Value = PropertyId> {
    prop_oneof![12 => 0..3_u16, 1 => any::<u16>()].prop_map(PropertyId)
}

pub(crate) fn observation() -> impl Strategy<Value = Observation> {
    (kind(), vec((property(), value()), 0..3))
        .prop_map(|(kind, properties)| Observation::new(kind, properties))
}

fn observations() -> impl Strategy<Value = Vec<Observation>> {
    vec(observation(), 0..4)
}

fn pattern() -> impl Strategy<Value = Pattern> {
    let term = prop_oneof![
        value().prop_map(Term::Constant),
        prop_oneof![0..3_u8, any::<u8>()].prop_map(|name| Term::Variable(Variable(name))),
    ];
    (kind(), vec((property(), term), 0..3)).prop_map(|(kind, terms)| Pattern::new(kind, terms))
}

fn schema() -> impl Strategy<Value = SchemaId> {
    prop_oneof![12 => 0..30_u32, 1 => any::<u32>()].prop_map(SchemaId)
}

fn primitive() -> impl Strategy<Value = PrimitiveId> {
    prop_oneof![12 => 0..4_u32, 1 => any::<u32>()].prop_map(PrimitiveId)
}

fn body() -> impl Strategy<Value = BodyId> {
    prop_oneof![12 => 0..2_u16, 1 => any::<u16>()].prop_map(BodyId)
}

fn scores() -> impl Strategy<Value = Vec<Score>> {
    vec(prop::sample::select(vec![Score::Held, Score::Missed, Score::Constrained]), 0..5)
}

fn post<T: std::fmt::Debug>(what: impl Strategy<Value = T>) -> impl Strategy<Value = Vec<(T, bool)>> {
    vec((what, any::<bool>()), 0..4)
}

fn binding() -> impl Strategy<Value = Substitution> {
    vec((0..4_u8, value()), 0..3).prop_map(|pairs| {
        let mut binding = Substitution::new();
        for (name, value) in pairs {
            binding.bind(Variable(name), value);
        }
        binding
    })
}

fn chain() -> impl Strategy<Value = Vec<ChainLink>> {
    let link = || {
        (schema(), binding(), option::weighted(0.2, schema()))
            .prop_map(|(schema, binding, carrier)| ChainLink { schema, binding, carrier })
    };
    prop_oneof![12 => vec(link(), 0..3), 1 => vec(link(), 60..70)]
}

fn execution() -> impl Strategy<Value = Execution> {
    let carrier = option::weighted(0.3, schema());
    (option::of(schema()), binding(), carrier, primitive(), observations(), chain(), any::<bool>()).prop_map(
        |(schema, binding, carrier, action, before, chain, for_goal)| {
            let before = WorldState::new(before);
            Execution { schema, binding, carrier, action, before, chain, for_goal }
        },
    )
}

/// Declarations, mostly of what nothing has declared yet.
fn declaration() -> impl Strategy<Value = Declaration> {
    let values = prop_oneof![
        Just(ValueKind::Integer),
        Just(ValueKind::Symbol),
        prop_oneof![Just(0.5), any::<f64>()].prop_map(|resolution| ValueKind::Real { resolution }),
    ];
    let parameter = prop_oneof![
        (0..3_i64).prop_map(Parameter::Integer),
        "[a-c]".prop_map(Parameter::Symbol),
        any::<f64>().prop_map(Parameter::Real),
    ];
    let named = |name: String, kind| DeclaredProperty { name, unit: String::new(), kind };
    let repertoire = vec((0..2_usize, vec(parameter, 0..2)), 0..3);
    ("[a-c]", "[a-c]", values, any::<[bool; 4]>(), repertoire).prop_map(
        move |(body, name, kind, [own, transient, heard, value], repertoire)| Declaration {
            body,
            observation_types: vec![DeclaredType {
                name: format!("new {name}"),
                own,
                transient,
                heard,
                value,
                properties: vec![named(format!("of {name}"), kind.clone())],
            }],
            actions: vec![DeclaredAction { name: format!("do {name}"), parameters: vec![named(name, kind)] }],
            repertoire,
        },
    )
}

fn stage() -> impl Strategy<Value = StageEffect> {
    let count = || prop_oneof![0..3_u32, any::<u32>()];
    let at = || prop_oneof![0..3_usize, any::<usize>()];
    let pools = vec(vec(any::<i64>(), 0..4), 0..3);
    prop_oneof![
        (body(), pools, any::<u64>()).prop_map(|(student, pools, random)| StageEffect::Begun {
            student,
            pools,
            random
        }),
        (at(), ".*").prop_map(|(stage, name)| StageEffect::Entered { stage, name }),
        vec((at(), any::<i64>()), 0..3).prop_map(|drawn| StageEffect::TrialBegun { drawn }),
        (count(), count(), count(), any::<bool>()).prop_map(
            |(concrete_new, generalised_new, counter_examples_new, absent)| StageEffect::Acted {
                concrete_new,
                generalised_new,
                counter_examples_new,
                absent,
            }
        ),
        (vec(at(), 0..3), any::<u64>())
            .prop_map(|(utterances, random)| StageEffect::Spoken { utterances, random }),
        any::<bool>().prop_map(StageEffect::Quiet),
        (any::<bool>(), count()).prop_map(|(met, generalised)| StageEffect::TrialEnded { met, generalised }),
        any::<bool>().prop_map(StageEffect::Held),
        ".*".prop_map(StageEffect::Stuck),
        prop::sample::select(vec![
            StageEffect::Saturated,
            StageEffect::Ended,
            StageEffect::Finished,
            StageEffect::Left,
        ]),
    ]
}

fn policy() -> impl Strategy<Value = Policy> {
    let kinds = || vec(kind(), 0..3);
    let probability = || prop_oneof![3 => 0.0..=1.0, 1 => any::<f64>()];
    let lead = (option::of(prop_oneof![0..2_u32, any::<u32>()]), probability());
    let leads = vec(lead.prop_map(|(to, probability)| Lead { to, probability }), 0..3);
    let row = (vec(observation(), 0..2), primitive(), probability(), leads)
        .prop_map(|(context, action, probability, leads)| PolicyRow { context, action, probability, leads });
    (kinds(), kinds(), vec(observation(), 0..2), vec(row, 0..3), probability()).prop_map(
        |(kinds, chance, circumstances, rows, actions)| Policy {
            kinds,
            chance,
            circumstances,
            rows,
            yields: Vec::new(),
            actions,
            after_actions: 0,
        },
    )
}

fn pursuit() -> impl Strategy<Value = PursuitEffect> {
    let because = prop::sample::select(vec![PlanCause::First, PlanCause::Interrupted]);
    let probability = prop_oneof![0.0..=1.0, any::<f64>()];
    let plan = (any::<u32>(), because, chain(), option::of(policy()), probability, any::<bool>()).prop_map(
        |(after_actions, because, chain, policy, probability, truncated)| {
            let policy = policy.map(Arc::new);
            let plan = PlanRecord { after_actions, because, chain, policy, probability, truncated };
            PursuitEffect::Planned(plan)
        },
    );
    let goal = prop_oneof![
        vec(pattern(), 0..3).prop_map(Goal::Observed),
        vec(pattern(), 0..3).prop_map(Goal::Again),
        kind().prop_map(Goal::Most),
    ];
    prop_oneof![
        3 => (body(), goal, prop_oneof![1..9_u32, any::<u32>()])
            .prop_map(|(body, goal, actions_max)| PursuitEffect::Begun { body, goal, actions_max }),
        1 => any::<f64>().prop_map(PursuitEffect::Came),
        2 => plan,
        1 => policy().prop_map(|policy| PursuitEffect::Revised(Arc::new(policy))),
        1 => Just(PursuitEffect::Acted),
        1 => prop::sample::select(vec![Ending::Achieved, Ending::Cancelled]).prop_map(PursuitEffect::Ended),
    ]
}

/// Any effect at all.
fn any_effect() -> impl Strategy<Value = Effect> {
    prop_oneof![
        1 => declaration().prop_map(|declaration| Effect::Declared(Box::new(declaration))),
        1 => vec(".*", 0..3).prop_map(Effect::SymbolsMet),
        2 => (primitive(), any::<bool>())
            .prop_map(|(primitive, carried_out)| Effect::Attempted { primitive, carried_out }),
        4 => (schema(), any::<bool>(), scores(), scores()).prop_map(
            |(schema, success, post, associations)| Effect::Executed { schema, success, post, associations }
        ),
        4 => (schema(), observation(), any::<bool>())
            .prop_map(|(schema, observation, absent)| Effect::OutcomeAdded { schema, observation, absent }),
        4 => (observations(), primitive(), post(observation()), option::of(schema()), option::weighted(0.3, schema()))
            .prop_map(|(pre, action, post, parent, contradicts)| {
                Effect::Created { pre, action, post, parent, contradicts }
            }),
        4 => (vec(pattern(), 0..4), vec(pattern(), 0..2), post(pattern()), schema(), vec(schema(), 0..3))
            .prop_map(|(pre, target, post, parent, examples)| {
                Effect::Generalised { pre, target, post, parent, examples }
            }),
        2 => (schema(), schema())
            .prop_map(|(generalised, example)| Effect::Supported { generalised, example }),
        1 => schema().prop_map(|generalised| Effect::Retired { generalised }),
        4 => (schema(), observation(), option::weighted(0.3, prop_oneof![0..3_usize, any::<usize>()])).prop_map(
            |(schema, observation, replaces)| Effect::Associated { schema, observation, replaces }
        ),
        2 => observations().prop_map(Effect::Happened),
        2 => observations().prop_map(Effect::Attended),
        3 => stage().prop_map(Effect::Stage),
        3 => pursuit().prop_map(Effect::Pursuit),
        3 => (body(), any::<u64>(), option::of(execution())).prop_map(|(body, random, pending)| {
            Effect::StepEnded { body, random, pending: pending.map(Arc::new) }
        }),
        1 => any::<bool>().prop_map(Effect::Full),
        1 => (body(), ".*").prop_map(|(body, text)| Effect::Described { body, text }),
        1 => any::<[bool; 6]>().prop_map(|[claims, curiosity, recall, items, policies, superschemas]| {
            Effect::Mechanisms(Mechanisms { claims, curiosity, recall, items, policies, superschemas })
        }),
        2 => (body(), vec(any::<bool>(), 0..3)).prop_map(|(body, on)| Effect::Followed { body, on }),
        2 => supposed(),
        2 => prop_oneof![0..3_u32, any::<u32>()].prop_map(|item| Effect::Dropped { item }),
        6 => experience().prop_map(|experience| Effect::Experienced(Box::new(experience))),
    ]
}

fn supposed() -> impl Strategy<Value = Effect> {
    let update = prop_oneof![Just(Update::On), Just(Update::Off), Just(Update::Turn)];
    let event =
        (primitive(), observations()).prop_map(|(primitive, after)| Event { primitive, after: after.into() });
    (body(), any::<bool>(), primitive(), vec(kind(), 0..3), vec((event, update), 0..4)).prop_map(
        |(body, on, primitive, kinds, updates)| Effect::Supposed {
            body,
            on,
            primitive,
            kinds: kinds.into(),
            updates: updates.into(),
        },
    )
}

fn experience() -> impl Strategy<Value = Experience> {
    let parameters = vec(option::of(value()), 0..3);
    (primitive(), parameters, observations(), observations(), vec(kind(), 0..4)).prop_map(
        |(primitive, parameters, before, after, sensed)| Experience {
            body: BodyId(0),
            recalled: None,
            primitive,
            parameters: parameters.into(),
            before: before.into(),
            after: after.into(),
            sensed: sensed.into(),
        },
    )
}

/// Any effect, and whether it is to be mended so that it says more of what memory may be told.
pub(crate) fn effect() -> impl Strategy<Value = (Effect, bool)> {
    (any_effect(), prop::bool::weighted(0.7))
}

/// The effect with lists as long as `content` has them, in their order, and with the numbers that are next.
pub(crate) fn mended(effect: &Effect, content: &Content) -> Effect {
    let mut effect = effect.clone();
    match &mut effect {
        Effect::Executed { schema, post, associations, .. } => {
            let Some(known) = content.schema(*schema) else { return effect };
            let len = match &known.form {
                Form::Concrete(concrete) => concrete.post.len(),
                Form::Generalised(generalised) => generalised.post.len(),
            };
            post.resize(len, Score::Held);
            associations.resize(known.associations.len(), Score::Held);
        }
        Effect::Created { pre, post, .. } => {
            pre.sort_unstable();
            pre.dedup();
            post.sort_unstable();
            post.dedup();
        }
        Effect::Experienced(experience) => {
            let ordered = |list: &Arc<[Observation]>| -> Arc<[Observation]> {
                WorldState::new(list.iter().cloned()).observations().into()
            };
            experience.before = ordered(&experience.before);
            experience.after = ordered(&experience.after);
            let mut sensed = experience.sensed.to_vec();
            sensed.sort_unstable();
            sensed.dedup();
            experience.sensed = sensed.into();
        }
        Effect::Followed { on, .. } => on.resize(content.items.all.len(), true),
        Effect::Supposed { kinds, updates, .. } => {
            let mut ordered = kinds.to_vec();
            ordered.sort_unstable();
            ordered.dedup();
            *kinds = ordered.into();
            let mut ordered = updates.to_vec();
            for (event, _) in &mut ordered {
                event.after = WorldState::new(event.after.to_vec()).observations().into();
            }
            ordered.sort_unstable();
            ordered.dedup_by(|a, b| a.0 == b.0);
            *updates = ordered.into();
        }
        Effect::Stage(StageEffect::TrialBegun { drawn }) => {
            let pools = content.progress.pools.iter().enumerate();
            *drawn = pools.filter_map(|(at, pool)| Some((at, *pool.last()?))).collect();
        }
        _ => (),
    }
    effect
}
