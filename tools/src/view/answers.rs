//! Answers for the page: the answers of a learner as they travel, with the texts and drawings that this program makes of
//! them.

use hyper::StatusCode;
use pschema_inspect::{
    Ask, ClaimQuery, Graph, GraphQuery, Live, LiveQuery, Report, ReportQuery, SayOrder, SchemaDetail,
    SchemaQuery, StageOrder, WhyNotQuery,
};
use serde::Serialize;

use super::question::Question;
use super::work::{Reply, Trouble};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::render::graph::svg;
use crate::render::words::{schema_notation, schema_sentence};
use crate::render::{claims, explanation, why_not};

/// Candidates of the last decision that the page shows.
const CANDIDATES_SHOWN: u32 = 8;
/// Terms of a candidate that the page shows one by one.
const TERMS_SHOWN: u32 = 12;
/// Newest schemas that the page shows.
const NEWEST_SHOWN: u32 = 8;
/// Schemas on one page of the list.
const LISTED_MAX: u32 = 100;
/// Trees on one page of the claims.
const TREES_MAX: u32 = 20;
/// Schemas drawn one by one in a graph: more can't be told apart on a screen.
const DRAWN_MAX: u32 = 200;
/// How far from a schema a graph reaches.
const DEPTH_MAX: u32 = 4;

/// The learner that a page is about.
#[derive(Debug, Default, Serialize)]
pub(super) struct About {
    /// The learner's name.
    pub(super) name: String,
    /// Whether a daemon is asked; if not, a memory on disk is all there is.
    pub(super) live: bool,
    /// Where memory is on disk; none while it is in RAM only.
    pub(super) directory: Option<String>,
    /// The first step that can be returned to.
    pub(super) oldest_step: Option<u64>,
    /// The last step on disk.
    pub(super) last_step: Option<u64>,
    /// The version of this program.
    pub(super) version: &'static str,
}

/// Who answers the page: the daemon, or memory as it was.
pub(super) trait Respondent: Asks {
    /// The learner that it is.
    fn about(&mut self) -> Result<About, Trouble>;

    /// Obeys an order; a memory on disk refuses it.
    fn obey<O: Ask<Answer = Report>>(&mut self, order: O) -> Result<Report, Trouble>;

    /// The reason why the last decision can't be told; none if it can.
    fn undecided(&self) -> Option<&str>;
}

/// The answer to a question of the page.
pub(super) fn reply(question: Question, from: &mut impl Respondent) -> Reply {
    match question {
        Question::About => json(&from.about()?),
        Question::Live { trace_from } => {
            let live = from.ask(LiveQuery {
                trace_from,
                candidates_max: CANDIDATES_SHOWN,
                terms_max: TERMS_SHOWN,
                newest_max: NEWEST_SHOWN,
            })?;
            let sentence = live.explanation.as_ref().map(explanation::in_a_sentence);
            json(&Moment { live: &live, sentence, undecided: from.undecided() })
        }
        Question::Report => json(&from.ask(ReportQuery {})?),
        Question::Schemas(query) => {
            json(&from.ask(SchemaQuery { limit: query.limit.clamp(1, LISTED_MAX), ..query })?)
        }
        Question::Show(query) => json(&SchemaTexts::from(&from.ask(query)?)),
        Question::Claims(query) => {
            let query = ClaimQuery { limit: query.limit.clamp(1, TREES_MAX), ..query };
            let list = from.ask(query.clone())?;
            json(&ClaimsText { matching: list.matching, text: claims::list(&list, query.offset) })
        }
        Question::WhyNot { id } => {
            let why = from.ask(WhyNotQuery { schema: id, step: None })?;
            json(&WhyNotText { text: why_not::why_not(&why) })
        }
        Question::Graph { around, depth } => {
            let depth = depth.clamp(1, DEPTH_MAX);
            let graph = from.ask(GraphQuery { around, depth, goal: Vec::new(), limit: DRAWN_MAX })?;
            json(&Drawing::from(&graph))
        }
        Question::Hold => json(&from.obey(StageOrder::Hold)?),
        Question::Resume => json(&from.obey(StageOrder::Resume)?),
        Question::Step => json(&from.obey(StageOrder::Step)?),
        Question::Say { words } => json(&from.obey(SayOrder { words })?),
    }
}

fn json(value: &impl Serialize) -> Reply {
    serde_json::to_vec(value).map_err(|error| Failure::of(error).into())
}

/// Everything that is shown of one moment.
#[derive(Serialize)]
struct Moment<'a> {
    #[serde(flatten)]
    live: &'a Live,
    /// The sentence that explains the last decision.
    sentence: Option<String>,
    /// The reason why there is no decision, when there was one that can't be made again.
    undecided: Option<&'a str>,
}

/// A schema, with how it reads.
#[derive(Serialize)]
struct SchemaTexts<'a> {
    #[serde(flatten)]
    schema: &'a SchemaDetail,
    sentence: String,
    notation: String,
    /// The claims that it rests on, as text; empty where there are none.
    rests_on: String,
}

impl<'a> From<&'a SchemaDetail> for SchemaTexts<'a> {
    fn from(schema: &'a SchemaDetail) -> Self {
        Self {
            sentence: schema_sentence(schema),
            notation: schema_notation(schema),
            rests_on: claims::foretold(&schema.claims, true),
            schema,
        }
    }
}

/// A page of the claims, as text.
#[derive(Serialize)]
struct ClaimsText {
    matching: u32,
    text: String,
}

/// Why a schema was not executed, as text.
#[derive(Serialize)]
struct WhyNotText {
    text: String,
}

/// A graph, drawn.
#[derive(Serialize)]
struct Drawing {
    step: u64,
    nodes_total: u64,
    shown: u32,
    truncated: bool,
    edges_total: u64,
    /// The schema of each node of the drawing; none where it stands for several.
    schemas: Vec<Option<u32>>,
    svg: String,
    style: &'static str,
}

impl From<&Graph> for Drawing {
    fn from(graph: &Graph) -> Self {
        Self {
            step: graph.step,
            nodes_total: graph.nodes_total,
            shown: graph.shown,
            truncated: graph.truncated,
            edges_total: graph.edges_total,
            schemas: graph.nodes.iter().map(|node| node.schema.as_ref().map(|schema| schema.id)).collect(),
            svg: svg::bare(graph),
            style: svg::STYLE,
        }
    }
}

/// The refusal of an order by a memory on disk.
pub(super) fn no_orders() -> Trouble {
    let problem = "memory on disk takes no orders: go back to the present of a learner that runs";
    Trouble::new(StatusCode::CONFLICT, problem)
}

#[cfg(test)]
mod tests {
    use pschema_inspect::{DetailQuery, Request, SchemaSort};
    use pschema_server::inspect::Inspect;

    use super::*;

    /// Answers nothing, and keeps the question.
    #[derive(Default)]
    struct Silent(Option<Request>);

    impl Asks for Silent {
        fn ask<Q: Inspect>(&mut self, question: Q) -> Result<Q::Answer, Failure> {
            self.0 = Some(question.into());
            Err(Failure::Failed("nothing".to_owned()))
        }
    }

    impl Respondent for Silent {
        fn about(&mut self) -> Result<About, Trouble> {
            Ok(About::default())
        }

        fn obey<O: Ask<Answer = Report>>(&mut self, _: O) -> Result<Report, Trouble> {
            Err(no_orders())
        }

        fn undecided(&self) -> Option<&str> {
            None
        }
    }

    fn asked(question: Question) -> Option<Request> {
        let mut silent = Silent::default();
        assert!(reply(question, &mut silent).is_err());
        silent.0
    }

    #[test]
    fn no_question_asks_for_more_than_a_page_shows() {
        let many = u32::MAX;
        let list = SchemaQuery { sort: SchemaSort::Uses, limit: many, offset: 5, ..SchemaQuery::default() };
        let query = SchemaQuery { limit: LISTED_MAX, ..list.clone() };
        assert_eq!(asked(Question::Schemas(list)), Some(query.into()));
        let list = ClaimQuery { action: Some("move".to_owned()), limit: many, offset: 7 };
        let query = ClaimQuery { limit: TREES_MAX, ..list.clone() };
        assert_eq!(asked(Question::Claims(list)), Some(query.into()));
        let query = GraphQuery { depth: DEPTH_MAX, limit: DRAWN_MAX, ..GraphQuery::default() };
        assert_eq!(asked(Question::Graph { around: None, depth: many }), Some(query.into()));
        assert_eq!(asked(Question::Show(DetailQuery { id: 3 })), Some(DetailQuery { id: 3 }.into()));
    }
}
