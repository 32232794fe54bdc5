//! Questions, as they are answered from a view of the learner.

use pschema_inspect::Ask;
use pschema_inspect::codec::Problem;

use crate::mind::View;

/// A question that can be answered.
pub trait Inspect: Ask {
    /// The answer, of the learner as `view` has it.
    ///
    /// # Errors
    /// Why there is none, and what to do.
    fn answer(&self, view: &View) -> Result<Self::Answer, Problem>;
}

/// Why a question about schema `id` has no answer.
pub(super) fn no_schema(view: &View, id: u32) -> Problem {
    Problem::of(match view.content.schemas.len() {
        0 => format!("there is no schema {id}: nothing has been learnt yet"),
        count => format!("there is no schema {id}: they are numbered 0 to {}", count - 1),
    })
}
