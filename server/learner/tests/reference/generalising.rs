//! Step 7 of the cycle: target actions and generalisation (II-E, figures 2 and 3).

use pschema_learner::effect::Effect;
use pschema_learner::observation::{
    Observation, Pattern, PropertyId, Substitution, Term, TypeId, Value, Variable,
};
use pschema_learner::schema::SchemaId;

use super::binding::ways;
use super::learner::Reference;
use super::schema::{Schema, put_in};

/// Similar schemas that a generalisation is tested against: the newest.
const SIMILAR_MAX: usize = 64;

/// What generalisation compares: conditions, and what is predicted.
#[derive(Clone)]
struct Lifted {
    pre: Vec<Pattern>,
    target: Vec<Pattern>,
    post: Vec<(Pattern, bool)>,
}

impl Reference {
    /// Generalises from a new concrete schema; how many generalised schemas that made.
    pub(crate) fn generalise(&mut self, new: SchemaId) -> u32 {
        let supporting: Vec<SchemaId> = self
            .memory
            .schemas
            .iter()
            .filter(|s| s.action.is_none() && !s.retired && self.represents(&lifted_of(s), new))
            .map(|s| s.id)
            .collect();
        for generalised in supporting {
            self.emit(Effect::Supported { generalised, example: new });
        }
        let mut laws = self.memory.schemas.iter().filter(|s| s.action.is_none() && !s.retired);
        if laws.any(|law| law.counter_examples.contains(&new)) {
            return 0;
        }
        let Some(lifted) = self.lift_values(new) else { return 0 };
        let known = self.memory.schemas.iter().filter(|s| s.action.is_none());
        if known.map(lifted_of).any(|known| same_up_to_renaming(&known, &lifted)) {
            return 0;
        }
        let signature = self.signature(self.memory.schema(new));
        let similar: Vec<SchemaId> = self
            .memory
            .schemas
            .iter()
            .filter(|s| s.action.is_some() && self.signature(s) == signature)
            .map(|s| s.id)
            .collect();
        let similar = &similar[similar.len().saturating_sub(SIMILAR_MAX)..];
        let examples: Vec<SchemaId> =
            similar.iter().copied().filter(|id| self.represents(&lifted, *id)).collect();
        let parameters = &self.memory.parameters;
        let share = examples.len() as f64 / similar.len() as f64;
        if examples.len() < parameters.generalisation_support_min
            || share < parameters.generalisation_share_min
        {
            return 0;
        }
        let Lifted { pre, target, post } = lifted;
        self.emit(Effect::Generalised { pre, target, post, parent: new, examples });
        1
    }

    /// The target action of a concrete schema: what its primitive is predicted to do in the simplest
    /// context. Empty when there is none.
    pub(crate) fn target(&self, id: SchemaId) -> Vec<Observation> {
        let none = Substitution::new();
        let schema = self.memory.schema(id);
        let own = schema.pre(&none);
        let simpler = self.memory.schemas.iter().filter(|s| {
            s.action == schema.action
                && s.pre.len() < own.len()
                && s.pre(&none).iter().all(|condition| own.contains(condition))
        });
        let simplest = simpler.min_by_key(|s| (s.pre.len(), s.id));
        sorted(simplest.map(|s| self.predicted(s, false)).unwrap_or_default())
    }

    fn predicted(&self, schema: &Schema, absent: bool) -> Vec<Observation> {
        let ratio_min = self.memory.parameters.prediction_ratio_min;
        let predicted = schema.predicted(&Substitution::new(), absent, ratio_min);
        predicted.into_iter().map(|(observation, _)| observation).collect()
    }

    /// The types of pre-conditions, predicted outcomes and predicted absences, each sorted.
    fn signature(&self, schema: &Schema) -> [Vec<TypeId>; 3] {
        let types = |observations: Vec<Observation>| {
            let mut kinds: Vec<_> = observations.iter().map(Observation::kind).collect();
            kinds.sort();
            kinds
        };
        let pre = types(schema.pre(&Substitution::new()));
        [pre, types(self.predicted(schema, false)), types(self.predicted(schema, true))]
    }

    /// Replaces shared values by variables; none without a target or without a shared value.
    fn lift_values(&self, id: SchemaId) -> Option<Lifted> {
        let schema = self.memory.schema(id);
        let target = self.target(id);
        if target.is_empty() {
            return None;
        }
        let pre = schema.pre(&Substitution::new());
        let post: Vec<(Observation, bool)> = schema
            .post
            .iter()
            .filter(|post| post.count.ratio() >= self.memory.parameters.prediction_ratio_min)
            .map(|post| (put_in(&post.what, &Substitution::new()), post.absent))
            .collect();
        let elsewhere: Vec<(PropertyId, Value)> = target
            .iter()
            .chain(post.iter().map(|(observation, _)| observation))
            .flat_map(|observation| observation.properties().to_vec())
            .collect();
        let mut variables: Vec<(PropertyId, Value)> = Vec::new();
        for pair in pre.iter().flat_map(|observation| observation.properties()) {
            if elsewhere.contains(pair) && !variables.contains(pair) {
                variables.push(*pair);
            }
        }
        if variables.is_empty() {
            return None;
        }
        let lift = |observation: &Observation| {
            let terms = observation.properties().iter().map(|pair| {
                let term = match variables.iter().position(|v| v == pair) {
                    Some(at) => Term::Variable(Variable(u8::try_from(at).unwrap())),
                    None => Term::Constant(pair.1),
                };
                (pair.0, term)
            });
            Pattern::new(observation.kind(), terms)
        };
        Some(Lifted {
            pre: pre.iter().map(lift).collect(),
            target: target.iter().map(lift).collect(),
            post: post.iter().map(|(observation, absent)| (lift(observation), *absent)).collect(),
        })
    }

    fn represents(&self, lifted: &Lifted, id: SchemaId) -> bool {
        let schema = self.memory.schema(id);
        let pre = schema.pre(&Substitution::new());
        let target = self.target(id);
        let outcome = [false, true].map(|absent| sorted(self.predicted(schema, absent)));
        lifted.pre.len() == pre.len()
            && ways(&lifted.pre, &pre).iter().any(|(_, binding)| {
                let bound = [false, true].map(|absent| {
                    let chosen = lifted.post.iter().filter(|(_, a)| *a == absent);
                    sorted(chosen.map(|(pattern, _)| put_in(pattern, binding)).collect())
                });
                bound == outcome && lifted.target.iter().all(|p| target.contains(&put_in(p, binding)))
            })
    }
}

fn sorted(mut observations: Vec<Observation>) -> Vec<Observation> {
    observations.sort();
    observations.dedup();
    observations
}

fn lifted_of(schema: &Schema) -> Lifted {
    Lifted {
        pre: schema.pre.clone(),
        target: schema.target.clone(),
        post: schema.post.iter().map(|post| (post.what.clone(), post.absent)).collect(),
    }
}

/// Whether two are one up to the names of variables and the order of conditions: tries every pairing.
fn same_up_to_renaming(left: &Lifted, right: &Lifted) -> bool {
    let parts = |lifted: &Lifted| -> Vec<(u8, Pattern)> {
        let pre = lifted.pre.iter().map(|p| (0, p.clone()));
        let target = lifted.target.iter().map(|p| (1, p.clone()));
        let post = lifted.post.iter().map(|(p, absent)| (2 + u8::from(*absent), p.clone()));
        pre.chain(target).chain(post).collect()
    };
    let (left, mut right) = (parts(left), parts(right));
    left.len() == right.len() && pair_up(&left, &mut right, &[])
}

fn pair_up(left: &[(u8, Pattern)], right: &mut Vec<(u8, Pattern)>, names: &[(Variable, Variable)]) -> bool {
    let Some(((part, first), rest)) = left.split_first() else { return true };
    for at in 0..right.len() {
        if right[at].0 == *part
            && let Some(names) = rename(first, &right[at].1, names)
        {
            let taken = right.remove(at);
            if pair_up(rest, right, &names) {
                return true;
            }
            right.insert(at, taken);
        }
    }
    false
}

/// The names extended so that both patterns read the same, one name for one name.
fn rename(
    left: &Pattern,
    right: &Pattern,
    names: &[(Variable, Variable)],
) -> Option<Vec<(Variable, Variable)>> {
    if left.kind() != right.kind() || left.terms().len() != right.terms().len() {
        return None;
    }
    let mut names = names.to_vec();
    for ((p, l), (q, r)) in left.terms().iter().zip(right.terms()) {
        match (l, r) {
            (Term::Constant(l), Term::Constant(r)) if p == q && l == r => {}
            (Term::Variable(l), Term::Variable(r)) if p == q => {
                let known = names.iter().find(|(a, b)| a == l || b == r);
                match known {
                    Some(pair) if *pair == (*l, *r) => {}
                    Some(_) => return None,
                    None => names.push((*l, *r)),
                }
            }
            _ => return None,
        }
    }
    Some(names)
}
