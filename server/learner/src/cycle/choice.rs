//! Choosing what to do: "the schema with the highest excitation value is then selected for execution"
//! (paper, II-C), and its resolution to a primitive.

use std::borrow::Cow;
use std::cell::OnceCell;

use crate::cycle::babbling;
use crate::cycle::chaining::{Access, Achievement, Reach};
use crate::cycle::claims;
use crate::cycle::curiosity::Curiosity;
use crate::cycle::excitation::{self, LawExcitation, PairCounts, Percepts, Resemblance};
use crate::cycle::frontier::{self, Frontier};
use crate::cycle::goals;
use crate::cycle::match_cache::MatchCache;
use crate::cycle::superschema::{self, achieved};
use crate::memory::Memory;
use crate::memory::evidence::Foresight;
use crate::memory::instance::Instance;
use crate::nouns::decision::{CANDIDATES_KEPT_MAX, Candidate, Decision, Reason, Role, Subject};
use crate::nouns::execution::{ChainLink, Execution};
use crate::nouns::observation::Substitution;
use crate::nouns::random::Random;
use crate::nouns::schema::SchemaId;
use crate::nouns::terms::{Drive, TermSource};
use crate::nouns::vocabulary::{BodyId, PrimitiveId};
use crate::nouns::world_state::WorldState;

/// After so many executions it is known whether anything comes of a primitive.
const TRIED: u32 = 2;

/// A generalised schema under a binding, or any candidate that is to be shown.
#[derive(Clone, Debug)]
struct Contender {
    subject: Subject,
    binding: Substitution,
    /// What its pre-conditions are under a binding, as places of the world state; none if that is not known.
    places: Option<Vec<usize>>,
    carrier: Option<SchemaId>,
    /// The schemas that achieve the rest of its target before the carrier does, in order.
    before: Vec<SchemaId>,
    access: Option<Access>,
    distance: u32,
    excitation: f64,
    /// w of equation 1, before it is shared among what is perceived.
    worth: f64,
    drives: [Option<Drive>; 2],
}

/// A candidate, in the order in which equals are drawn from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum ContenderKey {
    Concrete(SchemaId),
    /// As an index into the generalised ones.
    Generalised(usize),
    Primitive(PrimitiveId),
    Frontier,
}

/// Everything that could be done now. There may be tens of thousands: of concrete schemas and primitives only the
/// excitation is kept.
#[derive(Clone, Debug)]
pub(crate) struct Choice {
    concrete: Vec<(f64, SchemaId)>,
    generalised: Vec<Contender>,
    primitives: Vec<(f64, PrimitiveId)>,
    /// What draws it elsewhere, if that is more exciting than everything else.
    frontier: Option<Frontier>,
    /// The highest excitation; 0 when nothing is exciting.
    pub(crate) top: f64,
}

/// What is to be decided about.
pub(crate) struct Situation<'a> {
    pub(crate) body: BodyId,
    pub(crate) world: &'a WorldState,
    pub(crate) perceived: &'a PairCounts,
    pub(crate) reach: &'a Reach,
    /// Schemas that the stage still asks to be tried (II-G), ordered.
    pub(crate) unhabituated: &'a [SchemaId],
    /// Concrete schemas that can be executed here, ordered.
    pub(crate) executable: &'a [SchemaId],
    /// What drives it beside equation 1.
    pub(crate) curiosity: &'a Curiosity,
}

impl Situation<'_> {
    /// The drive to carry a primitive out, if that is done at once.
    fn drive(&self, memory: &Memory, primitive: PrimitiveId, access: Access) -> Option<Drive> {
        if access.preceding == 0 { self.curiosity.drive(memory, primitive) } else { None }
    }
}

impl Choice {
    /// Scores everything that could be done.
    pub(crate) fn new(
        memory: &Memory,
        situation: &Situation<'_>,
        matched: &mut MatchCache,
        foresight: &mut Foresight,
    ) -> Self {
        let mut concrete = concrete(memory, situation);
        let generalised = generalised(memory, situation, matched);
        let primitives = primitives(memory, situation);
        if concrete.is_empty() && generalised.is_empty() && primitives.is_empty() {
            // Nothing resembles anything known: every executable schema is as good as any other.
            let executable = situation.executable.iter();
            concrete = executable
                .filter_map(|id| Some((access(memory, situation, *id).map(|_| 0.0)?, *id)))
                .collect();
        }
        let mut choice = Self { concrete, generalised, primitives, frontier: None, top: 0.0 };
        choice.top = choice.all().map(|(excitation, _)| excitation).fold(0.0, f64::max);
        let drive = memory.parameters().babbling_excitation;
        let Situation { body, world, curiosity, .. } = *situation;
        // Where nothing drives it, it is drawn nowhere.
        if drive > 0.0 {
            choice.frontier = frontier::search(memory, body, world, curiosity, choice.top / drive, foresight);
            choice.top = choice
                .frontier
                .as_ref()
                .map_or(choice.top, |found| drive * found.weight / f64::from(found.distance));
        }
        choice
    }

    /// All of them that are here, first those that are mostly the most exciting.
    fn all(&self) -> impl Iterator<Item = (f64, ContenderKey)> + '_ {
        let concrete =
            self.concrete.iter().map(|(excitation, id)| (*excitation, ContenderKey::Concrete(*id)));
        let generalised = self.generalised.iter().enumerate();
        let generalised = generalised.map(|(at, scored)| (scored.excitation, ContenderKey::Generalised(at)));
        let primitives =
            self.primitives.iter().map(|(excitation, id)| (*excitation, ContenderKey::Primitive(*id)));
        generalised.chain(primitives).chain(concrete)
    }

    /// Takes the most excited candidate, drawing among equals, and resolves it to a primitive.
    pub(crate) fn decide(
        &self,
        memory: &Memory,
        situation: &Situation<'_>,
        random: &mut Random,
    ) -> Option<(Execution, Decision)> {
        // What draws it elsewhere is there only if it is the most exciting.
        let mut best: Vec<_> = self.frontier.iter().map(|_| ContenderKey::Frontier).collect();
        self.all().filter(|(excitation, _)| *excitation == self.top).for_each(|(_, which)| best.push(which));
        best.sort_unstable();
        let chosen = *best.get(random.below(best.len()))?;
        let execution = match &self.frontier {
            Some(found) => towards(memory, situation, found),
            None => resolve(memory, situation, &*self.scored(memory, situation, self.top, chosen)?)?,
        };
        let reason = if best.len() > 1 { Reason::Tie } else { Reason::Excitation };
        let (shown, at) = self.most_excited(memory, situation, chosen);
        let mut decision = explain(memory, situation, &shown, reason, execution.action);
        decision.chosen = at;
        decision.ties = best.len();
        let here = self.concrete.len() + self.generalised.len() + self.primitives.len();
        decision.candidates_total = here + usize::from(self.frontier.is_some());
        Some((execution, decision))
    }

    /// The candidates to be shown, the most excited first (of equals the chosen one), and where the chosen one is.
    fn most_excited(
        &self,
        memory: &Memory,
        situation: &Situation<'_>,
        chosen: ContenderKey,
    ) -> (Vec<Cow<'_, Contender>>, usize) {
        let first = |a: &(f64, ContenderKey), b: &(f64, ContenderKey)| {
            let rest = |which: ContenderKey| (which != chosen, which);
            b.0.total_cmp(&a.0).then_with(|| rest(a.1).cmp(&rest(b.1)))
        };
        let mut kept: Vec<(f64, ContenderKey)> = Vec::with_capacity(CANDIDATES_KEPT_MAX + 1);
        kept.extend(self.frontier.iter().map(|_| (self.top, ContenderKey::Frontier)));
        self.all().for_each(|candidate| {
            let full = kept.len() == CANDIDATES_KEPT_MAX;
            if full && kept.last().is_some_and(|last| first(last, &candidate).is_lt()) {
                return;
            }
            let at = kept.partition_point(|known| first(known, &candidate).is_lt());
            kept.truncate(CANDIDATES_KEPT_MAX - 1);
            kept.insert(at, candidate);
        });
        let at = kept.iter().position(|(_, which)| *which == chosen).unwrap_or(0);
        (kept.into_iter().filter_map(|(e, which)| self.scored(memory, situation, e, which)).collect(), at)
    }

    /// A candidate with all that it takes to show or resolve it.
    fn scored(
        &self,
        memory: &Memory,
        situation: &Situation<'_>,
        excitation: f64,
        which: ContenderKey,
    ) -> Option<Cow<'_, Contender>> {
        let (subject, action) = match which {
            ContenderKey::Concrete(id) => (Subject::Schema(id), memory.index().outline(id)?.action),
            ContenderKey::Generalised(at) => return self.generalised.get(at).map(Cow::Borrowed),
            ContenderKey::Primitive(primitive) => (Subject::Primitive(primitive), primitive),
            ContenderKey::Frontier => return self.elsewhere(memory, situation).map(Cow::Owned),
        };
        let (access, drives) = match which {
            ContenderKey::Concrete(id) => {
                let wanting = situation.unhabituated.binary_search(&id).is_ok();
                let drive = Drive { role: Role::Habituation, ..babbling_drive(memory, action) };
                let access = access(memory, situation, id);
                let curious = access.and_then(|access| situation.drive(memory, action, access));
                (access, [wanting.then_some(drive), curious])
            }
            _ => {
                let tried = tried(memory, situation, action);
                (None, [Some(tried.unwrap_or_else(|| babbling_drive(memory, action))), None])
            }
        };
        let distance = access.map_or(1, |access| access.preceding + 1);
        Some(Cow::Owned(Contender {
            subject,
            binding: Substitution::new(),
            places: None,
            carrier: None,
            before: Vec::new(),
            access,
            distance,
            excitation,
            worth: situation.curiosity.worth(memory, action) * situation.curiosity.part(access),
            drives,
        }))
    }

    /// What draws it elsewhere, as a candidate.
    fn elsewhere(&self, memory: &Memory, situation: &Situation<'_>) -> Option<Contender> {
        let found = self.frontier.as_ref()?;
        let value = memory.parameters().babbling_excitation * found.weight;
        let drive = Drive { role: Role::Curiosity, weight: found.weight, value };
        Some(Contender {
            subject: Subject::Primitive(found.new),
            binding: Substitution::new(),
            places: None,
            carrier: None,
            before: Vec::new(),
            access: None,
            distance: found.distance,
            excitation: self.top,
            worth: situation.curiosity.worth(memory, found.new),
            drives: [Some(drive), None],
        })
    }
}

/// The decision for the first of these candidates.
fn explain(
    memory: &Memory,
    situation: &Situation<'_>,
    shown: &[Cow<'_, Contender>],
    reason: Reason,
    action: PrimitiveId,
) -> Decision {
    let terms = keep(memory, situation, shown).terms();
    let candidates_total = shown.len();
    let candidates = shown.iter().zip(terms).map(|(scored, terms)| Candidate {
        subject: scored.subject,
        binding: scored.binding.clone(),
        together: match scored.before[..] {
            [] => Vec::new(),
            ref before => before.iter().copied().chain(scored.carrier).collect(),
        },
        distance: scored.distance,
        excitation: scored.excitation,
        terms,
    });
    Decision {
        step: memory.content().step + 1,
        body: situation.body,
        world: situation.world.clone(),
        candidates: candidates.collect(),
        candidates_total,
        chosen: 0,
        ties: 1,
        reason,
        action,
        search_truncated: situation.reach.truncated,
        goal: None,
    }
}

/// What the terms of these candidates will be made of.
fn keep(memory: &Memory, situation: &Situation<'_>, shown: &[Cow<'_, Contender>]) -> TermSource {
    let Situation { world, perceived, curiosity, .. } = *situation;
    let seen = OnceCell::new();
    let seen = || seen.get_or_init(|| Percepts::new(memory, world, perceived));
    // The one that was needed last: there are often many bindings of one law.
    let mut law: Option<LawExcitation<'_>> = None;
    // Most are remembered by little more than their pre-conditions.
    let remembered = shown.iter().map(|scored| scored.places.as_ref().map_or(0, Vec::len) + 2);
    let mut kept = TermSource::new(world, shown.len(), remembered.sum());
    for scored in shown {
        let Contender { subject, binding, places, worth, drives, .. } = &**scored;
        let weight = curiosity.weight(*worth);
        kept.add(*drives, |list| match (*subject, places) {
            (Subject::Schema(id), Some(places)) => {
                if law.as_ref().is_none_or(|law| law.id != id) {
                    law = LawExcitation::new(memory, id, world, seen());
                }
                law.iter().for_each(|law| law.remember(binding, places, weight, list));
            }
            (Subject::Schema(id), None) => excitation::remember(memory, id, binding, weight, list),
            (Subject::Primitive(_), _) => (),
        });
    }
    kept
}

/// How a concrete schema can be made executable; none if it can't, or not by this body.
fn access(memory: &Memory, situation: &Situation<'_>, id: SchemaId) -> Option<Access> {
    let Situation { body, reach, .. } = *situation;
    let outline = memory.index().outline(id)?;
    memory.content().vocabulary.can_do(body, outline.action).then(|| reach.way(outline.group)).flatten()
}

/// Concrete schemas with any excitation.
fn concrete(memory: &Memory, situation: &Situation<'_>) -> Vec<(f64, SchemaId)> {
    let unhabituated = situation.unhabituated;
    let index = memory.index();
    let resemblance = Resemblance::new(memory, situation.world);
    let worths = worths(memory, situation);
    let mut found = Vec::with_capacity(situation.executable.len());
    for (access, group) in situation.reach.ways(index.groups()) {
        let distance = f64::from(access.preceding + 1);
        let part = situation.curiosity.part(Some(access));
        let reliable = resemblance.of_pre(&group.pre, situation.curiosity.weight(1.0));
        for id in &group.schemas {
            let Some(outline) = index.outline(*id) else { continue };
            let Some(worth) = worths.get(outline.action.0 as usize).copied().flatten() else { continue };
            let worth = worth * part;
            let weight = situation.curiosity.weight(worth);
            let pre = if worth == 1.0 { reliable } else { resemblance.of_pre(&group.pre, weight) };
            let mut sum = resemblance.sum(*id, outline, pre, weight);
            if !unhabituated.is_empty() && unhabituated.binary_search(id).is_ok() {
                sum += babbling_drive(memory, outline.action).value;
            }
            if let Some(curious) = situation.drive(memory, outline.action, access) {
                sum += curious.value;
            }
            let excitation = sum / distance;
            if excitation > 0.0 {
                found.push((excitation, *id));
            }
        }
    }
    found
}

/// What each primitive is worth in equation 1, by number; none for what the body does not have.
fn worths(memory: &Memory, situation: &Situation<'_>) -> Vec<Option<f64>> {
    let vocabulary = &memory.content().vocabulary;
    let mut known = vec![None; vocabulary.primitives().len()];
    let body = vocabulary.bodies().get(usize::from(situation.body.0));
    for primitive in body.iter().flat_map(|b| &b.repertoire) {
        if let Some(known) = known.get_mut(primitive.0 as usize) {
            *known = Some(situation.curiosity.worth(memory, *primitive));
        }
    }
    known
}

/// Generalised schemas, once for each binding that the world state gives. A concrete schema with the same
/// pre-conditions and action, example or counter-example, stands in for them: "in any cases where counter
/// examples exist that contradict generalised solutions these are selected instead" (IV-A).
fn generalised(memory: &Memory, situation: &Situation<'_>, matched: &mut MatchCache) -> Vec<Contender> {
    let Situation { body, world, perceived, reach, .. } = *situation;
    let index = memory.index();
    let mut found = Vec::new();
    if index.generalised().is_empty() {
        return found;
    }
    let seen = Percepts::new(memory, world, perceived);
    for (id, law) in memory.laws(index.generalised()) {
        let Some(generally) = LawExcitation::new(memory, id, world, &seen) else { continue };
        for (binding, places) in matched.of(index, id, law, world) {
            let Some(target) = law.target_under(&binding) else { continue };
            let Some(achieved) = achieved(memory, reach, body, &target, world) else { continue };
            let Achievement { carrier, access } = achieved.last;
            let Some(action) = index.outline(carrier).map(|outline| outline.action) else { continue };
            if memory.content().mechanisms.claims
                && !claims::allow(memory, (body, action), world, (law, &binding), &achieved.held)
            {
                continue;
            }
            let before = achieved.before;
            let groups = index.groups();
            let known = || groups.exact(groups.with_pre(&seen.ids(&places)?)?, action);
            if access.preceding == 0 && known().is_some() {
                continue;
            }
            let part = situation.curiosity.part(Some(access));
            let worth = situation.curiosity.worth(memory, action) * part;
            let curious = situation.drive(memory, action, access);
            let sum = generally.sum(&binding, &places, situation.curiosity.weight(worth));
            let sum = curious.map_or(sum, |drive| sum + drive.value);
            let distance = access.preceding + 1;
            let excitation = sum / f64::from(distance);
            if sum > 0.0 {
                found.push(Contender {
                    subject: Subject::Schema(id),
                    binding,
                    places: Some(places),
                    carrier: Some(carrier),
                    before,
                    access: Some(access),
                    distance,
                    excitation,
                    worth,
                    drives: [None, curious],
                });
            }
        }
    }
    found
}

/// Primitives that no schema covers here, with the drive to try them.
fn primitives(memory: &Memory, situation: &Situation<'_>) -> Vec<(f64, PrimitiveId)> {
    let uncovered = babbling::uncovered(memory, situation.body, situation.executable).into_iter();
    let drive = memory.parameters().babbling_excitation;
    let value = |primitive| match tried(memory, situation, primitive) {
        Some(curious) => curious.value,
        None => drive * memory.content().reliability(primitive),
    };
    uncovered.map(|primitive| (value(primitive), primitive)).collect()
}

/// The drive to do again what no schema covers here, with curiosity, when it is known whether anything comes of the primitive: where nothing
/// does, no schema will ever cover it, and it must not draw for ever as what was never tried does.
#[inline]
fn tried(memory: &Memory, situation: &Situation<'_>, primitive: PrimitiveId) -> Option<Drive> {
    let curious = situation.curiosity.drive(memory, primitive)?;
    (memory.content().carried_out(primitive) >= TRIED).then_some(curious)
}

/// The drive to try a primitive at all.
fn babbling_drive(memory: &Memory, primitive: PrimitiveId) -> Drive {
    let weight = memory.content().reliability(primitive);
    Drive { role: Role::Babbling, weight, value: memory.parameters().babbling_excitation * weight }
}

/// What has to be sent to get where something draws it: the first of a chain, as far as schemas say what comes about.
fn towards(memory: &Memory, situation: &Situation<'_>, found: &Frontier) -> Execution {
    let (execution, _) = carry_out(memory, situation, found.first);
    let links =
        found.way.iter().map_while(|(world, action)| goals::in_use(memory, situation.body, world, *action));
    let chain = if execution.schema.is_some() { links.collect() } else { Vec::new() };
    Execution { chain, ..execution }
}

/// What has to be sent to execute the candidate: its own primitive, or the first of a chain to it.
fn resolve(memory: &Memory, situation: &Situation<'_>, scored: &Contender) -> Option<Execution> {
    let schema = match scored.subject {
        Subject::Primitive(action) => {
            return Some(Execution {
                schema: None,
                binding: Substitution::new(),
                carrier: None,
                action,
                before: situation.world.clone(),
                chain: Vec::new(),
                for_goal: false,
            });
        }
        Subject::Schema(schema) => schema,
    };
    let last = ChainLink { schema, binding: scored.binding.clone(), carrier: scored.carrier };
    let mut chain = scored.access.map_or(Vec::new(), |access| situation.reach.chain(access));
    chain.extend(superschema::links(&scored.before));
    chain.push(last);
    begin(memory, situation.world, chain)
}

/// The execution of the first link of `chain` in `world`.
fn begin(memory: &Memory, world: &WorldState, mut chain: Vec<ChainLink>) -> Option<Execution> {
    if chain.is_empty() {
        return None;
    }
    let ChainLink { schema, binding, carrier } = chain.remove(0);
    let action = memory.content().concrete(carrier.unwrap_or(schema))?.action;
    let before = world.clone();
    Some(Execution { schema: Some(schema), binding, carrier, action, before, chain, for_goal: false })
}

/// Goes on with a chain begun before, if the present outcome allows its next schema.
pub(crate) fn continue_chain(
    memory: &Memory,
    situation: &Situation<'_>,
    chain: &[ChainLink],
) -> Option<(Execution, Decision)> {
    let next = chain.first()?;
    let holds = |schema: SchemaId, binding: &Substitution| {
        Instance::new(memory.content(), schema, binding).is_some_and(|b| situation.world.satisfies(&b.pre))
    };
    let retired = memory.content().generalised(next.schema).is_some_and(|generalised| generalised.retired);
    let allowed = !retired
        && holds(next.schema, &next.binding)
        && next.carrier.is_none_or(|carrier| holds(carrier, &Substitution::new()))
        && superschema::is_held(memory, next, situation.world);
    let execution = allowed.then(|| begin(memory, situation.world, chain.to_vec())).flatten()?;
    let decision = follow(memory, situation, &execution, Reason::Chain);
    Some((execution, decision))
}

/// Carries a primitive out, as the schema that says what comes of it here, if any does.
pub(crate) fn carry_out(
    memory: &Memory,
    situation: &Situation<'_>,
    action: PrimitiveId,
) -> (Execution, Decision) {
    let Situation { body, world, .. } = *situation;
    let (schema, binding, carrier) = match goals::in_use(memory, body, world, action) {
        Some(ChainLink { schema, binding, carrier }) => (Some(schema), binding, carrier),
        None => (None, Substitution::new(), None),
    };
    let (before, chain) = (world.clone(), Vec::new());
    let execution = Execution { schema, binding, carrier, action, before, chain, for_goal: false };
    let decision = follow(memory, situation, &execution, Reason::Goal);
    (execution, decision)
}

/// The decision for an execution that was decided before.
fn follow(memory: &Memory, situation: &Situation<'_>, execution: &Execution, reason: Reason) -> Decision {
    let Execution { action, ref binding, carrier, .. } = *execution;
    let worth = situation.curiosity.worth(memory, action);
    let weight = situation.curiosity.weight(worth);
    let sum = |schema| excitation::sum(memory, schema, binding, situation.perceived, weight);
    let scored = Contender {
        subject: execution.schema.map_or(Subject::Primitive(action), Subject::Schema),
        binding: binding.clone(),
        places: None,
        carrier,
        before: Vec::new(),
        access: None,
        distance: 1,
        excitation: execution.schema.map_or(0.0, sum),
        worth,
        drives: [None, None],
    };
    explain(memory, situation, &[Cow::Owned(scored)], reason, action)
}
