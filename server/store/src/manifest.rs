//! The manifest: everything that a memory was begun with. Manifest, journal and snapshots are all that is needed to find the
//! memory again.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, ErrorKind};

use pschema_learner::mechanisms::Mechanisms;
use serde::{Deserialize, Serialize};

use crate::codec;
use crate::durable;
use crate::error::StoreError;
use crate::format::VERSION;
use crate::format::mirror::Mirror;
use crate::format::v1::{Curriculum, Mechanism, Parameters, Setting};
use crate::journal;
use crate::storage::Storage;

pub(crate) const FILE: &str = "manifest";
/// The manifest while it is being written.
pub(crate) const TEMPORARY: &str = "manifest.tmp";
const HEADER: &str = "# What this memory was begun with. Written once and never changed: what changed later is in the \
                      journal.\n";

/// What a memory was begun with.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Manifest {
    /// The learner's name. It is for people: a directory may be copied, and served under another name.
    pub(crate) learner: String,
    /// The seed, from which all its random numbers follow.
    pub(crate) seed: u64,
    /// The mechanisms beyond the paper that were to be on; none in a manifest of a release that did not write them. The journal's first
    /// batch switches them on.
    pub(crate) mechanisms: Option<Mechanisms>,
    /// The setting that it lived under at first.
    pub(crate) setting: Setting,
}

/// The manifest as it stands in the file.
#[derive(Serialize, Deserialize)]
struct ManifestFile {
    /// The version of the format.
    format: u32,
    /// The blake3 digest of seed, parameters and curriculum as the journal would have them.
    identity: String,
    learner: String,
    /// As text: the numbers of TOML end at half of the largest seed.
    seed: String,
    /// Those that are on from the first batch of the journal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mechanisms: Option<Vec<Mechanism>>,
    parameters: Parameters,
    curriculum: Curriculum,
}

/// The part of a manifest that every version has.
#[derive(Deserialize)]
struct FormatVersion {
    format: u32,
}

impl Manifest {
    fn identity(&self) -> Result<String, StoreError> {
        let bytes = codec::encode(&(self.seed, &self.setting))?;
        Ok(blake3::hash(&bytes).to_hex().to_string())
    }

    fn text(&self, path: &str) -> Result<String, StoreError> {
        let Self { learner, seed, mechanisms, setting: Setting { parameters, curriculum } } = self.clone();
        let (format, identity, seed) = (VERSION, self.identity()?, seed.to_string());
        let mechanisms = mechanisms.as_ref().map(Mirror::of);
        let file = ManifestFile { format, identity, learner, seed, mechanisms, parameters, curriculum };
        let text = toml::to_string(&file);
        let text = text.map_err(|error| wrong(path, error.to_string()))?;
        Ok(format!("{HEADER}{text}"))
    }

    fn parse(text: &str, path: &str) -> Result<Self, StoreError> {
        let wrong = |problem: String| wrong(path, problem);
        let FormatVersion { format } = toml::from_str(text).map_err(|error| wrong(error.to_string()))?;
        if format != VERSION {
            return Err(wrong(format!(
                "it has format {format}, and this release reads formats 1 to {VERSION}"
            )));
        }
        let written: ManifestFile = toml::from_str(text).map_err(|error| wrong(error.to_string()))?;
        let ManifestFile { identity, learner, seed, mechanisms, parameters, curriculum, .. } = written;
        let seed = seed.parse().map_err(|_| wrong(format!("{seed:?} is no seed")))?;
        let mechanisms = mechanisms.map(Mirror::live);
        let found = Self { learner, seed, mechanisms, setting: Setting { parameters, curriculum } };
        if found.identity()? != identity {
            let problem = "it is damaged, or was changed: its identity is not that of what it says. Put it back from a \
                           copy; to go on under other settings, give them with --change";
            return Err(wrong(problem.to_owned()));
        }
        found.setting.checked()?;
        Ok(found)
    }
}

fn wrong(path: &str, problem: String) -> StoreError {
    StoreError::Manifest { path: path.to_owned(), problem }
}

/// The manifest; none if there is no memory. Changes nothing.
pub(crate) fn read(storage: &dyn Storage) -> Result<Option<Manifest>, StoreError> {
    let path = storage.path(FILE);
    let bytes = match storage.read(FILE) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let journal = journal::segments(storage);
            if journal.map_err(StoreError::disk("read", storage.path(journal::DIRECTORY)))?.is_empty() {
                return Ok(None);
            }
            let problem = "it is missing, though there is a journal beside it: put it back from a copy";
            return Err(wrong(&path, problem.to_owned()));
        }
        Err(error) => return Err(StoreError::Disk { what: "read", path, error }),
    };
    let text = String::from_utf8(bytes).map_err(|error| wrong(&path, error.to_string()))?;
    Manifest::parse(&text, &path).map(Some)
}

/// Makes sure that the manifest still has the bytes `written`. Written anew with the same bytes, it is as good as before.
pub(crate) fn check(storage: &dyn Storage, written: &[u8]) -> io::Result<()> {
    let path = storage.path(FILE);
    match storage.read(FILE) {
        Ok(found) if found == written => Ok(()),
        Ok(_) => Err(io::Error::other(format!("{path} was changed, or another is in its place"))),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            Err(io::Error::new(error.kind(), format!("{path} was moved or removed")))
        }
        Err(error) => Err(io::Error::new(error.kind(), format!("cannot read {path}: {error}"))),
    }
}

/// Writes the manifest, and makes it durable.
pub(crate) fn write(storage: &dyn Storage, manifest: &Manifest) -> Result<(), StoreError> {
    let text = manifest.text(&storage.path(FILE))?;
    durable::replace(storage, FILE, TEMPORARY, text.as_bytes())
}

/// Everything in which `given` differs from `kept`: the name, the kept value and the given value. Parameters come first.
pub(crate) fn differences(kept: &Setting, given: &Setting) -> Vec<(String, String, String)> {
    let (kept, given) = (toml::Value::try_from(kept).ok(), toml::Value::try_from(given).ok());
    let mut found = Vec::new();
    for part in ["parameters", "curriculum"] {
        let of = |setting: &Option<toml::Value>| setting.as_ref()?.get(part).cloned();
        compare(part, of(&kept).as_ref(), of(&given).as_ref(), &mut found);
    }
    found
}

fn compare(
    path: &str,
    kept: Option<&toml::Value>,
    given: Option<&toml::Value>,
    found: &mut Vec<(String, String, String)>,
) {
    if kept == given {
        return;
    }
    match (kept.and_then(parts), given.and_then(parts)) {
        (Some(kept), Some(given)) => {
            let keys: BTreeSet<&String> = kept.keys().chain(given.keys()).collect();
            for key in keys {
                let path = format!("{path}.{key}");
                compare(&path, kept.get(key).copied(), given.get(key).copied(), found);
            }
        }
        _ => found.push((path.to_owned(), shown(kept), shown(given))),
    }
}

/// The entries of a table or of a list of tables. An entry that has a name is called by it, others by their place from 1.
fn parts(value: &toml::Value) -> Option<BTreeMap<String, &toml::Value>> {
    match value {
        toml::Value::Table(table) => Some(table.iter().map(|(key, value)| (key.clone(), value)).collect()),
        toml::Value::Array(list) if list.iter().all(toml::Value::is_table) => {
            let named = (1..).zip(list).map(|(at, value)| {
                let name = value.get("name").and_then(toml::Value::as_str);
                (name.map_or_else(|| at.to_string(), |name| format!("{name:?}")), value)
            });
            Some(named.collect())
        }
        _ => None,
    }
}

fn shown(value: Option<&toml::Value>) -> String {
    match value {
        None => "nothing".to_owned(),
        Some(toml::Value::Table(_)) => "something".to_owned(),
        Some(value) => value.to_string(),
    }
}

/// The name of the profile in which these mechanisms are on; the names of the mechanisms where no profile is so.
pub(crate) fn profile(mechanisms: Mechanisms) -> String {
    if mechanisms == Mechanisms::PAPER {
        return "paper".to_owned();
    }
    if mechanisms == Mechanisms::FULL {
        return "full".to_owned();
    }
    let on = mechanisms.named().into_iter().filter_map(|(name, on)| on.then_some(name));
    on.collect::<Vec<_>>().join(", ")
}

/// Whether two settings are the same, by the bytes that would be kept.
pub(crate) fn same(one: &Setting, other: &Setting) -> Result<bool, StoreError> {
    Ok(codec::encode(one)? == codec::encode(other)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::store::curriculum;

    fn manifest() -> Manifest {
        let setting = Setting::new(&Default::default(), &curriculum());
        Manifest { learner: "arm".to_owned(), seed: u64::MAX, mechanisms: Some(Mechanisms::FULL), setting }
    }

    #[test]
    fn it_reads_back_and_sees_what_was_changed_in_it() {
        let text = manifest().text("manifest").unwrap();
        assert_eq!(Manifest::parse(&text, "manifest").unwrap(), manifest());
        let other = text.replace("association_weight = 0.8", "association_weight = 0.7");
        assert_ne!(other, text);
        let error = Manifest::parse(&other, "manifest").unwrap_err().to_string();
        assert!(error.contains("manifest: it is damaged"), "{error}");
        let error = Manifest::parse("format = 2\nnew = true", "manifest").unwrap_err().to_string();
        assert!(error.contains("format 2, and this release reads formats 1 to 1"), "{error}");
    }

    #[test]
    fn differences_are_named() {
        let kept = manifest().setting;
        let mut live = curriculum();
        live.stages[0].trials = 7;
        live.stages
            .push(pschema_learner::curriculum::Stage { name: "more".to_owned(), ..live.stages[0].clone() });
        let parameters = pschema_learner::parameters::Parameters { attention: false, ..Default::default() };
        let found = differences(&kept, &Setting::new(&parameters, &live));
        let expected = [
            ("parameters.attention", "true", "false"),
            ("curriculum.stages.\"free\".trials", "0", "7"),
            ("curriculum.stages.\"more\"", "nothing", "something"),
        ];
        let expected = expected.map(|(key, kept, given)| (key.to_owned(), kept.to_owned(), given.to_owned()));
        assert_eq!(found, expected);
        assert!(differences(&kept, &kept).is_empty());
    }
}
