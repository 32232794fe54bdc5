//! Claims, and what they are made of. A claim that stands here is one of a list in which each stands before its exceptions, so that no
//! value is nested deeper than its types are.

use pschema_learner::claim as live;
use pschema_learner::evidence;
use serde::{Deserialize, Serialize};

use super::observation::{Observation, Value};
use crate::format::mirror::{Mirror, mirror};

/// Places in one item.
pub(crate) const PLACES_MAX: usize = 1_024;

mirror! {
    /// A value that is named by its part in what is done, or by its tie to a value that has such a part.
    #[derive(Copy)]
    enum Reference = live::Reference {
        /// The value of the action's parameter of this place.
        Parameter(at: u8),
        /// The value that the primitive brings about of itself, in an observation of this type, of this property.
        Effect(kind: u16, property: u16),
        /// The value in the only observation of this type, of this property.
        Only(kind: u16, property: u16),
        /// The value in the observation that the claim is about, of this property.
        Itself(property: u16),
        /// The value in the only observation of this type that is recalled, of this property.
        Recalled(kind: u16, property: u16),
        /// How many experiences ago it was that is recalled.
        Age,
        /// The value of the property `to` in the only observation of type `kind` that has the value of `from` in its property `at`.
        Tied { from: Anchor, kind: u16, at: u16, to: u16 },
    }

    /// A reference that others may be tied to.
    #[derive(Copy)]
    enum Anchor = live::Anchor {
        /// As of a reference.
        Parameter(at: u8),
        /// As of a reference.
        Effect(kind: u16, property: u16),
        /// As of a reference.
        Only(kind: u16, property: u16),
        /// As of a reference.
        Itself(property: u16),
        /// As of a reference.
        Age,
    }

    /// The value of a property in a claim.
    #[derive(Copy)]
    enum Expression = live::Expression {
        /// What the reference names, and this much more.
        Named(reference: Reference, more: i64),
        /// This value.
        Constant(value: Value),
    }

    /// An observation in a claim.
    struct Sketch = live::Sketch {
        /// The number of its observation type.
        kind: u16,
        /// Numbers of properties, with what they are, in order. Those left out may have any value.
        properties: Vec<(u16, Expression)>,
    }

    /// A condition of a claim.
    enum Condition = live::Condition {
        /// Such an observation is made.
        Observed(sketch: Sketch),
        /// The reference names this value.
        Is(anchor: Anchor, value: Value),
        /// Such an observation is recalled.
        Recalled(sketch: Sketch),
        /// The reference names a number that is at least this one; of a real, a bin.
        AtLeast(anchor: Anchor, least: i64),
    }

    /// How observations change.
    struct Change = live::Change {
        /// The only observation of its type becomes this one, or this one appears where there is none of its type.
        becomes: Vec<Sketch>,
        /// These are observed no longer.
        vanishes: Vec<Sketch>,
        /// These are observed besides.
        appears: Vec<Sketch>,
    }

    /// A claim.
    struct Claim = evidence::FoundClaim {
        /// To how many claims it is an exception, one within the other: to the last one before it that has one less, and so on.
        depth: u64,
        /// The condition; `null` at the top.
        condition: Option<Condition>,
        /// How much better its outcomes and others were told apart than together when it was grown: ln of the odds.
        gain: f64,
        /// The numbers of the changes that followed where it was in force, each with how often.
        outcomes: Vec<(u64, u32)>,
        /// How often it was in force.
        trials: u32,
    }

    /// The place of an experience among claims.
    #[derive(Copy)]
    struct ExamplePlace = evidence::FoundPlace {
        /// The number of the claim that was in force, in the tree of the claims about the action.
        claim: u64,
        /// The number of the change that came; `null` where it was none that can be said.
        change: Option<u64>,
    }

    /// What is known of the own effect of a primitive.
    struct OwnEffect = evidence::OwnEffect {
        /// The number of the primitive.
        primitive: u32,
        /// What it brings about of itself, in canonical order, with after how many tries this was changed last; `null` while nothing was.
        brought: Option<(Vec<Observation>, u64)>,
        /// Whether it is not known yet if what came with it once comes anyway.
        doubtful: bool,
    }
}

/// That what was found of the experiences of a pool follows, and need not be found again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct FoundPool {
    /// The number of the action whose pool it is; `null` for the background.
    pub(crate) pool: Option<u64>,
    /// The number of the type in which it shows how the action leaves a body; `null` where nothing is recalled.
    pub(crate) key: Option<u16>,
    /// How many facets follow, those not counted that tell observations of another facet one by one.
    pub(crate) facets: u64,
    /// The digest of all that was found, in hexadecimal.
    pub(crate) digest: String,
}

/// The own effect of a primitive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PoolEffect {
    /// The number of the action whose pool it is.
    pub(crate) pool: u64,
    /// The effect.
    pub(crate) effect: OwnEffect,
}

/// Types that change together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PoolFacet {
    /// The number of the action whose pool it is; `null` for the background.
    pub(crate) pool: Option<u64>,
    /// The numbers of the types, in order.
    pub(crate) kinds: Vec<u16>,
    /// How much surprised that was new, and how much was; the same of what was familiar.
    pub(crate) surprise: [f64; 4],
    /// What the facet tells one by one; `null` where all of its types are told together.
    pub(crate) singly: Option<Singly>,
}

/// That a facet tells the observations of another one by one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct Singly {
    /// The number of the other, which stands before it.
    pub(crate) facet: u64,
    /// The number of the first experience of the pool that is looked at.
    pub(crate) from: u64,
    /// The observations, in canonical order.
    pub(crate) known: Vec<Observation>,
    /// As long as it is not known whether that tells more: ln of the probabilities that the claims about the action gave to what came
    /// since, and those about the primitive, all observations together, then each by itself. `null` once it is known.
    pub(crate) trial: Option<[f64; 4]>,
}

/// What a body recalls, as it stands in the items after it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyMemory {
    /// The number of the body.
    pub(crate) body: u16,
    /// How many experiences it had.
    pub(crate) experiences: u64,
}

/// What was there at last when an observation showed how a body was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyRecollection {
    /// The number of the body.
    pub(crate) body: u16,
    /// The observation.
    pub(crate) shown: Observation,
    /// After how many experiences of the body that was.
    pub(crate) noted: u64,
    /// What was there, in canonical order.
    pub(crate) there: Vec<Observation>,
}

/// What was to be learnt where episodes of a body began.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct BodyBeginnings {
    /// The number of the body.
    pub(crate) body: u16,
    /// Whether an episode begins, and nothing was carried out in it yet.
    pub(crate) is_next: bool,
    /// How much was to be learnt, all added up, and of how many; an earlier one counts less.
    pub(crate) learnable: [f64; 2],
}

/// A change that the claims of a facet speak of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct FacetChange {
    /// The number of the facet.
    pub(crate) facet: u64,
    /// The change.
    pub(crate) change: Change,
}

/// A tree of claims.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct ClaimTree {
    /// The number of the facet.
    pub(crate) facet: u64,
    /// The number of the primitive that they are about; `null` if they are about the action.
    pub(crate) primitive: Option<u32>,
    /// How well each view foretold the primitive: ln of the probabilities of the claims about the action, of those about the primitive,
    /// and of the memory of the context.
    pub(crate) scores: Option<[f64; 3]>,
    /// From how many experiences they were grown.
    pub(crate) examples: u64,
    /// How many of these had an outcome that was not the most frequent one of its claim.
    pub(crate) exceptional: u64,
    /// How many since then.
    pub(crate) unforetold: u64,
    /// How many claims follow.
    pub(crate) claims: u64,
}

/// A claim in a tree.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct TreeClaim {
    /// The number of the tree.
    pub(crate) tree: u64,
    /// The claim.
    pub(crate) claim: Claim,
}

/// The places of experiences among the claims about the action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct ExamplePlaces {
    /// The number of the facet.
    pub(crate) facet: u64,
    /// The places, at most 1,024; `null` of an experience that does not tell of these types.
    pub(crate) places: Vec<Option<ExamplePlace>>,
}

impl ClaimTree {
    /// The head of a tree of a facet.
    pub(crate) fn of(facet: u64, live: &evidence::FoundClaims) -> Self {
        let evidence::FoundClaims { primitive, scores, examples, exceptional, unforetold, claims } = live;
        Self {
            facet,
            primitive: Mirror::of(primitive),
            scores: *scores,
            examples: Mirror::of(examples),
            exceptional: Mirror::of(exceptional),
            unforetold: Mirror::of(unforetold),
            claims: claims.len() as u64,
        }
    }

    /// The tree, without its claims.
    pub(crate) fn live(self) -> evidence::FoundClaims {
        evidence::FoundClaims {
            primitive: self.primitive.live(),
            scores: self.scores,
            examples: self.examples.live(),
            exceptional: self.exceptional.live(),
            unforetold: self.unforetold.live(),
            claims: Vec::new(),
        }
    }
}
