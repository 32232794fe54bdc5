//! Explanations of decisions.

use pschema_inspect::codec::Problem;
use pschema_inspect::{ExcitationTerm, Explanation, ExplanationQuery, NamedValues, SchemaForm, TermRole};
use pschema_learner::decision::{Candidate, Decision, Role, Subject, Term as LearntTerm};
use pschema_learner::execution::ChainLink;
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::Substitution;
use pschema_learner::schema::SchemaId;

use super::question::Inspect;
use super::{claims, goals, text, trace};
use crate::view::View;

impl Inspect for ExplanationQuery {
    fn answer(&self, view: &View) -> Result<Explanation, Problem> {
        let (content, decision) = (&view.content, decision(view, self.step)?);
        let told = explanation(content, decision, self.candidates_max);
        // Claims change with each step: those of an earlier one are no longer there.
        let at_hand = decision.step == content.step;
        let claims =
            at_hand.then(|| claims::foretold(content, Some(decision.body), decision.action, &decision.world));
        Ok(Explanation { claims: claims.unwrap_or_default(), ..told })
    }
}

/// The decision of `step`, or the last decision.
///
/// # Errors
/// When that step decided nothing, or too long ago.
pub(super) fn decision(view: &View, step: Option<u64>) -> Result<&Decision, Problem> {
    let decisions = &view.decisions;
    let (Some(first), Some(last)) = (decisions.front(), decisions.back()) else {
        return Err(Problem::of("nothing has been decided yet"));
    };
    let Some(step) = step else { return Ok(last) };
    let known = decisions.iter().find(|decision| decision.step == step);
    known.map(|decision| &**decision).ok_or_else(|| {
        if step > view.content.step {
            let last = view.content.step;
            return Problem::of(format!("step {step} has not been taken yet: the last step is {last}"));
        }
        let count = decisions.len();
        let (first, last) = (first.step, last.step);
        Problem::of(format!("step {step} is not among the last {count} decisions, steps {first} to {last}"))
    })
}

pub(super) fn explanation(content: &Content, decision: &Decision, candidates_max: u32) -> Explanation {
    let vocabulary = &content.vocabulary;
    let max = usize::try_from(candidates_max.max(1)).unwrap_or(usize::MAX);
    // The chosen candidate is always listed: if it is not among the most excited, it takes the last place.
    let mut listed: Vec<usize> = (0..decision.candidates.len()).take(max).collect();
    let chosen = listed.iter().position(|at| *at == decision.chosen).unwrap_or_else(|| {
        listed.truncate(max - 1);
        listed.push(decision.chosen);
        listed.len() - 1
    });
    let candidates = listed.iter().filter_map(|at| decision.candidates.get(*at));
    Explanation {
        step: decision.step,
        body: text::body(content, decision.body),
        world: text::observations(vocabulary, decision.world.observations()),
        chosen: u32::try_from(chosen).unwrap_or(u32::MAX),
        action: notation::primitive(vocabulary, decision.action),
        reason: trace::reason(decision.reason),
        ties: u32::try_from(decision.ties).unwrap_or(u32::MAX),
        candidates_total: u32::try_from(decision.candidates_total).unwrap_or(u32::MAX),
        candidates: candidates.map(|one| candidate(content, one)).collect(),
        goal: decision.goal.as_ref().map(|goal| goals::followed(content, goal)),
        claims: Vec::new(),
    }
}

pub(super) fn candidate(content: &Content, from: &Candidate) -> pschema_inspect::Candidate {
    let (schema, text, form, binding) = match from.subject {
        Subject::Schema(id) => {
            let known = content.schema(id);
            let text = known.map(|schema| notation::schema(content, schema)).unwrap_or_default();
            let form = known.map(|schema| text::form(content, schema)).unwrap_or_default();
            (Some(id.0), text, form, text::binding(content, id, &from.binding))
        }
        Subject::Primitive(id) => {
            let text = notation::primitive(&content.vocabulary, id);
            (None, text.clone(), SchemaForm { action: text, ..SchemaForm::default() }, NamedValues::default())
        }
    };
    pschema_inspect::Candidate {
        schema,
        text,
        form,
        binding,
        together: goals::chain(content, &superschema_links(&from.together)),
        distance: from.distance,
        excitation: from.excitation,
        terms: from.terms.iter().map(|one| term(content, one)).collect(),
    }
}

/// Schemas as a chain executes them.
fn superschema_links(together: &[SchemaId]) -> Vec<ChainLink> {
    let link = |schema: &SchemaId| ChainLink { schema: *schema, binding: Substitution::new(), carrier: None };
    together.iter().map(link).collect()
}

fn term(content: &Content, from: &LearntTerm) -> ExcitationTerm {
    let vocabulary = &content.vocabulary;
    let role = match from.role {
        Role::PreCondition => TermRole::PreCondition,
        Role::PostCondition => TermRole::PostCondition,
        Role::Association => TermRole::Association,
        Role::Babbling => TermRole::Babbling,
        Role::Curiosity => TermRole::Curiosity,
        Role::Habituation => TermRole::Habituation,
        Role::Rest => TermRole::Rest,
    };
    let pair = from.pair.as_ref();
    ExcitationTerm {
        observation: pair.map(|(remembered, _)| text::observation(vocabulary, remembered)),
        seen: pair.map(|(_, seen)| text::observation(vocabulary, seen)),
        role,
        shared: from.shared,
        attention: from.attention,
        probability: from.probability,
        weight: from.weight,
        value: from.value,
    }
}
