//! Why a schema was not executed. The decision is weighed once more, in memory as it was when it was made and by the same rules, and
//! told from the side of one schema.

use crate::cycle::babbling::executable;
use crate::cycle::chaining::{Access, Reach};
use crate::cycle::claims;
use crate::cycle::curiosity::Curiosity;
use crate::cycle::excitation::{self, PairCounts};
use crate::cycle::habituation::unhabituated;
use crate::cycle::stages;
use crate::cycle::superschema::{Superschema, achieved};
use crate::memory::Memory;
use crate::memory::instance::Instance;
use crate::memory::matching::can_match;
use crate::nouns::curriculum::Curriculum;
use crate::nouns::decision::{Candidate, Decision, Reason, Role, Subject};
use crate::nouns::execution::ChainLink;
use crate::nouns::observation::{Observation, Pattern, Substitution, Term};
use crate::nouns::schema::{Concrete, Form, Generalised, SchemaId};
use crate::nouns::terms::{Drive, TermSource, Weight};
use crate::nouns::vocabulary::PrimitiveId;

/// The obstacle in a schema's way, and how near the schema came to being chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Reweighing {
    /// The obstacle; of a generalised schema, the obstacle in the way of the binding that came nearest.
    pub verdict: Verdict,
    /// That binding.
    pub binding: Substitution,
    /// The number of bindings that were looked at.
    pub bindings: usize,
    /// Its excitation term by term (equation (1)), where it could have been executed, at once or by a chain.
    pub candidate: Option<Candidate>,
    /// The schemas to be executed before it.
    pub chain: Vec<ChainLink>,
    /// The primitive that it comes to, where that is known.
    pub action: Option<PrimitiveId>,
    /// Whether it was known well enough for the stage (II-G); none where the stage was not habituating.
    pub habituated: Option<bool>,
    /// Whether the search for chains used up its budget.
    pub search_truncated: bool,
}

/// The obstacle in a schema's way.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// None: the schema was chosen.
    Chosen,
    /// None: the schema was executed for the sake of this other one, as the carrier of its target or as the first of a chain to it.
    ExecutedFor(SchemaId),
    /// A chain or a plan was being followed, so nothing else was weighed.
    NotWeighed,
    /// It failed too often, and is never chosen again.
    Retired,
    /// The body does not have its action.
    NotInRepertoire,
    /// Its pre-conditions do not hold, and no chain that was found leads to where they do.
    PreConditions(Vec<UnmetCondition>),
    /// No schema achieves its target from here.
    TargetNotAchievable(Vec<Observation>),
    /// This concrete schema is for exactly this case, and is selected instead (IV-A).
    StoodInFor(SchemaId),
    /// It is a law, and what claims make of its action here is another one, or none.
    OtherClaims,
    /// No perceived observation resembles any that it remembers.
    NotExciting,
    /// Another candidate was more exciting, by so much, in the unit of equation (1).
    LessExciting(f64),
    /// Others were as exciting, and the lot fell on one of them.
    LotFellOnAnother,
}

/// A pre-condition that does not hold.
#[derive(Clone, Debug, PartialEq)]
pub struct UnmetCondition {
    /// The pre-condition.
    pub wanted: Pattern,
    /// The perceived observation of its type that has the most values in common with it; of equals the first.
    pub nearest: Option<Observation>,
    /// Whether the stage does not lift its type.
    pub constrained: bool,
}

/// Why the obstacle can't be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum WeighError {
    /// There is no such schema.
    #[error("there is no such schema")]
    Schema,
    /// Memory is not as it was when the decision was made: weighed once more, it comes out differently.
    #[error("memory is no longer as it was when this was decided")]
    Changed,
}

/// Weighs `decision` once more, from the side of schema `id`. `memory` must be as it was right after the decision's step.
///
/// # Errors
/// When there is no such schema, or memory has changed since so that the decision would come out differently.
pub fn weigh(
    memory: &Memory,
    curriculum: &Curriculum,
    decision: &Decision,
    id: SchemaId,
) -> Result<Reweighing, WeighError> {
    let schema = memory.content().schema(id).ok_or(WeighError::Schema)?;
    let reach = Reach::search(memory, decision.body, &decision.world);
    let executable = executable(memory, decision.body, &memory.index().known_ids(&decision.world));
    let progress = &memory.content().progress;
    let rule = stages::present(memory, curriculum).habituation.as_ref().filter(|_| progress.habituating);
    let first_step = progress.report().map_or(0, |report| report.first_step);
    let wanting = rule.map(|rule| unhabituated(memory, rule, first_step, &executable));
    let perceived = PairCounts::new(&decision.world);
    let curiosity = Curiosity::new(memory, decision.body, &decision.world);
    let scale = Scale { memory, curriculum, decision, perceived, reach, wanting, curiosity };
    scale.check()?;
    let mut weighed = match &schema.form {
        Form::Concrete(concrete) => scale.concrete(id, concrete),
        Form::Generalised(generalised) => scale.generalised(id, generalised),
    };
    weighed.search_truncated = scale.reach.truncated;
    if let Some(verdict) = scale.beyond_weighing(id) {
        weighed.verdict = verdict;
    }
    match weighed.verdict {
        Verdict::LessExciting(by) if by < 0.0 => Err(WeighError::Changed),
        _ => Ok(weighed),
    }
}

struct Scale<'a> {
    memory: &'a Memory,
    curriculum: &'a Curriculum,
    decision: &'a Decision,
    perceived: PairCounts,
    reach: Reach,
    /// What the stage still asks to be tried, if it is at that.
    wanting: Option<Vec<SchemaId>>,
    curiosity: Curiosity,
}

impl Scale<'_> {
    fn chosen(&self) -> Option<&Candidate> {
        self.decision.candidates.get(self.decision.chosen)
    }

    /// Every candidate that was kept must weigh what it weighed.
    fn check(&self) -> Result<(), WeighError> {
        let same = |candidate: &Candidate| {
            let Subject::Schema(id) = candidate.subject else { return true };
            let Some(schema) = self.memory.content().schema(id) else { return false };
            let action = match &schema.form {
                // What is followed is not searched for, so that nothing need lead there any more.
                _ if self.is_followed() => Some((self.decision.action, None)),
                Form::Concrete(concrete) => Some((concrete.action, self.access(id))),
                Form::Generalised(known) => self
                    .achieved(known, &candidate.binding)
                    .map(|(action, found)| (action, Some(found.last.access))),
            };
            let Some((action, access)) = action else { return false };
            let distance = access.map_or(1, |access| access.preceding + 1);
            let excitation = self.excitation(id, &candidate.binding, action, access);
            distance == candidate.distance && excitation.to_bits() == candidate.excitation.to_bits()
        };
        let all = self.decision.candidates.iter().all(same);
        if all && self.chosen().is_some() { Ok(()) } else { Err(WeighError::Changed) }
    }

    /// What is known without any weighing.
    fn beyond_weighing(&self, id: SchemaId) -> Option<Verdict> {
        let chosen = self.chosen()?;
        let Subject::Schema(subject) = chosen.subject else { return None };
        if subject == id {
            return Some(Verdict::Chosen);
        }
        let followed = self.is_followed();
        let (carrier, chain) = match self.memory.content().generalised(subject) {
            Some(known) => self
                .achieved(known, &chosen.binding)
                .map(|(_, found)| (found.last.carrier, found.chain(&self.reach)))
                .unzip(),
            None => (None, self.access(subject).map(|access| self.reach.chain(access))),
        };
        let chain = chain.filter(|_| !followed).unwrap_or_default();
        let first = chain.first();
        let carries = chain.is_empty() && carrier == Some(id);
        if carries || first.is_some_and(|first| first.schema == id || first.carrier == Some(id)) {
            return Some(Verdict::ExecutedFor(subject));
        }
        followed.then_some(Verdict::NotWeighed)
    }

    /// Whether the decision followed a chain or a plan.
    fn is_followed(&self) -> bool {
        matches!(self.decision.reason, Reason::Chain | Reason::Goal)
    }

    fn access(&self, id: SchemaId) -> Option<Access> {
        let outline = self.memory.index().outline(id)?;
        let can = self.memory.content().vocabulary.can_do(self.decision.body, outline.action);
        can.then(|| self.reach.way(outline.group)).flatten()
    }

    /// What would carry the target out under a binding, and from where; and its action.
    fn achieved(&self, known: &Generalised, binding: &Substitution) -> Option<(PrimitiveId, Superschema)> {
        let target = known.target_under(binding)?;
        let achieved = achieved(self.memory, &self.reach, self.decision.body, &target, &self.decision.world)?;
        Some((self.memory.content().concrete(achieved.last.carrier)?.action, achieved))
    }

    /// The drives that add to its excitation: none where something is followed.
    fn drives(&self, id: SchemaId, action: PrimitiveId, access: Option<Access>) -> [Option<Drive>; 2] {
        if self.is_followed() {
            return [None, None];
        }
        let weight = self.memory.content().reliability(action);
        let value = self.memory.parameters().babbling_excitation * weight;
        let wanting = self.wanting.as_ref().is_some_and(|wanting| wanting.binary_search(&id).is_ok());
        let habituation = wanting.then_some(Drive { role: Role::Habituation, weight, value });
        let curious = if access.is_none_or(|access| access.preceding == 0) {
            self.curiosity.drive(self.memory, action)
        } else {
            None
        };
        [habituation, curious]
    }

    /// The weight of equation 1's terms for what `access` leads to.
    fn weight(&self, action: PrimitiveId, access: Option<Access>) -> Weight {
        self.curiosity.weight(self.curiosity.worth(self.memory, action) * self.curiosity.part(access))
    }

    fn excitation(
        &self,
        id: SchemaId,
        binding: &Substitution,
        action: PrimitiveId,
        access: Option<Access>,
    ) -> f64 {
        let weight = self.weight(action, access);
        let sum = excitation::sum(self.memory, id, binding, &self.perceived, weight);
        let drives = self.drives(id, action, access);
        let distance = access.map_or(1, |access| access.preceding + 1);
        drives.iter().flatten().fold(sum, |sum, drive| sum + drive.value) / f64::from(distance)
    }

    /// As a candidate, reached by `access`, and what stood in its way as such.
    fn scored(
        &self,
        id: SchemaId,
        binding: Substitution,
        action: PrimitiveId,
        access: Access,
        achieved: Option<&Superschema>,
    ) -> Reweighing {
        let (memory, distance) = (self.memory, access.preceding + 1);
        let weight = self.weight(action, Some(access));
        let drives = self.drives(id, action, Some(access));
        let mut kept = TermSource::new(&self.decision.world, 1, 0);
        kept.add(drives, |list| excitation::remember(memory, id, &binding, weight, list));
        let excitation = self.excitation(id, &binding, action, Some(access));
        let top = self.decision.candidates.first().map_or(0.0, |candidate| candidate.excitation);
        let verdict = if excitation == top {
            Verdict::LotFellOnAnother
        } else if excitation == 0.0 {
            Verdict::NotExciting
        } else {
            Verdict::LessExciting(top - excitation)
        };
        let candidate = kept.terms().next().map(|terms| {
            let (subject, binding) = (Subject::Schema(id), binding.clone());
            let together = achieved.map_or_else(Vec::new, Superschema::together);
            Candidate { subject, binding, together, distance, excitation, terms }
        });
        let chain = achieved.map_or_else(|| self.reach.chain(access), |found| found.chain(&self.reach));
        Reweighing { candidate, chain, action: Some(action), ..out(verdict, binding) }
    }

    fn concrete(&self, id: SchemaId, concrete: &Concrete) -> Reweighing {
        let weighed = if !self.memory.content().vocabulary.can_do(self.decision.body, concrete.action) {
            out(Verdict::NotInRepertoire, Substitution::new())
        } else if let Some(access) = self.access(id) {
            self.scored(id, Substitution::new(), concrete.action, access, None)
        } else {
            let content = self.memory.content();
            let context = self.decision.world.context(self.memory.rules());
            let wanted = concrete.pre.iter().map(|id| content.observation(*id));
            let lacking = wanted.filter(|wanted| !context.contains(wanted)).map(|o| self.lacking(o.into()));
            out(Verdict::PreConditions(lacking.collect()), Substitution::new())
        };
        let habituated = self.wanting.as_ref().map(|wanting| wanting.binary_search(&id).is_err());
        Reweighing { action: Some(concrete.action), habituated, ..weighed }
    }

    /// The binding that came nearest: the most exciting; else one that was stood in for, then one that excites nothing, then one
    /// where other claims are in force, then one whose target nothing achieves.
    fn generalised(&self, id: SchemaId, known: &Generalised) -> Reweighing {
        if known.retired {
            return out(Verdict::Retired, Substitution::new());
        }
        let world = self.decision.world.observations();
        let found = self.memory.index().bindings(id, known, world);
        let count = found.len();
        let nearness = |weighed: &Reweighing| match &weighed.verdict {
            Verdict::LotFellOnAnother => (5, 0.0),
            Verdict::LessExciting(by) => (4, -by),
            Verdict::StoodInFor(_) => (3, 0.0),
            Verdict::NotExciting => (2, 0.0),
            Verdict::OtherClaims => (1, 0.0),
            _ => (0, 0.0),
        };
        let mut best: Option<Reweighing> = None;
        for binding in found {
            let weighed = self.bound(id, known, binding);
            let nearer = |best: &Reweighing| {
                let (a, b) = (nearness(&weighed), nearness(best));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).is_gt()
            };
            if best.as_ref().is_none_or(nearer) {
                best = Some(weighed);
            }
        }
        let lacking = || out(Verdict::PreConditions(self.unbound(&known.pre)), Substitution::new());
        Reweighing { bindings: count, ..best.unwrap_or_else(lacking) }
    }

    fn bound(&self, id: SchemaId, known: &Generalised, binding: Substitution) -> Reweighing {
        let Some((action, achieved)) = self.achieved(known, &binding) else {
            let target = known.target.iter().filter_map(|pattern| pattern.apply(&binding)).collect();
            return out(Verdict::TargetNotAchievable(target), binding);
        };
        let (memory, world, access) = (self.memory, &self.decision.world, achieved.last.access);
        let body = self.decision.body;
        if memory.content().mechanisms.claims
            && !claims::allow(memory, (body, action), world, (known, &binding), &achieved.held)
        {
            return Reweighing { action: Some(action), ..out(Verdict::OtherClaims, binding) };
        }
        let bound = Instance::new(self.memory.content(), id, &binding);
        let pre: Vec<_> = bound.iter().flat_map(|bound| &bound.pre).collect();
        let exact = self.memory.index().exact(&pre, action).filter(|_| access.preceding == 0);
        match exact {
            Some(exact) => Reweighing { action: Some(action), ..out(Verdict::StoodInFor(exact), binding) },
            None => self.scored(id, binding, action, access, Some(&achieved)),
        }
    }

    /// Patterns that nothing perceived matches; when each has a match and all together have none, the first that has none
    /// beside those before it.
    fn unbound(&self, pre: &[Pattern]) -> Vec<UnmetCondition> {
        let world = self.decision.world.observations();
        let none = |patterns: &[Pattern]| !can_match(patterns, world);
        let alone: Vec<_> = pre.iter().filter(|pattern| none(std::slice::from_ref(*pattern))).collect();
        let together = || (1..=pre.len()).find(|len| none(&pre[..*len])).and_then(|len| pre.get(len - 1));
        let lacking = if alone.is_empty() { together().into_iter().collect() } else { alone };
        lacking.into_iter().map(|pattern| self.lacking(pattern.clone())).collect()
    }

    fn lacking(&self, wanted: Pattern) -> UnmetCondition {
        let alike = |seen: &Observation| {
            let pairs = wanted.terms().iter().zip(seen.properties());
            let same = pairs.filter(|((property, term), (other, value))| {
                property == other && !matches!(term, Term::Constant(constant) if constant != value)
            });
            same.count()
        };
        let of_type = self.decision.world.observations().iter().filter(|seen| seen.kind() == wanted.kind());
        // Of equals the first.
        let nearest = of_type.rev().max_by_key(|seen| alike(seen)).cloned();
        let stage = stages::present(self.memory, self.curriculum);
        let lifted = stages::lifted(self.memory.content(), stage);
        let constrained = !stages::is_lifted(&lifted, wanted.kind());
        UnmetCondition { wanted, nearest, constrained }
    }
}

fn out(verdict: Verdict, binding: Substitution) -> Reweighing {
    Reweighing {
        verdict,
        binding,
        bindings: 0,
        candidate: None,
        chain: Vec::new(),
        action: None,
        habituated: None,
        search_truncated: false,
    }
}
