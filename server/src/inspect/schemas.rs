//! Lists of schemas, and one schema whole.

use std::collections::{BTreeMap, BinaryHeap};

use pschema_inspect::codec::Problem;
use pschema_inspect::{
    DetailQuery, SchemaDetail, SchemaForm, SchemaKind, SchemaList, SchemaQuery, SchemaSort, SchemaSummary,
};
use pschema_learner::decision::Subject;
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::{Observation, Pattern, PropertyId, Term};
use pschema_learner::probability::Count;
use pschema_learner::schema::{Form, ObservationId, Schema, SchemaId};

use super::question::{Inspect, no_schema};
use super::{claims, text};
use crate::view::View;

/// Most schemas in one list.
pub const LIST_MAX: u32 = 10_000;

impl Inspect for SchemaQuery {
    fn answer(&self, view: &View) -> Result<SchemaList, Problem> {
        list(view, self)
    }
}

impl Inspect for DetailQuery {
    fn answer(&self, view: &View) -> Result<SchemaDetail, Problem> {
        detail(view, self.id).ok_or_else(|| no_schema(view, self.id))
    }
}

/// The schemas that fit a query, in one pass over memory. Each observation is compared with the patterns once, before the
/// pass; in the pass the results are looked up.
fn list(view: &View, query: &SchemaQuery) -> Result<SchemaList, Problem> {
    let content = &view.content;
    let filter = Filter::new(content, query)?;
    let limit = if query.limit == 0 { LIST_MAX } else { query.limit.min(LIST_MAX) };
    let limit = usize::try_from(limit).unwrap_or(usize::MAX);
    let offset = usize::try_from(query.offset).unwrap_or(usize::MAX);
    let rank = Rank::new(view, query.sort);
    let end = offset.saturating_add(limit);
    // Only the schemas up to the end of the page are kept; the last of them in order is at the top.
    let mut kept: BinaryHeap<(u64, u32)> = BinaryHeap::new();
    let mut matching: u32 = 0;
    for (schema, id) in content.schemas.iter().zip(0_u32..).filter(|(schema, _)| filter.takes(schema)) {
        matching = matching.saturating_add(1);
        let one = (rank.of(id, schema), id);
        if kept.len() < end {
            kept.push(one);
        } else if let Some(mut last) = kept.peek_mut()
            && one < *last
        {
            *last = one;
        }
    }
    let kept = kept.into_sorted_vec();
    let page = kept.get(offset..).unwrap_or_default();
    let told = |(_, id): &(u64, u32)| Some(summary(content, *id, content.schema(SchemaId(*id))?));
    Ok(SchemaList { matching, schemas: page.iter().filter_map(told).collect() })
}

/// A pattern, with whether it matches each observation in memory.
struct PatternMatches {
    pattern: Pattern,
    matching: Vec<bool>,
}

impl PatternMatches {
    fn new(content: &Content, pattern: Pattern) -> Self {
        let matching =
            content.observations.iter().map(|known| matches_observation(&pattern, known)).collect();
        Self { pattern, matching }
    }

    fn has(&self, id: ObservationId) -> bool {
        self.matching.get(id.index()).copied().unwrap_or(false)
    }
}

/// As [`notation::matches`], without a copy of most observations that do not match.
fn matches_observation(pattern: &Pattern, observation: &Observation) -> bool {
    let agrees = |(property, term): &(PropertyId, Term)| {
        let known = observation.properties().iter().find(|(known, _)| known == property);
        known.is_some_and(|(_, value)| match term {
            Term::Constant(constant) => constant == value,
            Term::Variable(_) => true,
        })
    };
    pattern.kind() == observation.kind()
        && pattern.terms().iter().all(agrees)
        && notation::matches(pattern, &Pattern::from(observation))
}

struct Filter {
    /// For each primitive whether it is of the action asked for; none when none is.
    action: Option<Vec<bool>>,
    pre: Option<PatternMatches>,
    post: Option<PatternMatches>,
    generalised: bool,
}

impl Filter {
    fn new(content: &Content, query: &SchemaQuery) -> Result<Self, Problem> {
        let vocabulary = &content.vocabulary;
        let marked = |which: &str, text: &Option<String>| {
            let read = text.as_ref().map(|text| notation::parse_pattern(vocabulary, text)).transpose();
            let read = read.map_err(|error| Problem::of(format!("{which} pattern: {error}")))?;
            Ok::<_, Problem>(read.map(|pattern| PatternMatches::new(content, pattern)))
        };
        let action = query.action.as_deref().map(|name| primitives_of(content, name)).transpose()?;
        Ok(Self {
            action,
            pre: marked("pre-condition", &query.pre)?,
            post: marked("post-condition", &query.post)?,
            generalised: query.generalised,
        })
    }

    fn takes(&self, schema: &Schema) -> bool {
        if !self.generalised && self.action.is_none() && self.pre.is_none() && self.post.is_none() {
            return true;
        }
        match &schema.form {
            Form::Concrete(concrete) => {
                let is_done = |primitives: &Vec<bool>| {
                    usize::try_from(concrete.action.0).ok().and_then(|at| primitives.get(at)) == Some(&true)
                };
                !self.generalised
                    && self.action.as_ref().is_none_or(is_done)
                    && self.pre.as_ref().is_none_or(|marked| concrete.pre.iter().any(|id| marked.has(*id)))
                    && self
                        .post
                        .as_ref()
                        .is_none_or(|marked| concrete.post.iter().any(|post| marked.has(post.what)))
            }
            // A generalised schema has a target instead of an action.
            Form::Generalised(known) => {
                let matching =
                    |marked: &PatternMatches, given: &Pattern| notation::matches(&marked.pattern, given);
                self.action.is_none()
                    && self
                        .pre
                        .as_ref()
                        .is_none_or(|marked| known.pre.iter().any(|given| matching(marked, given)))
                    && self
                        .post
                        .as_ref()
                        .is_none_or(|m| known.post.iter().any(|post| matching(m, &post.what)))
            }
        }
    }
}

/// For each primitive, whether it is of the action of this name.
fn primitives_of(content: &Content, name: &str) -> Result<Vec<bool>, Problem> {
    let vocabulary = &content.vocabulary;
    let at = vocabulary.actions().iter().position(|known| known.name == name).ok_or_else(|| {
        let known: Vec<_> = vocabulary.actions().iter().map(|known| known.name.as_str()).collect();
        let known = if known.is_empty() { "none yet".to_owned() } else { known.join(", ") };
        Problem::of(format!("no action is named {name:?}; there are: {known}"))
    })?;
    Ok(vocabulary.primitives().iter().map(|primitive| primitive.action == at).collect())
}

/// The order of a list: schemas of smaller rank come first; among equals, the oldest.
enum Rank {
    Age,
    Uses,
    Probability,
    Excitation(BTreeMap<u32, f64>),
}

impl Rank {
    fn new(view: &View, by: SchemaSort) -> Self {
        match by {
            SchemaSort::Age => Self::Age,
            SchemaSort::Uses => Self::Uses,
            SchemaSort::Probability => Self::Probability,
            SchemaSort::Excitation => {
                let mut excitation: BTreeMap<u32, f64> = BTreeMap::new();
                for candidate in view.decisions.back().iter().flat_map(|decision| &decision.candidates) {
                    if let Subject::Schema(id) = candidate.subject {
                        let top = excitation.entry(id.0).or_default();
                        *top = top.max(candidate.excitation);
                    }
                }
                Self::Excitation(excitation)
            }
        }
    }

    fn of(&self, id: u32, schema: &Schema) -> u64 {
        // None of these figures is negative, so their bits are in the same order as they are.
        match self {
            Self::Age => 0,
            Self::Uses => !u64::from(schema.executions.trials),
            Self::Probability => !schema.executions.interval().0.max(0.0).to_bits(),
            Self::Excitation(known) => !known.get(&id).copied().unwrap_or(0.0).max(0.0).to_bits(),
        }
    }
}

/// The kind of a schema.
pub(super) fn kind(schema: &Schema) -> SchemaKind {
    match &schema.form {
        Form::Generalised(generalised) if generalised.retired => SchemaKind::Retired,
        Form::Generalised(_) => SchemaKind::Generalised,
        Form::Concrete(concrete) if concrete.contradicts.is_some() => SchemaKind::CounterExample,
        Form::Concrete(_) => SchemaKind::Concrete,
    }
}

/// Schema `id` for a list; none if there is no such schema.
pub(super) fn line(content: &Content, id: u32) -> Option<SchemaSummary> {
    content.schema(SchemaId(id)).map(|schema| summary(content, id, schema))
}

pub(super) fn summary(content: &Content, id: u32, schema: &Schema) -> SchemaSummary {
    let notation::SchemaText { pre, action, post, post_shares } = notation::schema_text(content, schema);
    let (low, high) = schema.executions.interval();
    SchemaSummary {
        id,
        kind: kind(schema),
        pre,
        action,
        post,
        post_shares,
        executions: schema.executions.trials,
        successes: schema.executions.occurrences,
        probability: schema.executions.ratio(),
        low,
        high,
    }
}

/// Schema `id` whole; none if there is no such schema.
fn detail(view: &View, id: u32) -> Option<SchemaDetail> {
    let content = &view.content;
    let schema = content.schema(SchemaId(id))?;
    let (low, high) = schema.executions.interval();
    let SchemaForm { pre, action, target, post } = text::form(content, schema);
    let counts: Vec<Count> = match &schema.form {
        Form::Concrete(concrete) => concrete.post.iter().map(|post| post.count).collect(),
        Form::Generalised(generalised) => generalised.post.iter().map(|post| post.count).collect(),
    };
    let post = post.into_iter().zip(counts);
    let post = post.map(|(told, count)| text::condition(told.observation, told.absent, count)).collect();
    let associated = schema.associations.iter().map(|one| {
        let seen = text::observation(&content.vocabulary, content.observation(one.observation));
        text::condition(seen, false, one.count)
    });
    let numbers = |ids: &[SchemaId]| ids.iter().map(|id| id.0).collect::<Vec<_>>();
    let generalised = schema.generalised();
    Some(SchemaDetail {
        id,
        kind: kind(schema),
        action,
        target,
        pre,
        post,
        associated: associated.collect(),
        executions: schema.executions.trials,
        successes: schema.executions.occurrences,
        probability: schema.executions.ratio(),
        low,
        high,
        parent: schema.parent.map(|parent| parent.0),
        contradicts: schema.concrete().and_then(|concrete| concrete.contradicts).map(|id| id.0),
        examples: generalised
            .map_or_else(|| exemplified(content, SchemaId(id)), |known| numbers(&known.examples)),
        counter_examples: generalised.map_or_else(Vec::new, |known| numbers(&known.counter_examples)),
        created_step: schema.created_step,
        claims: claims::beneath(content, schema),
    })
}

/// The generalised schemas that a concrete one is an example of.
fn exemplified(content: &Content, example: SchemaId) -> Vec<u32> {
    let numbered = content.schemas.iter().zip(0_u32..);
    let generalised = numbered.filter_map(|(schema, id)| Some((id, schema.generalised()?)));
    // The search ends after the last generalised schema.
    let generalised = generalised.take(usize::try_from(content.generalised_count).unwrap_or(usize::MAX));
    generalised.filter(|(_, known)| known.examples.contains(&example)).map(|(id, _)| id).collect()
}
