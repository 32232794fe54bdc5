//! How well the learner foretells what its actions bring about, in the exact worlds of `pschema-exact`, beside the truth, "nothing changes"
//! and a table of the first order.

pub(crate) mod foretelling;
mod lexicon;
mod life;
mod returning;
pub(crate) mod student;

use clap::Args;
use pschema_learner::mechanisms::Mechanisms;
use pschema_process::say;
use pschema_tools::kit::{Columns, Failure, Seeds, Summary, interval, show, summary};
use serde::Serialize;

use life::{Distances, Life, Manner, Task};

/// The tasks, in the order in which they are shown.
const TASKS: &[Task<'_>] = &[
    Task::new("flip", Manner::Led, 5_000),
    Task::new("float-reset", Manner::Led, 10_000),
    Task::new("modified-float-reset", Manner::Led, 10_000),
    Task::new("gripper", Manner::Scattered, 800),
    Task { tested: Some("gripper:blocks=7"), ..Task::new("gripper", Manner::Scattered, 800) },
    Task::new("grid", Manner::Own, 2_000),
    Task::new("cart", Manner::Led, 500),
    Task::new("cart:sensors=3", Manner::Led, 500),
    Task::new("lamps:lamps=0", Manner::Own, 500),
    Task::new("lamps:bystanders=4", Manner::Own, 500),
    Task::new("lamps", Manner::Own, 500),
    Task::new("lamps:lamps=8", Manner::Own, 500),
    Task::new("one-kind", Manner::Own, 500),
    Task::new("one-kind:felt_percent=80", Manner::Own, 500),
    Task::new("push", Manner::Own, 500),
    Task::new("posture", Manner::Own, 500),
    Task { returning: Some("glance"), ..Task::new("hand-eye", Manner::Own, 2_500) },
];

/// The tasks to measure.
#[derive(Debug, Args)]
pub(crate) struct TasksArgs {
    /// Only the tasks in this world; or, with numbers, in just this one: gripper:blocks=5
    #[arg(long, value_name = "WORLD", value_parser = known)]
    world: Option<String>,
    #[command(flatten)]
    lives: LivesAsked,
}

/// The lives that are asked for, and how they are shown.
#[derive(Debug, Args)]
pub(crate) struct LivesAsked {
    /// The seeds, each of which is a life in each world or environment
    #[arg(long, value_name = "A..B", default_value = "1..20")]
    pub(crate) seeds: Seeds,
    /// A mechanism of the full profile that is off. May be given several times
    #[arg(long, value_name = "MECHANISM", value_parser = known_mechanism)]
    without: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

impl LivesAsked {
    /// The full profile without the mechanisms that are off, and those that need them.
    pub(crate) fn mechanisms(&self) -> Mechanisms {
        let mut full = Mechanisms::FULL;
        for name in &self.without {
            full.switch(name).into_iter().for_each(|switch| *switch = false);
        }
        full.sound()
    }
}

/// The name of a mechanism.
fn known_mechanism(text: &str) -> Result<String, String> {
    let mut full = Mechanisms::FULL;
    let known = full.named().map(|(known, _)| known).join(", ");
    full.switch(text).map(|_| text.to_owned()).ok_or(format!("there is no such mechanism; there are {known}"))
}

/// A world that there is.
fn known(text: &str) -> Result<String, String> {
    pschema_exact::open(text, 0).map(|_| text.to_owned()).map_err(|error| error.to_string())
}

/// A figure over all seeds.
#[derive(Debug, Serialize)]
pub(crate) struct FigureSummary {
    pub(crate) median: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl From<Summary> for FigureSummary {
    fn from(Summary { median, low, high, .. }: Summary) -> Self {
        Self { median, low, high }
    }
}

/// Distances from the truth after so many actions.
#[derive(Debug, Serialize)]
struct Stand {
    actions: usize,
    ours: FigureSummary,
    first_order: FigureSummary,
}

/// One task, over all seeds.
#[derive(Debug, Serialize)]
struct TaskFigures {
    world: String,
    tested_in: String,
    actions: usize,
    figure: &'static str,
    ours: FigureSummary,
    paper: FigureSummary,
    bound: f64,
    nothing_changes: f64,
    first_order: FigureSummary,
    schemas: f64,
    laws: f64,
    step_us: f64,
    paper_schemas: f64,
    paper_step_us: f64,
    course: Vec<Stand>,
    senses: Vec<SenseFigures>,
    returned: Option<ReturnFigures>,
}

/// How far what is foretold of one sense is from the truth at the end.
#[derive(Debug, Serialize)]
struct SenseFigures {
    sense: String,
    ours: FigureSummary,
}

/// With what probability it is expected that what was there before a sense changed is there when it changes back, and what was not.
#[derive(Debug, Serialize)]
struct ReturnFigures {
    sense: String,
    there: FigureSummary,
    elsewhere: FigureSummary,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct TasksMeasurement {
    seeds: usize,
    /// The mechanisms that are on in `ours`.
    mechanisms: Vec<&'static str>,
    rows: Vec<TaskFigures>,
}

pub(crate) fn run(args: &TasksArgs, quiet: bool) -> Result<(), Failure> {
    let seeds: Vec<u64> = args.lives.seeds.iter().collect();
    let mut rows = Vec::new();
    let ours = args.lives.mechanisms();
    for task in chosen(args.world.as_deref()) {
        if !quiet {
            say(&format!("{}: {} lives of {} actions", task.title(), seeds.len(), task.actions));
        }
        let lives = |mechanisms| -> Result<Vec<_>, Failure> {
            seeds.iter().map(|seed| life::live(&task, *seed, mechanisms)).collect()
        };
        rows.extend(figures(&task, &lives(ours)?, &lives(Mechanisms::PAPER)?));
    }
    let mechanisms = ours.named().into_iter().filter_map(|(name, on)| on.then_some(name)).collect();
    show(args.lives.json, &TasksMeasurement { seeds: seeds.len(), mechanisms, rows }, text)
}

/// The tasks in `world`, or all of them. A world with other numbers is lived in as its kind is.
fn chosen(world: Option<&str>) -> Vec<Task<'_>> {
    let Some(world) = world else { return TASKS.to_vec() };
    let kind = |text: &str| pschema_exact::kind(text).map(|entry| entry.name);
    let of_kind = TASKS.iter().filter(|task| kind(task.world) == kind(world));
    match world.contains(':') {
        true => of_kind.take(1).map(|task| Task { world, tested: None, ..*task }).collect(),
        false => of_kind.copied().collect(),
    }
}

/// The figures of a task, by lives under the full profile and `of_the_paper`; none when there was no life.
fn figures(task: &Task<'_>, lives: &[Life], of_the_paper: &[Life]) -> Option<TaskFigures> {
    let over = |lives: &[Life], figure: &dyn Fn(&Life) -> f64| {
        summary(lives.iter().map(figure).collect()).map(FigureSummary::from)
    };
    let median = |lives, figure: &dyn Fn(&Life) -> f64| over(lives, figure).map(|figure| figure.median);
    let course = (0..lives.first()?.course.len()).map(|at| {
        let stand = |figure: fn(&Distances) -> f64| {
            over(lives, &|life: &Life| life.course.get(at).map_or(0.0, figure))
        };
        let actions = lives.first()?.course.get(at)?.actions;
        Some(Stand { actions, ours: stand(|d| d.ours)?, first_order: stand(|d| d.first_order)? })
    });
    let senses = lives.first()?.senses.iter().enumerate().map(|(at, first)| {
        let ours = over(lives, &|life: &Life| life.senses.get(at).map_or(0.0, |sense| sense.ours))?;
        Some(SenseFigures { sense: first.sense.clone(), ours })
    });
    let last = |lives, figure: fn(&Distances) -> f64| {
        over(lives, &|life: &Life| life.course.last().map_or(0.0, figure))
    };
    Some(TaskFigures {
        world: task.world.to_owned(),
        tested_in: task.tested.unwrap_or(task.world).to_owned(),
        actions: task.actions,
        figure: lives.first()?.figure,
        ours: last(lives, |d| d.ours)?,
        paper: last(of_the_paper, |d| d.ours)?,
        bound: last(lives, |d| d.bound)?.median,
        nothing_changes: last(lives, |d| d.nothing_changes)?.median,
        first_order: last(lives, |d| d.first_order)?,
        schemas: median(lives, &|life: &Life| life.schemas as f64)?,
        laws: median(lives, &|life: &Life| life.laws as f64)?,
        step_us: median(lives, &|life: &Life| life.step_us)?,
        paper_schemas: median(of_the_paper, &|life: &Life| life.schemas as f64)?,
        paper_step_us: median(of_the_paper, &|life: &Life| life.step_us)?,
        course: course.collect::<Option<_>>()?,
        senses: senses.collect::<Option<_>>()?,
        returned: returned(task, lives),
    })
}

/// What was expected at returns, over the lives in which there were any.
fn returned(task: &Task<'_>, lives: &[Life]) -> Option<ReturnFigures> {
    let over = |at: usize| {
        let figures = lives.iter().filter_map(|life| life.returned.map(|figures| figures[at]));
        summary(figures.collect()).map(FigureSummary::from)
    };
    Some(ReturnFigures { sense: task.returning?.to_owned(), there: over(0)?, elsewhere: over(1)? })
}

fn text(measurement: &TasksMeasurement) -> String {
    let headings = ["world", "ours", "interval", "paper", "best", "same", "table", "schemas", "us"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5, 6, 7, 8]);
    // None is above 1: without the 0 before the point a table fits a terminal.
    let share = |figure: f64| format!("{figure:.3}").trim_start_matches('0').to_owned();
    for row in &measurement.rows {
        table.row([
            row.tested_in.clone(),
            share(row.ours.median),
            format!("{}-{}", share(row.ours.low), share(row.ours.high)),
            share(row.paper.median),
            share(row.bound),
            share(row.nothing_changes),
            share(row.first_order.median),
            format!("{:.0}", row.schemas),
            format!("{:.0}", row.step_us),
        ]);
    }
    let told = measurement.rows.iter().filter_map(|row| Some((row, row.returned.as_ref()?)));
    let returns = told.map(|(row, returned)| {
        let ReturnFigures { sense, there, elsewhere } = returned;
        format!(
            "{}: what was there when {sense} was as it will be again is expected there with {}, what was not with {}\n",
            row.world,
            share(there.median),
            share(elsewhere.median)
        )
    });
    let returns: String = returns.collect();
    format!(
        "{}{returns}Total variation from the truth; in flip and float/reset the share of wrong predictions. 0 is perfect.\n\
        ours: the learner with {}, median of {} seeds, with {}; paper: under the paper's profile\n\
        schemas, us: ours without laws, and the time of a step (--json has the paper's as well)\n\
        best: the truth itself; same: nothing ever changes; table: what came of an action after the same observations\n",
        table.text(&[1, 2, 3, 4, 5, 6, 7, 8]),
        measurement.mechanisms.join(", "),
        measurement.seeds,
        interval(measurement.seeds)
    )
}
