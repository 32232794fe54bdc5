//! `pschema watch`: a learner on a terminal while it lives. One thread asks its daemon, one reads keys, one draws:
//! a daemon that is slow to answer delays no key, and a terminal that is slow delays no daemon.
//!
//! Everything known is in [`state::State`], and the screen follows from that state alone ([`draw::draw`]); so one frame as
//! text ([`mod@once`]) and the tests draw as the terminal does.

mod asker;
mod draw;
mod event;
mod eyes;
mod keys;
mod once;
mod state;
mod terminal;
#[cfg(test)]
mod tests;
mod theme;

use clap::ValueEnum;
use pschema_inspect::LiveQuery;

pub(crate) use once::once;
pub(crate) use terminal::watch;

/// Records of the trace that are kept: more than the widest screen has columns, several steps to each.
const STEPS_KEPT_MAX: usize = 4096;
/// Most used schemas that are asked for.
const MOST_USED_MAX: u32 = 50;

/// The question that is asked again and again.
fn query(trace_from: u64) -> LiveQuery {
    LiveQuery { trace_from, candidates_max: 12, terms_max: 6, newest_max: 50 }
}

/// The panes that are shown together on a terminal too small for all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum WatchPage {
    /// What is seen, perceived and exciting; on a large terminal, everything
    #[default]
    Now,
    /// Excitation over time, and the last steps
    Excitation,
    /// What could have been done, term by term
    Choice,
    /// The newest and the most used schemas
    Schemas,
    /// The learner, its stage and its bodies
    Learner,
    /// One schema
    Follow,
}

impl WatchPage {
    const ALL: [Self; 6] =
        [Self::Now, Self::Excitation, Self::Choice, Self::Schemas, Self::Learner, Self::Follow];

    fn name(self) -> &'static str {
        match self {
            Self::Now => "now",
            Self::Excitation => "excitation",
            Self::Choice => "choice",
            Self::Schemas => "schemas",
            Self::Learner => "learner",
            Self::Follow => "follow",
        }
    }

    fn next(self) -> Self {
        Self::at(self as usize + 1)
    }

    fn before(self) -> Self {
        Self::at(self as usize + Self::ALL.len() - 1)
    }

    fn at(index: usize) -> Self {
        Self::ALL.get(index % Self::ALL.len()).copied().unwrap_or_default()
    }
}

/// A part of the screen, with a border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pane {
    Camera,
    World,
    Excitation,
    Steps,
    Choice,
    Newest,
    MostUsed,
    Learner,
    Follow,
}

impl Pane {
    const COUNT: usize = 9;
}

/// A wish of the person who watches: an order to the learner, or something to be told.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Wish {
    /// Wait.
    Hold,
    /// Go on.
    Resume,
    /// Take one action, and wait.
    Step,
    /// The learner is to hear words.
    Say(Vec<String>),
    /// Ask for this schema from now on, or for none.
    Follow(Option<u32>),
    /// Whether the most used schemas are on the screen. The daemon looks at all of memory for them, so they are not asked
    /// for in vain.
    MostUsed(bool),
}
