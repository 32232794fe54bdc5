//! The `domain` file: which epoch a daemon serves, for bodies and tools to find.

use std::fs;
use std::hash::{BuildHasher, RandomState};
use std::io::{Read, Write};
use std::path::Path;

use super::error::io;
use super::{DomainError, runtime};

/// One epoch: one run of a daemon.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DomainRecord {
    /// Version of the protocol the daemon speaks.
    pub protocol: u32,
    /// Counts the daemon's starts since the last clean exit, from 1; for people.
    pub epoch: u64,
    /// The daemon's process.
    pub pid: u32,
    /// What every name of the epoch in `/dev/shm` begins with: `ps`, ten random hexadecimal digits, `-`. Two
    /// records of one prefix are of one epoch.
    pub prefix: String,
    /// Whether the epoch can be used: all services are there, and the daemon's ports on them.
    pub ready: bool,
}

/// The longest that a record may be, in bytes: more than any has.
const RECORD_BYTES_MAX: u64 = 1024;
/// The words for a record's state.
const STARTING: &str = "starting";
const READY: &str = "ready";

impl DomainRecord {
    /// The record of a new epoch of this process, which follows `before` and is not ready yet.
    pub(super) fn next(before: Option<&Self>) -> Self {
        // The standard library seeds each `RandomState` from the operating system.
        let random = RandomState::new().hash_one(std::process::id());
        Self {
            protocol: crate::wire::VERSION,
            epoch: before.map_or(0, |before| before.epoch).saturating_add(1),
            pid: std::process::id(),
            prefix: format!("ps{:010x}-", random & 0xff_ffff_ffff),
            ready: false,
        }
    }

    pub(super) fn write(&self, path: &Path) -> Result<(), DomainError> {
        let temporary = path.with_extension("new");
        let mut file = runtime::private_file(&temporary)?;
        let Self { protocol, epoch, pid, prefix, ready } = self;
        let state = if *ready { READY } else { STARTING };
        let text = format!(
            "protocol = {protocol}\nepoch = {epoch}\npid = {pid}\nprefix = {prefix}\nstate = {state}\n"
        );
        file.set_len(0).map_err(io("write", &temporary))?;
        file.write_all(text.as_bytes()).map_err(io("write", &temporary))?;
        fs::rename(&temporary, path).map_err(io("rename", &temporary))
    }

    pub(super) fn read(path: &Path) -> Result<Self, DomainError> {
        let mut text = String::new();
        let file = fs::File::open(path).map_err(io("read", path))?;
        file.take(RECORD_BYTES_MAX).read_to_string(&mut text).map_err(io("read", path))?;
        parse(&text).map_err(|problem| DomainError::Record { path: path.to_owned(), problem })
    }
}

fn parse(text: &str) -> Result<DomainRecord, String> {
    let field = |name: &str| {
        let value = text.lines().filter_map(|line| line.split_once(" = ")).find(|(key, _)| *key == name);
        value.map(|(_, value)| value).ok_or_else(|| format!("it has no {name}"))
    };
    let number =
        |name: &str| field(name)?.parse::<u64>().map_err(|error| format!("its {name} is no number: {error}"));
    let small = |name: &str| number(name)?.try_into().map_err(|_| format!("its {name} is too large"));
    let prefix = field("prefix")?;
    if !is_prefix(prefix) {
        return Err(format!("its prefix {prefix:?} is not one"));
    }
    let ready = match field("state")? {
        READY => true,
        STARTING => false,
        other => return Err(format!("its state {other:?} is neither {STARTING} nor {READY}")),
    };
    Ok(DomainRecord {
        protocol: small("protocol")?,
        epoch: number("epoch")?,
        pid: small("pid")?,
        prefix: prefix.to_owned(),
        ready,
    })
}

/// Whether `text` can be an epoch's prefix. This must be exact, because files are removed by their prefix.
pub(super) fn is_prefix(text: &str) -> bool {
    let digits = text.strip_prefix("ps").and_then(|rest| rest.strip_suffix('-'));
    digits.is_some_and(|digits| digits.len() == 10 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_reads_back_and_damage_is_named() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("domain");
        let record = DomainRecord::next(None);
        assert!(is_prefix(&record.prefix), "{record:?}");
        record.write(&path).unwrap();
        assert_eq!(DomainRecord::read(&path).unwrap(), record);
        let ready = DomainRecord { ready: true, ..record.clone() };
        ready.write(&path).unwrap();
        assert_eq!(DomainRecord::read(&path).unwrap(), ready);
        assert_eq!(DomainRecord::next(Some(&record)).epoch, 2);
        assert_ne!(DomainRecord::next(Some(&record)).prefix, record.prefix);
        let damages = [
            ("pid = ", "pidd = ", "it has no pid"),
            ("prefix = ps", "prefix = ../", "is not one"),
            ("epoch = 1", "epoch = one", "no number"),
            ("state = ready", "state = read", "neither starting nor ready"),
        ];
        for (from, to, complaint) in damages {
            let text = fs::read_to_string(&path).unwrap().replace(from, to);
            let error = parse(&text).unwrap_err();
            assert!(error.contains(complaint), "{error}");
        }
    }
}
