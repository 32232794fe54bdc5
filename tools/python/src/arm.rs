//! The simulated arm in this process, attached to nothing: `package/pschema/table.py` makes an environment of Gymnasium of it.

use pschema_protocol::body::{Body, Outcome, Senses};
use pschema_protocol::description::{self, Value};
use pschema_sim::body::SimBody;
use pschema_sim::config::WorldFile;
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

use crate::declared::PlainDescription;
use crate::values::{Action, python};

/// How an order went: its kind, as `pschema.Outcome` names it, and the reason.
type PlainOutcome = (&'static str, String);

/// An arm, a table, blocks and a camera: the body of `pschema sim`.
#[pyclass(module = "pschema._native")]
pub(crate) struct Arm {
    body: SimBody,
    description: description::Description,
}

#[pymethods]
impl Arm {
    /// The arm at rest in a world, nothing on the table. `world` is `wide`, `narrow`, `block-and-ball`, or the path of a world file; `seed`
    /// decides all chances.
    #[new]
    fn new(py: Python<'_>, world: &str, seed: u64) -> PyResult<Self> {
        let build = || WorldFile::load(world).and_then(|file| SimBody::new("arm", file, world, seed, false));
        let body = py.detach(build).map_err(|problem| PyValueError::new_err(problem.to_string()))?;
        Ok(Self { description: body.describe(), body })
    }

    /// What it declares, as `package/pschema/declare.py` hands it over.
    fn describe<'py>(&self, py: Python<'py>) -> PyResult<PlainDescription<'py>> {
        PlainDescription::of(&self.description, py)
    }

    /// All that it can be asked to do, in the order in which it declares it: [`Arm::act`] takes the place in this list.
    fn repertoire(&self) -> Vec<Action> {
        let repertoire = self.description.repertoire.iter();
        repertoire.map(|action| Action::of(action, &self.description.actions, false)).collect()
    }

    /// The places for objects: the field that one is seen in there, and whether the finger reaches it.
    fn places(&self) -> Vec<(usize, bool)> {
        self.body.workspace().places.iter().map(|place| (place.field, place.within_reach)).collect()
    }

    /// What is sensed now: the name of each sense, with its values in declared order.
    fn sense<'py>(&mut self, py: Python<'py>) -> PyResult<Vec<(String, Bound<'py, PyTuple>)>> {
        let mut senses = Senses::default();
        py.detach(|| self.body.sense(&mut senses));
        let types = &self.description.observation_types;
        let observed = senses.observations();
        let observed = observed.iter().filter_map(|one| {
            let declared = types.get(usize::from(one.sense().index()))?;
            let values = one.values().zip(&declared.properties);
            let values: PyResult<Vec<_>> = values.map(|(value, of)| python(py, value, &of.kind)).collect();
            Some(values.and_then(|values| Ok((declared.name.clone(), PyTuple::new(py, values)?))))
        });
        observed.collect()
    }

    /// Does what is at this place in the repertoire, to its end.
    fn act(&mut self, py: Python<'_>, number: usize) -> PyResult<PlainOutcome> {
        let Some(action) = self.description.repertoire.get(number) else {
            let count = self.description.repertoire.len();
            return Err(PyIndexError::new_err(format!(
                "there is no action {number}: there are {count}, from 0"
            )));
        };
        Ok(plain(py.detach(|| self.body.act(action))))
    }

    /// Puts an object down at a place, by their numbers; the arm is parked first.
    fn place(&mut self, py: Python<'_>, object: u32, place: i64) -> PlainOutcome {
        let command = description::Action::new(self.body.ids().place, (Value::Symbol(object), place));
        plain(py.detach(|| self.body.arrange(&command)))
    }

    /// Takes an object away.
    fn remove(&mut self, object: u32) -> PlainOutcome {
        let command = description::Action::new(self.body.ids().remove, [Value::Symbol(object)]);
        plain(self.body.arrange(&command))
    }

    /// Takes the arm to its rest posture, out of sight.
    fn park(&mut self) -> PlainOutcome {
        plain(self.body.arrange(&description::Action::new(self.body.ids().park, ())))
    }

    /// What the camera sees: width and height in pixels, and red, green and blue of each.
    fn picture<'py>(&mut self, py: Python<'py>) -> (usize, usize, Bound<'py, PyBytes>) {
        let (image, _) = py.detach(|| self.body.look());
        (image.width_px(), image.height_px(), PyBytes::new(py, image.as_rgb_bytes()))
    }
}

fn plain(outcome: Outcome) -> PlainOutcome {
    match outcome {
        Outcome::Done => ("done", String::new()),
        Outcome::Refused(reason) => ("refused", reason),
        Outcome::Failed(reason) => ("failed", reason),
        Outcome::TimedOut => ("timed-out", String::new()),
        Outcome::EpisodeEnded => ("episode-ended", String::new()),
        Outcome::EpisodeCut => ("episode-cut", String::new()),
    }
}
