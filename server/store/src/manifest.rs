//! What a memory was begun with. A memory goes on only with the same: effects mean nothing under other parameters, and a
//! stage is a number in one curriculum.

use std::collections::BTreeMap;
use std::io::ErrorKind;

use pschema_learner::curriculum::Curriculum;
use pschema_learner::parameters::{Parameters, TypeOverride};
use serde::{Deserialize, Serialize};

use crate::error::StoreError;
use crate::format::VERSION;
use crate::journal;
use crate::storage::Storage;

const FILE: &str = "manifest";

/// What a memory was begun with.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Manifest {
    /// The version of the format.
    format: u32,
    /// The learner's name.
    learner: String,
    /// Where its randomness began.
    seed: String,
    /// The curriculum's name.
    curriculum: String,
    /// Digest of the curriculum.
    curriculum_digest: String,
    /// The parameters, as text.
    parameters: BTreeMap<String, String>,
}

impl Manifest {
    /// For a memory that is begun now.
    pub(crate) fn new(learner: &str, seed: u64, parameters: &Parameters, curriculum: &Curriculum) -> Self {
        Self {
            format: VERSION,
            learner: learner.to_owned(),
            seed: seed.to_string(),
            curriculum: curriculum.name.clone(),
            curriculum_digest: blake3::hash(format!("{curriculum:?}").as_bytes()).to_hex().to_string(),
            parameters: texts(parameters),
        }
    }

    /// The first thing in which a memory that was begun with `kept` differs from what is given now.
    fn difference(&self, kept: &Self) -> Option<(String, String, String)> {
        let facts = |of: &Self| {
            let named = [
                ("name", &of.learner),
                ("seed", &of.seed),
                ("curriculum", &of.curriculum),
                ("digest of the curriculum", &of.curriculum_digest),
            ];
            let mut facts: BTreeMap<String, String> =
                named.into_iter().map(|(key, value)| (key.to_owned(), value.clone())).collect();
            facts.extend(of.parameters.clone());
            facts
        };
        let (given, kept) = (facts(self), facts(kept));
        let value = |of: &BTreeMap<String, String>, key| of.get(key).cloned().unwrap_or("nothing".to_owned());
        given
            .keys()
            .chain(kept.keys())
            .find(|key| given.get(*key) != kept.get(*key))
            .map(|key| (key.clone(), value(&kept, key), value(&given, key)))
    }
}

/// Every parameter by name. A parameter that is new in a later release counts as its default there.
fn texts(parameters: &Parameters) -> BTreeMap<String, String> {
    let Parameters {
        association_weight,
        excite_by_post_conditions,
        babbling_excitation,
        generalisation,
        generalisation_share_min,
        generalisation_support_min,
        prediction_ratio_min,
        association_low_min,
        attention,
        heard_decays,
        chain_length_max,
        chain_expansions_max,
        type_overrides,
    } = parameters;
    let mut texts: BTreeMap<String, String> = [
        ("association_weight", association_weight.to_string()),
        ("excite_by_post_conditions", excite_by_post_conditions.to_string()),
        ("babbling_excitation", babbling_excitation.to_string()),
        ("generalisation", generalisation.to_string()),
        ("generalisation_share_min", generalisation_share_min.to_string()),
        ("generalisation_support_min", generalisation_support_min.to_string()),
        ("prediction_ratio_min", prediction_ratio_min.to_string()),
        ("association_low_min", association_low_min.to_string()),
        ("attention", attention.to_string()),
        ("heard_decays", heard_decays.to_string()),
        ("chain_length_max", chain_length_max.to_string()),
        ("chain_expansions_max", chain_expansions_max.to_string()),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value))
    .collect();
    for TypeOverride { name, precondition, postcondition } in type_overrides {
        let says = |what: &Option<bool>| what.map_or("as declared".to_owned(), |what| what.to_string());
        let rule = format!("precondition {}, postcondition {}", says(precondition), says(postcondition));
        texts.insert(format!("types.{name}"), rule);
    }
    texts
}

/// Whether the directory has a memory, which is then one that was begun with `given`. Changes nothing.
pub(crate) fn check(storage: &dyn Storage, given: &Manifest) -> Result<bool, StoreError> {
    let path = storage.path(FILE);
    let bytes = match storage.read(FILE) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let journal = journal::segments(storage);
            if journal.map_err(StoreError::disk("read", storage.path(journal::DIRECTORY)))?.is_empty() {
                return Ok(false);
            }
            let problem =
                "it is missing, though there is a journal beside it: put it back from a copy".to_owned();
            return Err(StoreError::Manifest { path, problem });
        }
        Err(error) => return Err(StoreError::Disk { what: "read", path, error }),
    };
    let wrong = |problem: String| StoreError::Manifest { path: path.clone(), problem };
    let text = String::from_utf8(bytes).map_err(|error| wrong(error.to_string()))?;
    let kept: Manifest = toml::from_str(&text).map_err(|error| wrong(error.to_string()))?;
    if kept.format != VERSION {
        let problem = format!("it has format {}, and this release reads 1 to {VERSION}", kept.format);
        return Err(wrong(problem));
    }
    match given.difference(&kept) {
        None => Ok(true),
        Some((key, kept, given)) => Err(StoreError::Differs { path: storage.path(""), key, kept, given }),
    }
}

/// Writes it, durably.
pub(crate) fn write(storage: &dyn Storage, manifest: &Manifest) -> Result<(), StoreError> {
    let temporary = "manifest.tmp";
    let disk = |what| StoreError::disk(what, storage.path(temporary));
    let text = toml::to_string(manifest);
    let text =
        text.map_err(|error| StoreError::Manifest { path: storage.path(FILE), problem: error.to_string() })?;
    let mut file = storage.create(temporary).map_err(disk("create"))?;
    file.write_at(text.as_bytes(), 0).map_err(disk("write"))?;
    file.sync().map_err(disk("make durable"))?;
    storage.rename(temporary, FILE).map_err(disk("rename"))?;
    storage.sync_directory("").map_err(disk("make durable"))
}
