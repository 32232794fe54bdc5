//! What keeps a body's declaration from being learnt.

use std::fmt::{Display, Formatter};

use serde::{Deserialize, Serialize};

/// What a body declares that keeps it from being learnt, as its frames showed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "fault", rename_all = "kebab-case")]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum DeclarationWarning {
    /// The values of a sense are new almost each time: nothing that is learnt of one holds for another.
    ValuesNeverRepeat {
        /// The sense.
        sense: String,
        /// Observations that were counted.
        observations: u64,
        /// How many of them had come before.
        repeated: u64,
    },
    /// There are so many primitives that almost none is tried twice.
    ActionsNeverRepeat {
        /// Primitives of the body.
        primitives: u64,
        /// Actions that were counted.
        actions: u64,
        /// How many of them had been tried before.
        repeated: u64,
    },
    /// What actions do goes by senses that are declared as the body's own, and may be no pre-conditions under the learner's profile.
    OwnDecides {
        /// The senses.
        senses: Vec<String>,
        /// In how many contexts that was seen: the same but for these senses, and another outcome by them.
        contexts: u64,
    },
}

impl Display for DeclarationWarning {
    fn fmt(&self, to: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::ValuesNeverRepeat { sense, observations, repeated } => write!(
                to,
                "{sense} hardly ever has the same values ({repeated} of {observations} observations had come before), so that nothing \
                 learnt of one holds for another: declare a coarser resolution, or less in one sense"
            ),
            Self::ActionsNeverRepeat { primitives, actions, repeated } => write!(
                to,
                "of {primitives} primitives hardly any is tried twice ({repeated} of {actions} actions had been tried before): give the \
                 parameters fewer values"
            ),
            Self::OwnDecides { senses, contexts } => write!(
                to,
                "what actions do goes by {} (seen in {contexts} contexts), which is declared as the body's own and may be no \
                 pre-condition under this profile: declare it without own, or begin a memory with profile = \"full\"",
                senses.join(" and ")
            ),
        }
    }
}
