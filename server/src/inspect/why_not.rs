//! The reason why a schema was not executed.

use pschema_inspect::codec::Problem;
use pschema_inspect::{UnmetCondition, Verdict, WhyNot, WhyNotQuery};
use pschema_learner::decision::Decision;
use pschema_learner::memory::{Content, Memory};
use pschema_learner::notation;
use pschema_learner::observation::Term;
use pschema_learner::schema::{Schema, SchemaId};
use pschema_learner::why_not::{self, Reweighing, WeighError};

use super::question::{Inspect, no_schema};
use super::{claims, explain, goals, schemas, text, trace};
use crate::view::View;

impl Inspect for WhyNotQuery {
    fn answer(&self, view: &View) -> Result<WhyNot, Problem> {
        why_not(view, self.schema, self.step)
    }
}

/// Why schema `id` was not executed in `step`, or in the last decision. The decision is weighed once more in memory as it
/// was, which takes time in proportion to memory.
fn why_not(view: &View, id: u32, step: Option<u64>) -> Result<WhyNot, Problem> {
    let decision = explain::decision(view, step)?;
    let content = &view.content;
    let schema = content.schema(SchemaId(id)).ok_or_else(|| no_schema(view, id))?;
    if schema.created_step >= decision.step {
        let step = decision.step;
        return Err(Problem::of(format!("schema {id} was made only after step {step} decided")));
    }
    let memory = Memory::restore(content.clone(), view.setup.learner.parameters.clone());
    let weighed = why_not::weigh(&memory, &view.setup.curriculum, decision, SchemaId(id));
    let weighed = weighed.map_err(|error| match error {
        WeighError::Schema => no_schema(view, id),
        WeighError::Changed => Problem::of(format!(
            "step {} can't be weighed again: memory has changed since, up to step {}. Only the latest decision can be \
             asked about in RAM; of a memory on disk, any step",
            decision.step, content.step
        )),
    })?;
    told(view, decision, id, &weighed).ok_or_else(|| no_schema(view, id))
}

fn told(view: &View, decision: &Decision, id: u32, weighed: &Reweighing) -> Option<WhyNot> {
    let content = &view.content;
    let schema = content.schema(SchemaId(id))?;
    let action = weighed.action.and_then(|action| usize::try_from(action.0).ok());
    let attempts = action.and_then(|at| content.attempts.get(at)).copied().unwrap_or_default();
    Some(WhyNot {
        step: decision.step,
        body: text::body(content, decision.body),
        world: text::observations(&content.vocabulary, decision.world.observations()),
        schema: id,
        kind: schemas::kind(schema),
        text: notation::schema(content, schema),
        form: text::form(content, schema),
        verdict: verdict(content, decision, schema, weighed)?,
        binding: text::binding(content, SchemaId(id), &weighed.binding),
        bindings: u32::try_from(weighed.bindings).unwrap_or(u32::MAX),
        candidate: weighed.candidate.as_ref().map(|candidate| explain::candidate(content, candidate)),
        chain: goals::chain(content, &weighed.chain),
        attempts: attempts.trials,
        carried_out: attempts.occurrences,
        habituated: weighed.habituated,
        search_truncated: weighed.search_truncated,
        chosen: explain::candidate(content, decision.candidates.get(decision.chosen)?),
        action: notation::primitive(&content.vocabulary, decision.action),
        reason: trace::reason(decision.reason),
        ties: u32::try_from(decision.ties).unwrap_or(u32::MAX),
    })
}

fn verdict(content: &Content, decision: &Decision, schema: &Schema, weighed: &Reweighing) -> Option<Verdict> {
    Some(match &weighed.verdict {
        why_not::Verdict::Chosen => Verdict::Chosen,
        why_not::Verdict::ExecutedFor(schema) => Verdict::ExecutedFor { schema: schema.0 },
        why_not::Verdict::NotWeighed => Verdict::NotWeighed,
        why_not::Verdict::Retired => Verdict::Retired,
        why_not::Verdict::NotInRepertoire => Verdict::NotInRepertoire,
        why_not::Verdict::PreConditions(list) => {
            Verdict::PreConditions { lacking: list.iter().map(|one| unmet(content, one)).collect() }
        }
        why_not::Verdict::TargetNotAchievable(target) => {
            Verdict::TargetNotAchievable { target: text::observations(&content.vocabulary, target) }
        }
        why_not::Verdict::StoodInFor(by) => {
            Verdict::StoodInFor { by: by.0, kind: content.schema(*by).map(schemas::kind)? }
        }
        why_not::Verdict::OtherClaims => {
            let action = weighed.action?;
            Verdict::OtherClaims {
                claims: claims::of_schema(content, Some(decision.body), schema, action, &decision.world),
            }
        }
        why_not::Verdict::NotExciting => Verdict::NotExciting,
        why_not::Verdict::LessExciting(by) => Verdict::LessExciting { by: *by },
        why_not::Verdict::LotFellOnAnother => Verdict::LotFellOnAnother,
    })
}

fn unmet(content: &Content, from: &why_not::UnmetCondition) -> UnmetCondition {
    let vocabulary = &content.vocabulary;
    let seen = from.nearest.as_ref().map(|nearest| nearest.properties());
    // A variable matches any value, so only constants differ.
    let differs = from.wanted.terms().iter().filter(|(property, term)| {
        let value = seen.and_then(|seen| seen.iter().find(|(known, _)| known == property));
        matches!(term, Term::Constant(wanted) if value.map(|(_, value)| value) != Some(wanted))
    });
    UnmetCondition {
        wanted: text::pattern(vocabulary, &from.wanted),
        nearest: from.nearest.as_ref().map(|seen| text::observation(vocabulary, seen)),
        differs: match seen {
            Some(_) => differs.map(|(property, _)| text::property(vocabulary, *property)).collect(),
            None => Vec::new(),
        },
        constrained: from.constrained,
    }
}
