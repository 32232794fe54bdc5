//! Choosing what to do: "the schema with the highest excitation value is then selected for execution"
//! (paper, II-C), and its resolution to a primitive.

use rustc_hash::FxHashSet;

use crate::babbling;
use crate::bound::Bound;
use crate::chaining::{self, Access, BINDINGS_MAX, Reach, achieve, can_do};
use crate::decision::{
    CANDIDATES_KEPT_MAX, Candidate, Decision, Reason, Role, Subject, TERMS_KEPT_MAX, Term,
};
use crate::effect::{ChainLink, Execution};
use crate::excitation::{self, Perceived};
use crate::memory::Memory;
use crate::observation::{Substitution, bindings};
use crate::random::Random;
use crate::schema::{ObservationId, SchemaId};
use crate::target_action::reliability;
use crate::vocabulary::{BodyId, PrimitiveId};
use crate::world_state::WorldState;

/// A candidate as it is compared; its terms are worked out only when it is to be shown.
#[derive(Clone, Debug)]
struct Scored {
    subject: Subject,
    binding: Substitution,
    carrier: Option<SchemaId>,
    access: Option<Access>,
    distance: u32,
    excitation: f64,
    reliability: f64,
    drive: Option<(Role, f64)>,
}

/// Everything that could be done now, in canonical order: concrete schemas by number, generalised ones by
/// number and binding, primitives by number.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    candidates: Vec<Scored>,
    /// The highest excitation; 0 when nothing is exciting.
    pub(crate) top: f64,
}

/// What is to be decided about.
pub(crate) struct Situation<'a> {
    pub(crate) memory: &'a Memory,
    pub(crate) body: BodyId,
    pub(crate) world: &'a WorldState,
    pub(crate) perceived: &'a Perceived,
    pub(crate) reach: &'a Reach,
    /// Schemas that the stage still asks to be tried (II-G), ordered.
    pub(crate) unhabituated: &'a [SchemaId],
    /// Concrete schemas that can be executed here, ordered.
    pub(crate) executable: &'a [SchemaId],
}

/// The observations of `world` that memory knows by number.
pub(crate) fn known_ids(memory: &Memory, world: &WorldState) -> FxHashSet<ObservationId> {
    world.observations().iter().filter_map(|observation| memory.index().id(observation)).collect()
}

impl Choice {
    /// Scores everything that could be done.
    pub(crate) fn new(situation: &Situation<'_>) -> Self {
        let mut candidates = concrete(situation);
        candidates.extend(generalised(situation));
        candidates.extend(primitives(situation));
        if candidates.is_empty() {
            // Nothing resembles anything known: every executable schema is as good as any other.
            candidates =
                situation.executable.iter().filter_map(|id| score_concrete(situation, *id)).collect();
        }
        let top = candidates.iter().map(|c| c.excitation).fold(0.0, f64::max);
        Self { candidates, top }
    }

    /// Takes the most excited candidate, drawing among equals, and resolves it to a primitive.
    pub(crate) fn decide(
        &self,
        situation: &Situation<'_>,
        random: &mut Random,
    ) -> Option<(Execution, Decision)> {
        let best: Vec<usize> =
            (0..self.candidates.len()).filter(|at| self.candidates[*at].excitation == self.top).collect();
        let chosen = *best.get(random.below(best.len()))?;
        let execution = resolve(situation, &self.candidates[chosen])?;
        let reason = if best.len() > 1 { Reason::Tie } else { Reason::Excitation };
        let decision = self.explain(situation, chosen, best.len(), reason, execution.action);
        Some((execution, decision))
    }

    fn explain(
        &self,
        situation: &Situation<'_>,
        chosen: usize,
        ties: usize,
        reason: Reason,
        action: PrimitiveId,
    ) -> Decision {
        let mut order: Vec<usize> = (0..self.candidates.len()).collect();
        order.sort_by(|a, b| {
            let excitation = |at: usize| self.candidates[at].excitation;
            excitation(*b).total_cmp(&excitation(*a)).then_with(|| (*b == chosen).cmp(&(*a == chosen)))
        });
        order.truncate(CANDIDATES_KEPT_MAX);
        let kept = order.iter().position(|at| *at == chosen).unwrap_or(0);
        let mut room = TERMS_KEPT_MAX;
        let candidates = order.iter().map(|at| {
            let candidate = show(situation, &self.candidates[*at], room);
            room = room.saturating_sub(candidate.terms.len());
            candidate
        });
        Decision {
            step: situation.memory.content().step,
            body: situation.body,
            world: situation.world.clone(),
            candidates: candidates.collect(),
            candidates_total: self.candidates.len(),
            chosen: kept,
            ties,
            reason,
            action,
            search_truncated: situation.reach.truncated,
        }
    }
}

/// Concrete schemas with any excitation: only those that share a value with something perceived have.
fn concrete(situation: &Situation<'_>) -> Vec<Scored> {
    let index = situation.memory.index();
    let mut schemas: Vec<SchemaId> = situation
        .world
        .observations()
        .iter()
        .flat_map(|observation| observation.properties())
        .flat_map(|(property, value)| index.with_value(*property, *value))
        .flat_map(|observation| index.referring(*observation))
        .chain(situation.unhabituated)
        .copied()
        .collect();
    schemas.sort_unstable();
    schemas.dedup();
    let scored = schemas.into_iter().filter_map(|id| score_concrete(situation, id));
    scored.filter(|scored| scored.excitation > 0.0).collect()
}

fn score_concrete(situation: &Situation<'_>, id: SchemaId) -> Option<Scored> {
    let memory = situation.memory;
    let concrete = memory.content().schema(id)?.concrete()?;
    if !can_do(memory, situation.body, concrete.action) {
        return None;
    }
    let access = situation.reach.access(&concrete.pre)?;
    let distance = access.preceding + 1;
    let reliability = reliability(memory, concrete.action);
    let mut sum = excitation::sum(memory, id, &Substitution::new(), situation.perceived, reliability);
    let drive = situation.unhabituated.binary_search(&id).is_ok().then(|| {
        let value = memory.parameters().babbling_excitation * reliability;
        sum += value;
        (Role::Habituation, value)
    });
    Some(Scored {
        subject: Subject::Schema(id),
        binding: Substitution::new(),
        carrier: None,
        access: Some(access),
        distance,
        excitation: sum / f64::from(distance),
        reliability,
        drive,
    })
}

/// Generalised schemas, once for each binding that the world state gives. A concrete schema with the same
/// pre-conditions and action, example or counter-example, stands in for them: "in any cases where counter
/// examples exist that contradict generalised solutions these are selected instead" (IV-A).
fn generalised(situation: &Situation<'_>) -> Vec<Scored> {
    let memory = situation.memory;
    let mut found = Vec::new();
    for id in memory.index().generalised() {
        let Some(generalised) = memory.content().schema(*id).and_then(|s| s.generalised()) else { continue };
        for binding in bindings(&generalised.pre, situation.world.observations(), BINDINGS_MAX) {
            let target: Option<Vec<_>> = generalised.target.iter().map(|p| p.apply(&binding)).collect();
            let Some(achievement) =
                target.and_then(|target| achieve(memory, situation.reach, situation.body, &target))
            else {
                continue;
            };
            found.extend(score_generalised(situation, *id, binding, &achievement));
        }
    }
    found
}

fn score_generalised(
    situation: &Situation<'_>,
    id: SchemaId,
    binding: Substitution,
    achievement: &chaining::Achievement,
) -> Option<Scored> {
    let memory = situation.memory;
    let action = memory.content().schema(achievement.carrier)?.concrete()?.action;
    let bound = Bound::new(memory.content(), id, &binding)?;
    let pre: Vec<_> = bound.pre.iter().collect();
    if achievement.access.preceding == 0 && memory.index().exact(&pre, action).is_some() {
        return None;
    }
    let distance = achievement.access.preceding + 1;
    let reliability = reliability(memory, action);
    let sum = excitation::sum(memory, id, &binding, situation.perceived, reliability);
    (sum > 0.0).then(|| Scored {
        subject: Subject::Schema(id),
        binding,
        carrier: Some(achievement.carrier),
        access: Some(achievement.access),
        distance,
        excitation: sum / f64::from(distance),
        reliability,
        drive: None,
    })
}

fn primitives(situation: &Situation<'_>) -> Vec<Scored> {
    let memory = situation.memory;
    let uncovered = babbling::uncovered(memory, situation.body, situation.executable).into_iter();
    let scored = uncovered.map(|primitive| {
        let reliability = reliability(memory, primitive);
        let value = memory.parameters().babbling_excitation * reliability;
        Scored {
            subject: Subject::Primitive(primitive),
            binding: Substitution::new(),
            carrier: None,
            access: None,
            distance: 1,
            excitation: value,
            reliability,
            drive: Some((Role::Babbling, value)),
        }
    });
    scored.collect()
}

/// What has to be sent to execute the candidate: its own primitive, or the first of a chain to it.
fn resolve(situation: &Situation<'_>, scored: &Scored) -> Option<Execution> {
    let schema = match scored.subject {
        Subject::Primitive(action) => {
            return Some(Execution {
                schema: None,
                binding: Substitution::new(),
                carrier: None,
                action,
                before: situation.world.clone(),
                chain: Vec::new(),
            });
        }
        Subject::Schema(schema) => schema,
    };
    let last = ChainLink { schema, binding: scored.binding.clone(), carrier: scored.carrier };
    let mut chain = scored.access.map_or(Vec::new(), |access| situation.reach.chain(access));
    chain.push(last);
    begin(situation.memory, situation.world, chain)
}

/// The execution of the first link of `chain` in `world`.
fn begin(memory: &Memory, world: &WorldState, mut chain: Vec<ChainLink>) -> Option<Execution> {
    if chain.is_empty() {
        return None;
    }
    let ChainLink { schema, binding, carrier } = chain.remove(0);
    let action = memory.content().schema(carrier.unwrap_or(schema))?.concrete()?.action;
    Some(Execution { schema: Some(schema), binding, carrier, action, before: world.clone(), chain })
}

/// Goes on with a chain begun before, if the present outcome allows its next schema.
pub(crate) fn continue_chain(
    situation: &Situation<'_>,
    chain: &[ChainLink],
) -> Option<(Execution, Decision)> {
    let memory = situation.memory;
    let next = chain.first()?;
    let holds = |schema: SchemaId, binding: &Substitution| {
        Bound::new(memory.content(), schema, binding).is_some_and(|b| situation.world.satisfies(&b.pre))
    };
    let retired =
        memory.content().schema(next.schema)?.generalised().is_some_and(|generalised| generalised.retired);
    let allowed = !retired
        && holds(next.schema, &next.binding)
        && next.carrier.is_none_or(|carrier| holds(carrier, &Substitution::new()));
    let execution = allowed.then(|| begin(memory, situation.world, chain.to_vec())).flatten()?;
    let reliability = reliability(memory, execution.action);
    let sum = excitation::sum(memory, next.schema, &next.binding, situation.perceived, reliability);
    let scored = Scored {
        subject: Subject::Schema(next.schema),
        binding: next.binding.clone(),
        carrier: next.carrier,
        access: None,
        distance: 1,
        excitation: sum,
        reliability,
        drive: None,
    };
    let choice = Choice { top: sum, candidates: vec![scored] };
    let decision = choice.explain(situation, 0, 1, Reason::Chain, execution.action);
    Some((execution, decision))
}

/// The candidate with its terms, at most `room` of them one by one.
fn show(situation: &Situation<'_>, scored: &Scored, room: usize) -> Candidate {
    let mut terms = match scored.subject {
        Subject::Schema(schema) => {
            let Situation { memory, world, .. } = situation;
            excitation::terms(memory, schema, &scored.binding, world, scored.reliability, room)
        }
        Subject::Primitive(_) => Vec::new(),
    };
    terms.extend(scored.drive.map(|(role, value)| Term {
        role,
        pair: None,
        shared: 0,
        attention: 0,
        probability: 1.0,
        weight: scored.reliability,
        value,
    }));
    Candidate {
        subject: scored.subject,
        binding: scored.binding.clone(),
        distance: scored.distance,
        excitation: scored.excitation,
        terms,
    }
}
