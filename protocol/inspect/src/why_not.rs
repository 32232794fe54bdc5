//! What tools ask about a schema that was not executed.

use serde::{Deserialize, Serialize};

use super::{Candidate, ObservationText, SchemaInUse, ValueText};

/// Why a schema was not executed in a step, or that it was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WhyNot {
    /// The step.
    pub step: u64,
    /// The body that was sent to act.
    pub body: String,
    /// What was perceived, under the constraints of the stage.
    pub world: Vec<ObservationText>,
    /// The schema asked about.
    pub schema: u32,
    /// `concrete`, `generalised`, `retired`, `counter-example`.
    pub kind: String,
    /// It, as it prints.
    pub text: String,
    /// What stood in its way; of a generalised schema, in the way of the binding that came nearest.
    pub verdict: Verdict,
    /// Values of its variables under which the verdict is given; empty where none could be found, or it has none.
    pub binding: Vec<(String, ValueText)>,
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
    /// Whether the stage still asked it to be tried (habituation, paper II-G); none where the stage was not at that.
    pub habituated: Option<bool>,
    /// Whether the search for chains used up its budget, so that there may be one that was not found.
    pub search_truncated: bool,
    /// What was chosen instead.
    pub chosen: Candidate,
    /// The primitive sent, as it prints.
    pub action: String,
    /// What made the choice, as in [`Explanation::reason`](super::Explanation::reason).
    pub reason: String,
    /// How many candidates had the top excitation.
    pub ties: u32,
}

/// What stood in a schema's way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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
        lacking: Vec<Lacking>,
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
        /// `concrete` (an example), `counter-example`.
        kind: String,
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

/// A pre-condition that does not hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Lacking {
    /// It.
    pub wanted: ObservationText,
    /// What was perceived that comes nearest to it: of its type, with the most values the same; none when nothing of its
    /// type was perceived.
    pub nearest: Option<ObservationText>,
    /// The properties in which that differs: what is wanted, what was seen.
    pub differs: Vec<Difference>,
    /// Whether the stage does not lift its type, so that it can't be perceived.
    pub constrained: bool,
}

/// A property that has another value than wanted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Difference {
    /// Its name.
    pub property: String,
    /// The value wanted.
    pub wanted: ValueText,
    /// The value seen; none when what was seen has no such property.
    pub seen: Option<ValueText>,
}
