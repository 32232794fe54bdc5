//! Why effects are refused.

use crate::nouns::vocabulary::DeclarationError;

/// Why an effect can't be applied: it speaks of something that is not there. Effects that a learner
/// returned for this memory always apply; those read back from elsewhere may not.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// No such schema, or one of the other form.
    #[error("effect refers to schema {0}, which is not there or of another form")]
    Schema(u32),
    /// Lists of another length than the schema has.
    #[error("effect scores {given} conditions of schema {schema}, which has {known}")]
    Length {
        /// Which schema.
        schema: u32,
        /// How many are scored.
        given: usize,
        /// How many it has.
        known: usize,
    },
    /// No such primitive.
    #[error("effect refers to primitive {0}, which was never declared")]
    Primitive(u32),
    /// No such body.
    #[error("effect refers to body {0}, which never attached")]
    Body(u16),
    /// Items that are not there.
    #[error("effect speaks of {given} synthetic items, or of the one of this number, and there are {known}")]
    Items {
        /// How many are spoken of, or which.
        given: usize,
        /// How many there are.
        known: usize,
    },
    /// An observation, a pattern or a binding with a type, property or symbol that was never declared.
    #[error("effect speaks of an observation type, a property or a symbol that was never declared")]
    Undeclared,
    /// Conditions that are not in canonical order, or one of them twice.
    #[error("effect makes a schema whose conditions are not in canonical order, each once")]
    Order,
    /// A schema, or a part of one, that is there already.
    #[error("effect adds to memory what schema {0} has or is already")]
    Twice(u32),
    /// More than memory holds.
    #[error("{what}: {count} are more than the limit of {limit}")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// How many there would be.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// No goal is pursued, or one is already, or what it asks for is out of range.
    #[error(
        "effect speaks of a goal that is not pursued, begins one while another is, or one without a sound measure"
    )]
    Goal,
    /// A policy is not one.
    #[error("effect has a policy with too many contexts, or of which the parts do not fit together")]
    Policy,
    /// A probability outside 0..=1.
    #[error("effect gives a plan a probability of {0}, which is outside 0..=1")]
    Probability(f64),
    /// An utterance that no stage can have.
    #[error("effect says utterance {0}, which no stage can have")]
    Utterance(usize),
    /// A number from a pool that was not the next in it.
    #[error("effect draws {0}, which is not the next of its pool")]
    Draw(i64),
    /// A declaration that contradicts what is known.
    #[error(transparent)]
    Declaration(#[from] DeclarationError),
}
