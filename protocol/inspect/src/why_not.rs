//! Why a schema was not executed.

use serde::{Deserialize, Serialize};

use crate::claims::Foretold;
use crate::closed_set::closed_set;
use crate::decision::{Candidate, Reason};
use crate::notation::{NamedValues, ObservationText, SchemaForm};
use crate::schema::{SchemaInUse, SchemaKind};

/// Why a schema was not executed in a step, or that it was. The decision is weighed once more in memory as it was, and
/// told only if it comes out as it was made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WhyNot {
    /// The step.
    pub step: u64,
    /// The body that was sent to act.
    pub body: String,
    /// What was perceived, under the constraints of the stage.
    pub world: Vec<ObservationText>,
    /// The schema asked about.
    pub schema: u32,
    /// What it is.
    pub kind: SchemaKind,
    /// The schema as it prints.
    pub text: String,
    /// The same, part by part.
    pub form: SchemaForm,
    /// What stood in its way; of a generalised schema, in the way of the binding that came nearest.
    #[serde(flatten)]
    #[cfg_attr(feature = "schema", schemars(with = "VerdictFields"))]
    pub verdict: Verdict,
    /// Values of its variables under which the verdict is given; empty where none could be found, or it has none.
    pub binding: NamedValues,
    /// Bindings that were looked at; 0 for a concrete schema.
    pub bindings: u32,
    /// Its excitation term by term, where it could have been executed, at once or by a chain.
    pub candidate: Option<Candidate>,
    /// The schemas to be executed before it, in order; empty when it could have been executed at once, or not at all.
    pub chain: Vec<SchemaInUse>,
    /// How often its action was asked for; of a generalised schema, the action of what would have carried it out.
    pub attempts: u32,
    /// How often the body carried it out.
    pub carried_out: u32,
    /// Whether it was known well enough for the stage (habituation, paper II-G); none where the stage was not at that.
    pub habituated: Option<bool>,
    /// Whether the search for chains used up its budget, so that there may be one that was not found.
    pub search_truncated: bool,
    /// What was chosen instead.
    pub chosen: Candidate,
    /// The primitive sent, as it prints.
    pub action: String,
    /// What made the choice.
    pub reason: Reason,
    /// How many candidates had the top excitation.
    pub ties: u32,
}

/// What stood in a schema's way.
///
/// In JSON the name of the verdict is `verdict`, and what it says more of is in `other`, `other_kind`, `lacking`, `target`,
/// `less_by` and `claims` beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "VerdictFields", try_from = "VerdictFields")]
pub enum Verdict {
    /// Nothing: it is what was executed.
    Chosen,
    /// It was executed for the sake of another: as what carries out its target, or as the first of a chain to it.
    ExecutedFor {
        /// Which.
        schema: u32,
    },
    /// A chain or a plan was being followed, so nothing else was weighed.
    NotWeighed,
    /// It failed too often, and is never chosen again.
    Retired,
    /// The body does not have its action.
    NotInRepertoire,
    /// Its pre-conditions do not hold, and no chain that was found leads to where they do.
    PreConditions {
        /// Those that do not hold.
        lacking: Vec<UnmetCondition>,
    },
    /// Nothing that is known achieves its target from here.
    TargetNotAchievable {
        /// The target.
        target: Vec<ObservationText>,
    },
    /// A concrete schema for exactly this case is there, and is selected instead (paper, IV-A).
    StoodInFor {
        /// Which.
        by: u32,
        /// Whether that one is an example or a counter-example.
        kind: SchemaKind,
    },
    /// It is a law, and other claims are in force for its action here than those that it is made of.
    OtherClaims {
        /// What they foretell of the types that it tells of.
        claims: Vec<Foretold>,
    },
    /// Nothing that is perceived resembles anything that it remembers: its excitation is 0.
    NotExciting,
    /// Another was more exciting.
    LessExciting {
        /// By how much.
        by: f64,
    },
    /// Others were as exciting, and the lot fell on another.
    LotFellOnAnother,
}

closed_set! {
    /// The name of a [`Verdict`].
    VerdictKind {
        /// Nothing stood in its way: it is what was chosen.
        Chosen = "chosen",
        /// It was executed for the sake of `other`: as what carries out its target, or as the first of a chain to it.
        ExecutedFor = "executed-for",
        /// A chain or a plan was being followed (`reason`), so nothing else was weighed; `candidate` says how it would
        /// have stood.
        NotWeighed = "not-weighed",
        /// It failed too often, and is never chosen again.
        Retired = "retired",
        /// The body does not have its action.
        NotInRepertoire = "not-in-repertoire",
        /// Some pre-conditions do not hold (`lacking`), and no chain leads to where they do.
        PreConditions = "pre-conditions",
        /// Nothing known achieves its `target` from here.
        TargetNotAchievable = "target-not-achievable",
        /// The concrete schema `other` is for exactly this case, and is selected instead (paper, IV-A).
        StoodInFor = "stood-in-for",
        /// It is a law, and other claims are in force for its action here (`claims`).
        OtherClaims = "other-claims",
        /// Nothing perceived shares a value with what it remembers.
        NotExciting = "not-exciting",
        /// `chosen`, or another, was more exciting, by `less_by`.
        LessExciting = "less-exciting",
        /// `ties` candidates were equally exciting.
        LotFellOnAnother = "lot-fell-on-another",
    }
}

/// A [`Verdict`] as it stands in JSON.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
struct VerdictFields {
    /// What stood in its way.
    verdict: VerdictKind,
    /// Of `executed-for` and `stood-in-for`: which schema.
    other: Option<u32>,
    /// Of `stood-in-for`: what that schema is.
    other_kind: Option<SchemaKind>,
    /// Of `pre-conditions`: those that do not hold.
    lacking: Vec<UnmetCondition>,
    /// Of `target-not-achievable`: the target.
    target: Vec<ObservationText>,
    /// Of `less-exciting`: by how much.
    less_by: Option<f64>,
    /// Of `other-claims`: what those that are in force foretell of the types that the law tells of; else left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    claims: Vec<Foretold>,
}

impl From<Verdict> for VerdictFields {
    fn from(from: Verdict) -> Self {
        let mut fields = Self {
            verdict: VerdictKind::Chosen,
            other: None,
            other_kind: None,
            lacking: Vec::new(),
            target: Vec::new(),
            less_by: None,
            claims: Vec::new(),
        };
        fields.verdict = match from {
            Verdict::Chosen => VerdictKind::Chosen,
            Verdict::ExecutedFor { schema } => {
                fields.other = Some(schema);
                VerdictKind::ExecutedFor
            }
            Verdict::NotWeighed => VerdictKind::NotWeighed,
            Verdict::Retired => VerdictKind::Retired,
            Verdict::NotInRepertoire => VerdictKind::NotInRepertoire,
            Verdict::PreConditions { lacking } => {
                fields.lacking = lacking;
                VerdictKind::PreConditions
            }
            Verdict::TargetNotAchievable { target } => {
                fields.target = target;
                VerdictKind::TargetNotAchievable
            }
            Verdict::StoodInFor { by, kind } => {
                (fields.other, fields.other_kind) = (Some(by), Some(kind));
                VerdictKind::StoodInFor
            }
            Verdict::OtherClaims { claims } => {
                fields.claims = claims;
                VerdictKind::OtherClaims
            }
            Verdict::NotExciting => VerdictKind::NotExciting,
            Verdict::LessExciting { by } => {
                fields.less_by = Some(by);
                VerdictKind::LessExciting
            }
            Verdict::LotFellOnAnother => VerdictKind::LotFellOnAnother,
        };
        fields
    }
}

impl TryFrom<VerdictFields> for Verdict {
    type Error = String;

    fn try_from(from: VerdictFields) -> Result<Self, String> {
        let lacks = |field: &str| format!("a verdict {:?} has no {field:?}", from.verdict.as_str());
        Ok(match from.verdict {
            VerdictKind::Chosen => Self::Chosen,
            VerdictKind::ExecutedFor => {
                Self::ExecutedFor { schema: from.other.ok_or_else(|| lacks("other"))? }
            }
            VerdictKind::NotWeighed => Self::NotWeighed,
            VerdictKind::Retired => Self::Retired,
            VerdictKind::NotInRepertoire => Self::NotInRepertoire,
            VerdictKind::PreConditions => Self::PreConditions { lacking: from.lacking },
            VerdictKind::TargetNotAchievable => Self::TargetNotAchievable { target: from.target },
            VerdictKind::StoodInFor => Self::StoodInFor {
                by: from.other.ok_or_else(|| lacks("other"))?,
                kind: from.other_kind.ok_or_else(|| lacks("other_kind"))?,
            },
            VerdictKind::OtherClaims => Self::OtherClaims { claims: from.claims },
            VerdictKind::NotExciting => Self::NotExciting,
            // What is not finite is null.
            VerdictKind::LessExciting => Self::LessExciting { by: from.less_by.unwrap_or(f64::NAN) },
            VerdictKind::LotFellOnAnother => Self::LotFellOnAnother,
        })
    }
}

/// A pre-condition that does not hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UnmetCondition {
    /// The pre-condition.
    pub wanted: ObservationText,
    /// What was perceived that comes nearest to it: of its type, with the most values the same; none when nothing of its
    /// type was perceived.
    pub nearest: Option<ObservationText>,
    /// The names of the properties in which that differs.
    pub differs: Vec<String>,
    /// Whether the stage does not lift its type, so that it can't be perceived.
    pub constrained: bool,
}
