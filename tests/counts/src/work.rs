//! The works that are counted.

mod frame;
mod journal;
mod picture;
pub(crate) mod step;

use std::path::Path;

use pschema_worlds::Mix;

use crate::counted::Tally;
use crate::failure::CountFailure;

/// Work that is done often, and counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Work {
    /// A step of a learner that knows about so many schemas.
    Step { mix: Mix, schemas: usize },
    /// A step of a learner with all mechanisms, after a life of some hundred.
    Full,
    /// The frame of a body, checked and read.
    Frame,
    /// The effects of a step, encoded, and appended to the journal.
    Journal,
    /// A picture of the simulated camera, rendered and looked at.
    Picture,
}

impl Work {
    /// All works, in the order in which they are told.
    pub(crate) fn all() -> Vec<Self> {
        let steps =
            Mix::ALL.into_iter().flat_map(|mix| step::SIZES.map(|schemas| Self::Step { mix, schemas }));
        steps.chain([Self::Full, Self::Frame, Self::Journal, Self::Picture]).collect()
    }

    /// The work of that name.
    pub(crate) fn named(name: &str) -> Result<Self, CountFailure> {
        let found = Self::all().into_iter().find(|work| work.name() == name);
        found.ok_or_else(|| CountFailure::NoSuchWork(name.to_owned()))
    }

    /// Its name in the file of budgets.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Step { mix, schemas } => format!("step/{}/{schemas}", mix.name()),
            Self::Full => "step/full".to_owned(),
            Self::Frame => "frame".to_owned(),
            Self::Journal => "journal".to_owned(),
            Self::Picture => "picture".to_owned(),
        }
    }

    /// The life that must have been lived before.
    pub(crate) fn life(self) -> Option<Mix> {
        match self {
            Self::Step { mix, .. } => Some(mix),
            Self::Journal => Some(journal::MIX),
            Self::Full | Self::Frame | Self::Picture => None,
        }
    }

    /// How many schemas there are while the work is done.
    pub(crate) fn schemas(self) -> usize {
        match self {
            Self::Step { schemas, .. } => schemas,
            Self::Journal => journal::SCHEMAS,
            Self::Full | Self::Frame | Self::Picture => 0,
        }
    }

    /// A function that does a part of the work on another thread, if there is one.
    pub(crate) fn elsewhere(self) -> Option<&'static str> {
        (self == Self::Journal).then_some(journal::ON_THE_WRITERS_THREAD)
    }

    /// Does the work, with what lives have left in `lives`.
    pub(crate) fn carry_out(self, lives: &Path) -> Result<Tally, CountFailure> {
        match self {
            Self::Step { mix, schemas } => step::carry_out(mix, schemas, lives),
            Self::Full => step::carry_out_fully(),
            Self::Frame => frame::carry_out(),
            Self::Journal => journal::carry_out(lives),
            Self::Picture => picture::carry_out(),
        }
    }
}
