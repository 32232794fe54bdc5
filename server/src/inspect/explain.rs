//! Why an action was chosen.

use pschema_inspect::{ExcitationTerm, Explanation};
use pschema_learner::decision::{Candidate, Decision, Role, Subject, Term as LearntTerm};
use pschema_learner::memory::Content;
use pschema_learner::notation;

use super::{goals, text, trace};
use crate::mind::View;

/// The explanation of the decision of `step`, or of the last one, with at most `candidates_max` candidates.
///
/// # Errors
/// When that step decided nothing, or too long ago.
pub(super) fn explain(view: &View, step: Option<u64>, candidates_max: u32) -> Result<Explanation, String> {
    Ok(explanation(&view.content, decision(view, step)?, candidates_max))
}

/// The decision of `step`, or the last one.
///
/// # Errors
/// When that step decided nothing, or too long ago.
pub(super) fn decision(view: &View, step: Option<u64>) -> Result<&Decision, String> {
    let decisions = &view.decisions;
    let (Some(first), Some(last)) = (decisions.first(), decisions.last()) else {
        return Err("nothing has been decided yet".to_owned());
    };
    let Some(step) = step else { return Ok(last) };
    let known = decisions.iter().find(|decision| decision.step == step);
    known.map(|decision| &**decision).ok_or_else(|| {
        let count = decisions.len();
        format!("step {step} is not among the last {count} decisions, steps {} to {}", first.step, last.step)
    })
}

fn explanation(content: &Content, decision: &Decision, candidates_max: u32) -> Explanation {
    let vocabulary = &content.vocabulary;
    let max = usize::try_from(candidates_max.max(1)).unwrap_or(usize::MAX);
    // The chosen candidate is always listed: the last place is its, when it would not be.
    let mut listed: Vec<usize> = (0..decision.candidates.len()).take(max).collect();
    let chosen = listed.iter().position(|at| *at == decision.chosen).unwrap_or_else(|| {
        listed.truncate(max - 1);
        listed.push(decision.chosen);
        listed.len() - 1
    });
    let candidates = listed.iter().filter_map(|at| decision.candidates.get(*at));
    let body = vocabulary.bodies().get(usize::from(decision.body.0));
    let reason = trace::reason(decision.reason);
    Explanation {
        step: decision.step,
        body: body.map(|body| body.name.clone()).unwrap_or_default(),
        world: decision.world.observations().iter().map(|one| text::observation(vocabulary, one)).collect(),
        chosen: u32::try_from(chosen).unwrap_or(u32::MAX),
        action: notation::primitive(vocabulary, decision.action),
        reason: reason.to_owned(),
        ties: u32::try_from(decision.ties).unwrap_or(u32::MAX),
        candidates_total: u32::try_from(decision.candidates_total).unwrap_or(u32::MAX),
        candidates: candidates.map(|one| candidate(content, one)).collect(),
        goal: decision.goal.as_ref().map(|goal| goals::followed(content, goal)),
    }
}

pub(super) fn candidate(content: &Content, from: &Candidate) -> pschema_inspect::Candidate {
    let (schema, text, binding) = match from.subject {
        Subject::Schema(id) => {
            let text = content.schema(id).map(|schema| notation::schema(content, schema));
            (Some(id.0), text.unwrap_or_default(), text::binding(content, id, &from.binding))
        }
        Subject::Primitive(id) => (None, notation::primitive(&content.vocabulary, id), Vec::new()),
    };
    pschema_inspect::Candidate {
        schema,
        text,
        binding,
        distance: from.distance,
        excitation: from.excitation,
        terms: from.terms.iter().map(|one| term(content, one)).collect(),
    }
}

fn term(content: &Content, from: &LearntTerm) -> ExcitationTerm {
    let vocabulary = &content.vocabulary;
    let role = match from.role {
        Role::PreCondition => "pre-condition",
        Role::PostCondition => "post-condition",
        Role::Association => "association",
        Role::Babbling => "babbling",
        Role::Habituation => "habituation",
        Role::Rest => "rest",
    };
    let pair = from.pair.as_ref();
    ExcitationTerm {
        observation: pair.map(|(remembered, _)| text::observation(vocabulary, remembered)),
        seen: pair.map(|(_, seen)| text::observation(vocabulary, seen)),
        role: role.to_owned(),
        shared: from.shared,
        attention: from.attention,
        probability: from.probability,
        weight: from.weight,
        value: from.value,
    }
}
