//! Questions and orders, each with the type of its answer.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::claims::ClaimList;
use crate::closed_set::closed_set;
use crate::decision::Explanation;
use crate::goals::{Plan, Prediction, Pursuit};
use crate::graph::Graph;
use crate::live::Live;
use crate::schema::{SchemaDetail, SchemaList};
use crate::stage::Report;
use crate::status::Status;
use crate::trace::TracePage;
use crate::why_not::WhyNot;

/// What a tool sends: a question or an order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Request {
    /// Changes nothing.
    Question(Question),
    /// Is obeyed first, and answered then.
    Order(Order),
}

/// A question or an order of one kind, with the type of its answer.
pub trait Ask: Clone + Into<Request> {
    /// What is answered.
    type Answer: Serialize + DeserializeOwned;
}

/// An enum of the kinds of request, and for each kind the type of its answer.
macro_rules! kinds {
    ($(#[$about:meta])* $set:ident: $($(#[$meaning:meta])* $kind:ident($asked:ident) -> $answer:ty,)+) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(rename_all = "kebab-case")]
        pub enum $set {
            $($(#[$meaning])* $kind($asked),)+
        }

        $(
            impl From<$asked> for Request {
                fn from(asked: $asked) -> Self {
                    Self::$set($set::$kind(asked))
                }
            }

            impl Ask for $asked {
                type Answer = $answer;
            }
        )+
    };
}

kinds! {
    /// What can be asked of a learner.
    Question:
    /// How the daemon and its learner are.
    Status(StatusQuery) -> Status,
    /// A list of schemas.
    Schemas(SchemaQuery) -> SchemaList,
    /// One schema whole.
    Show(DetailQuery) -> SchemaDetail,
    /// The claims about actions.
    Claims(ClaimQuery) -> ClaimList,
    /// Why an action was chosen.
    Explain(ExplanationQuery) -> Explanation,
    /// Why a schema was not executed.
    WhyNot(WhyNotQuery) -> WhyNot,
    /// What the curriculum has done so far.
    Report(ReportQuery) -> Report,
    /// What was decided in each step, page by page.
    Trace(TraceQuery) -> TracePage,
    /// What an action would do in the world as it is.
    Predict(PredictionQuery) -> Prediction,
    /// How a goal could be brought about from the world as it is.
    Plan(PlanQuery) -> Plan,
    /// How the goal is doing that is pursued, or was the last to be.
    Pursuit(PursuitQuery) -> Pursuit,
    /// Everything that somebody who watches the learner is shown.
    Live(LiveQuery) -> Live,
    /// Schemas and what ties them together.
    Graph(GraphQuery) -> Graph,
}

kinds! {
    /// What can be ordered.
    Order:
    /// Words are to be heard with the next frame.
    Say(SayOrder) -> Report,
    /// Developmental control.
    Stage(StageOrder) -> Report,
    /// A goal is to be brought about.
    Achieve(AchieveOrder) -> Pursuit,
    /// A goal is to be pursued no more.
    Cancel(CancelOrder) -> Pursuit,
    /// The daemon is to end, cleanly.
    Shutdown(ShutdownOrder) -> (),
}

impl Order {
    /// The question whose answer tells of the order once it is obeyed; none where there is nothing to tell.
    #[must_use]
    pub fn told_by(&self) -> Option<Question> {
        match self {
            Self::Say(_) | Self::Stage(_) => Some(Question::Report(ReportQuery {})),
            Self::Achieve(_) | Self::Cancel(_) => Some(Question::Pursuit(PursuitQuery {})),
            Self::Shutdown(_) => None,
        }
    }
}

/// Defines what is asked: fields that are left out have their default, and a field that is not known is refused.
macro_rules! query {
    ($(#[$about:meta])* $name:ident { $($(#[$meaning:meta])* $field:ident: $of:ty,)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $($(#[$meaning])* pub $field: $of,)*
        }
    };
}

query! {
    /// Asks how the daemon and its learner are.
    StatusQuery {}
}

query! {
    /// Asks for a list of schemas.
    SchemaQuery {
        /// Only schemas whose action has this name.
        action: Option<String>,
        /// Only schemas with a pre-condition that this pattern matches, as it prints: `object{colour=blue}`.
        pre: Option<String>,
        /// Only schemas with a post-condition that this pattern matches.
        post: Option<String>,
        /// Only generalised schemas.
        generalised: bool,
        /// The order.
        sort: SchemaSort,
        /// At most this many; 0 for the daemon's limit.
        limit: u32,
        /// Leave out so many of the first in that order: those of the pages before.
        offset: u32,
    }
}

closed_set! {
    /// In which order to list schemas.
    #[derive(Default)]
    SchemaSort {
        /// The oldest first.
        #[default]
        Age = "age",
        /// The most executed first.
        Uses = "uses",
        /// The most reliable first: by the lower end of the interval.
        Probability = "probability",
        /// The most excited in the last decision first.
        Excitation = "excitation",
    }
}

/// Asks for one schema whole.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DetailQuery {
    /// The number of the schema.
    pub id: u32,
}

query! {
    /// Asks for claims. With no `action`, for those about each action and about whatever is done.
    ClaimQuery {
        /// Only those about this action, by its name; or about a primitive alone, as it prints.
        action: Option<String>,
        /// At most so many trees; 0 for the daemon's limit.
        limit: u32,
        /// Leave out so many of the first: those of the pages before.
        offset: u32,
    }
}

query! {
    /// Asks why an action was chosen.
    ExplanationQuery {
        /// The step that decided; the last decision when none is named.
        step: Option<u64>,
        /// Candidates to list, the most excited first. The chosen one is always listed.
        candidates_max: u32,
    }
}

/// Asks why a schema was not executed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WhyNotQuery {
    /// The number of the schema.
    pub schema: u32,
    /// The step that decided; the last decision when none is named.
    #[serde(default)]
    pub step: Option<u64>,
}

query! {
    /// Asks what the curriculum has done so far.
    ReportQuery {}
}

query! {
    /// Asks what was decided in each step, page by page.
    TraceQuery {
        /// The number of the first record wanted, from 0 in the order in which they were kept.
        from: u64,
    }
}

query! {
    /// Asks what an action would do in the world as it is.
    PredictionQuery {
        /// The action, as it prints: `move(j1=0.426, j2=0.817)`.
        action: String,
    }
}

query! {
    /// Asks how a goal could be brought about from the world as it is.
    PlanQuery {
        /// A pattern for each thing wanted, as it prints: `object{colour=blue, field=$x}`.
        goal: Vec<String>,
        /// That it holds already does not count: it is to be brought about.
        again: bool,
        /// Instead of patterns, the value of which most is wanted: the name of an observation type.
        most: Option<String>,
    }
}

query! {
    /// Asks how the goal is doing that is pursued, or was the last to be.
    PursuitQuery {}
}

query! {
    /// Asks for everything that somebody who watches the learner is shown.
    LiveQuery {
        /// The number of the first record of the trace wanted, as in a question for the trace.
        trace_from: u64,
        /// Candidates of the last decision to list, the most excited first; at most 32.
        candidates_max: u32,
        /// Terms of each candidate to list one by one, the greatest first; the others are added up as one of role `rest`.
        terms_max: u32,
        /// Newest schemas to list; at most 100.
        newest_max: u32,
    }
}

query! {
    /// Asks for schemas and what ties them together. With neither `around` nor `goal`, for all of memory.
    GraphQuery {
        /// Only what is tied to the schema of this number.
        around: Option<u32>,
        /// How many ties away from it, 1 to 8; 0 for 1.
        depth: u32,
        /// Only the chain that would bring this goal about from the world as it is: a pattern for each thing wanted.
        goal: Vec<String>,
        /// Schemas to be shown one by one, at most; the others stand together. 0 for the daemon's limit.
        limit: u32,
    }
}

query! {
    /// Orders that words are heard with the next frame.
    SayOrder {
        /// The words, in order.
        words: Vec<String>,
    }
}

/// An order to the curriculum.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum StageOrder {
    /// End the present stage.
    Next,
    /// Wait.
    Hold,
    /// Go on.
    Resume,
    /// Take one action, and wait again.
    Step,
    /// Enter the stage of this name.
    Set(String),
}

query! {
    /// Orders that a goal is brought about.
    AchieveOrder {
        /// A pattern for each thing wanted.
        goal: Vec<String>,
        /// That it holds already does not count: it is to be brought about.
        again: bool,
        /// Instead of patterns, the value of which most is wanted: the name of an observation type.
        most: Option<String>,
        /// Actions that may be taken for it.
        actions_max: u32,
    }
}

/// Orders that a goal is pursued no more.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CancelOrder {
    /// The number of the goal.
    pub number: u64,
}

query! {
    /// Orders that the daemon ends.
    ShutdownOrder {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec;

    #[test]
    fn a_request_says_what_it_is() {
        let step = WhyNotQuery { schema: 7, step: None };
        let requests: [(Request, &str); 5] = [
            (StatusQuery {}.into(), r#"{"question":{"status":{}}}"#),
            (DetailQuery { id: 3 }.into(), r#"{"question":{"show":{"id":3}}}"#),
            (step.into(), r#"{"question":{"why-not":{"schema":7,"step":null}}}"#),
            (StageOrder::Hold.into(), r#"{"order":{"stage":"hold"}}"#),
            (StageOrder::Set("free".to_owned()).into(), r#"{"order":{"stage":{"set":"free"}}}"#),
        ];
        for (request, text) in requests {
            assert_eq!(String::from_utf8(codec::encode(&request).unwrap()).unwrap(), text);
            assert_eq!(codec::decode::<Request>(text.as_bytes()).unwrap(), request);
        }
    }

    #[test]
    fn what_is_left_out_is_usual_and_what_is_not_known_is_refused() {
        let read = |text: &str| codec::decode::<Request>(text.as_bytes());
        let usual = Request::from(SchemaQuery::default());
        assert_eq!(read(r#"{"question":{"schemas":{}}}"#).unwrap(), usual);
        for wrong in [
            r#"{"question":{"schemas":{"generalized":true}}}"#,
            r#"{"question":{"show":{}}}"#,
            r#"{"question":{"show":{"id":-1}}}"#,
            r#"{"question":"hold"}"#,
            r#"{"order":{"status":{}}}"#,
            "{}",
            "",
        ] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
