//! Generalisation (paper, II-E and figure 3): identical values in pre-conditions and target or
//! post-conditions become variables; the result is kept if it represents enough of what is similar.

use std::collections::BTreeMap;

use crate::bound;
use crate::effect::Effect;
use crate::groups::GroupId;
use crate::memory::Memory;
use crate::observation::{
    Observation, Pattern, PropertyId, Substitution, Term, TypeId, Value, Variable, bindings, bindings_within,
};
use crate::outline::ClassId;
use crate::probability::Count;
use crate::schema::{Concrete, Generalised, ObservationId, PostCondition, SchemaId, signature};
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
    let Some(concrete) = memory.content().schema(seed).and_then(|s| s.concrete()) else {
        return Vec::new();
    };
    let mut effects = Vec::new();
    let target = target_action::target(memory, concrete).filter(|_| !is_exception(memory, concrete));
    let lifted = target.map(|target| lift(memory, concrete, &target));
    // What was retired is not made anew: its history speaks against it.
    let known = lifted.as_ref().is_some_and(|lifted| lifted.is_known(memory));
    for id in memory.index().generalised() {
        let Some(generalised) = memory.content().schema(*id).and_then(|s| s.generalised()) else {
            continue;
        };
        if represents(memory, generalised, concrete) {
            effects.push(Effect::Supported { generalised: *id, example: seed });
        }
    }
    let Some(lifted) = lifted.filter(|lifted| !known && lifted.has_variables()) else {
        return effects;
    };
    // "The same number of the same type of observations for their pre-conditions and post-conditions".
    let Some(class) = memory.index().outline(seed).map(|outline| outline.class) else {
        return effects;
    };
    let similar = memory.index().classes().size(class);
    let examples = examples(memory, &lifted, class);
    let share = examples.len() as f64 / similar.max(1) as f64;
    let parameters = memory.parameters();
    if examples.len() >= parameters.generalisation_support_min && share >= parameters.generalisation_share_min
    {
        let Lifted { pre, target, post } = lifted;
        effects.push(Effect::Generalised { pre, target, post, parent: seed, examples });
    }
    effects
}

/// Whether `concrete` is a counter-example to a law that is in use: it bounds that law (IV-A: "these are selected
/// instead"), and founds no rival to it. Else two objects out of reach would make a law of pointing, which
/// from then on would hold as much as that of touching wherever something is within reach.
fn is_exception(memory: &Memory, concrete: &Concrete) -> bool {
    let law = concrete.contradicts.and_then(|law| memory.content().schema(law)?.generalised());
    law.is_some_and(|law| !law.retired)
}

/// The schemas of `class` that `lifted` represents, by number. Its variables are bound once for all that have
/// the same pre-conditions, and of these only those are looked at that have an outcome which it says they have.
fn examples(memory: &Memory, lifted: &Lifted, class: ClassId) -> Vec<SchemaId> {
    let index = memory.index();
    let mut found = Vec::new();
    // Bounds what a crowded world full of equal things can cost; beyond it less is generalised, and nothing wrongly.
    let mut budget = ATTEMPTS_MAX;
    for (group, only) in candidates(memory, lifted) {
        let group = index.groups().get(group);
        if group.pre.len() != lifted.pre.len() {
            continue;
        }
        let pre: Vec<_> = group.pre.iter().map(|o| memory.content().observation(*o).clone()).collect();
        for binding in bindings_within(&lifted.pre, &pre, BINDINGS_MAX, &mut budget) {
            let post = lifted.post.iter().map(|(what, absent)| (what, *absent));
            let Some(law) = Law::new(memory, post, &lifted.target, &binding) else { continue };
            let of_class = |id: &SchemaId| index.outline(*id).is_some_and(|known| known.class == class);
            let concrete = |id: &SchemaId| memory.content().schema(*id).and_then(|s| s.concrete());
            let holds = |id: &SchemaId| of_class(id) && concrete(id).is_some_and(|c| law.holds(memory, c));
            match (only, law.post.first()) {
                (Some(id), _) => found.extend(Some(id).filter(holds)),
                (None, Some((what, _))) => found.extend(group.with_outcome(*what).filter(holds)),
                (None, None) => found.extend(group.schemas.iter().copied().filter(holds)),
            }
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Groups among whose schemas are all that `lifted` can represent, or one schema of each: whatever it says without a
/// variable narrows the choice, of its pre-conditions or of what it predicts, and the rarest narrows it most. Without
/// any such, groups with pre-conditions of the same types.
fn candidates(memory: &Memory, lifted: &Lifted) -> Vec<(GroupId, Option<SchemaId>)> {
    let index = memory.index();
    let types = signature(lifted.pre.iter().map(Pattern::kind));
    let ground = lifted.pre.iter().filter(|pattern| !pattern.has_variables());
    let requiring = ground.map(|pattern| {
        let observation = pattern.apply(&Substitution::new()).and_then(|one| index.id(&one));
        observation.map_or(&[][..], |id| index.groups().requiring(id))
    });
    let groups = requiring.chain([index.with_pre_types(&types)]).min_by_key(|groups| groups.len());
    let groups = groups.unwrap_or_default();
    let mut fewest: Option<Vec<&[SchemaId]>> = None;
    let mut most = groups.len();
    for (pattern, _) in lifted.post.iter().filter(|(_, absent)| !absent) {
        if let Some((schemas, count)) = predicting(memory, pattern, most) {
            (fewest, most) = (Some(schemas), count);
        }
    }
    match fewest {
        None => groups.iter().map(|group| (*group, None)).collect(),
        Some(schemas) => {
            let of = |id: &SchemaId| index.outline(*id).map(|known| (known.group, Some(*id)));
            schemas.into_iter().flatten().filter_map(of).collect()
        }
    }
}

/// The concrete schemas that have an outcome with a value that `pattern` says, and how many; none if there are `most` or
/// more, or it says no value.
fn predicting<'a>(
    memory: &'a Memory,
    pattern: &Pattern,
    most: usize,
) -> Option<(Vec<&'a [SchemaId]>, usize)> {
    let index = memory.index();
    if !pattern.has_variables() {
        let known = pattern.apply(&Substitution::new()).and_then(|one| index.id(&one));
        let schemas = known.map_or(&[][..], |id| index.causing(id));
        return (schemas.len() < most).then(|| (vec![schemas], schemas.len()));
    }
    let said = pattern.terms().iter().filter_map(|(property, term)| match term {
        Term::Constant(value) => Some(index.with_value(*property, *value)),
        Term::Variable(_) => None,
    });
    let observations = said.min_by_key(|observations| observations.len())?;
    let (mut schemas, mut count) = (Vec::new(), 0);
    for observation in observations {
        let causing = index.causing(*observation);
        count += causing.len().max(1);
        if count >= most {
            return None;
        }
        schemas.push(causing);
    }
    Some((schemas, count))
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

/// Attempts at matching one pattern with one observation that the search for the examples of one new schema may make: about
/// a millisecond. A dozen things on a table can be told apart in half a billion ways.
const ATTEMPTS_MAX: usize = 10_000;

/// A test of representation tries every binding; the attempts of [`bindings`] bound the work.
const BINDINGS_MAX: usize = usize::MAX;

/// What a generalised schema says under a binding, by number.
struct Law {
    /// What is predicted, and whether as absent; ordered.
    post: Vec<(ObservationId, bool)>,
    target: Vec<ObservationId>,
}

impl Law {
    /// None if it speaks of an observation that no schema knows, so that it represents none.
    fn new<'a>(
        memory: &Memory,
        post: impl Iterator<Item = (&'a Pattern, bool)>,
        target: &[Pattern],
        binding: &Substitution,
    ) -> Option<Self> {
        let number = |pattern: &Pattern| memory.index().id(&pattern.apply(binding)?);
        let mut post: Vec<_> =
            post.map(|(what, absent)| Some((number(what)?, absent))).collect::<Option<_>>()?;
        post.sort_unstable();
        post.dedup();
        Some(Self { post, target: target.iter().map(number).collect::<Option<_>>()? })
    }

    /// Whether `other` predicts just this, and its action achieves the target.
    fn holds(&self, memory: &Memory, other: &Concrete) -> bool {
        let predicted = other.post.iter().filter(|p| bound::predicted(p.count, memory.parameters()));
        let mut predicted: Vec<_> = predicted.map(|p| (p.what, p.absent)).collect();
        predicted.sort_unstable();
        predicted == self.post && target_action::achieves(memory, other, &self.target)
    }
}

/// Whether some binding turns the pre-conditions into those of `other`, the post-conditions into just what `other`
/// predicts, and the target into something its action achieves.
fn represents(memory: &Memory, generalised: &Generalised, other: &Concrete) -> bool {
    if generalised.pre.len() != other.pre.len() {
        return false;
    }
    let pre: Vec<_> = other.pre.iter().map(|o| memory.content().observation(*o).clone()).collect();
    bindings(&generalised.pre, &pre, BINDINGS_MAX).into_iter().any(|binding| {
        let post = generalised.post.iter().map(|p| (&p.what, p.absent));
        Law::new(memory, post, &generalised.target, &binding).is_some_and(|law| law.holds(memory, other))
    })
}

/// What generalised schemas that differ only in the names of variables and the order of conditions have in common:
/// their pre-conditions, targets and post-conditions, each without its variables.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Shape([Vec<Nameless>; 3]);

/// A pattern, whether it is an absence, and where it has variables.
type Nameless = (TypeId, bool, Vec<(PropertyId, Option<Value>)>);

impl Shape {
    fn new<'a>(pre: &[Pattern], target: &[Pattern], post: impl Iterator<Item = (&'a Pattern, bool)>) -> Self {
        let nameless = |(pattern, absent): (&Pattern, bool)| {
            let value = |term: Term| match term {
                Term::Constant(value) => Some(value),
                Term::Variable(_) => None,
            };
            (pattern.kind(), absent, pattern.terms().iter().map(|(p, term)| (*p, value(*term))).collect())
        };
        let mut lists: [Vec<Nameless>; 3] = [
            pre.iter().map(|p| nameless((p, false))).collect(),
            target.iter().map(|p| nameless((p, false))).collect(),
            post.map(nameless).collect(),
        ];
        lists.iter_mut().for_each(|list| list.sort_unstable());
        Self(lists)
    }

    pub(crate) fn of(generalised: &Generalised) -> Self {
        let post = generalised.post.iter().map(|p| (&p.what, p.absent));
        Self::new(&generalised.pre, &generalised.target, post)
    }
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
    /// Whether the same is in memory, in use or retired.
    fn is_known(&self, memory: &Memory) -> bool {
        let post = self.post.iter().map(|(what, absent)| (what, *absent));
        let alike = memory.index().with_shape(&Shape::new(&self.pre, &self.target, post));
        alike.iter().any(|id| {
            let known = memory.content().schema(*id).and_then(|s| s.generalised());
            known.is_some_and(|known| self.equals(known))
        })
    }

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
