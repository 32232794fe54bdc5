//! Why something that was read can't be the content of a memory.

/// Why something that was read can't be the content of a memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ContentError {
    /// The items of a memory come in one order.
    #[error("`{item}` stands after `{before}`: something is missing, or out of order")]
    Order {
        /// The item that is out of order.
        item: &'static str,
        /// The item before it.
        before: &'static str,
    },
    /// There is one item of this kind in a memory.
    #[error("a second `{item}`")]
    Second {
        /// The kind of the item.
        item: &'static str,
    },
    /// An item of this kind stands once in a memory.
    #[error("this {item} was there before")]
    Again {
        /// The kind of the item.
        item: &'static str,
    },
    /// An item without which there is no memory.
    #[error("there is no `{item}`: something is missing")]
    Missing {
        /// The kind of the item.
        item: &'static str,
    },
    /// Names tell things of one kind apart.
    #[error("the {what} {name:?} was there before")]
    Twice {
        /// What has the name.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A name of something that is not there.
    #[error("it speaks of the {what} {name:?}, and nothing before has that name")]
    Unknown {
        /// What should have the name.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// A number of something that is not there.
    #[error("it refers to {what} {number}, and there are {count}, numbered from 0")]
    Reference {
        /// What the number is of.
        what: &'static str,
        /// The number.
        number: usize,
        /// How many there are.
        count: usize,
    },
    /// An observation, a pattern or a binding of something that no body declared.
    #[error("it speaks of an observation type, a property or a symbol that was never declared")]
    Undeclared,
    /// More than a memory has room for.
    #[error("there are more than {limit} {what}, the limit")]
    Limit {
        /// What there are too many of.
        what: &'static str,
        /// How many there may be.
        limit: usize,
    },
    /// Something happened more often than it was tried.
    #[error("something happened {occurrences} times in {trials} trials")]
    Count {
        /// How often it happened.
        occurrences: u32,
        /// How often it could have happened.
        trials: u32,
    },
    /// Another number than was announced.
    #[error("{said} {what} are announced, and there are {there}: something is missing, or too much")]
    Total {
        /// What was counted.
        what: &'static str,
        /// How many are announced.
        said: u64,
        /// How many there are.
        there: u64,
    },
    /// A value, or a number of values, that is not allowed there.
    #[error("{0} is out of range, or of another kind")]
    Value(&'static str),
    /// Lists of a vocabulary that do not fit each other.
    #[error("its {0} refer to something that is not there, or are too many")]
    Vocabulary(&'static str),
    /// Settings that no learner can live under.
    #[error("no learner can live under its settings: {0}")]
    Setting(String),
}
