//! Version 1. Frozen: the names and the order of fields and of variants are the format (see `docs/FORMAT.md` and
//! `docs/EXPORT.md`). The journal and snapshots have these types in bincode, the manifest in TOML, an export in JSON.

mod assembly;
mod claim;
mod effect;
mod execution;
mod experience;
mod finding;
mod goal;
mod item;
mod observation;
mod record;
mod schema;
mod setting;
mod stage;
mod vocabulary;

pub(crate) use assembly::{Assembly, WholeMemory};
pub(crate) use effect::Effect;
pub(crate) use experience::Mechanism;
pub(crate) use item::{End, Item, Kind, items};
pub(crate) use record::{Cause, Input, Record};
pub(crate) use setting::{Curriculum, Parameters, Setting};
