//! What was found of experiences, as it is written down.

use crate::nouns::claim::{Change, Condition};
use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;

/// What was found of the experiences of a pool. All else that a pool knows is seen from its experiences at once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// The type in which it shows how the action leaves a body; none where nothing is recalled.
    pub key: Option<TypeId>,
    /// What is known of the own effects of primitives, in the order of the primitives.
    pub effects: Vec<OwnEffect>,
    /// The facets, in their order.
    pub facets: Vec<FoundFacet>,
}

/// What is known of the own effect of a primitive.
#[derive(Clone, Debug, PartialEq)]
pub struct OwnEffect {
    /// The primitive.
    pub primitive: PrimitiveId,
    /// What it brings about of itself, in canonical order, and after how many tries this was changed last; none while nothing was.
    pub brought: Option<(Vec<Observation>, usize)>,
    /// Whether it is not known yet if what came with it once comes anyway.
    pub doubtful: bool,
}

/// What was found of types that change together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundFacet {
    /// The types, in order.
    pub kinds: Vec<TypeId>,
    /// The changes that were seen, in the order in which they are counted.
    pub changes: Vec<Change>,
    /// How much surprised that was new, and how much was; the same of what was familiar.
    pub surprise: [f64; 4],
    /// The claims about the action, then those about each primitive, in the order of the primitives.
    pub grown: Vec<FoundClaims>,
    /// The place of each experience among the claims about the action; none where it does not tell of these types. Where each observation is
    /// told by itself there is one place for each of them.
    pub places: Vec<Option<FoundPlace>>,
    /// The claims about each observation by itself, where that tells more.
    pub each: Option<FoundEach>,
    /// The same, as long as it is not known whether it tells more.
    pub trial: Option<FoundTrial>,
}

/// What was found of each observation of a type by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundEach {
    /// The number of the first experience of the pool that is looked at.
    pub from: usize,
    /// The observations that were met, in canonical order.
    pub known: Vec<Observation>,
    /// The claims.
    pub facet: Box<FoundFacet>,
}

/// What was found of each observation, and how well that told what came since.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundTrial {
    /// What was found.
    pub each: FoundEach,
    /// ln of the probabilities that the claims about the action gave to what came, and those about the primitive: all observations
    /// together, then each by itself.
    pub scores: [f64; 4],
}

/// A tree of claims.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundClaims {
    /// The primitive that they are about; none if they are about the action.
    pub primitive: Option<PrimitiveId>,
    /// How well each view foretold the primitive: ln of the probabilities.
    pub scores: Option<[f64; 3]>,
    /// From how many examples they were grown.
    pub examples: usize,
    /// How many of these had an outcome that was not the most frequent one of its claim.
    pub exceptional: usize,
    /// How many since then.
    pub unforetold: usize,
    /// The claims, each before its exceptions; none where nothing was counted.
    pub claims: Vec<FoundClaim>,
}

/// A claim in a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundClaim {
    /// To how many claims it is an exception, one within the other.
    pub depth: usize,
    /// The condition; none at the top.
    pub condition: Option<Condition>,
    /// See [`crate::nouns::claim::Claim::gain`].
    pub gain: f64,
    /// The numbers of the changes that followed, each with how often.
    pub outcomes: Vec<(usize, u32)>,
    /// How often it was in force.
    pub trials: u32,
}

/// The place of an experience among claims.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FoundPlace {
    /// The number of the claim that was in force.
    pub claim: usize,
    /// The number of the change that came; none where it was none that can be said.
    pub change: Option<usize>,
}
