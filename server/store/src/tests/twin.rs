//! A directory in memory that loses power: what was not synced is lost, sector by sector, as the seed decides.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pschema_learner::random::Random;

use crate::storage::{OpenFile, Storage};

const SECTOR: usize = 512;

/// What goes wrong next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Nothing.
    None,
    /// The disk holds so many bytes more.
    Full(u64),
    /// The sync after so many others is not confirmed.
    Sync(u32),
}

#[derive(Clone, Debug, Default)]
struct Node {
    /// What a reader sees.
    seen: Vec<u8>,
    /// What survives.
    durable: Vec<u8>,
    /// Sectors that differ, in no order.
    dirty: Vec<usize>,
}

#[derive(Clone, Debug)]
enum Change {
    Created(String, u64),
    Renamed(String, String),
    Removed(String),
}

#[derive(Debug)]
struct State {
    nodes: BTreeMap<u64, Node>,
    /// Names, as seen and as they survive.
    names: BTreeMap<String, u64>,
    durable_names: BTreeMap<String, u64>,
    changes: Vec<Change>,
    next: u64,
    fault: Fault,
    /// Whether the sync of a snapshot waits.
    hold_snapshots: bool,
    /// Whether every sync of a file waits.
    hold_syncs: bool,
}

/// The twin. A clone is the same directory.
#[derive(Clone, Debug)]
pub(crate) struct Twin(Arc<Mutex<State>>);

impl Twin {
    pub(crate) fn new() -> Self {
        let state = State {
            nodes: BTreeMap::new(),
            names: BTreeMap::new(),
            durable_names: BTreeMap::new(),
            changes: Vec::new(),
            next: 0,
            fault: Fault::None,
            hold_snapshots: false,
            hold_syncs: false,
        };
        Self(Arc::new(Mutex::new(state)))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn fail(&self, fault: Fault) {
        self.state().fault = fault;
    }

    /// Loses power: of what was not synced, any subset survives.
    pub(crate) fn lose_power(&self, random: &mut Random) {
        let mut state = self.state();
        // Names change in order: some of the changes made it, the later ones did not.
        let kept = random.below(state.changes.len() + 1);
        let changes = std::mem::take(&mut state.changes);
        let mut names = state.durable_names.clone();
        changes.iter().take(kept).for_each(|change| apply(&mut names, change));
        state.durable_names = names.clone();
        state.names = names;
        for node in state.nodes.values_mut() {
            for sector in std::mem::take(&mut node.dirty) {
                if random.below(2) == 0 {
                    node.keep(sector);
                }
            }
            node.seen = node.durable.clone();
        }
    }

    /// Has the sync of a snapshot wait until it is said otherwise.
    pub(crate) fn hold_snapshots(&self, hold: bool) {
        self.state().hold_snapshots = hold;
    }

    /// Has the sync of every file wait until it is said otherwise.
    pub(crate) fn hold_syncs(&self, hold: bool) {
        self.state().hold_syncs = hold;
    }

    /// Damages one bit for good.
    pub(crate) fn flip(&self, name: &str, bit: usize) {
        self.edit(name, |bytes| bytes[bit / 8] ^= 1 << (bit % 8));
    }

    pub(crate) fn edit(&self, name: &str, change: impl FnOnce(&mut Vec<u8>)) {
        let mut state = self.state();
        let id = state.names[name];
        let node = state.nodes.get_mut(&id).unwrap();
        change(&mut node.seen);
        node.durable = node.seen.clone();
        node.dirty.clear();
    }

    /// Another directory with the same in it.
    pub(crate) fn copy(&self) -> Self {
        let state = self.state();
        Self(Arc::new(Mutex::new(State {
            nodes: state.nodes.clone(),
            names: state.names.clone(),
            durable_names: state.durable_names.clone(),
            changes: state.changes.clone(),
            next: state.next,
            fault: state.fault,
            hold_snapshots: state.hold_snapshots,
            hold_syncs: state.hold_syncs,
        })))
    }
}

impl Node {
    fn keep(&mut self, sector: usize) {
        let from = sector * SECTOR;
        let to = (from + SECTOR).min(self.seen.len());
        if from >= to {
            return;
        }
        if self.durable.len() < to {
            self.durable.resize(to, 0);
        }
        let (durable, seen) = (&mut self.durable[from..to], &self.seen[from..to]);
        durable.copy_from_slice(seen);
    }

    fn sync(&mut self) {
        self.durable = self.seen.clone();
        self.dirty.clear();
    }
}

fn apply(names: &mut BTreeMap<String, u64>, change: &Change) {
    match change {
        Change::Created(name, id) => drop(names.insert(name.clone(), *id)),
        Change::Renamed(from, to) => {
            if let Some(id) = names.remove(from) {
                names.insert(to.clone(), id);
            }
        }
        Change::Removed(name) => drop(names.remove(name)),
    }
}

impl State {
    fn change(&mut self, change: Change) {
        apply(&mut self.names, &change);
        self.changes.push(change);
    }

    fn node(&self, name: &str) -> io::Result<u64> {
        self.names.get(name).copied().ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn sync(&mut self) -> io::Result<()> {
        match &mut self.fault {
            Fault::Sync(0) => Err(io::Error::other("the disk did not confirm")),
            Fault::Sync(left) => {
                *left -= 1;
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

impl Storage for Twin {
    fn list(&self, directory: &str) -> io::Result<Vec<String>> {
        let prefix = format!("{directory}/");
        let state = self.state();
        Ok(state.names.keys().filter_map(|name| name.strip_prefix(&prefix)).map(str::to_owned).collect())
    }

    fn is_there(&self, _: &str) -> bool {
        true
    }

    fn open(&self, name: &str) -> io::Result<Box<dyn Read>> {
        let state = self.state();
        let id = state.node(name)?;
        Ok(Box::new(io::Cursor::new(state.nodes[&id].seen.clone())))
    }

    fn size(&self, name: &str) -> io::Result<u64> {
        let state = self.state();
        let id = state.node(name)?;
        Ok(state.nodes[&id].seen.len() as u64)
    }

    fn truncate(&self, name: &str, to: u64) -> io::Result<()> {
        let mut state = self.state();
        let id = state.node(name)?;
        if let Some(node) = state.nodes.get_mut(&id) {
            node.seen.truncate(usize::try_from(to).unwrap());
            node.dirty.retain(|sector| sector * SECTOR < node.seen.len());
        }
        Ok(())
    }

    fn create(&self, name: &str) -> io::Result<Box<dyn OpenFile>> {
        let mut state = self.state();
        let id = state.next;
        state.next += 1;
        state.nodes.insert(id, Node::default());
        state.change(Change::Created(name.to_owned(), id));
        Ok(Box::new(Open { twin: self.clone(), id }))
    }

    fn confirm(&self, name: &str, _: u64) -> io::Result<()> {
        self.sync(name)
    }

    fn sync(&self, name: &str) -> io::Result<()> {
        let mut state = self.state();
        state.sync()?;
        let id = state.node(name)?;
        if let Some(node) = state.nodes.get_mut(&id) {
            node.sync();
        }
        Ok(())
    }

    fn rename(&self, from: &str, to: &str) -> io::Result<()> {
        self.state().change(Change::Renamed(from.to_owned(), to.to_owned()));
        Ok(())
    }

    fn remove(&self, name: &str) -> io::Result<()> {
        self.state().change(Change::Removed(name.to_owned()));
        Ok(())
    }

    fn directory(&self, _: &str) -> io::Result<()> {
        Ok(())
    }

    fn sync_directory(&self, _: &str) -> io::Result<()> {
        let mut state = self.state();
        state.sync()?;
        state.durable_names = state.names.clone();
        state.changes.clear();
        Ok(())
    }

    fn path(&self, name: &str) -> String {
        name.to_owned()
    }
}

#[derive(Debug)]
struct Open {
    twin: Twin,
    id: u64,
}

impl OpenFile for Open {
    fn write_at(&mut self, bytes: &[u8], offset: u64) -> io::Result<()> {
        let mut state = self.twin.state();
        let from = usize::try_from(offset).unwrap();
        let node_len = state.nodes[&self.id].seen.len();
        let grows = (from + bytes.len()).saturating_sub(node_len) as u64;
        let mut taken = bytes.len();
        let mut full = false;
        if let Fault::Full(left) = &mut state.fault {
            if grows > *left {
                taken = bytes.len() - usize::try_from(grows - *left).unwrap();
                full = true;
                *left = 0;
            } else {
                *left -= grows;
            }
        }
        let node = state.nodes.get_mut(&self.id).unwrap();
        let bytes = &bytes[..taken];
        if node.seen.len() < from + bytes.len() {
            node.seen.resize(from + bytes.len(), 0);
        }
        node.seen[from..from + bytes.len()].copy_from_slice(bytes);
        node.dirty.extend(from / SECTOR..(from + bytes.len()).div_ceil(SECTOR));
        if full { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
    }

    fn sync(&mut self) -> io::Result<()> {
        let mut state = self.twin.state();
        while state.hold_syncs
            || state.hold_snapshots && state.names.get(crate::snapshot::TEMPORARY) == Some(&self.id)
        {
            drop(state);
            std::thread::yield_now();
            state = self.twin.state();
        }
        state.sync()?;
        if let Some(node) = state.nodes.get_mut(&self.id) {
            node.sync();
        }
        Ok(())
    }
}
