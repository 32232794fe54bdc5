//! Where a learner's daemon, bodies and tools meet: a private directory, and an iceoryx2 domain of its
//! own that lives exactly as long as one run of the daemon (an *epoch*).
//!
//! ```text
//! <runtime>/                 0700, owned by the user
//!   <learner>/lock           held by the daemon for its life
//!   <learner>/domain         text: which epoch is being served, written atomically
//!   .ps0123456789/           the epoch's iceoryx2 files; the name is its prefix in /dev/shm
//! ```
//!
//! Every start of a daemon takes a new random prefix and removes all that the epoch before it left. A
//! process that dies at any instruction can therefore leave nothing that a restart does not sweep, and no
//! state in shared memory outlives the daemon it belonged to.

mod doctor;
mod error;
mod membership;
mod owned;
mod place;
mod record;
mod runtime;
mod shared_memory;
mod sweep;

pub use doctor::{Exposure, MachineState, StaleEpoch, examine};
pub use error::DomainError;
pub(crate) use error::io;
#[doc(hidden)]
pub use membership::Membership;
pub use owned::OwnedDomain;
pub use place::Place;
pub use record::DomainRecord;
pub(crate) use runtime::private_file;
pub use runtime::{LearnerName, RuntimeDir};
pub use shared_memory::SHARED_MEMORY_NEEDED;
pub(crate) use shared_memory::{PEER_SHARED_MEMORY_NEEDED, require_shared_memory, shared_memory_files};
