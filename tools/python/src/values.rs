//! Values, observations and actions, between Python and the protocol.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use pschema_process::readable;
use pschema_protocol::description::{self, ActionType, Description, Property, SenseId, Value, ValueKind};
use pschema_protocol::limits::{OBSERVATIONS_MAX, PROPERTIES_MAX};
use pschema_protocol::wire::check;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyMapping, PyString, PyTuple};

use crate::errors::FrameError;

/// What Python gave, as a value of `property`; else what is wrong with it. Whether it is within the property's limits is left
/// to [`checked`].
pub(crate) fn value(given: &Bound<'_, PyAny>, property: &Property) -> Result<Value, String> {
    let is_boolean = || given.is_instance_of::<PyBool>();
    let value = match &property.kind {
        ValueKind::Integer { .. } if !is_boolean() => given.extract().ok().map(Value::Integer),
        ValueKind::Real { .. } if !is_boolean() => given.extract().ok().map(Value::Real),
        ValueKind::Boolean => given.extract().ok().map(Value::Boolean),
        ValueKind::Symbol { symbols } => match given.extract::<Cow<'_, str>>() {
            Ok(text) => return symbol(&text, symbols),
            Err(_) => None,
        },
        _ => None,
    };
    value.ok_or_else(|| format!("{} given where {} is declared", told(given), kind(&property.kind)))
}

fn symbol(text: &str, symbols: &[String]) -> Result<Value, String> {
    let at = symbols.iter().position(|symbol| symbol == text);
    at.map(Value::symbol).ok_or_else(|| {
        let known = symbols.iter().take(8).map(|symbol| format!("{symbol:?}")).collect::<Vec<_>>().join(", ");
        let more = if symbols.len() > 8 { ", …" } else { "" };
        format!("{} is none of the symbols declared: {known}{more}", readable(&format!("{text:?}")))
    })
}

/// What was given, for people: the beginning and the end of what is long.
fn told(given: &Bound<'_, PyAny>) -> String {
    let kind = given.get_type().name().map_or_else(|_| "?".to_owned(), |name| name.to_string());
    match given.repr() {
        // An integer that is too large is an integer all the same, and says so.
        Ok(text) => format!("{} ({kind})", readable(&text.to_string_lossy())),
        Err(_) => format!("a {kind}"),
    }
}

fn kind(of: &ValueKind) -> &'static str {
    match of {
        ValueKind::Integer { .. } => "an integer of 64 bits",
        ValueKind::Symbol { .. } => "a symbol",
        ValueKind::Boolean => "a boolean",
        ValueKind::Real { .. } => "a real",
    }
}

/// A value of `property` that is within its limits, or what is wrong with it and where.
fn checked(place: &dyn Fn() -> String, given: &Bound<'_, PyAny>, property: &Property) -> PyResult<Value> {
    let value = value(given, property)
        .map_err(|problem| FrameError::new_err(format!("{} {}: {problem}", place(), property.name)))?;
    check::value(place, property, &value).map_err(|refusal| FrameError::new_err(refusal.to_string()))?;
    Ok(value)
}

/// The properties of a sense, each with its name as Python has it.
type Properties = Vec<(Property, Py<PyString>)>;

/// The senses that a body declared, by their names.
pub(crate) struct SenseTable {
    senses: Vec<(String, Properties)>,
    by_name: BTreeMap<String, usize>,
}

impl SenseTable {
    pub(crate) fn of(description: &Description, py: Python<'_>) -> Self {
        let named = |property: &Property| (property.clone(), PyString::intern(py, &property.name).unbind());
        let senses: Vec<_> = description
            .observation_types
            .iter()
            .map(|one| (one.name.clone(), one.properties.iter().map(named).collect()))
            .collect();
        let by_name = senses.iter().enumerate();
        let by_name = by_name.map(|(at, (name, _)): (_, &(String, Vec<_>))| (name.clone(), at)).collect();
        Self { senses, by_name }
    }

    /// Hands everything that `reported` has to `observe`, one observation after the other. What is wrong is said with its place, and what
    /// was handed on is of no use then.
    pub(crate) fn read(
        &self,
        reported: &Bound<'_, PyAny>,
        mut observe: impl FnMut(SenseId, &[Value]),
    ) -> PyResult<()> {
        if reported.is_none() {
            let problem =
                "nothing was reported, not even an empty list: return the observations, or yield them";
            return Err(FrameError::new_err(problem));
        }
        let iterator = reported.try_iter().map_err(|_| {
            FrameError::new_err(format!(
                "{} was reported where a list of observations is wanted",
                told(reported)
            ))
        })?;
        for (number, item) in iterator.enumerate() {
            if number == OBSERVATIONS_MAX {
                let problem = format!(
                    "more than {OBSERVATIONS_MAX} observations were reported, which is all that a frame holds"
                );
                return Err(FrameError::new_err(problem));
            }
            self.observation(number, &item?, &mut observe)?;
        }
        Ok(())
    }

    fn observation(
        &self,
        number: usize,
        item: &Bound<'_, PyAny>,
        observe: &mut impl FnMut(SenseId, &[Value]),
    ) -> PyResult<()> {
        let (name, values) = if let Ok(pair) = item.cast::<PyTuple>() {
            match pair.len() {
                1 => (pair.get_item(0)?, None),
                2 => (pair.get_item(0)?, Some(pair.get_item(1)?)),
                _ => return Err(Self::shapeless(number, item)),
            }
        } else {
            (item.clone(), None)
        };
        let Ok(name) = name.extract::<Cow<'_, str>>() else { return Err(Self::shapeless(number, item)) };
        let Some((at, (name, properties))) =
            self.by_name.get(&*name).and_then(|at| Some((*at, self.senses.get(*at)?)))
        else {
            let known = self.by_name.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
            let name = format!("{name:?}");
            return Err(FrameError::new_err(format!(
                "observation {number}: no sense {} is declared; there are: {known}",
                readable(&name)
            )));
        };
        let place = || format!("observation {number} ({name})");
        let mut read = [Value::Boolean(false); PROPERTIES_MAX];
        let count = values.map_or(Ok(0), |values| Self::values(&place, &values, properties, &mut read))?;
        if count != properties.len() {
            let wanted: Vec<_> = properties.iter().map(|(property, _)| property.name.as_str()).collect();
            return Err(FrameError::new_err(format!(
                "{}: {count} values, {} are declared: {}",
                place(),
                wanted.len(),
                wanted.join(", ")
            )));
        }
        let id = SenseId::from_index(u16::try_from(at).unwrap_or(u16::MAX));
        observe(id, read.get(..count).unwrap_or_default());
        Ok(())
    }

    fn shapeless(number: usize, item: &Bound<'_, PyAny>) -> PyErr {
        FrameError::new_err(format!(
            "observation {number}: {} is no observation: give (name, {{property: value}}), (name, (value, …)), or the name alone",
            told(item)
        ))
    }

    /// Reads values by the names of their properties, or in declared order; returns how many were given.
    fn values(
        place: &dyn Fn() -> String,
        given: &Bound<'_, PyAny>,
        properties: &[(Property, Py<PyString>)],
        read: &mut [Value; PROPERTIES_MAX],
    ) -> PyResult<usize> {
        let of_property = || format!("{}: property", place());
        if let Ok(given) = given.cast::<PyDict>() {
            for ((property, name), to) in properties.iter().zip(read.iter_mut()) {
                let Some(given) = given.get_item(name)? else {
                    return Err(FrameError::new_err(format!(
                        "{}: property {} is not given",
                        place(),
                        property.name
                    )));
                };
                *to = checked(&of_property, &given, property)?;
            }
            if given.len() != properties.len() {
                return Err(FrameError::new_err(format!(
                    "{}: {} is more than the properties that are declared",
                    place(),
                    told(given)
                )));
            }
            return Ok(given.len());
        }
        if let Ok(given) = given.cast::<PyMapping>() {
            let copy = PyDict::new(given.py());
            for item in given.items()? {
                let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
                copy.set_item(name, value)?;
            }
            return Self::values(place, copy.as_any(), properties, read);
        }
        let sequence = if given.is_instance_of::<PyString>() { None } else { given.try_iter().ok() };
        let Some(sequence) = sequence else {
            return Err(FrameError::new_err(format!(
                "{}: {} is neither a dict nor a tuple of values",
                place(),
                told(given)
            )));
        };
        let mut count = 0;
        for given in sequence {
            let given = given?;
            if let (Some((property, _)), Some(to)) = (properties.get(count), read.get_mut(count)) {
                *to = checked(&of_property, &given, property)?;
            }
            count += 1;
        }
        Ok(count)
    }
}

/// An action that a body is asked for: its name, and its parameters.
#[pyclass(module = "pschema", frozen, eq, hash)]
#[derive(PartialEq)]
pub(crate) struct Action {
    name: String,
    /// In declared order; printed as it is typed in a command.
    text: String,
    values: Vec<(String, Parameter)>,
    scene: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Parameter {
    Integer(i64),
    Symbol(String),
    Boolean(bool),
    Real(f64),
}

impl std::hash::Hash for Action {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.text.hash(state);
        self.scene.hash(state);
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer(number) => write!(to, "{number}"),
            Self::Symbol(symbol) => write!(to, "{symbol}"),
            Self::Boolean(truth) => write!(to, "{truth}"),
            Self::Real(number) => write!(to, "{number}"),
        }
    }
}

impl Parameter {
    fn python<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(match self {
            Self::Integer(number) => PyInt::new(py, *number).into_any(),
            Self::Symbol(text) => PyString::new(py, text).into_any(),
            Self::Boolean(truth) => PyBool::new(py, *truth).to_owned().into_any(),
            Self::Real(number) => PyFloat::new(py, *number).into_any(),
        })
    }
}

impl Action {
    /// The order of a body that declared these actions, or scene commands.
    pub(crate) fn of(order: &description::Action, declared: &[ActionType], scene: bool) -> Self {
        let kind = declared.get(usize::from(order.id.index()));
        let name = kind.map_or_else(String::new, |kind| kind.name.clone());
        let parameters = kind.map(|kind| kind.parameters.as_slice()).unwrap_or_default();
        let values: Vec<_> = order
            .parameters
            .iter()
            .zip(parameters)
            .map(|(value, property)| (property.name.clone(), parameter(*value, &property.kind)))
            .collect();
        let told: Vec<_> = values.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let text = format!("{name}({})", told.join(", "));
        Self { name, text, values, scene }
    }
}

/// A value of this kind, as Python has it.
pub(crate) fn python<'py>(py: Python<'py>, value: Value, kind: &ValueKind) -> PyResult<Bound<'py, PyAny>> {
    parameter(value, kind).python(py)
}

fn parameter(value: Value, kind: &ValueKind) -> Parameter {
    match (value, kind) {
        (Value::Integer(number), _) => Parameter::Integer(number),
        (Value::Boolean(truth), _) => Parameter::Boolean(truth),
        (Value::Real(number), _) => Parameter::Real(number),
        (Value::Symbol(index), ValueKind::Symbol { symbols }) => {
            let symbol = usize::try_from(index).ok().and_then(|index| symbols.get(index));
            Parameter::Symbol(symbol.cloned().unwrap_or_default())
        }
        (Value::Symbol(index), _) => Parameter::Integer(index.into()),
    }
}

#[pymethods]
impl Action {
    /// The action's name, as it was declared.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is a scene command, by which a curriculum arranges the body's surroundings.
    #[getter]
    fn scene(&self) -> bool {
        self.scene
    }

    /// The parameters by their names, in declared order.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, value) in &self.values {
            dict.set_item(name, value.python(py)?)?;
        }
        Ok(dict)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        match self.values.iter().find(|(known, _)| known == name) {
            Some((_, value)) => value.python(py),
            None => Err(PyKeyError::new_err(format!("{} has no parameter {name:?}", self.text))),
        }
    }

    fn __repr__(&self) -> &str {
        &self.text
    }
}
