//! The lines of an export, as `docs/EXPORT.md` has them. Format 1 is frozen: a field may be added only where its
//! absence means what its absence meant before.

use serde::{Deserialize, Serialize};

use super::values::{Binding, KindWord, Named, Observation, Parameter};
use crate::format::v1;

/// The version that is written.
pub(super) const FORMAT: u32 = 1;

/// One line: an object with one field, whose name says what it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Line {
    /// The first.
    Pschema(Box<Header>),
    /// A property name.
    Property(PropertyLine),
    /// An observation type.
    Type(TypeLine),
    /// A symbol, words included.
    Symbol(SymbolLine),
    /// An action.
    Action(ActionLine),
    /// An action with its parameters filled in.
    Primitive(PrimitiveLine),
    /// A body.
    Body(BodyLine),
    /// An observation that memory refers to.
    Observation(ObservationLine),
    /// A schema.
    Schema(Box<SchemaLine>),
    /// What is left to be drawn.
    Pool(PoolLine),
    /// What happened in a stage.
    Stage(Box<StageLine>),
    /// Where the curriculum stands.
    Progress(Box<ProgressLine>),
    /// The goal that is pursued, or was the last to be.
    Goal(Box<GoalLine>),
    /// What a body was sent to do.
    Pending(Box<PendingLine>),
    /// The generator.
    Generator(GeneratorLine),
    /// The last.
    End(EndLine),
}

impl Line {
    /// How a person calls it.
    pub(super) fn name(&self) -> &'static str {
        match self {
            Self::Pschema(_) => "pschema",
            Self::Property(_) => "property",
            Self::Type(_) => "type",
            Self::Symbol(_) => "symbol",
            Self::Action(_) => "action",
            Self::Primitive(_) => "primitive",
            Self::Body(_) => "body",
            Self::Observation(_) => "observation",
            Self::Schema(_) => "schema",
            Self::Pool(_) => "pool",
            Self::Stage(_) => "stage",
            Self::Progress(_) => "progress",
            Self::Goal(_) => "goal",
            Self::Pending(_) => "pending",
            Self::Generator(_) => "generator",
            Self::End(_) => "end",
        }
    }
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Header {
    /// [`FORMAT`].
    pub(super) format: u32,
    pub(super) learner: String,
    pub(super) seed: u64,
    pub(super) step: u64,
    pub(super) observations: u64,
    pub(super) schemas: u64,
    pub(super) memory_digest: String,
    /// Parameters and curriculum.
    pub(super) setting: v1::Setting,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PropertyLine {
    pub(super) name: String,
    pub(super) kind: KindWord,
    /// Width of a bin; of reals alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) resolution: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeclaredLine {
    pub(super) name: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub(super) unit: String,
    pub(super) kind: KindWord,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) resolution: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TypeLine {
    pub(super) name: String,
    pub(super) own: bool,
    pub(super) transient: bool,
    pub(super) heard: bool,
    pub(super) properties: Vec<DeclaredLine>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SymbolLine {
    pub(super) name: String,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ActionLine {
    pub(super) name: String,
    pub(super) parameters: Vec<DeclaredLine>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PrimitiveLine {
    /// From 0 without a gap: what schemas refer to.
    pub(super) id: u32,
    pub(super) action: String,
    pub(super) parameters: Named<Parameter>,
    pub(super) attempts: u32,
    pub(super) carried_out: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BodyLine {
    pub(super) name: String,
    /// Primitives.
    pub(super) repertoire: Vec<u32>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObservationLine {
    pub(super) id: u32,
    pub(super) observation: Observation,
    pub(super) attention: u32,
    pub(super) happened: u32,
}

/// An observation with its statistics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Counted {
    pub(super) observation: Observation,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(super) absent: bool,
    pub(super) occurrences: u32,
    pub(super) trials: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Associated {
    pub(super) observation: Observation,
    pub(super) occurrences: u32,
    pub(super) trials: u32,
    pub(super) since_step: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SchemaLine {
    pub(super) id: u32,
    pub(super) created_step: u64,
    pub(super) parent: Option<u32>,
    pub(super) executions: u32,
    pub(super) successes: u32,
    pub(super) pre: Vec<Observation>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) concrete: Option<ConcreteLine>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) generalised: Option<GeneralisedLine>,
    pub(super) post: Vec<Counted>,
    pub(super) associated: Vec<Associated>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ConcreteLine {
    pub(super) primitive: u32,
    /// The primitive as it prints; for those who read it.
    #[serde(default)]
    pub(super) action: String,
    pub(super) contradicts: Option<u32>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GeneralisedLine {
    pub(super) target: Vec<Observation>,
    pub(super) examples: Vec<u32>,
    pub(super) counter_examples: Vec<u32>,
    pub(super) retired: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoolLine {
    /// Next to be drawn last.
    pub(super) left: Vec<i64>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StageLine {
    pub(super) name: String,
    pub(super) first_step: u64,
    pub(super) actions: u64,
    pub(super) concrete_new: u32,
    pub(super) generalised_new: u32,
    pub(super) counter_examples_new: u32,
    pub(super) trials: u32,
    pub(super) trials_met: u32,
    pub(super) trials_met_first: u32,
    pub(super) actions_of_trial: Vec<u32>,
    pub(super) generalised_after_trial: Vec<u32>,
    pub(super) drawn: Vec<i64>,
    pub(super) saturated: bool,
    pub(super) ended: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProgressLine {
    /// A body.
    pub(super) student: Option<String>,
    /// From 0.
    pub(super) stage: u64,
    pub(super) begun: bool,
    pub(super) finished: bool,
    pub(super) held: bool,
    pub(super) stuck: Option<String>,
    pub(super) trial_open: bool,
    pub(super) trial_actions: u32,
    pub(super) absent_actions: u32,
    pub(super) trial_fresh: bool,
    pub(super) said: Vec<u32>,
    pub(super) quiet_actions: u32,
    pub(super) habituating: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GoalLine {
    pub(super) number: u64,
    pub(super) body: String,
    pub(super) goal: Vec<Observation>,
    pub(super) actions_max: u32,
    pub(super) actions: u32,
    pub(super) plans_made: u32,
    pub(super) plans: Vec<PlanLine>,
    pub(super) ended: Option<EndingWord>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PlanLine {
    pub(super) after_actions: u32,
    pub(super) because: BecauseWord,
    pub(super) chain: Vec<LinkLine>,
    pub(super) probability: f64,
    pub(super) truncated: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum EndingWord {
    Achieved,
    NothingLeadsThere,
    ActionsUsedUp,
    Constrained,
    Cancelled,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum BecauseWord {
    First,
    NotReached,
    NextNotAllowed,
    NotCarriedOut,
    Interrupted,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LinkLine {
    pub(super) schema: u32,
    pub(super) binding: Binding,
    pub(super) carrier: Option<u32>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PendingLine {
    pub(super) body: String,
    pub(super) schema: Option<u32>,
    pub(super) binding: Binding,
    pub(super) carrier: Option<u32>,
    pub(super) primitive: u32,
    pub(super) before: Vec<Observation>,
    pub(super) chain: Vec<LinkLine>,
    pub(super) for_goal: bool,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GeneratorLine {
    /// 16 hexadecimal digits: more than many readers of JSON can take as a number.
    pub(super) state: String,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EndLine {
    /// Lines, this one included.
    pub(super) lines: u64,
    pub(super) memory_digest: String,
}
