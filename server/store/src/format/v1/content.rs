//! Memory whole, as a snapshot has it. Everything that refers to something else is checked on the way back: a file
//! must not be able to make a learner look for what is not there.

use std::sync::Arc;

use pschema_learner::chunks::Chunks;
use pschema_learner::memory::Content;
use pschema_learner::observation as seen;
use pschema_learner::random::Random;
use pschema_learner::schema::{self as live, ObservationId, SchemaId};
use pschema_learner::vocabulary::PrimitiveId;
use serde::{Deserialize, Serialize};

use super::effect::Execution;
use super::observation::{Count, Observation, Pattern, Term, Value, back, list};
use super::stage::{Progress, Pursuit};
use super::vocabulary::Vocabulary;
use super::{Block, Impossible};

/// Items in one block.
const BLOCK_LEN: usize = 1_024;

/// What there is one of, and how much of the rest follows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Facts {
    vocabulary: Vocabulary,
    attempts: Vec<Count>,
    pending: Vec<Option<Execution>>,
    progress: Progress,
    pursuit: Option<Pursuit>,
    random: u64,
    step: u64,
    generalised_count: u32,
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
                live::Form::Generalised(live::Generalised {
                    pre: back(pre),
                    target: back(target),
                    post: posts_back(post, seen::Pattern::from),
                    examples: examples.into_iter().map(SchemaId).collect(),
                    counter_examples: counter_examples.into_iter().map(SchemaId).collect(),
                    retired,
                })
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

/// How much there is of what numbers on disk refer to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    types: usize,
    properties: usize,
    symbols: usize,
    primitives: usize,
    observations: usize,
    schemas: usize,
}

impl Bounds {
    /// What `content` has: what an effect that changes it may refer to.
    pub(crate) fn of(content: &Content) -> Self {
        let vocabulary = &content.vocabulary;
        Self {
            types: vocabulary.types().len(),
            properties: vocabulary.properties().len(),
            symbols: vocabulary.symbols().len(),
            primitives: vocabulary.primitives().len(),
            observations: content.observations.len(),
            schemas: content.schemas.len(),
        }
    }

    fn value(&self, value: Value) -> bool {
        !matches!(value, Value::Symbol(symbol) if symbol as usize >= self.symbols)
    }

    fn observation(&self, observation: &Observation) -> bool {
        usize::from(observation.kind) < self.types
            && observation.properties.iter().all(|(p, v)| usize::from(*p) < self.properties && self.value(*v))
    }

    fn pattern(&self, pattern: &Pattern) -> bool {
        let term = |term: &Term| match term {
            Term::Constant(value) => self.value(*value),
            Term::Variable(_) => true,
        };
        usize::from(pattern.kind) < self.types
            && pattern.terms.iter().all(|(p, t)| usize::from(*p) < self.properties && term(t))
    }

    fn schemas<'a>(&self, ids: impl IntoIterator<Item = &'a u32>) -> bool {
        ids.into_iter().all(|id| (*id as usize) < self.schemas)
    }

    fn interned<'a>(&self, ids: impl IntoIterator<Item = &'a u32>) -> bool {
        ids.into_iter().all(|id| (*id as usize) < self.observations)
    }

    fn execution(&self, execution: &Execution) -> bool {
        let links =
            execution.chain.iter().flat_map(|link| [Some(&link.schema), link.carrier.as_ref()]).flatten();
        (execution.action as usize) < self.primitives
            && self.schemas(execution.schema.iter().chain(&execution.carrier).chain(links))
            && execution.before.iter().all(|observation| self.observation(observation))
    }

    fn schema(&self, schema: &Schema) -> bool {
        let form = match &schema.form {
            Form::Concrete { pre, action, post, contradicts } => {
                (*action as usize) < self.primitives
                    && self.interned(pre.iter().chain(post.iter().map(|p| &p.what)))
                    && self.schemas(contradicts)
            }
            Form::Generalised { pre, target, post, examples, counter_examples, retired: _ } => {
                let patterns = pre.iter().chain(target).chain(post.iter().map(|p| &p.what));
                patterns.into_iter().all(|pattern| self.pattern(pattern))
                    && self.schemas(examples.iter().chain(counter_examples))
            }
        };
        form && self.interned(schema.associations.iter().map(|a| &a.observation))
            && self.schemas(&schema.parent)
            && schema.associations.len() <= live::ASSOCIATIONS_MAX
    }
}

/// Everything in `content`, block by block, the end with its digest left out.
pub(crate) fn blocks(content: &Content) -> impl Iterator<Item = Block> {
    let facts = Facts {
        vocabulary: (&*content.vocabulary).into(),
        attempts: content.attempts.iter().map(|count| (*count).into()).collect(),
        pending: content.pending.iter().map(|slot| slot.as_ref().map(|e| Execution::from(&**e))).collect(),
        progress: (&content.progress).into(),
        pursuit: content.pursuit.as_ref().map(Pursuit::from),
        random: content.random.state(),
        step: content.step,
        generalised_count: content.generalised_count,
        observations: content.observations.len() as u64,
        schemas: content.schemas.len() as u64,
    };
    let starts = |len: usize| (0..len).step_by(BLOCK_LEN).map(move |from| from..(from + BLOCK_LEN).min(len));
    let observations = starts(content.observations.len()).map(|range| {
        let remembered = range.filter_map(|at| {
            Some(Remembered {
                observation: content.observations.get(at)?.into(),
                attention: content.attention.get(at).copied().unwrap_or(0),
                happened: content.happened.get(at).copied().unwrap_or(0),
            })
        });
        Block::Observations(remembered.collect())
    });
    let schemas = starts(content.schemas.len()).map(|range| {
        Block::Schemas(range.filter_map(|at| content.schemas.get(at).map(Schema::from)).collect())
    });
    std::iter::once(Block::Facts(Box::new(facts))).chain(observations).chain(schemas)
}

/// Memory in the making, from blocks.
#[derive(Debug)]
pub(crate) struct Reading {
    content: Content,
    bounds: Bounds,
}

impl Reading {
    /// Begins with the facts.
    pub(crate) fn begin(facts: Facts) -> Result<Self, Impossible> {
        let vocabulary = pschema_learner::vocabulary::Vocabulary::try_from(facts.vocabulary)?;
        let count = |number: u64, limit: usize, what| {
            usize::try_from(number).ok().filter(|count| *count <= limit).ok_or(Impossible(what))
        };
        let bounds = Bounds {
            types: vocabulary.types().len(),
            properties: vocabulary.properties().len(),
            symbols: vocabulary.symbols().len(),
            primitives: vocabulary.primitives().len(),
            observations: count(facts.observations, u32::MAX as usize, "observations")?,
            schemas: count(facts.schemas, live::SCHEMAS_MAX, "schemas")?,
        };
        let sound = |sound: bool, what| if sound { Ok(()) } else { Err(Impossible(what)) };
        sound(facts.attempts.len() == bounds.primitives, "attempts")?;
        sound(facts.pending.len() == vocabulary.bodies().len(), "pending")?;
        sound(facts.pending.iter().flatten().all(|e| bounds.execution(e)), "pending")?;
        let goal = facts.pursuit.as_ref();
        let goal = goal.is_none_or(|p| {
            usize::from(p.body) < facts.pending.len() && p.goal.iter().all(|pattern| bounds.pattern(pattern))
        });
        sound(goal, "pursuit")?;
        let mut attempts = Chunks::default();
        facts.attempts.into_iter().for_each(|count| attempts.push(count.into()));
        let content = Content {
            vocabulary: Arc::new(vocabulary),
            schemas: Chunks::default(),
            observations: Chunks::default(),
            attention: Chunks::default(),
            happened: Chunks::default(),
            attempts,
            pending: facts.pending.into_iter().map(|slot| slot.map(|e| Box::new(e.into()))).collect(),
            progress: facts.progress.into(),
            pursuit: facts.pursuit.map(Into::into),
            random: Random::from_seed(facts.random),
            step: facts.step,
            generalised_count: facts.generalised_count,
        };
        Ok(Self { content, bounds })
    }

    pub(crate) fn observations(&mut self, remembered: Vec<Remembered>) -> Result<(), Impossible> {
        for Remembered { observation, attention, happened } in remembered {
            if !self.bounds.observation(&observation)
                || self.content.observations.len() >= self.bounds.observations
            {
                return Err(Impossible("an observation"));
            }
            self.content.observations.push(observation.into());
            self.content.attention.push(attention);
            self.content.happened.push(happened);
        }
        Ok(())
    }

    pub(crate) fn schemas(&mut self, schemas: Vec<Schema>) -> Result<(), Impossible> {
        for schema in schemas {
            if !self.bounds.schema(&schema) || self.content.schemas.len() >= self.bounds.schemas {
                return Err(Impossible("a schema"));
            }
            self.content.schemas.push(schema.into());
        }
        Ok(())
    }

    /// All of it, if all of it was there.
    pub(crate) fn end(self) -> Result<Content, Impossible> {
        let Self { content, bounds } = self;
        let whole =
            content.observations.len() == bounds.observations && content.schemas.len() == bounds.schemas;
        let generalised = content.schemas.iter().filter(|schema| schema.generalised().is_some()).count();
        if whole && generalised == content.generalised_count as usize {
            Ok(content)
        } else {
            Err(Impossible("a count"))
        }
    }
}

impl super::Effect {
    /// Whether all that the effect says of observations can be said of memory as it is; the rest
    /// [`pschema_learner::memory::Memory::apply`] checks.
    pub(crate) fn fits(&self, bounds: &Bounds) -> bool {
        let all = |list: &[Observation]| list.iter().all(|one| bounds.observation(one));
        match self {
            Self::OutcomeAdded { observation, .. } | Self::Associated { observation, .. } => {
                bounds.observation(observation)
            }
            Self::Created { pre, post, parent, .. } => {
                all(pre) && post.iter().all(|(one, _)| bounds.observation(one)) && bounds.schemas(parent)
            }
            Self::Generalised { pre, target, post, .. } => {
                let patterns = pre.iter().chain(target).chain(post.iter().map(|(pattern, _)| pattern));
                patterns.into_iter().all(|pattern| bounds.pattern(pattern))
            }
            Self::Happened(list) | Self::Attended(list) => all(list),
            Self::StepEnded { pending: Some(execution), .. } => bounds.execution(execution),
            _ => true,
        }
    }
}
