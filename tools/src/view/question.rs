//! What the page may ask and order. Closed: what is not here can't be asked.

use pschema_inspect::SchemaSort;
use serde::Deserialize;

/// A question, and of when.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PageQuestion {
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Option<PageQuestion> {
        serde_json::from_str(text).ok()
    }

    #[test]
    fn only_what_the_page_asks_is_a_question() {
        let show = read(r#"{"question": {"ask": "show", "id": 3}, "until": 7}"#).unwrap();
        assert_eq!(show, PageQuestion { question: Question::Show { id: 3 }, until: Some(7) });
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
}
