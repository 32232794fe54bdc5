//! How many bytes a schema takes in RAM, everything included that makes it fast to ask, as memory grows: the lives of
//! `pschema-worlds`. Beside it what the same schemas take as plain structures that share nothing and that nothing finds again but
//! by looking through all of them: what memory would be without an index. Both are measured as what the process grows by,
//! so that what an allocator adds is in both.

use pschema_learner::memory::Content;
use pschema_learner::observation::{Observation, Pattern};
use pschema_learner::probability::Count;
use pschema_learner::schema::{Form, Schema, SchemaId};
use pschema_learner::vocabulary::PrimitiveId;
use pschema_tools::kit::{Columns, Failure, show};
use serde::{Deserialize, Serialize};

use crate::lives::{Lives, LivesArgs, OfLife, growth, lives, resident_bytes};
use pschema_worlds::{Mix, World};

/// Schemas that are copied into plain structures at most: those of a large memory, evenly chosen.
const COPIED_MAX: usize = 50_000;
/// What is wanted: so many bytes a schema, in the mix of scenario 3, from so many schemas on.
const WANTED: (Mix, usize, f64) = (Mix::Scenario3, 1_000_000, 300.0);

/// The size of one memory.
#[derive(Debug, Serialize, Deserialize)]
struct MemorySize {
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

pub(crate) fn run(args: &LivesArgs, quiet: bool) -> Result<(), Failure> {
    show(args.json, &lives(args, quiet)?, text)
}

impl OfLife for MemorySize {
    const COMMAND: &'static str = "memory";
    /// Below it, what a process needs anyway weighs as much.
    const SCHEMAS_MIN: usize = 10_000;

    fn life(mix: Mix, sizes: &[usize], seed: u64) -> Result<Vec<Self>, Failure> {
        let unknown = || Failure::Failed("this system does not say how much memory a process has".to_owned());
        let before = resident_bytes().ok_or_else(unknown)?;
        let mut world = World::new(mix, seed).map_err(Failure::of)?;
        let mut rows = Vec::new();
        // What was copied stays, for it would leave room behind in which memory grows on unseen.
        let mut copies: Vec<Vec<Plain>> = Vec::new();
        let mut copied = 0;
        for size in sizes {
            while world.schemas() < *size {
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
            rows.push(Self {
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

    /// Of all bytes, from the smallest to the largest memory.
    fn exponent(life: &[Self]) -> Option<f64> {
        let (from, to) = (life.first()?, life.last()?);
        let schemas = to.schemas as f64 / from.schemas as f64;
        growth(from.resident_bytes as f64, to.resident_bytes as f64, schemas)
    }
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

fn text(measurement: &Lives<MemorySize>) -> String {
    let headings = ["mix", "schemas", "laws", "observations", "bytes/schema", "wanted", "plain", "ratio"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5, 6, 7]);
    for row in &measurement.rows {
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
    for (mix, exponent) in &measurement.growth_exponent {
        if let Some(exponent) = exponent {
            text.push_str(&format!("{mix}: all bytes grow with schemas to the power of {exponent:.2}\n"));
        }
    }
    text
}
