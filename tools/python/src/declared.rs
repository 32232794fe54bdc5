//! What a body declares, from the plain tuples that `package/pschema/declare.py` makes of it.

use pschema_learner::vocabulary::Vocabulary;
use pschema_protocol::description::{ActionType, Description, ObservationType, Property, Value, ValueKind};
use pschema_server::translate::declaration;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::errors::DeclarationError;
use crate::values::{python, value};

/// Name, unit, kind of value, and what belongs to the kind.
type PlainProperty<'py> = (String, String, String, Bound<'py, PyTuple>);
/// Name, whether it is the body's own, whether it is an event, whether it is a value, properties.
type PlainSense<'py> = (String, bool, bool, bool, Vec<PlainProperty<'py>>);
/// Name, parameters, and the combinations of them that are primitives, by declared order; none: each there is.
type PlainAction<'py> = (String, Vec<PlainProperty<'py>>, Option<Vec<Vec<Bound<'py, PyAny>>>>);

/// A body's declaration: name, kind, senses, actions, scene commands.
#[derive(FromPyObject, IntoPyObject)]
pub(crate) struct PlainDescription<'py>(
    String,
    String,
    Vec<PlainSense<'py>>,
    Vec<PlainAction<'py>>,
    Vec<PlainAction<'py>>,
);

impl<'py> PlainDescription<'py> {
    /// The declaration of a body that is written in Rust.
    pub(crate) fn of(description: &Description, py: Python<'py>) -> PyResult<Self> {
        let properties =
            |of: &[Property]| of.iter().map(|one| plain_property(one, py)).collect::<PyResult<Vec<_>>>();
        let senses = description.observation_types.iter();
        let senses = senses.map(|one| {
            Ok((one.name.clone(), one.own, one.transient, one.value, properties(&one.properties)?))
        });
        let scene_commands = description.scene_commands.iter();
        let scene_commands =
            scene_commands.map(|one| Ok((one.name.clone(), properties(&one.parameters)?, None)));
        let actions = description.actions.iter().enumerate().map(|(number, one)| {
            let own =
                description.repertoire.iter().filter(|primitive| usize::from(primitive.id.index()) == number);
            let own = own.map(|primitive| {
                let values = primitive.parameters.iter().zip(&one.parameters);
                values.map(|(value, of)| python(py, *value, &of.kind)).collect::<PyResult<Vec<_>>>()
            });
            Ok((one.name.clone(), properties(&one.parameters)?, Some(own.collect::<PyResult<Vec<_>>>()?)))
        });
        Ok(Self(
            description.name.clone(),
            description.kind.clone(),
            senses.collect::<PyResult<_>>()?,
            actions.collect::<PyResult<_>>()?,
            scene_commands.collect::<PyResult<_>>()?,
        ))
    }
}

impl PlainDescription<'_> {
    /// The declaration, checked.
    pub(crate) fn description(self) -> PyResult<Description> {
        let Self(name, kind, senses, actions, scene_commands) = self;
        let mut description = Description::new(name, kind);
        for (name, own, transient, value, properties) in senses {
            let mut declared =
                if transient { ObservationType::event(name) } else { ObservationType::state(name) };
            (declared.own, declared.value) = (own, value);
            declared.properties = properties.iter().map(property).collect::<PyResult<_>>()?;
            description.observation_types.push(declared);
        }
        for (name, parameters, primitives) in actions {
            let declared = action_type(name, &parameters)?;
            let Some(primitives) = primitives else {
                description.action_with_primitives(declared);
                continue;
            };
            let id = description.action(declared.clone());
            for (number, given) in primitives.iter().enumerate() {
                let place = || format!("action {}: primitive {number}", declared.name);
                description.primitive(id, &primitive(&place, given, &declared)?[..]);
            }
        }
        for (name, parameters, _) in scene_commands {
            description.scene_command(action_type(name, &parameters)?);
        }
        let refused = |problem: String| DeclarationError::new_err(problem);
        description.check().map_err(|refusal| refused(refusal.to_string()))?;
        // What a learner that knows nothing would refuse, every learner does.
        let declared = declaration(&description).map_err(|problem| refused(problem.to_string()))?;
        Vocabulary::default().check(&declared).map_err(|problem| refused(problem.to_string()))?;
        Ok(description)
    }
}

fn action_type(name: String, parameters: &[PlainProperty<'_>]) -> PyResult<ActionType> {
    let mut declared = ActionType::new(name);
    declared.parameters = parameters.iter().map(property).collect::<PyResult<_>>()?;
    Ok(declared)
}

fn property((name, unit, kind, of_kind): &PlainProperty<'_>) -> PyResult<Property> {
    let kind = match kind.as_str() {
        "integer" => {
            let (min, max) = of_kind.extract()?;
            ValueKind::Integer { min, max }
        }
        "symbol" => ValueKind::Symbol { symbols: of_kind.extract::<(Vec<String>,)>()?.0 },
        "boolean" => ValueKind::Boolean,
        "real" => {
            let (min, max, resolution) = of_kind.extract()?;
            ValueKind::Real { min, max, resolution }
        }
        other => {
            return Err(DeclarationError::new_err(format!("property {name}: there is no kind {other:?}")));
        }
    };
    Ok(Property::new(name, kind).unit(unit))
}

fn plain_property<'py>(of: &Property, py: Python<'py>) -> PyResult<PlainProperty<'py>> {
    let (kind, of_kind) = match &of.kind {
        ValueKind::Integer { min, max } => ("integer", (*min, *max).into_pyobject(py)?),
        ValueKind::Symbol { symbols } => ("symbol", (symbols.clone(),).into_pyobject(py)?),
        ValueKind::Boolean => ("boolean", PyTuple::empty(py)),
        ValueKind::Real { min, max, resolution } => ("real", (*min, *max, *resolution).into_pyobject(py)?),
    };
    Ok((of.name.clone(), of.unit.clone(), kind.to_owned(), of_kind))
}

fn primitive(
    place: &dyn Fn() -> String,
    given: &[Bound<'_, PyAny>],
    declared: &ActionType,
) -> PyResult<Vec<Value>> {
    if given.len() != declared.parameters.len() {
        let (found, wanted) = (given.len(), declared.parameters.len());
        return Err(DeclarationError::new_err(format!(
            "{}: it has {found} values, and the action {wanted} parameters",
            place()
        )));
    }
    let values = given.iter().zip(&declared.parameters);
    let values = values.map(|(given, parameter)| {
        value(given, parameter).map_err(|problem| {
            DeclarationError::new_err(format!("{}: parameter {}: {problem}", place(), parameter.name))
        })
    });
    values.collect()
}

/// Refuses a declaration that the protocol does not allow, with the place of the mistake.
#[pyfunction]
pub(crate) fn check(description: PlainDescription<'_>) -> PyResult<()> {
    description.description().map(drop)
}
