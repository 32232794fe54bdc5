//! What is answered, as the page reads it.

use hyper::StatusCode;
use pschema_inspect::{
    Answer, Candidate, ExcitationTerm, Explanation, Live, Perceived, SchemaDetail, SchemaSummary, TracePage,
    TraceRecord,
};
use serde::Serialize;

use super::work::{Reply, Trouble};
use crate::failure::Failure;
use crate::render::graph::svg;
use crate::render::json::{Observation, Schema};
use crate::render::words::{binding, notation, schema_notation, schema_sentence};
use crate::render::{explanation, why_not};

/// Which learner a page is about.
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
    /// Of this program.
    pub(super) version: &'static str,
}

/// As JSON.
pub(super) fn json(value: &impl Serialize) -> Reply {
    serde_json::to_vec(value).map_err(|error| Failure::of(error).into())
}

/// An answer of the daemon, or of memory as it was; `undecided` says why its last decision can't be told, if so.
pub(super) fn answer(answer: &Answer, undecided: Option<&str>) -> Reply {
    match answer {
        Answer::Live(live) => json(&Shown { undecided, ..Shown::from(&**live) }),
        Answer::Schemas(list) => json(list),
        Answer::Schema(schema) => json(&Whole::from(&**schema)),
        Answer::Report(report) => json(report),
        Answer::Graph(drawn) => json(&Drawn {
            step: drawn.step,
            nodes_total: drawn.nodes_total,
            shown: drawn.shown,
            truncated: drawn.truncated,
            edges_total: drawn.edges_total,
            schemas: drawn.nodes.iter().map(|node| node.schema.as_ref().map(|schema| schema.id)).collect(),
            svg: svg::bare(drawn),
            style: svg::STYLE,
        }),
        Answer::WhyNot(why) => json(&Told { text: why_not::why_not(why) }),
        Answer::Error(problem) => Err(Trouble::new(StatusCode::UNPROCESSABLE_ENTITY, problem.clone())),
        other => Err(crate::learner::unexpected(other).into()),
    }
}

#[derive(Serialize)]
struct Told {
    text: String,
}

#[derive(Serialize)]
struct Drawn {
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

/// A schema, with how it reads.
#[derive(Serialize)]
struct Whole<'a> {
    #[serde(flatten)]
    schema: Schema<'a>,
    sentence: String,
    notation: String,
}

impl<'a> From<&'a SchemaDetail> for Whole<'a> {
    fn from(schema: &'a SchemaDetail) -> Self {
        Self { sentence: schema_sentence(schema), notation: schema_notation(schema), schema: schema.into() }
    }
}

/// All that is shown at once; fields of `live` mean the same here.
#[derive(Serialize)]
struct Shown<'a> {
    name: &'a str,
    uptime_s: f64,
    step: u64,
    durable_step: Option<u64>,
    curriculum: &'a str,
    stage: &'a str,
    stage_state: &'a str,
    saturation: &'a Option<pschema_inspect::SaturationStatus>,
    habituation: &'a Option<pschema_inspect::HabituationStatus>,
    trial: &'a Option<pschema_inspect::TrialStatus>,
    goal: &'a Option<pschema_inspect::GoalSummary>,
    schemas_total: u32,
    schemas_generalised: u32,
    steps_per_s: f64,
    step_latency_us_p50: f64,
    step_latency_us_p99: f64,
    commit_latency_us_p50: f64,
    commit_latency_us_p99: f64,
    memory_bytes: u64,
    bodies: &'a [pschema_inspect::BodyStatus],
    world: Vec<Noticed<'a>>,
    decision: Option<Decided<'a>>,
    /// Why there is no decision, when there was one that can't be made again.
    undecided: Option<&'a str>,
    newest: &'a [SchemaSummary],
    trace: Trace<'a>,
}

impl<'a> From<&'a Live> for Shown<'a> {
    fn from(live: &'a Live) -> Self {
        Self {
            name: &live.name,
            uptime_s: live.uptime_s,
            step: live.step,
            durable_step: live.durable_step,
            curriculum: &live.curriculum,
            stage: &live.stage,
            stage_state: &live.stage_state,
            saturation: &live.saturation,
            habituation: &live.habituation,
            trial: &live.trial,
            goal: &live.goal,
            schemas_total: live.schemas_total,
            schemas_generalised: live.schemas_generalised,
            steps_per_s: live.steps_per_s,
            step_latency_us_p50: live.step_latency_us_p50,
            step_latency_us_p99: live.step_latency_us_p99,
            commit_latency_us_p50: live.commit_latency_us_p50,
            commit_latency_us_p99: live.commit_latency_us_p99,
            memory_bytes: live.memory_bytes,
            bodies: &live.bodies,
            world: live.world.iter().map(Noticed::from).collect(),
            decision: live.explanation.as_ref().map(Decided::from),
            undecided: None,
            newest: &live.newest,
            trace: Trace::from(&live.trace),
        }
    }
}

#[derive(Serialize)]
struct Noticed<'a> {
    text: &'a str,
    observation: Observation<'a>,
    new: bool,
    attention: u32,
}

impl<'a> From<&'a Perceived> for Noticed<'a> {
    fn from(one: &'a Perceived) -> Self {
        Self {
            text: &one.text,
            observation: (&one.observation).into(),
            new: one.new,
            attention: one.attention,
        }
    }
}

/// A decision, with the sentence that tells it.
#[derive(Serialize)]
struct Decided<'a> {
    step: u64,
    body: &'a str,
    action: &'a str,
    reason: &'a str,
    ties: u32,
    chosen: u32,
    candidates_total: u32,
    sentence: String,
    candidates: Vec<Considered<'a>>,
}

impl<'a> From<&'a Explanation> for Decided<'a> {
    fn from(e: &'a Explanation) -> Self {
        Self {
            step: e.step,
            body: &e.body,
            action: &e.action,
            reason: &e.reason,
            ties: e.ties,
            chosen: e.chosen,
            candidates_total: e.candidates_total,
            sentence: explanation::in_a_sentence(e),
            candidates: e.candidates.iter().map(Considered::from).collect(),
        }
    }
}

#[derive(Serialize)]
struct Considered<'a> {
    schema: Option<u32>,
    text: &'a str,
    binding: String,
    distance: u32,
    excitation: f64,
    terms: Vec<Term<'a>>,
}

impl<'a> From<&'a Candidate> for Considered<'a> {
    fn from(c: &'a Candidate) -> Self {
        Self {
            schema: c.schema,
            text: &c.text,
            binding: binding(&c.binding),
            distance: c.distance,
            excitation: c.excitation,
            terms: c.terms.iter().map(Term::from).collect(),
        }
    }
}

#[derive(Serialize)]
struct Term<'a> {
    remembered: Option<String>,
    seen: Option<String>,
    role: &'a str,
    shared: u32,
    attention: u32,
    probability: f64,
    weight: f64,
    value: f64,
}

impl<'a> From<&'a ExcitationTerm> for Term<'a> {
    fn from(t: &'a ExcitationTerm) -> Self {
        Self {
            remembered: t.observation.as_ref().map(notation),
            seen: t.seen.as_ref().map(notation),
            role: &t.role,
            shared: t.shared,
            attention: t.attention,
            probability: t.probability,
            weight: t.weight,
            value: t.value,
        }
    }
}

/// Steps, as far as the curve needs them.
#[derive(Serialize)]
struct Trace<'a> {
    from: u64,
    total: u64,
    stages: &'a [String],
    records: Vec<Point<'a>>,
}

impl<'a> From<&'a TracePage> for Trace<'a> {
    fn from(page: &'a TracePage) -> Self {
        let records = page.records.iter().map(Point::from).collect();
        Self { from: page.from, total: page.total, stages: &page.stages, records }
    }
}

/// A step of the curve.
#[derive(Serialize)]
struct Point<'a> {
    step: u64,
    stage: u32,
    /// Excitation of the most excited candidate; none when nothing was decided.
    top: Option<f64>,
    /// Whether the schema chosen predicts a touch: the lower curve of figure 6.
    touching: bool,
    /// Whether a touch was felt.
    touched: bool,
    heard: &'a [String],
}

/// The paper's touch sensor; other bodies have other senses, and then nothing is marked.
const TOUCH: &str = "touch";

impl<'a> From<&'a TraceRecord> for Point<'a> {
    fn from(record: &'a TraceRecord) -> Self {
        let decision = record.decision.as_ref();
        Self {
            step: record.step,
            stage: record.stage,
            top: decision.map(|decision| decision.excitation_top),
            touching: decision.is_some_and(|decision| decision.predicts.iter().any(|kind| kind == TOUCH)),
            touched: record.perceived.iter().any(|one| one.kind == TOUCH),
            heard: &record.heard,
        }
    }
}
