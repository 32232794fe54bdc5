//! What tools ask of a learner and what it answers: plain serde types, carried as bytes in pages.
//! The JSON that `pschema --json` prints is these types as they are, so field names are stable and carry
//! their units.

mod goals;
mod graph;
mod live;
mod stage;
mod why_not;

use serde::{Deserialize, Serialize};

pub use goals::*;
pub use graph::*;
pub use live::*;
pub use stage::*;
pub use why_not::*;

/// A question or an order from a tool.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// How the daemon and its learner are.
    Status,
    /// A list of schemas.
    Schemas(SchemaQuery),
    /// One schema whole.
    Show {
        /// Its number.
        id: u32,
    },
    /// Why an action was chosen.
    Explain {
        /// The decision of this step; the last decision when none is named.
        step: Option<u64>,
        /// Candidates to list, the most excited first.
        candidates_max: u32,
    },
    /// Words are heard, with the next frame.
    Say {
        /// The words, in order.
        words: Vec<String>,
    },
    /// Developmental control.
    Stage(StageOrder),
    /// What the curriculum has done so far.
    Report,
    /// End the daemon, cleanly.
    Shutdown,
    /// What was decided in each step, page by page.
    Trace {
        /// The number of the first record wanted, from 0 in the order in which they were kept.
        from: u64,
    },
    /// What an action would do in the world as it is.
    Predict {
        /// The action, as it prints: `move(j1=0.426, j2=0.817)`.
        action: String,
    },
    /// How a goal could be brought about from the world as it is.
    Plan {
        /// A pattern for each thing wanted, as it prints: `object{colour=blue, field=$x}`.
        goal: Vec<String>,
    },
    /// A goal is to be brought about.
    Achieve {
        /// A pattern for each thing wanted.
        goal: Vec<String>,
        /// Actions that it may take.
        actions_max: u32,
    },
    /// How the goal is doing that is pursued, or was the last to be.
    Pursuit,
    /// The goal of this number is to be pursued no more, if it still is.
    Cancel {
        /// Its number.
        number: u64,
    },
    /// All that somebody who watches is shown.
    Live(LiveQuery),
    /// Schemas and what ties them together.
    Graph(GraphQuery),
    /// Why a schema was not executed.
    WhyNot {
        /// Its number.
        schema: u32,
        /// In this step; in the last decision when none is named.
        step: Option<u64>,
    },
}

/// Which schemas to list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemaQuery {
    /// Only those whose action has this name.
    pub action: Option<String>,
    /// Only those with a pre-condition that this pattern matches, as it prints: `object{colour=blue}`.
    pub pre: Option<String>,
    /// Only those with a post-condition that this pattern matches.
    pub post: Option<String>,
    /// Only generalised ones.
    pub generalised: bool,
    /// The order.
    pub sort: SchemaSort,
    /// At most this many; 0 for the daemon's limit.
    pub limit: u32,
    /// Leave out so many of the first in that order: those of the pages before.
    pub offset: u32,
}

/// In which order to list schemas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SchemaSort {
    /// The oldest first.
    #[default]
    Age,
    /// The most executed first.
    Uses,
    /// The most reliable first: by the lower end of the interval.
    Probability,
    /// The most excited in the last decision first.
    Excitation,
}

/// An order to the curriculum.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StageOrder {
    /// Say where it stands.
    Show,
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

/// The answer to a [`Request`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// To [`Request::Status`].
    Status(Box<Status>),
    /// To [`Request::Schemas`].
    Schemas(SchemaList),
    /// To [`Request::Show`].
    Schema(Box<SchemaDetail>),
    /// To [`Request::Explain`].
    Explanation(Box<Explanation>),
    /// To [`Request::Say`], [`Request::Stage`] and [`Request::Report`].
    Report(Box<Report>),
    /// The request was obeyed.
    Done,
    /// It can't be answered, and why.
    Error(String),
    /// To [`Request::Trace`].
    Trace(Box<TracePage>),
    /// To [`Request::Predict`].
    Prediction(Box<Prediction>),
    /// To [`Request::Plan`].
    Plan(Box<Plan>),
    /// To [`Request::Achieve`], [`Request::Pursuit`] and [`Request::Cancel`].
    Pursuit(Box<Pursuit>),
    /// To [`Request::Live`].
    Live(Box<Live>),
    /// To [`Request::Graph`].
    Graph(Box<Graph>),
    /// To [`Request::WhyNot`].
    WhyNot(Box<WhyNot>),
}

/// How a daemon and its learner are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// The learner's name.
    pub name: String,
    /// The daemon's process.
    pub pid: u32,
    /// Since its start.
    pub uptime_s: f64,
    /// Steps taken in the life of this memory.
    pub step: u64,
    /// The last step known to be on disk; none while memory is kept in RAM only.
    pub durable_step: Option<u64>,
    /// The curriculum.
    pub curriculum: String,
    /// The present stage.
    pub stage: String,
    /// What it is doing: `acting`, `saturated`, `habituating`, `held`, `finished`, `waiting for a body`, or
    /// why it is stuck.
    pub stage_state: String,
    /// How near the stage is to saturation; none where it does not end so, or the curriculum is over.
    pub saturation: Option<SaturationStatus>,
    /// What the stage asks of its schemas once it is saturated; none where it asks nothing, or the curriculum is over.
    pub habituation: Option<HabituationStatus>,
    /// The present trial; none where the stage has none, or the curriculum is over.
    pub trial: Option<TrialStatus>,
    /// Schemas in memory.
    pub schemas_total: u32,
    /// Those with constants only.
    pub schemas_concrete: u32,
    /// Those with variables.
    pub schemas_generalised: u32,
    /// Bodies attached now or before.
    pub bodies: Vec<BodyStatus>,
    /// Steps a second, over the last 10 seconds.
    pub steps_per_s: f64,
    /// Time of a decision (a frame's arrival to the action chosen), median of the last 4,096.
    pub step_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub step_latency_us_p99: f64,
    /// From a frame's arrival until its reply has left: with memory on disk, once the step is durable. Median of the
    /// last 4,096.
    pub commit_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub commit_latency_us_p99: f64,
    /// Resident memory of the daemon.
    pub memory_bytes: u64,
    /// What steps cost as memory grew, since the daemon began: a row for each doubling of the schemas, the smallest first.
    pub growth: Vec<Growth>,
    /// Digest of everything learnt: equal digests are equal memories.
    pub memory_digest: String,
    /// Top excitation of the last decision.
    pub excitation_top: f64,
    /// What is perceived now, as it prints.
    pub world: Vec<String>,
    /// The goal that is pursued, if any.
    pub goal: Option<GoalSummary>,
    /// How memory is kept; none while it is in RAM only.
    pub storage: Option<Storage>,
    /// Messages of bodies and tools that were refused since the daemon began, by reason; only those that there were.
    pub refused: Vec<RefusalCount>,
}

/// What steps cost while memory had from `schemas` up to twice as many of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Growth {
    /// Schemas from which on this row counts: 0, 2, 4, 8 …
    pub schemas: u32,
    /// Steps.
    pub steps: u64,
    /// Time of a decision, median of all of them, to within a sixteenth.
    pub step_latency_us_p50: f64,
    /// The same, 99th percentile.
    pub step_latency_us_p99: f64,
    /// Resident memory of the daemon when the first of these steps was taken.
    pub memory_bytes: u64,
}

/// How many messages were refused for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RefusalCount {
    /// The number of the refusal, as in `docs/PROTOCOL.md`.
    pub code: u32,
    /// What it is about, in a word or two.
    pub reason: String,
    /// How many.
    pub count: u64,
}

/// How memory is kept on disk.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Storage {
    /// The data directory.
    pub directory: String,
    /// When an action may leave: `strict`, when the step that chose it is on disk; `relaxed`, at once.
    pub durability: String,
    /// The last step known to be on disk.
    pub durable_step: u64,
    /// Bytes of journal there are.
    pub journal_bytes: u64,
    /// The oldest step that memory can be returned to.
    pub oldest_step: u64,
    /// The step of the last snapshot; none before the first.
    pub snapshot_step: Option<u64>,
}

/// A body as the daemon sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyStatus {
    /// Its session number.
    pub id: u64,
    /// Its name.
    pub name: String,
    /// Its kind.
    pub kind: String,
    /// Its process.
    pub pid: u32,
    /// `attached`, `left`, `lost`.
    pub state: String,
    /// Frames accepted.
    pub frames: u64,
    /// Frames refused.
    pub frames_refused: u64,
    /// Why the last one was refused.
    pub last_refusal: Option<String>,
}

/// A list of schemas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SchemaList {
    /// How many fit, listed or not.
    pub matching: u32,
    /// Those listed.
    pub schemas: Vec<SchemaSummary>,
}

/// One line of a list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SchemaSummary {
    /// Its number.
    pub id: u32,
    /// `concrete`, `generalised`, `retired`, `counter-example`.
    pub kind: String,
    /// Pre-conditions as they print.
    pub pre: Vec<String>,
    /// Action (or target action) as it prints.
    pub action: String,
    /// Post-conditions as they print.
    pub post: Vec<String>,
    /// Executions.
    pub executions: u32,
    /// Executions in which all it predicts happened.
    pub successes: u32,
    /// Share of successes; with `low` and `high`, its 95 % interval.
    pub probability: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

/// An observation or pattern in JSON: `{"type": "object", "properties": {"colour": "blue", "field": 4}}`; a
/// variable is `{"var": "a"}`. (On the wire it is a list of pairs: the codec is not self-describing.)
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObservationText {
    /// Its type's name.
    pub kind: String,
    /// Property names and values.
    pub properties: Vec<(String, ValueText)>,
}

/// A value in JSON.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum ValueText {
    /// A whole number.
    Integer(i64),
    /// A symbol.
    Symbol(String),
    /// True or false.
    Boolean(bool),
    /// The middle of a real's bin.
    Real(f64),
    /// A variable's name, without the `$`.
    Variable(String),
}

/// One schema whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SchemaDetail {
    /// Its number.
    pub id: u32,
    /// `concrete`, `generalised`, `retired`, `counter-example`.
    pub kind: String,
    /// The primitive as it prints, or the target's observations.
    pub action: String,
    /// The target action of a generalised schema.
    pub target: Vec<ObservationText>,
    /// Pre-conditions.
    pub pre: Vec<ObservationText>,
    /// Post-conditions.
    pub post: Vec<Condition>,
    /// Associated observations.
    pub associated: Vec<Condition>,
    /// Executions.
    pub executions: u32,
    /// Successes.
    pub successes: u32,
    /// Share of successes.
    pub probability: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
    /// The schema whose execution led to it.
    pub parent: Option<u32>,
    /// The generalised schema that it is a counter-example to.
    pub contradicts: Option<u32>,
    /// Generalised schemas that count it as an example (or, of a generalised one, its examples).
    pub examples: Vec<u32>,
    /// Counter-examples of a generalised schema.
    pub counter_examples: Vec<u32>,
    /// The step that made it.
    pub created_step: u64,
}

/// A condition with its statistics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Condition {
    /// What is observed.
    pub observation: ObservationText,
    /// True for "no longer observed".
    pub absent: bool,
    /// How often it held.
    pub occurrences: u32,
    /// Of how often it could have.
    pub trials: u32,
    /// Their ratio.
    pub probability: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
}

/// Why an action was chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Explanation {
    /// The step.
    pub step: u64,
    /// The body that was sent to act.
    pub body: String,
    /// What was perceived.
    pub world: Vec<ObservationText>,
    /// The chosen candidate, as an index into `candidates` (it is always listed).
    pub chosen: u32,
    /// The primitive sent, as it prints.
    pub action: String,
    /// `excitation`, `chain` (the next schema of a chain begun before), `tie` (drawn among equals), `goal` (the
    /// next schema of a plan for a goal).
    pub reason: String,
    /// How many candidates had the top excitation.
    pub ties: u32,
    /// Candidates with any excitation, listed or not.
    pub candidates_total: u32,
    /// The candidates, the most excited first.
    pub candidates: Vec<Candidate>,
    /// The goal that it follows, when that is the reason.
    pub goal: Option<GoalFollowed>,
}

/// Something that could have been done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The schema; none for a primitive that no schema covers here.
    pub schema: Option<u32>,
    /// The schema, or primitive, as it prints.
    pub text: String,
    /// Values of its variables.
    pub binding: Vec<(String, ValueText)>,
    /// d of equation (1): schemas to be executed, this one included.
    pub distance: u32,
    /// E of equation (1): the sum of the terms' `value` over `distance`.
    pub excitation: f64,
    /// The terms of the sum.
    pub terms: Vec<ExcitationTerm>,
}

/// One term of equation (1), or a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExcitationTerm {
    /// Remembered observation; none for a drive.
    pub observation: Option<ObservationText>,
    /// Perceived observation that resembles it; none for a drive.
    pub seen: Option<ObservationText>,
    /// `pre-condition`, `post-condition`, `association`, `babbling`, `habituation`; `rest` for those
    /// that are too many to be told one by one, added up.
    pub role: String,
    /// Properties that the two share.
    pub shared: u32,
    /// N of the remembered observation.
    pub attention: u32,
    /// Probability of the remembered observation in the schema.
    pub probability: f64,
    /// 1 or ω, times the reliability of the action.
    pub weight: f64,
    /// shared × probability × weight / (1 + attention).
    pub value: f64,
}

/// What a curriculum has done so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The curriculum's name.
    pub curriculum: String,
    /// The learner's seed.
    pub seed: u64,
    /// The present stage.
    pub stage: String,
    /// As in [`Status::stage_state`].
    pub stage_state: String,
    /// Whether the last stage is over.
    pub finished: bool,
    /// Why it can't go on, if it can't.
    pub stuck: Option<String>,
    /// Steps taken.
    pub step: u64,
    /// Schemas now.
    pub schemas_total: u32,
    /// Those with constants only.
    pub schemas_concrete: u32,
    /// Those with variables.
    pub schemas_generalised: u32,
    /// Actions carried out in all stages.
    pub actions_total: u64,
    /// Median step latency since the daemon began.
    pub step_latency_us_p50: f64,
    /// 99th percentile of it.
    pub step_latency_us_p99: f64,
    /// Digest of everything learnt, once the curriculum has come to its end: it costs time in proportion to
    /// memory, and those who watch a run ask often. [`Status`] always has it.
    pub memory_digest: Option<String>,
    /// The stages entered so far.
    pub stages: Vec<StageSummary>,
}

/// One stage of a curriculum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageSummary {
    /// Its name.
    pub name: String,
    /// Whether anything was learnt in it, or only measured.
    pub learning: bool,
    /// Actions carried out.
    pub actions: u64,
    /// Schemas made.
    pub schemas_new: u32,
    /// Generalised ones among them.
    pub generalised_new: u32,
    /// Counter-examples among them.
    pub counter_examples_new: u32,
    /// Trials begun.
    pub trials: u32,
    /// Trials that ended with what they were waiting for.
    pub trials_met: u32,
    /// Of these, those that needed one action.
    pub trials_met_first: u32,
    /// Generalised schemas in memory at the end of each trial.
    pub generalised_after_trial: Vec<u32>,
    /// Actions of each trial that is over.
    pub actions_of_trial: Vec<u32>,
    /// What was drawn for each trial (table positions).
    pub drawn: Vec<i64>,
    /// Whether it ended by saturation.
    pub saturated: bool,
    /// Whether it is over.
    pub ended: bool,
}

/// Some of the records that a daemon keeps of its learner's steps, in order. Holds everything a figure of a run
/// is drawn from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracePage {
    /// The number of the first record in `records`. Above the one asked for when that is no longer kept.
    pub from: u64,
    /// How many records there have been; ask on from `from` plus the length of `records` until there.
    pub total: u64,
    /// How many the daemon keeps: the last of them.
    pub kept_max: u64,
    /// Names of the stages, which records refer to by index.
    pub stages: Vec<String>,
    /// The records.
    pub records: Vec<TraceRecord>,
}

/// One step of a learner: what it perceived, what it then decided, and where it stood. The same run has the same
/// records, but for their latencies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceRecord {
    /// The step.
    pub step: u64,
    /// The stage in which it ended, as an index into [`TracePage::stages`].
    pub stage: u32,
    /// The trial of that stage, from 1; 0 before the first and in stages without.
    pub trial: u32,
    /// What was drawn for a trial that this step began.
    pub drawn: Vec<i64>,
    /// Whether the trial that this step ended, if it ended one, ended with what it was waiting for.
    pub trial_met: Option<bool>,
    /// Actions of the student carried out so far.
    pub actions: u64,
    /// Schemas in memory.
    pub schemas_total: u32,
    /// Generalised ones among them.
    pub schemas_generalised: u32,
    /// What was perceived, words included; at most 16 observations.
    pub perceived: Vec<ObservationText>,
    /// Words heard: their observations' symbols.
    pub heard: Vec<String>,
    /// What was decided; none when nothing was chosen, as when the surroundings were to be arranged.
    pub decision: Option<TracedDecision>,
    /// Quiet actions in a row, that before this step included: nothing new and nothing exciting (saturation, paper
    /// II-F). In the step that ends a stage, those of the stage that it ended.
    pub quiet_actions: u32,
    /// Whether the stage is saturated and being habituated to (paper II-G).
    pub habituating: bool,
    /// Time of the step, from the frame decoded to the reply sent.
    pub latency_us: f64,
}

/// What a step decided.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracedDecision {
    /// Excitation of the most excited candidate: the curve of the paper's figure 6.
    pub excitation_top: f64,
    /// Excitation of the chosen candidate.
    pub excitation: f64,
    /// The chosen schema; none for a primitive that no schema covers here.
    pub schema: Option<u32>,
    /// Whether that schema is generalised.
    pub generalised: bool,
    /// d of equation (1): schemas to be executed, the chosen one included.
    pub distance: u32,
    /// The primitive sent, as it prints.
    pub action: String,
    /// `excitation`, `chain`, `tie`, or what else made the choice, as in [`Explanation::reason`].
    pub reason: String,
    /// Types of what the chosen schema predicts to be observed, each once, in alphabetical order.
    pub predicts: Vec<String>,
}
