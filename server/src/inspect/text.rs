//! Observations, patterns, schemas and bindings by names, for tools.

use pschema_inspect::{Condition, Expectation, NamedValues, ObservationText, SchemaForm, ValueText};
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::{
    Observation, Pattern, PropertyId, Substitution, Term, TypeId, Value, Variable,
};
use pschema_learner::probability::Count;
use pschema_learner::schema::{Form, Generalised, Schema, SchemaId};
use pschema_learner::vocabulary::{BodyId, ValueKind, Vocabulary, bin_middle};

pub(super) fn observation(vocabulary: &Vocabulary, from: &Observation) -> ObservationText {
    pattern(vocabulary, &Pattern::from(from))
}

pub(super) fn observations(vocabulary: &Vocabulary, list: &[Observation]) -> Vec<ObservationText> {
    list.iter().map(|one| observation(vocabulary, one)).collect()
}

/// The name of a body.
pub(super) fn body(content: &Content, body: BodyId) -> String {
    let known = content.vocabulary.bodies().get(usize::from(body.0));
    known.map(|body| body.name.clone()).unwrap_or_default()
}

pub(super) fn pattern(vocabulary: &Vocabulary, from: &Pattern) -> ObservationText {
    let term = |(known, term): &(PropertyId, Term)| {
        let value = match term {
            Term::Constant(constant) => value(vocabulary, *known, *constant),
            Term::Variable(variable) => ValueText::Variable { var: notation::variable(*variable) },
        };
        (property(vocabulary, *known), value)
    };
    ObservationText {
        kind: kind(vocabulary, from.kind()),
        properties: from.terms().iter().map(term).collect(),
    }
}

pub(super) fn value(vocabulary: &Vocabulary, property: PropertyId, from: Value) -> ValueText {
    value_of_kind(vocabulary, vocabulary.property_kind(property), from)
}

/// A value of a property or parameter of this kind.
pub(super) fn value_of_kind(vocabulary: &Vocabulary, kind: Option<&ValueKind>, from: Value) -> ValueText {
    match from {
        Value::Integer(number) => ValueText::Integer(number),
        Value::Boolean(truth) => ValueText::Boolean(truth),
        Value::Symbol(symbol) => ValueText::Symbol(notation::symbol(vocabulary, symbol)),
        Value::Bin(bin) => match kind {
            Some(ValueKind::Real { resolution }) => ValueText::Real(bin_middle(bin, *resolution)),
            _ => ValueText::Integer(bin),
        },
    }
}

/// The name of a type.
pub(super) fn kind(vocabulary: &Vocabulary, kind: TypeId) -> String {
    if kind == TypeId::ENDED {
        return "episode_ended".to_owned();
    }
    let known = vocabulary.types().get(usize::from(kind.0));
    known.map(|known| known.declared.name.clone()).unwrap_or_default()
}

/// The name of a property.
pub(super) fn property(vocabulary: &Vocabulary, property: PropertyId) -> String {
    vocabulary.properties().get(usize::from(property.0)).cloned().unwrap_or_default()
}

pub(super) fn condition(observation: ObservationText, absent: bool, count: Count) -> Condition {
    let (low, high) = count.interval();
    Condition {
        observation,
        absent,
        occurrences: count.occurrences,
        trials: count.trials,
        probability: count.ratio(),
        low,
        high,
    }
}

/// The parts of a schema.
pub(super) fn form(content: &Content, schema: &Schema) -> SchemaForm {
    let vocabulary = &content.vocabulary;
    let known = |id| observation(vocabulary, content.observation(id));
    let expectation =
        |observation, absent, count| Expectation { observation, absent, share: notation::share(count) };
    match &schema.form {
        Form::Concrete(concrete) => SchemaForm {
            pre: concrete.pre.iter().map(|id| known(*id)).collect(),
            action: notation::primitive(vocabulary, concrete.action),
            target: Vec::new(),
            post: concrete
                .post
                .iter()
                .map(|post| expectation(known(post.what), post.absent, post.count))
                .collect(),
        },
        Form::Generalised(law) => SchemaForm {
            pre: law.pre.iter().map(|one| pattern(vocabulary, one)).collect(),
            action: notation::schema_text(content, schema).action,
            target: law.target.iter().map(|one| pattern(vocabulary, one)).collect(),
            post: law
                .post
                .iter()
                .map(|post| expectation(pattern(vocabulary, &post.what), post.absent, post.count))
                .collect(),
        },
    }
}

/// The values of a generalised schema's variables. How a value prints depends on its property, which is looked up where the
/// variable occurs.
pub(super) fn binding(content: &Content, id: SchemaId, from: &Substitution) -> NamedValues {
    let Some(generalised) = content.generalised(id) else {
        return NamedValues::default();
    };
    let shown = from.bindings().iter().filter_map(|(variable, bound)| {
        let property = property_of(generalised, *variable)?;
        Some((notation::variable(*variable), value(&content.vocabulary, property, *bound)))
    });
    shown.collect()
}

fn property_of(schema: &Generalised, wanted: Variable) -> Option<PropertyId> {
    let post = schema.post.iter().map(|post| &post.what);
    let mut terms = schema.pre.iter().chain(&schema.target).chain(post).flat_map(|pattern| pattern.terms());
    terms.find(|(_, term)| *term == Term::Variable(wanted)).map(|(property, _)| *property)
}
