//! Why an action was chosen.

use serde::{Deserialize, Serialize};

use crate::claims::Foretold;
use crate::closed_set::closed_set;
use crate::goals::DecisionGoal;
use crate::notation::{NamedValues, ObservationText, SchemaForm};
use crate::schema::SchemaInUse;

closed_set! {
    /// What made a choice.
    Reason {
        /// The highest excitation.
        Excitation = "excitation",
        /// The lot, drawn among several candidates with the highest excitation.
        Tie = "tie",
        /// A chain begun before, of which the chosen schema is the next.
        Chain = "chain",
        /// A plan for a goal, of which the chosen schema is the next.
        Goal = "goal",
    }
}

closed_set! {
    /// What the observation of a term is to the schema, or which drive the term is.
    TermRole {
        /// A pre-condition.
        PreCondition = "pre-condition",
        /// A post-condition.
        PostCondition = "post-condition",
        /// An associated observation.
        Association = "association",
        /// The drive to try what no schema covers.
        Babbling = "babbling",
        /// The drive to do what may surprise here, of a learner that keeps claims.
        Curiosity = "curiosity",
        /// The drive to repeat what is not yet known well enough (paper, II-G).
        Habituation = "habituation",
        /// The terms that are too many to be told one by one, added up.
        Rest = "rest",
    }
}

/// Why an action was chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Explanation {
    /// The step.
    pub step: u64,
    /// The body that was sent to act.
    pub body: String,
    /// What was perceived.
    pub world: Vec<ObservationText>,
    /// The chosen candidate, as an index into `candidates` (it is always listed).
    pub chosen: u32,
    /// The primitive sent, as it prints.
    pub action: String,
    /// What made the choice.
    pub reason: Reason,
    /// How many candidates had the top excitation.
    pub ties: u32,
    /// Candidates with any excitation, listed or not.
    pub candidates_total: u32,
    /// The candidates, the most excited first.
    pub candidates: Vec<Candidate>,
    /// The goal that the decision follows, when that is the reason.
    pub goal: Option<DecisionGoal>,
    /// What claims foretold of the action, if memory is at hand as it was then: of the latest decision, and of any step of a memory
    /// on disk. Else, and where there are none, it is left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub claims: Vec<Foretold>,
}

/// Something that could have been done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Candidate {
    /// The schema; none for a primitive that no schema covers here.
    pub schema: Option<u32>,
    /// The schema, or primitive, as it prints.
    pub text: String,
    /// The same, part by part.
    pub form: SchemaForm,
    /// Values of its variables.
    pub binding: NamedValues,
    /// The schemas that achieve its target together, in order (a superschema); left out where a single one does.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub together: Vec<SchemaInUse>,
    /// d of equation (1): schemas to be executed, this one included.
    pub distance: u32,
    /// E of equation (1): the sum of the terms' `value` over `distance`, but for the last bits of a 64-bit float (terms are
    /// told pair by pair, and added up observation by observation).
    #[serde(deserialize_with = "crate::number::or_nan")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub excitation: f64,
    /// The terms of the sum.
    pub terms: Vec<ExcitationTerm>,
}

/// One term of equation (1), or a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ExcitationTerm {
    /// Remembered observation; none for a drive and for the rest.
    pub observation: Option<ObservationText>,
    /// Perceived observation that resembles it; none for a drive and for the rest.
    pub seen: Option<ObservationText>,
    /// What the observation is to the schema, or which drive this is. `rest`: of a decision with more than 8192 terms,
    /// those of the less exciting candidates are added up to one each.
    pub role: TermRole,
    /// Properties that the two share.
    pub shared: u32,
    /// N of the remembered observation.
    pub attention: u32,
    /// Probability of the remembered observation in the schema.
    pub probability: f64,
    /// 1 or ω, times the reliability of the action.
    #[serde(deserialize_with = "crate::number::or_nan")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub weight: f64,
    /// shared × probability × weight / (1 + attention).
    #[serde(deserialize_with = "crate::number::or_nan")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub value: f64,
}
