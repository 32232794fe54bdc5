//! Memory whole, as a snapshot has it. Everything that refers to something else is checked on the way back: a file
//! must not be able to make a learner look for what is not there.

mod bounds;

use std::ops::Range;
use std::sync::Arc;

use pschema_learner::chunks::Chunks;
use pschema_learner::memory::Content;
use pschema_learner::observation as seen;
use pschema_learner::progress::REPORTS_MAX;
use pschema_learner::random::Random;
use pschema_learner::schema::{self as live, ObservationId, PreConditionInterner, SchemaId};
use pschema_learner::vocabulary::PrimitiveId;
use serde::{Deserialize, Serialize};

use super::effect::Execution;
use super::observation::{Count, Observation, Pattern, back, list};
use super::setting::Setting;
use super::stage::{Progress, Pursuit, StageReport};
use super::vocabulary::{Body, Primitive, Vocabulary};
use super::{Block, Impossible};
pub(crate) use bounds::Bounds;

/// Items in one block: few enough that no block can be longer than a frame.
const BLOCK_LEN: usize = 256;
/// Names in one block.
const NAMES_LEN: usize = 4_096;

/// What there is one of, and how much of the rest follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Facts {
    pub(crate) setting: Setting,
    vocabulary: Vocabulary,
    pending: Vec<Option<Execution>>,
    progress: Progress,
    pursuit: Option<Pursuit>,
    random: u64,
    step: u64,
    generalised_count: u32,
    follow: Follow,
}

/// How much of the rest follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Follow {
    symbols: u64,
    primitives: u64,
    bodies: u64,
    pools: u64,
    reports: u64,
    observations: u64,
    schemas: u64,
}

/// An observation that memory refers to, with its counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Remembered {
    observation: Observation,
    attention: u32,
    happened: u32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PostCondition<T> {
    what: T,
    absent: bool,
    count: Count,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Association {
    observation: u32,
    count: Count,
    since_step: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Form {
    Concrete {
        pre: Vec<u32>,
        action: u32,
        post: Vec<PostCondition<u32>>,
        contradicts: Option<u32>,
    },
    Generalised {
        pre: Vec<Pattern>,
        target: Vec<Pattern>,
        post: Vec<PostCondition<Pattern>>,
        examples: Vec<u32>,
        counter_examples: Vec<u32>,
        retired: bool,
    },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Schema {
    form: Form,
    executions: Count,
    associations: Vec<Association>,
    parent: Option<u32>,
    created_step: u64,
}

impl From<&live::Schema> for Schema {
    fn from(schema: &live::Schema) -> Self {
        let form = match &schema.form {
            live::Form::Concrete(concrete) => Form::Concrete {
                pre: concrete.pre.iter().map(|id| id.0).collect(),
                action: concrete.action.0,
                post: posts(&concrete.post, |id| id.0),
                contradicts: concrete.contradicts.map(|id| id.0),
            },
            live::Form::Generalised(general) => Form::Generalised {
                pre: list(&general.pre),
                target: list(&general.target),
                post: posts(&general.post, |pattern| Pattern::from(pattern)),
                examples: general.examples.iter().map(|id| id.0).collect(),
                counter_examples: general.counter_examples.iter().map(|id| id.0).collect(),
                retired: general.retired,
            },
        };
        let associations = schema.associations.iter().map(|association| Association {
            observation: association.observation.0,
            count: association.count.into(),
            since_step: association.since_step,
        });
        Self {
            form,
            executions: schema.executions.into(),
            associations: associations.collect(),
            parent: schema.parent.map(|id| id.0),
            created_step: schema.created_step,
        }
    }
}

impl From<Schema> for live::Schema {
    fn from(schema: Schema) -> Self {
        let form = match schema.form {
            Form::Concrete { pre, action, post, contradicts } => live::Form::Concrete(live::Concrete {
                pre: pre.into_iter().map(ObservationId).collect(),
                action: PrimitiveId(action),
                post: posts_back(post, ObservationId),
                contradicts: contradicts.map(SchemaId),
            }),
            Form::Generalised { pre, target, post, examples, counter_examples, retired } => {
                live::Form::Generalised(Box::new(live::Generalised {
                    pre: back(pre),
                    target: back(target),
                    post: posts_back(post, seen::Pattern::from),
                    examples: examples.into_iter().map(SchemaId).collect(),
                    counter_examples: counter_examples.into_iter().map(SchemaId).collect(),
                    retired,
                }))
            }
        };
        let associations = schema.associations.into_iter().map(|association| live::Association {
            observation: ObservationId(association.observation),
            count: association.count.into(),
            since_step: association.since_step,
        });
        Self {
            form,
            executions: schema.executions.into(),
            associations: associations.collect(),
            parent: schema.parent.map(SchemaId),
            created_step: schema.created_step,
        }
    }
}

fn posts<A, B>(post: &[live::PostCondition<A>], convert: impl Fn(&A) -> B) -> Vec<PostCondition<B>> {
    let convert = |p: &live::PostCondition<A>| PostCondition {
        what: convert(&p.what),
        absent: p.absent,
        count: p.count.into(),
    };
    post.iter().map(convert).collect()
}

fn posts_back<A, B>(post: Vec<PostCondition<A>>, convert: impl Fn(A) -> B) -> Vec<live::PostCondition<B>> {
    let convert = |p: PostCondition<A>| live::PostCondition {
        what: convert(p.what),
        absent: p.absent,
        count: p.count.into(),
    };
    post.into_iter().map(convert).collect()
}

/// Everything in `content`, block by block, the end with its digest left out.
pub(crate) fn blocks<'a>(content: &'a Content, setting: &Setting) -> impl Iterator<Item = Block> + 'a {
    let vocabulary = &*content.vocabulary;
    let progress = &content.progress;
    let follow = Follow {
        symbols: vocabulary.symbols().len() as u64,
        primitives: vocabulary.primitives().len() as u64,
        bodies: vocabulary.bodies().len() as u64,
        pools: progress.pools.len() as u64,
        reports: progress.reports.len() as u64,
        observations: content.observations.len() as u64,
        schemas: content.schemas.len() as u64,
    };
    let facts = Facts {
        setting: setting.clone(),
        vocabulary: vocabulary.into(),
        pending: content.pending.iter().map(|slot| slot.as_ref().map(|e| Execution::from(&**e))).collect(),
        progress: progress.into(),
        pursuit: content.pursuit.as_ref().map(Pursuit::from),
        random: content.random.state(),
        step: content.step,
        generalised_count: content.generalised_count,
        follow,
    };
    let symbols = vocabulary.symbols().chunks(NAMES_LEN).map(|names| Block::Symbols(names.to_vec()));
    let primitives = starts(vocabulary.primitives().len(), NAMES_LEN).map(|range| {
        let one = |at: usize| {
            let attempts = content.attempts.get(at).copied().unwrap_or_default();
            Some(Primitive::new(vocabulary.primitives().get(at)?, attempts.into()))
        };
        Block::Primitives(range.filter_map(one).collect())
    });
    let bodies = vocabulary.bodies().iter().map(|body| Block::Body(body.into()));
    let pools = progress.pools.iter().map(|pool| Block::Pool(pool.clone()));
    let reports = progress.reports.iter().map(|report| Block::Report(Box::new(report.into())));
    let observations = starts(content.observations.len(), BLOCK_LEN).map(|range| {
        let remembered = range.filter_map(|at| {
            Some(Remembered {
                observation: content.observations.get(at)?.into(),
                attention: content.attention.get(at).copied().unwrap_or(0),
                happened: content.happened.get(at).copied().unwrap_or(0),
            })
        });
        Block::Observations(remembered.collect())
    });
    let schemas = starts(content.schemas.len(), BLOCK_LEN).map(|range| {
        Block::Schemas(range.filter_map(|at| content.schemas.get(at).map(Schema::from)).collect())
    });
    let vocabulary = symbols.chain(primitives).chain(bodies);
    let rest = pools.chain(reports).chain(observations).chain(schemas);
    std::iter::once(Block::Facts(Box::new(facts))).chain(vocabulary).chain(rest)
}

fn starts(len: usize, step: usize) -> impl Iterator<Item = Range<usize>> {
    (0..len).step_by(step).map(move |from| from..(from + step).min(len))
}

/// Memory in the making, from blocks.
#[derive(Debug)]
pub(crate) struct Reading {
    facts: Facts,
    symbols: Vec<String>,
    primitives: Vec<Primitive>,
    bodies: Vec<Body>,
    pools: Vec<Vec<i64>>,
    reports: Vec<StageReport>,
    sharing: PreConditionInterner,
    /// Once all of the vocabulary is there.
    content: Option<(Content, Bounds)>,
}

/// What a snapshot holds.
#[derive(Debug)]
pub(crate) struct Whole {
    pub(crate) content: Content,
    pub(crate) setting: Setting,
}

fn sound(sound: bool, what: &'static str) -> Result<(), Impossible> {
    if sound { Ok(()) } else { Err(Impossible(what)) }
}

impl Reading {
    /// Begins with the facts.
    pub(crate) fn begin(facts: Facts) -> Self {
        let (symbols, primitives, bodies) = (Vec::new(), Vec::new(), Vec::new());
        let (pools, reports, content) = (Vec::new(), Vec::new(), None);
        let sharing = PreConditionInterner::default();
        Self { facts, symbols, primitives, bodies, pools, reports, sharing, content }
    }

    /// Takes the next block, none of which is [`Block::End`].
    pub(crate) fn take(&mut self, block: Block) -> Result<(), Impossible> {
        let early = self.content.is_none();
        match block {
            Block::Symbols(symbols) if early => self.symbols.extend(symbols),
            Block::Primitives(primitives) if early => self.primitives.extend(primitives),
            Block::Body(body) if early => self.bodies.push(body),
            Block::Pool(pool) if early => self.pools.push(pool),
            Block::Report(report) if early => self.reports.push(*report),
            Block::Observations(remembered) => self.content()?.observations(remembered)?,
            Block::Schemas(schemas) => self.content()?.schemas(schemas)?,
            _ => return Err(Impossible("a block in the wrong place")),
        }
        let follow = self.facts.follow;
        let counts = [
            (self.symbols.len(), follow.symbols),
            (self.primitives.len(), follow.primitives),
            (self.bodies.len(), follow.bodies),
            (self.pools.len(), follow.pools),
            (self.reports.len(), follow.reports),
        ];
        let within = early || self.content.is_some();
        sound(within && counts.iter().all(|(count, said)| *count as u64 <= *said), "a count")
    }

    fn content(&mut self) -> Result<Filling<'_>, Impossible> {
        if self.content.is_none() {
            self.content = Some(self.basis()?);
        }
        match &mut self.content {
            Some((content, bounds)) => Ok(Filling { content, bounds, sharing: &mut self.sharing }),
            None => Err(Impossible("a block in the wrong place")),
        }
    }

    /// Everything but observations and schemas.
    fn basis(&mut self) -> Result<(Content, Bounds), Impossible> {
        let Self { facts, symbols, primitives, bodies, pools, reports, .. } = self;
        let Facts { vocabulary, pending, progress, pursuit, random, step, generalised_count, follow, .. } =
            facts.clone();
        let mut attempts = Chunks::default();
        primitives.iter().for_each(|primitive| attempts.push(primitive.attempts.into()));
        let (symbols, primitives) = (std::mem::take(symbols), std::mem::take(primitives));
        let (bodies, pools, reports) =
            (std::mem::take(bodies), std::mem::take(pools), std::mem::take(reports));
        let counts = [
            (symbols.len(), follow.symbols),
            (primitives.len(), follow.primitives),
            (bodies.len(), follow.bodies),
            (pools.len(), follow.pools),
            (reports.len(), follow.reports),
        ];
        sound(counts.iter().all(|(count, said)| *count as u64 == *said), "a count")?;
        let vocabulary = super::vocabulary::whole(vocabulary, symbols, primitives, bodies)?;
        let count = |number: u64, limit: usize, what| {
            usize::try_from(number).ok().filter(|count| *count <= limit).ok_or(Impossible(what))
        };
        let bounds = Bounds {
            types: vocabulary.types().len(),
            properties: vocabulary.properties().len(),
            symbols: vocabulary.symbols().len(),
            primitives: vocabulary.primitives().len(),
            bodies: vocabulary.bodies().len(),
            stages: facts.setting.curriculum.stages(),
            observations: count(follow.observations, u32::MAX as usize, "observations")?,
            schemas: count(follow.schemas, live::SCHEMAS_MAX, "schemas")?,
        };
        sound(pending.len() == vocabulary.bodies().len(), "pending")?;
        sound(pending.iter().flatten().all(|e| bounds.execution(e)), "pending")?;
        let goal = pursuit.as_ref();
        let goal =
            goal.is_none_or(|p| bounds.goal(p.body, &p.goal) && p.chains().all(|link| bounds.link(link)));
        sound(goal, "pursuit")?;
        let mut progress = pschema_learner::progress::Progress::from(progress);
        (progress.pools, progress.reports) = (pools, back(reports));
        let student = progress.student.is_none_or(|body| usize::from(body.0) < bounds.bodies);
        let stage = progress.stage < bounds.stages;
        sound(student && stage && progress.reports.len() <= REPORTS_MAX, "progress")?;
        let content = Content {
            vocabulary: Arc::new(vocabulary),
            schemas: Chunks::default(),
            observations: Chunks::default(),
            attention: Chunks::default(),
            happened: Chunks::default(),
            attempts,
            pending: pending.into_iter().map(|slot| slot.map(|e| Box::new(e.into()))).collect(),
            progress,
            pursuit: pursuit.map(Into::into),
            random: Random::from_seed(random),
            step,
            generalised_count,
        };
        Ok((content, bounds))
    }

    /// All of it, if all of it was there.
    pub(crate) fn end(mut self) -> Result<Whole, Impossible> {
        self.content()?;
        let (content, bounds) = self.content.ok_or(Impossible("a count"))?;
        let whole =
            content.observations.len() == bounds.observations && content.schemas.len() == bounds.schemas;
        let generalised = content.schemas.iter().filter(|schema| schema.generalised().is_some()).count();
        sound(whole && generalised == content.generalised_count as usize, "a count")?;
        Ok(Whole { content, setting: self.facts.setting })
    }
}

/// Where observations and schemas go.
struct Filling<'a> {
    content: &'a mut Content,
    bounds: &'a Bounds,
    sharing: &'a mut PreConditionInterner,
}

impl Filling<'_> {
    fn observations(self, remembered: Vec<Remembered>) -> Result<(), Impossible> {
        for Remembered { observation, attention, happened } in remembered {
            let room = self.content.observations.len() < self.bounds.observations;
            sound(room && self.bounds.observation(&observation), "an observation")?;
            self.content.observations.push(observation.into());
            self.content.attention.push(attention);
            self.content.happened.push(happened);
        }
        Ok(())
    }

    fn schemas(self, schemas: Vec<Schema>) -> Result<(), Impossible> {
        for schema in schemas {
            let room = self.content.schemas.len() < self.bounds.schemas;
            sound(room && self.bounds.schema(&schema), "a schema")?;
            let mut schema = schema.into();
            self.sharing.share(&mut schema);
            self.content.schemas.push(schema);
        }
        Ok(())
    }
}
