//! The questions that a view of the learner answers.

use pschema_inspect::Ask;
use pschema_inspect::codec::Problem;

use crate::view::View;

/// A question that a view of the learner answers.
pub trait Inspect: Ask {
    /// The answer about the learner in `view`.
    ///
    /// # Errors
    /// [`Problem`]: why there is no answer, and what to do.
    fn answer(&self, view: &View) -> Result<Self::Answer, Problem>;
}

/// The problem that there is no schema `id`.
pub(super) fn no_schema(view: &View, id: u32) -> Problem {
    Problem::of(match view.content.schemas.len() {
        0 => format!("there is no schema {id}: nothing has been learnt yet"),
        count => format!("there is no schema {id}: they are numbered 0 to {}", count - 1),
    })
}
