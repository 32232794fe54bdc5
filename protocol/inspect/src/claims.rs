//! Claims: under these conditions an action changes the world in one of these ways, so often. What is counted are experiences: each action that
//! was carried out is one, and of what is to be expected whatever is done the end of an episode as well, of which the type `episode_ended`
//! tells. Of claims about each observation by itself every observation counts.

use serde::{Deserialize, Serialize};

use crate::closed_set::closed_set;
use crate::notation::{ObservationText, Reference, ValueText};

/// How observations change. What it does not mention stays as it is; where it mentions nothing, nothing changes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Change {
    /// The only observation of its type becomes this one, or this one appears where there is none of its type.
    pub becomes: Vec<ObservationText>,
    /// These are observed no longer.
    pub vanishes: Vec<ObservationText>,
    /// These are observed besides.
    pub appears: Vec<ObservationText>,
}

/// A condition of a claim.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ClaimCondition {
    /// Such an observation is made. Properties that are left out may have any value.
    Observed(ObservationText),
    /// Such an observation is recalled: it was there when the body was last as the action makes it.
    Recalled(ObservationText),
    /// What is named is this value.
    Is(Comparison),
    /// The number that is named is at least this one.
    AtLeast(Comparison),
}

/// A value that is named, beside one that is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// What names the one.
    pub named: Reference,
    /// The other.
    pub value: ValueText,
}

/// A condition with the evidence that made it: what followed where it holds, beside what followed where it does not, though the
/// conditions of the claim do that it is an exception to, and those of no earlier exception.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClaimEvidence {
    /// The condition.
    pub condition: ClaimCondition,
    /// By how many bits the outcomes were told shorter apart than together when the condition was made, beyond its price.
    pub gain_bits: f64,
    /// In how many experiences it held.
    pub trials_with: u32,
    /// In how many it did not.
    pub trials_without: u32,
    /// The changes that followed, the most frequent first.
    pub outcomes: Vec<OutcomeEvidence>,
}

/// How often a change followed where a condition holds, and where it does not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OutcomeEvidence {
    /// The change.
    pub change: Change,
    /// How often it followed where the condition held.
    pub with: u32,
    /// How often it followed where the condition did not hold.
    pub without: u32,
}

/// A change that followed, and how often.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClaimOutcome {
    /// The change.
    pub change: Change,
    /// How often.
    pub occurrences: u32,
}

/// A claim with the exceptions to it. In force is the claim at the top, or the first of its exceptions whose condition holds,
/// and so on within that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Claim {
    /// The condition that it has besides those of the claim that it is an exception to; none at the top.
    pub because: Option<ClaimEvidence>,
    /// What followed where it was in force and no exception was, the most frequent first.
    pub outcomes: Vec<ClaimOutcome>,
    /// In how many experiences it was in force and no exception was; more than the outcomes add up to where some
    /// changes have no form.
    pub trials: u32,
    /// The exceptions, in their order.
    pub exceptions: Vec<Claim>,
}

/// The claims about types that change together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClaimTree {
    /// The name of the action; the primitive as it prints, if they are about that one alone; none if they are about whatever
    /// is done.
    pub action: Option<String>,
    /// The types.
    pub types: Vec<String>,
    /// Whether the claims are about each observation of the type by itself, whatever becomes of the others.
    pub each: bool,
    /// The most general claim.
    pub claim: Claim,
}

/// Claims, one tree for each action and types that change together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClaimList {
    /// How many trees fit, listed or not; the offset does not change it.
    pub matching: u32,
    /// Those listed.
    pub claims: Vec<ClaimTree>,
    /// The synthetic items that are kept, about the actions that were asked for.
    pub items: Vec<SyntheticItem>,
}

/// What is supposed to be so or not though no sense shows it: a condition that claims may ask for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SyntheticItem {
    /// The name of the type by which it is perceived.
    pub name: String,
    /// The primitive whose outcomes it was found to tell apart, as it prints.
    pub action: String,
    /// The types of these outcomes.
    pub types: Vec<String>,
    /// The names of the bodies that suppose it now.
    pub supposed_by: Vec<String>,
    /// What becomes of it at each of these events; at others it stays as it is.
    pub events: Vec<ItemEvent>,
}

/// Something at which a synthetic item changes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ItemEvent {
    /// The primitive that is carried out, as it prints.
    pub action: String,
    /// What is observed afterwards of the types that the item is about.
    pub after: Vec<ObservationText>,
    /// What becomes of the item.
    pub update: ItemUpdate,
}

closed_set! {
    /// What becomes of a synthetic item.
    ItemUpdate {
        /// It is supposed from then on.
        On = "on",
        /// It is not supposed from then on.
        Off = "off",
        /// It is supposed if it was not, and the other way round.
        Turn = "turn",
    }
}

closed_set! {
    /// The experiences that something is foretold from.
    ClaimView {
        /// All with the action, whatever its parameters.
        General = "general",
        /// Those with the very primitive.
        Primitive = "primitive",
        /// Those with the primitive in the very same context.
        Context = "context",
    }
}

/// What claims foretell of types that change together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Foretold {
    /// The types.
    pub types: Vec<String>,
    /// Whether this is put together of what is foretold of each observation by itself.
    pub each: bool,
    /// What this is foretold from.
    pub view: ClaimView,
    /// The conditions of the claim in force; none where there is no condition, or it is foretold from the very same context.
    pub because: Vec<ClaimEvidence>,
    /// Whether the most frequent outcome is put down to the action. If not, it is to be expected whatever is done.
    pub attributed: bool,
    /// The outcomes, the most frequent first. That nothing changes is one, too.
    pub outcomes: Vec<JointOutcome>,
    /// In how many experiences the claim was in force; more than the outcomes add up to where some can't be said here.
    pub trials: u32,
}

/// One outcome of an action: all that is observed of some types afterwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct JointOutcome {
    /// What is observed of the types.
    pub observed: Vec<ObservationText>,
    /// What of it is not observed before.
    pub appears: Vec<ObservationText>,
    /// What is observed before, and no longer.
    pub vanishes: Vec<ObservationText>,
    /// How often it came to that.
    pub occurrences: u32,
    /// The share of the trials.
    pub probability: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
}
