//! Records of the journal: what changed memory, and the digests that tell whether replaying leads to the same memory.

use pschema_learner::frame;
use serde::{Deserialize, Serialize};

use super::effect::Effect;
use super::observation::Observation;
use super::setting::Setting;
use crate::format::mirror::mirror;

/// The payload of one frame of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Record {
    /// What one step, one order or one attachment changed.
    Batch {
        /// Steps taken, this one included.
        step: u64,
        /// The time by the machine's clock, in milliseconds since 1970: for people; nothing is decided by it.
        at_unix_ms: u64,
        /// What led to the change.
        cause: Cause,
        /// The effects in the order in which they are applied.
        effects: Vec<Effect>,
    },
    /// The digest of memory at this place follows in a later frame, for it takes time; or never, when the daemon ended
    /// before.
    Mark {
        /// Steps taken.
        step: u64,
    },
    /// The digest of memory at an earlier place.
    Digest {
        /// The frame of the [`Record::Mark`].
        mark: u64,
        /// Steps taken there.
        step: u64,
        /// The digest, in hexadecimal.
        digest: String,
    },
}

/// What led to a batch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Cause {
    /// A body of this name attached.
    Declared(String),
    /// An operator's order, as it was given.
    Order(String),
    /// A body's frame.
    Step(Input),
    /// Memory goes on under this setting from here: the effects say what that changed of it.
    Changed(Box<Setting>),
}

mirror! {
    /// The frame that a step was taken on.
    struct Input = frame::Frame {
        body: u16,
        outcome: Option<Outcome>,
        observations: Vec<Observation>,
    }

    /// How the action went that the body was sent to do.
    enum Outcome = frame::ActionOutcome {
        Done,
        Refused,
        Failed,
        TimedOut,
        EpisodeEnded,
        EpisodeCut,
    }
}
