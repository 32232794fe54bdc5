//! Replies as bytes for tools.

use pschema_inspect::Question;
use pschema_inspect::codec::{self, Problem, Reply};
use serde::Serialize;

use super::question::Inspect;
use crate::view::View;

/// The reply to a question as bytes for its tool.
#[must_use]
pub fn reply(view: &View, question: &Question) -> Vec<u8> {
    fn of<Q: Inspect>(view: &View, question: &Q) -> Vec<u8> {
        encoded(&Reply::from(question.answer(view)))
    }
    match question {
        Question::Status(status) => of(view, status),
        Question::Schemas(schemas) => of(view, schemas),
        Question::Show(show) => of(view, show),
        Question::Claims(claims) => of(view, claims),
        Question::Explain(explain) => of(view, explain),
        Question::WhyNot(why_not) => of(view, why_not),
        Question::Report(report) => of(view, report),
        Question::Trace(trace) => of(view, trace),
        Question::Predict(predict) => of(view, predict),
        Question::Plan(plan) => of(view, plan),
        Question::Pursuit(pursuit) => of(view, pursuit),
        Question::Live(live) => of(view, live),
        Question::Graph(graph) => of(view, graph),
    }
}

/// A reply as bytes; an answer that is too long becomes a problem that says so.
pub(crate) fn encoded<A: Serialize>(reply: &Reply<A>) -> Vec<u8> {
    codec::encode(reply)
        .unwrap_or_else(|error| problem(format!("{error}: ask for less, with a limit or a narrower pattern")))
}

/// The bytes of a reply that says why there is no answer.
pub(crate) fn problem(why: String) -> Vec<u8> {
    // The text is short, so it always fits.
    codec::encode(&Reply::<()>::Problem(Problem(why))).unwrap_or_default()
}
