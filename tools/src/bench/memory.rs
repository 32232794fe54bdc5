//! How many bytes a schema takes in RAM, everything included that makes it fast to ask, as memory grows: the lives of
//! `worlds.rs`. Beside it what the same schemas take as plain structures that share nothing and that nothing finds again but
//! by looking through all of them: what memory would be without an index. Both are measured as what the process grows by,
//! so that what an allocator adds is in both.

use std::collections::BTreeMap;

use pschema_learner::memory::Content;
use pschema_learner::observation::{Observation, Pattern};
use pschema_learner::probability::Count;
use pschema_learner::schema::{Form, Schema, SchemaId};
use pschema_learner::vocabulary::PrimitiveId;
use serde::{Deserialize, Serialize};

use super::alone;
use super::worlds::{Mix, World, resident_bytes, schemas};
use crate::cli::BenchDecisionArgs;
use crate::failure::Failure;
use crate::output;
use crate::render::table::Columns;
use crate::talk;

/// The smallest memory that says anything about bytes: below it, what a process needs anyway weighs as much.
const LEAST: usize = 10_000;
/// Schemas that are copied into plain structures at most: those of a large memory, evenly chosen.
const COPIED_MAX: usize = 50_000;
/// What is wanted: so many bytes a schema, in the mix of scenario 3, from so many schemas on.
const WANTED: (Mix, usize, f64) = (Mix::Scenario3, 1_000_000, 300.0);

#[derive(Debug, Serialize, Deserialize)]
struct Row {
    mix: String,
    schemas: usize,
    generalised: u32,
    observations: usize,
    /// What the process grew by since there was no memory.
    resident_bytes: u64,
    bytes_per_schema: f64,
    /// The same schemas as plain structures.
    plain_bytes_per_schema: f64,
    /// Of the one to the other.
    ratio: f64,
    bytes_per_schema_wanted: Option<f64>,
}

/// What `--json` prints.
#[derive(Debug, Serialize, Deserialize)]
struct Figures {
    rows: Vec<Row>,
    /// By mix: the exponent of the power of the number of schemas that all bytes grow by, 1 where each takes as much as
    /// the one before; `null` where only one size was measured.
    growth_exponent: BTreeMap<String, Option<f64>>,
}

pub(super) fn run(args: &BenchDecisionArgs, quiet: bool) -> Result<(), Failure> {
    let mut sizes: Vec<_> = args.schemas.iter().copied().filter(|size| *size >= LEAST).collect();
    sizes.sort_unstable();
    sizes.dedup();
    if sizes.is_empty() {
        let told =
            format!("below {LEAST} schemas bytes a schema say nothing: give larger sizes with --schemas");
        return Err(Failure::Usage(told));
    }
    let mut figures = Figures { rows: Vec::new(), growth_exponent: BTreeMap::new() };
    match Mix::ALL.into_iter().find(|mix| args.mix.as_deref() == Some(mix.name())) {
        Some(mix) => {
            if !quiet {
                talk::say(&format!("{}: a life up to {} schemas", mix.name(), sizes.last().unwrap_or(&0)));
            }
            figures.rows = life(mix, &sizes, args.seed)?;
            figures.growth_exponent.insert(mix.name().to_owned(), exponent(&figures.rows));
        }
        // What one life leaves behind in an allocator is not the next one's.
        None => {
            for mix in Mix::ALL {
                let Figures { rows, growth_exponent } = alone("memory", mix, &sizes, args.seed, quiet)?;
                figures.rows.extend(rows);
                figures.growth_exponent.extend(growth_exponent);
            }
        }
    }
    if args.json { output::print_json(&figures) } else { output::print(&text(&figures)) }
}

/// One life, measured whenever memory has come to one of `sizes`.
fn life(mix: Mix, sizes: &[usize], seed: u64) -> Result<Vec<Row>, Failure> {
    let unknown = || Failure::Failed("this system does not say how much memory a process has".to_owned());
    let before = resident_bytes().ok_or_else(unknown)?;
    let mut world = World::new(mix, seed).map_err(Failure::of)?;
    let mut rows = Vec::new();
    // What was copied stays, for it would leave room behind in which memory grows on unseen.
    let mut copies: Vec<Vec<Plain>> = Vec::new();
    let mut copied = 0;
    for size in sizes {
        while schemas(&world) < *size {
            let frame = world.frame();
            let step = world.learner_mut().step(&frame);
            world.follow(&step.output);
        }
        let content = world.learner().memory().content();
        let count = content.schemas.len();
        let alive = resident_bytes().ok_or_else(unknown)?;
        let grown = alive.saturating_sub(before).saturating_sub(copied);
        let every = count.div_ceil(COPIED_MAX);
        let plain: Vec<_> =
            content.schemas.iter().step_by(every).map(|schema| Plain::new(content, schema)).collect();
        let for_copy = resident_bytes().ok_or_else(unknown)?.saturating_sub(alive);
        copied += for_copy;
        let (bytes, plain_bytes) = (grown as f64 / count as f64, for_copy as f64 / plain.len() as f64);
        copies.push(plain);
        let (of, from, wanted) = WANTED;
        rows.push(Row {
            mix: mix.name().to_owned(),
            schemas: count,
            generalised: content.generalised_count,
            observations: content.observations.len(),
            resident_bytes: grown,
            bytes_per_schema: bytes,
            plain_bytes_per_schema: plain_bytes,
            ratio: bytes / plain_bytes,
            bytes_per_schema_wanted: (of == mix && count >= from).then_some(wanted),
        });
    }
    // Read once, so that nothing of it can be left out.
    let kept: usize = copies.iter().flatten().map(Plain::conditions).sum();
    if kept == 0 {
        return Err(Failure::Failed(format!("{}: not one schema has a condition", mix.name())));
    }
    Ok(rows)
}

/// A schema as a plain structure.
struct Plain {
    pre: Vec<Pattern>,
    action: Option<PrimitiveId>,
    target: Vec<Pattern>,
    post: Vec<(Pattern, bool, Count)>,
    associations: Vec<(Observation, Count, u64)>,
    executions: Count,
    parent: Option<SchemaId>,
    created_step: u64,
}

impl Plain {
    fn new(content: &Content, schema: &Schema) -> Self {
        let pattern = |id| Pattern::from(content.observation(id));
        let association = |known: &pschema_learner::schema::Association| {
            let observation = content.observation(known.observation);
            let own = Observation::new(observation.kind(), observation.properties().iter().copied());
            (own, known.count, known.since_step)
        };
        let (pre, action, target, post) = match &schema.form {
            Form::Concrete(concrete) => {
                let post = concrete.post.iter().map(|p| (pattern(p.what), p.absent, p.count)).collect();
                let pre = concrete.pre.iter().map(|id| pattern(*id)).collect();
                (pre, Some(concrete.action), Vec::new(), post)
            }
            Form::Generalised(general) => {
                let post = general.post.iter().map(|p| (p.what.clone(), p.absent, p.count)).collect();
                (general.pre.to_vec(), None, general.target.to_vec(), post)
            }
        };
        Self {
            pre,
            action,
            target,
            post,
            associations: schema.associations.iter().map(association).collect(),
            executions: schema.executions,
            parent: schema.parent,
            created_step: schema.created_step,
        }
    }

    /// How many conditions it has, and by the way everything else.
    fn conditions(&self) -> usize {
        let rest = (self.action, self.parent, self.created_step, self.executions);
        let none = (None, None, u64::MAX, Count::default());
        let counted = self.pre.len() + self.target.len() + self.post.len() + self.associations.len();
        counted + usize::from(rest == none)
    }
}

/// The exponent of growth from the smallest to the largest memory.
fn exponent(rows: &[Row]) -> Option<f64> {
    let (from, to) = (rows.first()?, rows.last()?);
    let times = to.schemas as f64 / from.schemas as f64;
    (times > 1.5).then(|| (to.resident_bytes as f64 / from.resident_bytes as f64).ln() / times.ln())
}

fn text(figures: &Figures) -> String {
    let headings = ["mix", "schemas", "laws", "observations", "bytes/schema", "wanted", "plain", "ratio"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5, 6, 7]);
    for row in &figures.rows {
        table.row([
            row.mix.clone(),
            row.schemas.to_string(),
            row.generalised.to_string(),
            row.observations.to_string(),
            format!("{:.0}", row.bytes_per_schema),
            row.bytes_per_schema_wanted.map_or(String::new(), |wanted| format!("<= {wanted:.0}")),
            format!("{:.0}", row.plain_bytes_per_schema),
            format!("{:.2}", row.ratio),
        ]);
    }
    let mut text = table.text(&[0]);
    for (mix, exponent) in &figures.growth_exponent {
        if let Some(exponent) = exponent {
            text.push_str(&format!("{mix}: all bytes grow with schemas to the power of {exponent:.2}\n"));
        }
    }
    text
}
