//! Decisions, with everything that it takes to explain them.

use crate::nouns::execution::ChainLink;
use crate::nouns::observation::Substitution;
use crate::nouns::pursuit::Goal;
use crate::nouns::schema::SchemaId;
pub use crate::nouns::terms::{Role, TERMS_KEPT_MAX, Term, Terms};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// How many candidates a decision keeps with their terms: the most excited ones.
pub const CANDIDATES_KEPT_MAX: usize = 32;

/// The decision of one step: its candidates with the terms of equation (1), and the chosen one.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The number of the step that decided; steps are counted from 1.
    pub step: u64,
    /// The body that was sent to act.
    pub body: BodyId,
    /// The world state Υ in which it was decided, under the constraints of the stage.
    pub world: WorldState,
    /// The candidates, the most excited first; at most [`CANDIDATES_KEPT_MAX`], the chosen one always among them.
    pub candidates: Vec<Candidate>,
    /// The number of all candidates, kept or not.
    pub candidates_total: usize,
    /// The chosen candidate, as an index into `candidates`.
    pub chosen: usize,
    /// The number of candidates with the highest excitation, among which it was drawn; 1 when a chain or a plan was followed.
    pub ties: usize,
    /// The rule that made the choice.
    pub reason: Reason,
    /// The primitive that was sent to the body.
    pub action: PrimitiveId,
    /// Whether the search for chains used up its budget (`Parameters::chain_expansions_max`).
    pub search_truncated: bool,
    /// The goal and the plan that the decision follows, when its reason is [`Reason::Goal`].
    pub goal: Option<DecisionGoal>,
}

/// The goal and the plan that a decision follows.
#[derive(Clone, Debug, PartialEq)]
pub struct DecisionGoal {
    /// What is wanted.
    pub goal: Goal,
    /// The schemas of the plan, in order; none of a policy.
    pub chain: Vec<ChainLink>,
    /// The place of the chosen schema in the plan, as an index.
    pub at: usize,
    /// The actions to the goal when all comes about that is most likely, the chosen one first; none but of a policy.
    pub course: Vec<PrimitiveId>,
    /// The probability of the plan when it was made, in 0..=1 (II-A); of a policy, from where the body is. 0 where an episode had ended, so
    /// that something is done for the next to begin, and where most of something is wanted.
    pub probability: f64,
    /// What is expected to come from where the body is, if most of something is wanted: see
    /// [`Yield::worth`](crate::policy::Yield::worth).
    pub worth: Option<f64>,
}

/// The rule that made a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// One candidate had the highest excitation (II-C).
    Excitation,
    /// Several candidates had the highest excitation, and the generator drew one of them.
    Tie,
    /// It is the next schema of a chain that was begun before.
    Chain,
    /// It is the next schema of a plan for a goal.
    Goal,
}

/// The schema or the primitive that a candidate is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// A schema.
    Schema(SchemaId),
    /// A primitive that no schema covers here.
    Primitive(PrimitiveId),
}

/// A schema or a primitive that could have been executed.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// The schema or the primitive.
    pub subject: Subject,
    /// The values of the schema's variables, when it is generalised.
    pub binding: Substitution,
    /// The concrete schemas that achieve its target together, in order, where no single one does (a superschema); else none.
    pub together: Vec<SchemaId>,
    /// d of equation (1): the number of schemas to be executed, this one included; 1 or more.
    pub distance: u32,
    /// E of equation (1), 0 or more; it has no unit.
    pub excitation: f64,
    /// The terms of equation (1): their sum is `excitation` times `distance`, but for rounding.
    pub terms: Terms,
}
