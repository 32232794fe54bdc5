//! The JSON of `--json`: what a daemon answers, with observations as objects. Field names never change meaning;
//! `docs/CLI.md` documents them.

use pschema_inspect::{
    Candidate, Condition, ExcitationTerm, Explanation, ObservationText, SchemaDetail, ValueText,
};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use super::json_goals::Followed;

/// `{"type": "object", "properties": {"colour": "blue", "field": 4}}`.
#[derive(Debug, Serialize)]
pub(crate) struct Observation<'a> {
    #[serde(rename = "type")]
    kind: &'a str,
    properties: Values<'a>,
}

/// Names with values, as an object. A variable is `{"var": "x"}`.
#[derive(Debug)]
pub(super) struct Values<'a>(pub(super) &'a [(String, ValueText)]);

#[derive(Serialize)]
#[serde(untagged)]
enum Value<'a> {
    Integer(i64),
    Symbol(&'a str),
    Boolean(bool),
    Real(f64),
    Variable { var: &'a str },
}

impl Serialize for Values<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let mut map = to.serialize_map(Some(self.0.len()))?;
        for (name, value) in self.0 {
            let value = match value {
                ValueText::Integer(n) => Value::Integer(*n),
                ValueText::Symbol(s) => Value::Symbol(s),
                ValueText::Boolean(b) => Value::Boolean(*b),
                ValueText::Real(r) => Value::Real(*r),
                ValueText::Variable(var) => Value::Variable { var },
            };
            map.serialize_entry(name, &value)?;
        }
        map.end()
    }
}

impl<'a> From<&'a ObservationText> for Observation<'a> {
    fn from(text: &'a ObservationText) -> Self {
        Self { kind: &text.kind, properties: Values(&text.properties) }
    }
}

/// An observation with its statistics; `"absent": true` only where it says what is no longer observed.
#[derive(Debug, Serialize)]
pub(super) struct Counted<'a> {
    observation: Observation<'a>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    absent: bool,
    occurrences: u32,
    trials: u32,
    probability: f64,
    low: f64,
    high: f64,
}

impl<'a> From<&'a Condition> for Counted<'a> {
    fn from(c: &'a Condition) -> Self {
        Self {
            observation: (&c.observation).into(),
            absent: c.absent,
            occurrences: c.occurrences,
            trials: c.trials,
            probability: c.probability,
            low: c.low,
            high: c.high,
        }
    }
}

/// What `pschema show --json` prints.
#[derive(Debug, Serialize)]
pub(crate) struct Schema<'a> {
    id: u32,
    kind: &'a str,
    action: &'a str,
    target: Vec<Observation<'a>>,
    pre: Vec<Observation<'a>>,
    post: Vec<Counted<'a>>,
    associated: Vec<Counted<'a>>,
    executions: u32,
    successes: u32,
    probability: f64,
    low: f64,
    high: f64,
    parent: Option<u32>,
    contradicts: Option<u32>,
    examples: &'a [u32],
    counter_examples: &'a [u32],
    created_step: u64,
}

pub(super) fn all<'a, T: 'a, U: From<&'a T>>(list: &'a [T]) -> Vec<U> {
    list.iter().map(U::from).collect()
}

impl<'a> From<&'a SchemaDetail> for Schema<'a> {
    fn from(s: &'a SchemaDetail) -> Self {
        Self {
            id: s.id,
            kind: &s.kind,
            action: &s.action,
            target: all(&s.target),
            pre: all(&s.pre),
            post: all(&s.post),
            associated: all(&s.associated),
            executions: s.executions,
            successes: s.successes,
            probability: s.probability,
            low: s.low,
            high: s.high,
            parent: s.parent,
            contradicts: s.contradicts,
            examples: &s.examples,
            counter_examples: &s.counter_examples,
            created_step: s.created_step,
        }
    }
}

/// What `pschema explain --json` prints.
#[derive(Debug, Serialize)]
pub struct Reasons<'a> {
    step: u64,
    body: &'a str,
    world: Vec<Observation<'a>>,
    /// An index into `candidates`.
    chosen: u32,
    action: &'a str,
    reason: &'a str,
    ties: u32,
    candidates_total: u32,
    candidates: Vec<CandidateJson<'a>>,
    /// The goal followed, when that is the reason.
    goal: Option<Followed<'a>>,
}

/// One thing that could have been done.
#[derive(Debug, Serialize)]
pub(super) struct CandidateJson<'a> {
    schema: Option<u32>,
    text: &'a str,
    binding: Values<'a>,
    distance: u32,
    excitation: f64,
    terms: Vec<Term<'a>>,
}

#[derive(Debug, Serialize)]
struct Term<'a> {
    observation: Option<Observation<'a>>,
    seen: Option<Observation<'a>>,
    role: &'a str,
    shared: u32,
    attention: u32,
    probability: f64,
    weight: f64,
    value: f64,
}

impl<'a> From<&'a Explanation> for Reasons<'a> {
    fn from(e: &'a Explanation) -> Self {
        Self {
            step: e.step,
            body: &e.body,
            world: all(&e.world),
            chosen: e.chosen,
            action: &e.action,
            reason: &e.reason,
            ties: e.ties,
            candidates_total: e.candidates_total,
            candidates: all(&e.candidates),
            goal: e.goal.as_ref().map(Followed::from),
        }
    }
}

impl<'a> From<&'a Candidate> for CandidateJson<'a> {
    fn from(c: &'a Candidate) -> Self {
        Self {
            schema: c.schema,
            text: &c.text,
            binding: Values(&c.binding),
            distance: c.distance,
            excitation: c.excitation,
            terms: all(&c.terms),
        }
    }
}

impl<'a> From<&'a ExcitationTerm> for Term<'a> {
    fn from(t: &'a ExcitationTerm) -> Self {
        Self {
            observation: t.observation.as_ref().map(Observation::from),
            seen: t.seen.as_ref().map(Observation::from),
            role: &t.role,
            shared: t.shared,
            attention: t.attention,
            probability: t.probability,
            weight: t.weight,
            value: t.value,
        }
    }
}
