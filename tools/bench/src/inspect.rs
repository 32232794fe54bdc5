//! How long answers to tools take, by kind of question, and what being asked all the time does to the time of a step: as
//! a daemon does it, with a view taken between two steps and the answer worked out on another thread.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::{Duration, Instant};

use clap::Args;
use pschema_inspect::{
    DetailQuery, ExplanationQuery, GraphQuery, Question, SchemaQuery, SchemaSort, StatusQuery, WhyNotQuery,
};
use pschema_learner::decision::{Decision, Subject};
use pschema_learner::observation::Observation;
use pschema_learner::vocabulary::BodyId;
use pschema_process::say;
use pschema_server::inspect;
use pschema_server::view::View;
use pschema_tools::kit::{Columns, Failure, show};
use serde::Serialize;

use crate::lives::{ascending, size};
use crate::times::Times;
use pschema_worlds::{Mix, World};

/// Steps at a time, with and without questions in turn.
const STEPS: usize = 500;
/// How often each.
const TURNS: usize = 8;
/// What is wanted of a list: so many milliseconds.
const LIST_MS_WANTED: f64 = 100.0;

/// The memories to ask.
#[derive(Debug, Args)]
pub(crate) struct InspectArgs {
    /// What memory is filled with: scenario-1, scenario-3 or wide
    #[arg(long, value_name = "MIX", default_value = "scenario-3")]
    mix: Mix,
    /// Sizes of memory, in schemas; a million takes some minutes
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [20_000], value_parser = size)]
    schemas: Vec<usize>,
    /// How many times each question
    #[arg(long, default_value_t = 9, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=1_000))]
    rounds: u32,
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Times of the answers to one question.
#[derive(Debug, Serialize)]
struct AnswerTimes {
    question: &'static str,
    answer_ms_p50: f64,
    answer_ms_max: f64,
    answer_bytes: usize,
    /// `null` where nothing is wanted of it.
    answer_ms_wanted: Option<f64>,
}

/// Times of answers, and of steps beside them, with a memory of one size.
#[derive(Debug, Serialize)]
struct InspectTimes {
    mix: &'static str,
    schemas: usize,
    observations: usize,
    /// To take a view of memory, between two steps.
    view_us_p50: f64,
    view_us_max: f64,
    questions: Vec<AnswerTimes>,
    step_us_p50: f64,
    step_us_p99: f64,
    /// With a question always under way.
    asked_step_us_p50: f64,
    asked_step_us_p99: f64,
    ratio_p50: f64,
    ratio_p99: f64,
    /// Questions that were answered meanwhile.
    answered: u64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct InspectMeasurement {
    rows: Vec<InspectTimes>,
}

pub(crate) fn run(args: &InspectArgs, quiet: bool) -> Result<(), Failure> {
    let mut life = Life::begin(args.mix, args.seed)?;
    let mut rows = Vec::new();
    for size in ascending(&args.schemas) {
        if !quiet {
            say(&format!("{}: a life up to {size} schemas", args.mix.name()));
        }
        while life.world.schemas() < size {
            life.step();
        }
        rows.push(measured(&mut life, args.mix, args.rounds)?);
    }
    show(args.json, &InspectMeasurement { rows }, text)
}

/// A learner in its world, and what it decided last.
struct Life {
    world: World,
    seed: u64,
    decided: Option<(Decision, (BodyId, Vec<Observation>))>,
}

impl Life {
    fn begin(mix: Mix, seed: u64) -> Result<Self, Failure> {
        Ok(Self { world: World::new(mix, seed).map_err(Failure::of)?, seed, decided: None })
    }

    /// One step; returns how long the learner took.
    fn step(&mut self) -> Duration {
        let frame = self.world.frame();
        let began = Instant::now();
        let step = self.world.learner_mut().step(&frame);
        let took = began.elapsed();
        self.world.follow(&step.output);
        if let Some(decision) = step.decision {
            self.decided = Some((decision, (frame.body, frame.observations)));
        }
        took
    }

    fn view(&self) -> View {
        let (decision, perceived) = self.decided.clone().unzip();
        View::alone("bench", self.world.learner(), self.seed, decision, perceived)
    }

    /// A schema to ask about: one that was a candidate last, but not the chosen one if there is another.
    fn schema(&self) -> u32 {
        let mut candidates = self.decided.iter().flat_map(|(decision, _)| &decision.candidates).rev();
        let schema = candidates.find_map(|candidate| match candidate.subject {
            Subject::Schema(id) => Some(id.0),
            Subject::Primitive(_) => None,
        });
        schema.unwrap_or(0)
    }
}

/// One question of each kind, and what is wanted of it.
fn questions(schema: u32) -> Vec<(&'static str, Question, Option<f64>)> {
    let list = |query: SchemaQuery| Question::Schemas(SchemaQuery { limit: 100, ..query });
    let pattern = |text: &str| Some(text.to_owned());
    let wanted = Some(LIST_MS_WANTED);
    let (action, pre, post) = (pattern("move"), pattern("object{field=17}"), pattern("touch{}"));
    let finger = pattern("finger{field=$x}");
    let (uses, surest) = (SchemaSort::Uses, SchemaSort::Probability);
    let explain = ExplanationQuery { step: None, candidates_max: 5 };
    let all = GraphQuery { limit: 2_000, ..GraphQuery::default() };
    let around = GraphQuery { around: Some(schema), limit: 200, ..GraphQuery::default() };
    let usual = SchemaQuery::default;
    vec![
        ("status", Question::Status(StatusQuery {}), None),
        ("schemas, the oldest", list(usual()), wanted),
        ("schemas by action", list(SchemaQuery { action, ..usual() }), wanted),
        ("schemas by pre-condition", list(SchemaQuery { pre, ..usual() }), wanted),
        ("schemas by outcome", list(SchemaQuery { post, ..usual() }), wanted),
        (
            "schemas by outcome, the most used",
            list(SchemaQuery { post: finger, sort: uses, ..usual() }),
            wanted,
        ),
        ("schemas, the surest", list(SchemaQuery { sort: surest, ..usual() }), wanted),
        ("show", Question::Show(DetailQuery { id: schema }), None),
        ("explain", Question::Explain(explain), None),
        ("why not", Question::WhyNot(WhyNotQuery { schema, step: None }), None),
        ("graph, the whole", Question::Graph(all), None),
        ("graph around a schema", Question::Graph(around), None),
    ]
}

fn measured(life: &mut Life, mix: Mix, rounds: u32) -> Result<InspectTimes, Failure> {
    // Of a step that decided something.
    life.step();
    let schemas = life.world.schemas();
    let observations = life.world.learner().memory().content().observations.len();
    let mut asked = Vec::new();
    for (name, question, wanted) in questions(life.schema()) {
        let mut times = Times::default();
        let mut bytes = 0;
        for _ in 0..rounds {
            let view = life.view();
            let began = Instant::now();
            bytes = answered(&view, &question)?;
            times.push(began.elapsed());
        }
        asked.push(AnswerTimes {
            question: name,
            answer_ms_p50: times.p50() / 1e3,
            answer_ms_max: times.at(1.0) / 1e3,
            answer_bytes: bytes,
            answer_ms_wanted: wanted,
        });
    }
    let StepsBeside { alone, beside, views, answered } = beside(life)?;
    Ok(InspectTimes {
        mix: mix.name(),
        schemas,
        observations,
        view_us_p50: views.p50(),
        view_us_max: views.at(1.0),
        questions: asked,
        step_us_p50: alone.p50(),
        step_us_p99: alone.p99(),
        asked_step_us_p50: beside.p50(),
        asked_step_us_p99: beside.p99(),
        ratio_p50: beside.p50() / alone.p50(),
        ratio_p99: beside.p99() / alone.p99(),
        answered,
    })
}

/// How long the answer is, as a tool gets it.
fn answered(view: &View, question: &Question) -> Result<usize, Failure> {
    let reply = inspect::reply(view, question);
    if reply.starts_with(b"{\"problem\":") {
        return Err(Failure::Failed(format!("{question:?}: {}", String::from_utf8_lossy(&reply))));
    }
    Ok(reply.len())
}

/// Times of steps without questions, of steps with questions, and of the views that those were answered from.
struct StepsBeside {
    alone: Times,
    beside: Times,
    views: Times,
    answered: u64,
}

/// Steps without and with questions in turn, so that both see the same memory and the same machine.
fn beside(life: &mut Life) -> Result<StepsBeside, Failure> {
    let (jobs, questions) = sync_channel::<(View, Question)>(1);
    let idle = AtomicBool::new(true);
    std::thread::scope(|scope| {
        let idle = &idle;
        let inspector = scope.spawn(move || serve(&questions, idle));
        let (mut alone, mut beside, mut views) = (Times::default(), Times::default(), Times::default());
        for _ in 0..TURNS {
            (0..STEPS).for_each(|_| alone.push(life.step()));
            for _ in 0..STEPS {
                ask(life, &jobs, idle, &mut views);
                beside.push(life.step());
            }
        }
        drop(jobs);
        let answered = inspector.join().map_err(|_| Failure::Failed("answering panicked".to_owned()))??;
        Ok(StepsBeside { alone, beside, views, answered })
    })
}

/// Asks the next question if nobody waits for an answer.
fn ask(life: &Life, jobs: &SyncSender<(View, Question)>, idle: &AtomicBool, views: &mut Times) {
    if !idle.swap(false, Ordering::AcqRel) {
        return;
    }
    let kinds = questions(life.schema());
    let next = views.len() % kinds.len();
    let Some((_, question, _)) = kinds.into_iter().nth(next) else { return };
    let began = Instant::now();
    let view = life.view();
    views.push(began.elapsed());
    // If the other thread is gone, it says why when it is joined.
    jobs.send((view, question)).ok();
}

fn serve(questions: &Receiver<(View, Question)>, idle: &AtomicBool) -> Result<u64, Failure> {
    let mut count = 0;
    while let Ok((view, question)) = questions.recv() {
        answered(&view, &question)?;
        drop(view);
        count += 1;
        idle.store(true, Ordering::Release);
    }
    Ok(count)
}

fn text(measurement: &InspectMeasurement) -> String {
    let mut text = String::new();
    for row in &measurement.rows {
        text.push_str(&format!(
            "{}, {} schemas, {} observations\n\n",
            row.mix, row.schemas, row.observations
        ));
        let mut table =
            Columns::new(&["question", "answer p50", "max", "wanted", "bytes"]).figures(&[1, 2, 3, 4]);
        for asked in &row.questions {
            table.row([
                asked.question.to_owned(),
                format!("{:.2} ms", asked.answer_ms_p50),
                format!("{:.2} ms", asked.answer_ms_max),
                asked.answer_ms_wanted.map_or(String::new(), |wanted| format!("< {wanted:.0} ms")),
                asked.answer_bytes.to_string(),
            ]);
        }
        text.push_str(&table.text(&[0, 1, 2, 3, 4]));
        text.push_str(&format!(
            "\nA step takes {:.1} us, p99 {:.1}; with a question always under way {:.1} and {:.1}:\n\
             {:.2} and {:.2} times as long ({} answered). A view takes {:.1} us, at most {:.1}.\n\n",
            row.step_us_p50,
            row.step_us_p99,
            row.asked_step_us_p50,
            row.asked_step_us_p99,
            row.ratio_p50,
            row.ratio_p99,
            row.answered,
            row.view_us_p50,
            row.view_us_max
        ));
    }
    text
}

#[cfg(test)]
mod tests;
