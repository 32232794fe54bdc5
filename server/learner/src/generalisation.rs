//! Generalisation (paper, II-E and figure 3): identical values in pre-conditions and target or
//! post-conditions become variables; the result is kept if it represents enough of what is similar.

use std::collections::BTreeMap;

use crate::bound;
use crate::effect::Effect;
use crate::memory::Memory;
use crate::observation::{Observation, Pattern, PropertyId, Substitution, Term, Value, Variable, bindings};
use crate::probability::Count;
use crate::schema::{Concrete, Generalised, PostCondition, SchemaId, signature};
use crate::target_action;

/// A generalised schema before it is kept.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lifted {
    pub(crate) pre: Vec<Pattern>,
    pub(crate) target: Vec<Pattern>,
    pub(crate) post: Vec<(Pattern, bool)>,
}

/// Effects that follow from the new concrete schema `seed`: generalised schemas that now have one more
/// example, and the generalisation of `seed`, if it holds.
pub(crate) fn generalise(memory: &Memory, seed: SchemaId) -> Vec<Effect> {
    let Some(concrete) = memory.content().schema(seed).and_then(|s| s.concrete()) else { return Vec::new() };
    let mut effects = Vec::new();
    let lifted = target_action::target(memory, concrete).map(|target| lift(memory, concrete, &target));
    // What was retired is not made anew: its history speaks against it.
    let known = memory.index().generalised().iter().chain(memory.index().retired()).any(|id| {
        let known = memory.content().schema(*id).and_then(|s| s.generalised());
        known.is_some_and(|known| lifted.as_ref().is_some_and(|lifted| lifted.equals(known)))
    });
    for id in memory.index().generalised() {
        let Some(generalised) = memory.content().schema(*id).and_then(|s| s.generalised()) else { continue };
        if represents(memory, &Lifted::from(generalised), concrete) {
            effects.push(Effect::Supported { generalised: *id, example: seed });
        }
    }
    let Some(lifted) = lifted.filter(|lifted| !known && lifted.has_variables()) else { return effects };
    let similar = similar(memory, concrete);
    let examples: Vec<_> =
        similar.iter().filter(|(_, other)| represents(memory, &lifted, other)).map(|(id, _)| *id).collect();
    let share = examples.len() as f64 / similar.len().max(1) as f64;
    let parameters = memory.parameters();
    if examples.len() >= parameters.generalisation_support_min && share >= parameters.generalisation_share_min
    {
        let Lifted { pre, target, post } = lifted;
        effects.push(Effect::Generalised { pre, target, post, parent: seed, examples });
    }
    effects
}

/// Concrete schemas with "the same number of the same type of observations for their pre-conditions and
/// post-conditions", `seed` included.
fn similar<'a>(memory: &'a Memory, seed: &Concrete) -> Vec<(SchemaId, &'a Concrete)> {
    let content = memory.content();
    let kind = |id| content.observation(id).kind();
    let post_signature = |concrete: &Concrete| {
        let predicted = |absent: bool| {
            signature(
                concrete
                    .post
                    .iter()
                    .filter(|p| p.absent == absent && bound::predicted(p.count, memory.parameters()))
                    .map(|p| kind(p.what)),
            )
        };
        (predicted(false), predicted(true))
    };
    let pre = signature(seed.pre.iter().map(|o| kind(*o)));
    let post = post_signature(seed);
    memory
        .index()
        .with_pre_types(&pre)
        .iter()
        .filter_map(|id| content.schema(*id).and_then(|s| s.concrete()).map(|concrete| (*id, concrete)))
        .filter(|(_, concrete)| post_signature(concrete) == post)
        .collect()
}

/// Replaces by a variable every (property, value) that occurs in the pre-conditions and also in the target
/// or the post-conditions. Variables are numbered in the order of first occurrence.
fn lift(memory: &Memory, seed: &Concrete, target: &[Observation]) -> Lifted {
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
    Lifted {
        pre: pre.into_iter().map(lift_one).collect(),
        target: target.iter().map(lift_one).collect(),
        post: post.iter().map(|p| (lift_one(&p.what), p.absent)).collect(),
    }
}

fn predicted<'a>(
    memory: &'a Memory,
    concrete: &'a Concrete,
) -> impl Iterator<Item = PostCondition<Observation>> + 'a {
    let parameters = memory.parameters();
    concrete.post.iter().filter(|p| bound::predicted(p.count, parameters)).map(|p| PostCondition {
        what: memory.content().observation(p.what).clone(),
        absent: p.absent,
        count: p.count,
    })
}

/// A test of representation tries every binding; the attempts of [`bindings`] bound the work.
const BINDINGS_MAX: usize = usize::MAX;

/// Whether some binding turns the lifted pre-conditions into those of `other`, the lifted post-conditions
/// into just what `other` predicts, and the lifted target into something its action achieves.
fn represents(memory: &Memory, lifted: &Lifted, other: &Concrete) -> bool {
    if lifted.pre.len() != other.pre.len() {
        return false;
    }
    let pre: Vec<_> = other.pre.iter().map(|o| memory.content().observation(*o).clone()).collect();
    let mut post: Vec<_> = predicted(memory, other).map(|p| (p.what, p.absent)).collect();
    post.sort_unstable();
    bindings(&lifted.pre, &pre, BINDINGS_MAX).into_iter().any(|binding| {
        let expected: Option<Vec<_>> =
            lifted.post.iter().map(|(p, absent)| Some((p.apply(&binding)?, *absent))).collect();
        let target: Option<Vec<_>> = lifted.target.iter().map(|p| p.apply(&binding)).collect();
        let (Some(mut expected), Some(target)) = (expected, target) else { return false };
        expected.sort_unstable();
        expected.dedup();
        expected == post && target_action::achieves(memory, other, &target)
    })
}

impl From<&Generalised> for Lifted {
    fn from(generalised: &Generalised) -> Self {
        Self {
            pre: generalised.pre.to_vec(),
            target: generalised.target.to_vec(),
            post: generalised.post.iter().map(|p| (p.what.clone(), p.absent)).collect(),
        }
    }
}

impl Lifted {
    fn has_variables(&self) -> bool {
        let variable = |p: &Pattern| p.terms().iter().any(|(_, term)| matches!(term, Term::Variable(_)));
        self.pre.iter().any(variable)
    }

    /// Whether the two are one but for the names of variables and the order of conditions.
    fn equals(&self, generalised: &Generalised) -> bool {
        let other = Lifted::from(generalised);
        let sizes = |l: &Lifted| (l.pre.len(), l.target.len(), l.post.len());
        if sizes(self) != sizes(&other) {
            return false;
        }
        // Renaming is a binding between variables: a ground instance with a value of its own for each
        // variable is matched by the other, and the other way round.
        self.covers(&other) && other.covers(self)
    }

    /// Whether `other`, its variables taken for constants, is an instance of `self`.
    fn covers(&self, other: &Lifted) -> bool {
        let ground = |p: &Pattern| freeze(p);
        let pre: Vec<_> = other.pre.iter().map(ground).collect();
        let mut target: Vec<_> = other.target.iter().map(ground).collect();
        let mut post: Vec<_> = other.post.iter().map(|(p, absent)| (freeze(p), *absent)).collect();
        target.sort_unstable();
        post.sort_unstable();
        bindings(&self.pre, &pre, BINDINGS_MAX).into_iter().any(|binding: Substitution| {
            let mine: Option<Vec<_>> = self.target.iter().map(|p| p.apply(&binding)).collect();
            let mine_post: Option<Vec<_>> =
                self.post.iter().map(|(p, absent)| Some((p.apply(&binding)?, *absent))).collect();
            let (Some(mut mine), Some(mut mine_post)) = (mine, mine_post) else { return false };
            mine.sort_unstable();
            mine_post.sort_unstable();
            mine == target && mine_post == post
        })
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
