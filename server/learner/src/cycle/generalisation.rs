//! Generalisation (paper, II-E and figure 3): identical values in pre-conditions and target or
//! post-conditions become variables; the result is kept if it represents enough of what is similar.

use std::collections::BTreeMap;

use crate::cycle::target_action;
use crate::memory::Memory;
use crate::memory::matching::{Case, ConditionRoles, Statement, Symmetry, represents};
use crate::memory::outline::ClassId;
use crate::memory::shape::Shape;
use crate::nouns::effect::Effect;
use crate::nouns::observation::{Observation, Pattern, PropertyId, Term, Value, Variable};
use crate::nouns::probability::Count;
use crate::nouns::schema::{Concrete, Generalised, ObservationId, PostCondition, SchemaId, among};

/// A generalised schema before it is kept.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Hypothesis {
    pub(crate) pre: Vec<Pattern>,
    pub(crate) target: Vec<Pattern>,
    pub(crate) post: Vec<(Pattern, bool)>,
}

/// Effects that follow from the new concrete schema `seed`: generalised schemas that now have one more
/// example, and the generalisation of `seed`, if it holds.
pub(crate) fn generalise(memory: &Memory, seed: SchemaId) -> Vec<Effect> {
    let Some(concrete) = memory.content().concrete(seed) else {
        return Vec::new();
    };
    let mut effects = supported(memory, seed, concrete);
    let Some(class) = memory.index().outline(seed).map(|outline| outline.class) else {
        return effects;
    };
    if memory.is_full() || !is_shared(memory, concrete, class) {
        return effects;
    }
    let target = target_action::target(memory, concrete).filter(|_| !is_exception(memory, concrete));
    let lifted = target.map(|target| lift(memory, concrete, &target));
    // What was retired is not made anew: its history speaks against it.
    let known = lifted.as_ref().is_some_and(|lifted| lifted.is_known(memory));
    let Some(lifted) = lifted.filter(|lifted| !known && lifted.has_variables()) else {
        return effects;
    };
    if let Some(examples) = examples(memory, &lifted, class) {
        let Hypothesis { pre, target, post } = lifted;
        effects.push(Effect::Generalised { pre, target, post, parent: seed, examples });
    }
    effects
}

/// The laws in use that have the new schema as one more example.
fn supported(memory: &Memory, seed: SchemaId, concrete: &Concrete) -> Vec<Effect> {
    let laws = memory.index().generalised();
    if laws.is_empty() {
        return Vec::new();
    }
    let (case, achieved) = (case(memory, concrete), achieved(memory, concrete));
    let known = |id: &SchemaId| {
        let generalised = memory.content().generalised(*id);
        generalised.is_some_and(|law| is_example(memory, *id, law, &case, &achieved))
    };
    laws.iter()
        .filter(|id| known(id))
        .map(|id| Effect::Supported { generalised: *id, example: seed })
        .collect()
}

/// Whether enough similar schemas predict what the new one predicts of nothing in its pre-conditions: no variable can stand
/// for that, so without it there is no law. Mostly there is none, and this tells at little cost.
fn is_shared(memory: &Memory, concrete: &Concrete, class: ClassId) -> bool {
    let index = memory.index();
    let parameters = memory.parameters();
    let pairs: Vec<_> = concrete.pre.iter().flat_map(|id| index.pairs_of(*id)).collect();
    let ground = |what: ObservationId| !index.pairs_of(what).iter().any(|pair| pairs.contains(&pair));
    let predicted = |p: &&PostCondition<ObservationId>| parameters.predicts(p.count);
    let said: Vec<_> = concrete.post.iter().filter(|p| predicted(p) && ground(p.what)).collect();
    let says = |other: &Concrete| {
        said.iter().all(|one| {
            other.post.iter().any(|p| (p.what, p.absent) == (one.what, one.absent) && predicted(&p))
        })
    };
    let similar = index.classes().newest(class).take(SIMILAR_MAX);
    let (mut all, mut saying) = (0, 0);
    for other in similar.filter_map(|id| memory.content().concrete(id)) {
        all += 1;
        saying += usize::from(says(other));
    }
    is_enough(memory, saying, all)
}

/// Whether so many examples among so many similar schemas are enough for a law.
fn is_enough(memory: &Memory, examples: usize, similar: usize) -> bool {
    let parameters = memory.parameters();
    let share = examples as f64 / similar as f64;
    examples >= parameters.generalisation_support_min && share >= parameters.generalisation_share_min
}

/// Whether a law in use represents a case.
fn is_example(
    memory: &Memory,
    id: SchemaId,
    generalised: &Generalised,
    case: &Case<'_>,
    achieved: &[&Observation],
) -> bool {
    let post: Vec<_> = generalised.post.iter().map(|p| (&p.what, p.absent)).collect();
    memory.index().alike(id).is_some_and(|alike| {
        let law = Statement { pre: &generalised.pre, alike, target: &generalised.target, post: &post };
        represents(law, case, achieved, &mut { ATTEMPTS_MAX })
    })
}

/// Whether `concrete` is a counter-example to a law that is in use: it bounds that law (IV-A: "these are selected
/// instead"), and founds no rival to it. Else two objects out of reach would make a law of pointing, which
/// from then on would hold as much as that of touching wherever something is within reach.
fn is_exception(memory: &Memory, concrete: &Concrete) -> bool {
    let law = concrete.contradicts.and_then(|law| memory.content().generalised(law));
    law.is_some_and(|law| !law.retired)
}

/// Similar schemas that a generalisation is tested against. "The same number of the same type of observations for their
/// pre-conditions and post-conditions" is true of hundreds of thousands in a long life: these are the newest of them.
const SIMILAR_MAX: usize = 64;

/// The schemas that `lifted` represents of those of `class` that it is tested against, by number; none if it represents too
/// few of them to be kept.
fn examples(memory: &Memory, lifted: &Hypothesis, class: ClassId) -> Option<Vec<SchemaId>> {
    let similar: Vec<_> = memory.index().classes().newest(class).take(SIMILAR_MAX).collect();
    let enough = |examples: usize| is_enough(memory, examples, similar.len());
    let post: Vec<_> = lifted.post.iter().map(|(what, absent)| (what, *absent)).collect();
    let alike = Symmetry::new(&lifted.pre, &lifted.target, post.iter().copied());
    let law = Statement { pre: &lifted.pre, alike: &alike, target: &lifted.target, post: &post };
    // Bounds what a crowded world full of equal things can cost; beyond it less is generalised, and nothing wrongly.
    let mut budget = ATTEMPTS_MAX;
    let mut found = Vec::new();
    for (rest, id) in (0..similar.len()).rev().zip(&similar) {
        let concrete = memory.content().concrete(*id);
        let represented = concrete.is_some_and(|concrete| {
            let case = case(memory, concrete);
            // What the action achieves elsewhere is looked for only where it matters.
            case.may_be(law) && represents(law, &case, &achieved(memory, concrete), &mut budget)
        });
        found.extend(represented.then_some(*id));
        if !enough(found.len() + rest) {
            return None;
        }
    }
    found.sort_unstable();
    enough(found.len()).then_some(found)
}

/// A concrete schema as a case of a law.
fn case<'a>(memory: &'a Memory, concrete: &Concrete) -> Case<'a> {
    let content = memory.content();
    let predicted = || concrete.post.iter().filter(|p| memory.parameters().predicts(p.count));
    let parts = |id: &ObservationId| {
        ConditionRoles::all(predicted().filter(|p| p.what == *id).map(|p| ConditionRoles::post(p.absent)))
    };
    let is_pre = among(&concrete.pre);
    let loose = predicted().filter(|p| !is_pre(p.what));
    Case {
        pre: concrete.pre.iter().map(|o| content.observation(*o)).collect(),
        parts: concrete.pre.iter().map(parts).collect(),
        post: loose.map(|p| (content.observation(p.what), p.absent)).collect(),
    }
}

fn achieved<'a>(memory: &'a Memory, concrete: &Concrete) -> Vec<&'a Observation> {
    target_action::achieved(memory, concrete).collect()
}

/// Replaces by a variable every (property, value) that occurs in the pre-conditions and also in the target
/// or the post-conditions. Variables are numbered in the order of first occurrence.
fn lift(memory: &Memory, seed: &Concrete, target: &[Observation]) -> Hypothesis {
    let content = memory.content();
    let pre: Vec<_> = seed.pre.iter().map(|o| content.observation(*o)).collect();
    let post: Vec<_> = predicted(memory, seed).collect();
    let occurs = |pair: &(PropertyId, Value)| {
        let mut elsewhere = target.iter().chain(post.iter().map(|p| &p.what));
        elsewhere.any(|observation| observation.properties().contains(pair))
    };
    let mut variables: BTreeMap<(PropertyId, Value), Variable> = BTreeMap::new();
    for pair in pre.iter().flat_map(|observation| observation.properties()) {
        // More than 256 values in one schema's pre-conditions stay constants: nothing is lifted wrongly.
        if occurs(pair)
            && !variables.contains_key(pair)
            && let Ok(next) = u8::try_from(variables.len())
        {
            variables.insert(*pair, Variable(next));
        }
    }
    let lift_one = |observation: &Observation| {
        let terms = observation.properties().iter().map(|pair| {
            let term = variables.get(pair).map_or(Term::Constant(pair.1), |v| Term::Variable(*v));
            (pair.0, term)
        });
        Pattern::new(observation.kind(), terms)
    };
    Hypothesis {
        pre: pre.into_iter().map(lift_one).collect(),
        target: target.iter().map(lift_one).collect(),
        post: post.iter().map(|p| (lift_one(&p.what), p.absent)).collect(),
    }
}

fn predicted<'a>(
    memory: &'a Memory,
    concrete: &'a Concrete,
) -> impl Iterator<Item = PostCondition<Observation>> + 'a {
    let predicted = concrete.post.iter().filter(|p| memory.parameters().predicts(p.count));
    predicted.map(|p| p.of(memory.content().observation(p.what).clone()))
}

/// Attempts at matching one pattern with one observation that the search for the examples of one new schema may make, and
/// the search whether a law in use represents it.
const ATTEMPTS_MAX: usize = 10_000;

impl From<&Generalised> for Hypothesis {
    fn from(generalised: &Generalised) -> Self {
        Self {
            pre: generalised.pre.to_vec(),
            target: generalised.target.to_vec(),
            post: generalised.post.iter().map(|p| (p.what.clone(), p.absent)).collect(),
        }
    }
}

impl Hypothesis {
    /// Whether the same is in memory, in use or retired.
    pub(crate) fn is_known(&self, memory: &Memory) -> bool {
        let post = self.post.iter().map(|(what, absent)| (what, *absent));
        let alike = memory.index().with_shape(&Shape::new(&self.pre, &self.target, post));
        alike.iter().any(|id| {
            let known = memory.content().generalised(*id);
            known.is_some_and(|known| self.equals(known))
        })
    }

    fn has_variables(&self) -> bool {
        let variable = |p: &Pattern| p.terms().iter().any(|(_, term)| matches!(term, Term::Variable(_)));
        self.pre.iter().any(variable)
    }

    /// Whether the two are one but for the names of variables and the order of conditions.
    pub(crate) fn equals(&self, generalised: &Generalised) -> bool {
        let other = Hypothesis::from(generalised);
        let sizes = |l: &Hypothesis| (l.pre.len(), l.target.len(), l.post.len());
        // Renaming is a binding between variables: a ground instance with a value of its own for each
        // variable is matched by the other, and the other way round.
        sizes(self) == sizes(&other) && self.covers(&other) && other.covers(self)
    }

    /// Whether `other`, its variables taken for constants, is an instance of `self`.
    fn covers(&self, other: &Hypothesis) -> bool {
        let frozen = |patterns: &[Pattern]| patterns.iter().map(freeze).collect::<Vec<_>>();
        let (pre, target) = (frozen(&other.pre), frozen(&other.target));
        let other_post: Vec<_> = other.post.iter().map(|(what, absent)| (freeze(what), *absent)).collect();
        let parts = |one: &Observation| {
            let same = other_post.iter().filter(|(what, _)| what == one);
            ConditionRoles::all(same.map(|(_, absent)| ConditionRoles::post(*absent)))
        };
        let loose = other_post.iter().filter(|(what, _)| !pre.contains(what));
        let case = Case {
            pre: pre.iter().collect(),
            parts: pre.iter().map(parts).collect(),
            post: loose.map(|(what, absent)| (what, *absent)).collect(),
        };
        let target: Vec<_> = target.iter().collect();
        let post: Vec<_> = self.post.iter().map(|(what, absent)| (what, *absent)).collect();
        let alike = Symmetry::new(&self.pre, &self.target, post.iter().copied());
        let law = Statement { pre: &self.pre, alike: &alike, target: &self.target, post: &post };
        represents(law, &case, &target, &mut { ATTEMPTS_MAX })
    }
}

/// A pattern as an observation, each variable as a value that occurs nowhere else.
fn freeze(pattern: &Pattern) -> Observation {
    let properties = pattern.terms().iter().map(|(property, term)| match term {
        Term::Constant(value) => (*property, *value),
        Term::Variable(variable) => (*property, Value::Bin(i64::MIN + i64::from(variable.0))),
    });
    Observation::new(pattern.kind(), properties)
}

/// Whether later evidence has taken a generalised schema out of use: counting its examples as successes,
/// even the upper end of the interval of its success rate is below the share that it was accepted at.
pub(crate) fn refuted(memory: &Memory, id: SchemaId) -> bool {
    let Some(schema) = memory.content().schema(id) else { return false };
    let Some(generalised) = schema.generalised().filter(|generalised| !generalised.retired) else {
        return false;
    };
    let examples = u32::try_from(generalised.examples.len()).unwrap_or(u32::MAX);
    let evidence = Count {
        occurrences: schema.executions.occurrences.saturating_add(examples),
        trials: schema.executions.trials.saturating_add(examples),
    };
    evidence.interval().1 < memory.parameters().generalisation_share_min
}
