//! Lists of schemas, and one schema whole.

use std::collections::BTreeMap;

use pschema_learner::decision::Subject;
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::Pattern;
use pschema_learner::schema::{Form, Schema, SchemaId};
use pschema_protocol::inspect::{SchemaDetail, SchemaList, SchemaQuery, SchemaSort, SchemaSummary};

use super::{LIST_MAX, text};
use crate::mind::View;

/// The schemas that fit a query.
///
/// # Errors
/// When a pattern can't be read or the action is unknown: what is wrong and what there is.
pub(super) fn list(view: &View, query: &SchemaQuery) -> Result<SchemaList, String> {
    let content = &view.content;
    let filter = Filter::new(content, query)?;
    let numbered = content.schemas.iter().enumerate();
    let numbered = numbered.filter_map(|(at, schema)| Some((u32::try_from(at).ok()?, schema)));
    let mut found: Vec<(u32, &Schema)> =
        numbered.filter(|(_, schema)| filter.takes(content, schema)).collect();
    sort(view, query.sort, &mut found);
    let limit = if query.limit == 0 { LIST_MAX } else { query.limit.min(LIST_MAX) };
    let limit = usize::try_from(limit).unwrap_or(usize::MAX);
    Ok(SchemaList {
        matching: u32::try_from(found.len()).unwrap_or(u32::MAX),
        schemas: found.into_iter().take(limit).map(|(id, schema)| summary(content, id, schema)).collect(),
    })
}

struct Filter<'a> {
    action: Option<&'a str>,
    pre: Option<Pattern>,
    post: Option<Pattern>,
    generalised: bool,
}

impl<'a> Filter<'a> {
    fn new(content: &Content, query: &'a SchemaQuery) -> Result<Self, String> {
        let vocabulary = &content.vocabulary;
        let pattern = |which: &str, text: &Option<String>| {
            let read = text.as_ref().map(|text| notation::parse_pattern(vocabulary, text)).transpose();
            read.map_err(|error| format!("{which} pattern: {error}"))
        };
        let action = query.action.as_deref();
        if let Some(name) = action
            && !vocabulary.actions().iter().any(|known| known.name == name)
        {
            let known: Vec<_> = vocabulary.actions().iter().map(|known| known.name.as_str()).collect();
            let known = if known.is_empty() { "none yet".to_owned() } else { known.join(", ") };
            return Err(format!("no action is named {name:?}; there are: {known}"));
        }
        Ok(Self {
            action,
            pre: pattern("pre-condition", &query.pre)?,
            post: pattern("post-condition", &query.post)?,
            generalised: query.generalised,
        })
    }

    fn takes(&self, content: &Content, schema: &Schema) -> bool {
        let (pre, post) = conditions(content, schema);
        let matches = |wanted: &Option<Pattern>, given: &[Pattern]| {
            wanted.as_ref().is_none_or(|wanted| given.iter().any(|one| notation::matches(wanted, one)))
        };
        (!self.generalised || schema.generalised().is_some())
            && self.action.is_none_or(|name| action_name(content, schema) == Some(name))
            && matches(&self.pre, &pre)
            && matches(&self.post, &post)
    }
}

/// The action's name; a generalised schema has a target instead.
fn action_name<'a>(content: &'a Content, schema: &Schema) -> Option<&'a str> {
    let vocabulary = &content.vocabulary;
    let primitive = vocabulary.primitives().get(usize::try_from(schema.concrete()?.action.0).ok()?)?;
    Some(vocabulary.actions().get(primitive.action)?.name.as_str())
}

/// Pre- and post-conditions as patterns, those that are no longer observed included.
fn conditions(content: &Content, schema: &Schema) -> (Vec<Pattern>, Vec<Pattern>) {
    match &schema.form {
        Form::Concrete(concrete) => (
            concrete.pre.iter().map(|id| Pattern::from(content.observation(*id))).collect(),
            concrete.post.iter().map(|post| Pattern::from(content.observation(post.what))).collect(),
        ),
        Form::Generalised(generalised) => {
            (generalised.pre.to_vec(), generalised.post.iter().map(|post| post.what.clone()).collect())
        }
    }
}

fn sort(view: &View, by: SchemaSort, found: &mut [(u32, &Schema)]) {
    match by {
        SchemaSort::Age => (),
        SchemaSort::Uses => found.sort_by_key(|(_, schema)| std::cmp::Reverse(schema.executions.trials)),
        SchemaSort::Probability => {
            found.sort_by(|(_, a), (_, b)| b.executions.interval().0.total_cmp(&a.executions.interval().0));
        }
        SchemaSort::Excitation => {
            let mut excitation: BTreeMap<u32, f64> = BTreeMap::new();
            for candidate in view.decisions.last().iter().flat_map(|decision| &decision.candidates) {
                if let Subject::Schema(id) = candidate.subject {
                    let top = excitation.entry(id.0).or_default();
                    *top = top.max(candidate.excitation);
                }
            }
            let of = |id: &u32| excitation.get(id).copied().unwrap_or(0.0);
            found.sort_by(|(a, _), (b, _)| of(b).total_cmp(&of(a)));
        }
    }
}

pub(super) fn kind(schema: &Schema) -> &'static str {
    match &schema.form {
        Form::Generalised(generalised) if generalised.retired => "retired",
        Form::Generalised(_) => "generalised",
        Form::Concrete(concrete) if concrete.contradicts.is_some() => "counter-example",
        Form::Concrete(_) => "concrete",
    }
}

fn summary(content: &Content, id: u32, schema: &Schema) -> SchemaSummary {
    let (pre, action, post) = notation::parts(content, schema);
    let (low, high) = schema.executions.interval();
    SchemaSummary {
        id,
        kind: kind(schema).to_owned(),
        pre,
        action,
        post,
        executions: schema.executions.trials,
        successes: schema.executions.occurrences,
        probability: schema.executions.ratio(),
        low,
        high,
    }
}

/// One schema whole; none of that number, none.
pub(super) fn detail(view: &View, id: u32) -> Option<SchemaDetail> {
    let content = &view.content;
    let vocabulary = &content.vocabulary;
    let schema = content.schema(SchemaId(id))?;
    let (low, high) = schema.executions.interval();
    let (_, action, _) = notation::parts(content, schema);
    let seen = |id| text::observation(vocabulary, content.observation(id));
    let pattern = |pattern: &Pattern| text::pattern(vocabulary, pattern);
    let (target, pre, post) = match &schema.form {
        Form::Concrete(concrete) => (
            Vec::new(),
            concrete.pre.iter().map(|id| seen(*id)).collect(),
            concrete
                .post
                .iter()
                .map(|post| text::condition(seen(post.what), post.absent, post.count))
                .collect(),
        ),
        Form::Generalised(generalised) => (
            generalised.target.iter().map(pattern).collect(),
            generalised.pre.iter().map(pattern).collect(),
            generalised
                .post
                .iter()
                .map(|post| text::condition(pattern(&post.what), post.absent, post.count))
                .collect(),
        ),
    };
    let associated = schema.associations.iter();
    let numbers = |ids: &[SchemaId]| ids.iter().map(|id| id.0).collect::<Vec<_>>();
    let generalised = schema.generalised();
    Some(SchemaDetail {
        id,
        kind: kind(schema).to_owned(),
        action,
        target,
        pre,
        post,
        associated: associated.map(|one| text::condition(seen(one.observation), false, one.count)).collect(),
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
    })
}

/// The generalised schemas that a concrete one is an example of.
fn exemplified(content: &Content, example: SchemaId) -> Vec<u32> {
    let schemas = content.schemas.iter().enumerate();
    let counting = schemas.filter(|(_, schema)| {
        schema.generalised().is_some_and(|generalised| generalised.examples.contains(&example))
    });
    counting.filter_map(|(at, _)| u32::try_from(at).ok()).collect()
}
