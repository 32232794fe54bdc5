//! What is encoded decodes to itself; what is no message is refused, and never panics.

#![allow(clippy::unwrap_used)] // A test panics to fail.

use proptest::prelude::*;
use pschema_inspect::codec::{self, Reply};
use pschema_inspect::{
    AchieveOrder, NamedValue, NamedValues, ObservationText, Reference, Request, SayOrder, SchemaQuery,
    SchemaSort, StageOrder, Status, UnmetCondition, ValueText, Verdict, WhyNotQuery,
};

fn finite() -> impl Strategy<Value = f64> {
    any::<f64>().prop_filter("a figure", |number| number.is_finite())
}

fn value() -> impl Strategy<Value = ValueText> {
    prop_oneof![
        any::<i64>().prop_map(ValueText::Integer),
        any::<String>().prop_map(ValueText::Symbol),
        any::<bool>().prop_map(ValueText::Boolean),
        finite().prop_map(ValueText::Real),
        any::<String>().prop_map(|var| ValueText::Variable { var }),
        (any::<String>(), any::<String>(), finite()).prop_map(|(kind, property, more)| ValueText::Named {
            named: Box::new(NamedValue { reference: Reference::Only { kind, property }, more })
        }),
    ]
}

fn observation() -> impl Strategy<Value = ObservationText> {
    let properties = proptest::collection::vec((any::<String>(), value()), 0..5);
    (any::<String>(), properties)
        .prop_map(|(kind, properties)| ObservationText { kind, properties: NamedValues(properties) })
}

fn verdict() -> impl Strategy<Value = Verdict> {
    let lacking = (observation(), proptest::option::of(observation()), any::<Vec<String>>(), any::<bool>());
    let lacking = lacking.prop_map(|(wanted, nearest, differs, constrained)| UnmetCondition {
        wanted,
        nearest,
        differs,
        constrained,
    });
    prop_oneof![
        Just(Verdict::Chosen),
        any::<u32>().prop_map(|schema| Verdict::ExecutedFor { schema }),
        proptest::collection::vec(lacking, 0..3).prop_map(|lacking| Verdict::PreConditions { lacking }),
        proptest::collection::vec(observation(), 0..3)
            .prop_map(|target| Verdict::TargetNotAchievable { target }),
        Just(Verdict::LotFellOnAnother),
    ]
}

fn request() -> impl Strategy<Value = Request> {
    prop_oneof![
        (any::<Option<String>>(), any::<Option<String>>(), any::<bool>(), any::<u32>()).prop_map(
            |(action, pre, generalised, limit)| {
                let sort = SchemaSort::Probability;
                SchemaQuery { action, pre, post: None, generalised, sort, limit, offset: 3 }.into()
            }
        ),
        (any::<u32>(), any::<Option<u64>>()).prop_map(|(schema, step)| WhyNotQuery { schema, step }.into()),
        any::<Vec<String>>().prop_map(|words| SayOrder { words }.into()),
        any::<String>().prop_map(|stage| StageOrder::Set(stage).into()),
        (any::<Vec<String>>(), any::<bool>(), any::<Option<String>>(), any::<u32>()).prop_map(
            |(goal, again, most, actions_max)| AchieveOrder { goal, again, most, actions_max }.into()
        ),
    ]
}

proptest! {
    #[test]
    fn requests_are_read_as_they_were_written(request in request()) {
        prop_assert_eq!(codec::decode::<Request>(&codec::encode(&request).unwrap()).unwrap(), request);
    }

    #[test]
    fn observations_are_read_as_they_were_written_to_the_last_bit(observation in observation()) {
        let back: ObservationText = codec::decode(&codec::encode(&observation).unwrap()).unwrap();
        let is_same = |(one, other): (&(String, ValueText), &(String, ValueText))| match (&one.1, &other.1) {
            (ValueText::Real(one), ValueText::Real(other)) => one.to_bits() == other.to_bits(),
            (one, other) => one == other,
        };
        prop_assert!(back.properties.iter().zip(&observation.properties).all(is_same), "{back:?}");
        prop_assert_eq!(back, observation);
    }

    #[test]
    fn verdicts_are_read_as_they_were_written(verdict in verdict()) {
        prop_assert_eq!(codec::decode::<Verdict>(&codec::encode(&verdict).unwrap()).unwrap(), verdict);
    }

    #[test]
    fn bytes_that_are_no_message_are_refused(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(codec::decode::<Request>(&bytes).is_err());
        prop_assert!(codec::decode::<Reply<Status>>(&bytes).is_err());
    }
}
