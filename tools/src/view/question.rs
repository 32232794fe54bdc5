//! What the page may ask and order. Closed: what is not here can't be asked.

use pschema_inspect::{GraphQuery, LiveQuery, Request, SchemaQuery, SchemaSort, StageOrder};
use serde::Deserialize;

/// Candidates of a decision that the page shows.
const CANDIDATES_SHOWN: u32 = 8;
/// Terms of each that it shows one by one.
const TERMS_SHOWN: u32 = 12;
/// Newest schemas that it shows.
const NEWEST_SHOWN: u32 = 8;
/// Schemas on one page of the list.
const LISTED_MAX: u32 = 100;
/// Schemas drawn one by one in a graph: more can't be told apart on a screen.
const DRAWN_MAX: u32 = 200;
/// How far from a schema a graph reaches.
const DEPTH_MAX: u32 = 4;

/// A question, and of when.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Asked {
    /// What.
    pub(super) question: Question,
    /// Of memory as it was after this step; as it is when none is named.
    pub(super) until: Option<u64>,
}

/// What the page may ask.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Question {
    /// Which learner this is, and how far back its memory on disk goes.
    About,
    /// All that is shown at once.
    Live {
        /// The number of the first record of the trace that the page does not have.
        trace_from: u64,
    },
    /// What the curriculum has done so far.
    Report,
    /// A page of the list of schemas.
    Schemas {
        /// Only those with this action.
        action: Option<String>,
        /// Only those with a pre-condition like this.
        pre: Option<String>,
        /// Only those with a post-condition like this.
        post: Option<String>,
        /// Only those with variables.
        generalised: bool,
        /// In which order.
        sort: SchemaSort,
        /// How many.
        limit: u32,
        /// After so many.
        offset: u32,
    },
    /// One schema whole.
    Show {
        /// Its number.
        id: u32,
    },
    /// Why a schema was not executed in the last decision.
    WhyNot {
        /// Its number.
        id: u32,
    },
    /// What ties schemas together.
    Graph {
        /// Those around this one; all when none is named.
        around: Option<u32>,
        /// How many ties away.
        depth: u32,
    },
    /// An order: wait.
    Hold,
    /// An order: go on.
    Resume,
    /// An order: take one action.
    Step,
    /// An order: words are heard.
    Say {
        /// Which.
        words: Vec<String>,
    },
}

impl Question {
    /// Whether it is to change something.
    pub(super) fn is_order(&self) -> bool {
        matches!(self, Self::Hold | Self::Resume | Self::Step | Self::Say { .. })
    }

    /// As it is asked of a daemon, or of a memory on disk.
    pub(super) fn request(self) -> Request {
        match self {
            Self::About => Request::Status,
            Self::Live { trace_from } => Request::Live(LiveQuery {
                trace_from,
                candidates_max: CANDIDATES_SHOWN,
                terms_max: TERMS_SHOWN,
                newest_max: NEWEST_SHOWN,
            }),
            Self::Report => Request::Report,
            Self::Schemas { action, pre, post, generalised, sort, limit, offset } => {
                let limit = limit.clamp(1, LISTED_MAX);
                Request::Schemas(SchemaQuery { action, pre, post, generalised, sort, limit, offset })
            }
            Self::Show { id } => Request::Show { id },
            Self::WhyNot { id } => Request::WhyNot { schema: id, step: None },
            Self::Graph { around, depth } => Request::Graph(GraphQuery {
                around,
                depth: depth.clamp(1, DEPTH_MAX),
                goal: Vec::new(),
                limit: DRAWN_MAX,
            }),
            Self::Hold => Request::Stage(StageOrder::Hold),
            Self::Resume => Request::Stage(StageOrder::Resume),
            Self::Step => Request::Stage(StageOrder::Step),
            Self::Say { words } => Request::Say { words },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<Asked> {
        serde_json::from_str(text).ok()
    }

    #[test]
    fn only_what_the_page_asks_is_a_question() {
        let show = read(r#"{"question": {"ask": "show", "id": 3}, "until": 7}"#).unwrap();
        assert_eq!(show, Asked { question: Question::Show { id: 3 }, until: Some(7) });
        assert_eq!(show.question.request(), Request::Show { id: 3 });
        for text in [
            r#"{"question": {"ask": "shutdown"}, "until": null}"#,
            r#"{"question": {"ask": "show", "id": -1}, "until": null}"#,
            r#"{"question": {"ask": "show", "id": 1, "more": 1}, "until": null}"#,
            r#"{"question": {"ask": "show", "id": 1}, "until": null, "more": 1}"#,
            r#"{"question": "show"}"#,
            "[]",
            "",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }

    #[test]
    fn no_question_asks_for_more_than_a_page_shows() {
        let text = r#"{"question": {"ask": "schemas", "generalised": false, "sort": "uses", "limit": 4000000000,
            "offset": 5}}"#;
        let Request::Schemas(query) = read(text).unwrap().question.request() else {
            panic!("a list is asked for")
        };
        assert_eq!((query.limit, query.offset), (LISTED_MAX, 5));
        let text = r#"{"question": {"ask": "graph", "depth": 4000000000}}"#;
        let Request::Graph(query) = read(text).unwrap().question.request() else {
            panic!("a graph is asked for")
        };
        assert_eq!((query.depth, query.limit), (DEPTH_MAX, DRAWN_MAX));
    }
}
