//! Decisions, with everything needed to explain them.

use crate::nouns::execution::ChainLink;
use crate::nouns::observation::{Pattern, Substitution};
use crate::nouns::schema::SchemaId;
pub use crate::nouns::terms::{Role, TERMS_KEPT_MAX, Term, Terms};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// Candidates that a decision keeps with their terms, the most excited first.
pub const CANDIDATES_KEPT_MAX: usize = 32;

/// Why something was done: the candidates, term by term.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The step that decided.
    pub step: u64,
    /// The body that was sent to act.
    pub body: BodyId,
    /// What was perceived.
    pub world: WorldState,
    /// The candidates, the most excited first; at most [`CANDIDATES_KEPT_MAX`], the chosen one always.
    pub candidates: Vec<Candidate>,
    /// How many there were.
    pub candidates_total: usize,
    /// The chosen one, as an index into `candidates`.
    pub chosen: usize,
    /// How many had the top excitation.
    pub ties: usize,
    /// What made the choice.
    pub reason: Reason,
    /// The primitive that was sent.
    pub action: PrimitiveId,
    /// Whether the search for chains used up its budget.
    pub search_truncated: bool,
    /// The goal and the plan that it follows, when that is the reason.
    pub goal: Option<DecisionGoal>,
}

/// What a decision in pursuit of a goal follows.
#[derive(Clone, Debug, PartialEq)]
pub struct DecisionGoal {
    /// What is to be brought about.
    pub goal: Vec<Pattern>,
    /// The plan's schemas, in order.
    pub chain: Vec<ChainLink>,
    /// Which of them this is, as an index.
    pub at: usize,
    /// The probability of the plan when it was made.
    pub probability: f64,
}

/// What made a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The highest excitation.
    Excitation,
    /// Drawn among several with the highest excitation.
    Tie,
    /// The next schema of a chain begun before.
    Chain,
    /// The next schema of a plan for a goal.
    Goal,
}

/// What a candidate is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// A schema.
    Schema(SchemaId),
    /// A primitive that no schema covers here.
    Primitive(PrimitiveId),
}

/// Something that could have been done.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// What it is.
    pub subject: Subject,
    /// Values of its variables, when it is generalised.
    pub binding: Substitution,
    /// d of equation (1): schemas to be executed, this one included.
    pub distance: u32,
    /// E of equation (1).
    pub excitation: f64,
    /// The terms of E, which times `distance` is their sum.
    pub terms: Terms,
}
