//! The questions and orders of the page. The set is closed: nothing else can be asked.

use pschema_inspect::{ClaimQuery, DetailQuery, SchemaQuery};
use serde::Deserialize;

/// A question, with the moment that it is about.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PageQuestion {
    /// The question.
    pub(super) question: Question,
    /// The step after which memory is asked about; memory as it is when none is named.
    pub(super) until: Option<u64>,
}

/// A question or an order of the page.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum Question {
    /// The learner, and how far back its memory on disk goes.
    About,
    /// Everything that is shown of one moment.
    Live {
        /// The number of the first record of the trace that the page does not have.
        trace_from: u64,
    },
    /// What the curriculum has done so far.
    Report,
    /// A page of the list of schemas.
    Schemas(SchemaQuery),
    /// One schema whole.
    Show(DetailQuery),
    /// A page of the claims.
    Claims(ClaimQuery),
    /// Why a schema was not executed in the last decision.
    WhyNot {
        /// Its number.
        id: u32,
    },
    /// Schemas and what ties them together.
    Graph {
        /// Only schemas around this one; all schemas when none is named.
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
        /// The words.
        words: Vec<String>,
    },
}

impl Question {
    /// Whether it is an order.
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
        assert_eq!(show, PageQuestion { question: Question::Show(DetailQuery { id: 3 }), until: Some(7) });
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
