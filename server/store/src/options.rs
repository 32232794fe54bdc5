//! What a memory is begun with or found again with, and how it is kept.

use pschema_learner::curriculum::Curriculum;
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::parameters::Parameters;

use crate::change::Durability;
use crate::journal::Sizes;

/// What a memory is begun with, or found again with.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// The learner's name.
    pub learner: &'a str,
    /// The seed, from which all its random numbers follow.
    pub seed: u64,
    /// The learner's numbers and switches.
    pub parameters: &'a Parameters,
    /// The mechanisms beyond the paper that are on.
    pub mechanisms: Mechanisms,
    /// The curriculum that it is led through.
    pub curriculum: &'a Curriculum,
    /// Whether somebody asked for this seed: a memory that was begun with another seed is then refused.
    pub seed_given: bool,
    /// Whether somebody asked for these parameters, mechanisms and this curriculum: a memory that lives under others is then
    /// refused, unless `change` is set.
    pub setting_given: bool,
    /// Whether a memory that lives under other parameters, mechanisms or another curriculum goes on under these.
    pub change: bool,
    /// The time now, in milliseconds since 1970. It is for people who want to know when a memory was changed.
    pub at_unix_ms: u64,
    /// When a reply may leave.
    pub durability: Durability,
    /// How much of the past is kept.
    pub retention: Retention,
}

impl<'a> Options<'a> {
    /// A memory of this learner that is begun with this seed and this setting, or found again with the same, and is durable at
    /// every step. The learner is that of the paper.
    #[must_use]
    pub fn new(learner: &'a str, seed: u64, parameters: &'a Parameters, curriculum: &'a Curriculum) -> Self {
        Self {
            learner,
            seed,
            parameters,
            mechanisms: Mechanisms::PAPER,
            curriculum,
            seed_given: true,
            setting_given: true,
            change: false,
            at_unix_ms: 0,
            durability: Durability::Strict,
            retention: Retention::default(),
        }
    }
}

/// How much of a memory's past is kept on disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Retention {
    /// A snapshot is made whenever the journal has grown by so many bytes, or by the size of the last snapshot if that is
    /// more.
    pub snapshot_bytes: u64,
    /// So many bytes of journal are kept to return to earlier steps; without a number, all of the journal is kept. The journal
    /// that the two newest snapshots need is always kept.
    pub history_bytes: Option<u64>,
}

impl Default for Retention {
    fn default() -> Self {
        Self { snapshot_bytes: 64 << 20, history_bytes: Some(8 << 30) }
    }
}

impl Retention {
    /// Sizes of segments that are so short that history can be dropped in small parts.
    pub(crate) fn sizes(self) -> Sizes {
        let default = Sizes::default();
        let history = self.history_bytes.unwrap_or(u64::MAX);
        Sizes { segment_max: (history / 8).clamp(1 << 20, default.segment_max), ..default }
    }
}
