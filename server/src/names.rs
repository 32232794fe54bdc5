//! The names that a curriculum uses, compared with those that the body declared which it leads. A misspelt name would be
//! obeyed in silence: a sense that nobody has lifts nothing, and an observation that nobody makes ends no trial.

use pschema_learner::curriculum::{Argument, Curriculum, Lift, NamedObservation, Pool, SceneCommand, Stage};
use pschema_learner::parameters::Parameters;
use pschema_learner::vocabulary::{DeclaredProperty, ValueKind as KnownKind, Vocabulary};
use pschema_protocol::description::{Description, Property, ValueKind};

use crate::translate::{HEARING, Translation, listed};

/// The names of a body, and of all that attached before.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names<'a> {
    pub(crate) description: &'a Description,
    pub(crate) translation: &'a Translation,
    pub(crate) vocabulary: &'a Vocabulary,
}

impl Names<'_> {
    /// The first name in the curriculum, or in the parameters, that stands for nothing: its place, and the names that there are.
    pub(crate) fn mistake(&self, curriculum: &Curriculum, parameters: &Parameters) -> Option<String> {
        let overridden = parameters.type_overrides.iter().find_map(|one| {
            let problem = self.observation_type(&one.name).err()?;
            Some(format!("[learner] types: {problem}"))
        });
        overridden.or_else(|| {
            curriculum.stages.iter().find_map(|stage| {
                let problem = self.stage(stage, &curriculum.pools).err()?;
                Some(format!("stage {:?}, {problem}", stage.name))
            })
        })
    }

    fn stage(&self, stage: &Stage, pools: &[Pool]) -> Result<(), String> {
        if let Lift::Types(names) = &stage.lift {
            names.iter().try_for_each(|name| self.observation_type(name).map_err(at("lift")))?;
        }
        stage.arrange.iter().try_for_each(|command| self.command(command, pools).map_err(at("arrange")))?;
        let absent = stage.until_absent.as_ref().map(|absence| &absence.observation);
        let mut observations = vec![("until", stage.until.as_ref()), ("until_absent", absent)];
        for utterance in &stage.say {
            observations.push(("say: when", utterance.when.as_ref()));
            observations.push(("say: unless", utterance.unless.as_ref()));
        }
        let named = observations.into_iter().filter_map(|(key, observation)| Some((key, observation?)));
        named.into_iter().try_for_each(|(key, observation)| self.observation(observation).map_err(at(key)))
    }

    fn observation_type(&self, name: &str) -> Result<(), String> {
        if self.vocabulary.type_named(name).is_some() {
            return Ok(());
        }
        let known = self.vocabulary.types().iter().map(|known| known.declared.name.as_str());
        Err(format!("no observation type is named {name:?}; there are: {}", listed(known)))
    }

    fn observation(&self, named: &NamedObservation) -> Result<(), String> {
        let kind = &named.kind;
        self.observation_type(kind)?;
        let mut own = self.description.observation_types.iter();
        if let Some(own) = own.find(|declared| declared.name == *kind) {
            return named.properties.iter().try_for_each(|(name, value)| {
                let found = own.properties.iter().find(|property| property.name == *name);
                let found =
                    found.ok_or_else(|| no_property(kind, name, own.properties.iter().map(|p| &*p.name)))?;
                takes(found, value).map_err(|problem| format!("{kind}{{{name}}} {problem}"))
            });
        }
        // Another body's sense, or hearing, for which any text is a word.
        let known = self.vocabulary.types().iter().find(|known| known.declared.name == *kind);
        let properties: &[DeclaredProperty] = known.map_or(&[], |known| &known.declared.properties);
        named.properties.iter().try_for_each(|(name, value)| {
            let found = properties.iter().find(|property| property.name == *name);
            let found = found.ok_or_else(|| no_property(kind, name, properties.iter().map(|p| &*p.name)))?;
            match (&found.kind, value) {
                (KnownKind::Integer, Argument::Integer(_)) => Ok(()),
                (KnownKind::Symbol, Argument::Symbol(symbol))
                    if kind == HEARING || self.vocabulary.symbol_named(symbol).is_some() =>
                {
                    Ok(())
                }
                _ => Err(format!("{kind}{{{name}}} has no value {}", shown(value))),
            }
        })
    }

    /// Tries a command of the curriculum with the first and the last number of each pool that it draws from.
    fn command(&self, command: &SceneCommand, pools: &[Pool]) -> Result<(), String> {
        for last in [false, true] {
            let drawn = |argument: &Argument| match argument {
                Argument::Draw(name) => {
                    let pool = pools.iter().find(|pool| pool.name == *name);
                    pool.map_or(argument.clone(), |pool| {
                        Argument::Integer(if last { pool.to } else { pool.from })
                    })
                }
                given => given.clone(),
            };
            let arguments = command.arguments.iter().map(|(name, argument)| (name.clone(), drawn(argument)));
            let tried = SceneCommand { command: command.command.clone(), arguments: arguments.collect() };
            self.translation.scene_command(&tried).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

fn at(key: &str) -> impl Fn(String) -> String {
    move |problem| format!("{key}: {problem}")
}

fn no_property<'a>(kind: &str, name: &str, known: impl Iterator<Item = &'a str>) -> String {
    format!("{kind} has no property {name:?}; it has: {}", listed(known))
}

/// Whether a property can have the value; the error says which it can have.
fn takes(property: &Property, value: &Argument) -> Result<(), String> {
    let has = match (&property.kind, value) {
        (ValueKind::Integer { min, max }, Argument::Integer(number)) if (min..=max).contains(&number) => {
            return Ok(());
        }
        (ValueKind::Symbol { symbols }, Argument::Symbol(symbol)) if symbols.contains(symbol) => {
            return Ok(());
        }
        (ValueKind::Integer { min, max }, _) => format!("whole numbers from {min} to {max}"),
        (ValueKind::Symbol { symbols }, _) => listed(symbols.iter().map(String::as_str)),
        (ValueKind::Boolean, _) => "truth values, of which a curriculum can name none".to_owned(),
        (ValueKind::Real { .. }, _) => "reals, of which a curriculum can name none".to_owned(),
    };
    Err(format!("is never {}; it has: {has}", shown(value)))
}

fn shown(value: &Argument) -> String {
    match value {
        Argument::Integer(number) => number.to_string(),
        Argument::Symbol(text) | Argument::Draw(text) => text.clone(),
    }
}
