//! The schemas around one schema. For each further tie away from it, one pass goes through memory. Before the pass, the
//! observations that the schemas at the edge need and make are marked.

use std::cell::Cell;
use std::collections::BTreeSet;

use pschema_learner::observation::Pattern;
use pschema_learner::schema::{Form, Generalised, Schema, SchemaId};

use super::basis::{Basis, COMPARISONS_MAX, Selection, made_by_law, may_be, may_both_be, numbered};

/// The schemas at most `depth` ties away from `centre`, at most `limit` of them: the nearest first; of equally near ones
/// examples, counter-examples, parents and children, then the oldest.
pub(super) fn around(basis: Basis<'_>, centre: SchemaId, depth: u32, limit: usize) -> Selection {
    let mut known = BTreeSet::from([centre]);
    let mut edge = vec![centre];
    let (mut total, mut truncated) = (1, false);
    for _ in 0..depth {
        if edge.is_empty() || truncated {
            break;
        }
        let (mut found, all) = next(basis, &edge, &known);
        total += found.len() as u64;
        truncated |= !all;
        let room = limit.saturating_sub(known.len());
        if found.len() > room {
            found.truncate(room);
            truncated = true;
        }
        edge = found.into_iter().map(|(_, id)| id).collect();
        known.extend(&edge);
    }
    Selection { shown: known.into_iter().collect(), total, next: Vec::new(), truncated }
}

/// The observations that the schemas at the edge need and make.
#[derive(Debug, Default)]
struct Marks<'a> {
    /// For each observation, whether one of them needs it or has it as its target.
    wanted: Vec<bool>,
    /// For each observation, whether one of them makes it.
    given: Vec<bool>,
    laws: Vec<&'a Generalised>,
    /// Their examples, counter-examples and parents, and the schemas that they contradict.
    linked: BTreeSet<SchemaId>,
    /// How many comparisons of patterns with observations were made.
    comparisons: Cell<usize>,
}

impl<'a> Marks<'a> {
    fn new(basis: Basis<'a>, edge: &[SchemaId]) -> Self {
        let content = basis.content;
        let none = vec![false; content.observations.len()];
        let mut marks = Self { wanted: none.clone(), given: none, ..Self::default() };
        for schema in edge.iter().filter_map(|id| content.schema(*id)) {
            marks.linked.extend(schema.parent);
            match &schema.form {
                Form::Concrete(concrete) => {
                    marks.linked.extend(concrete.contradicts);
                    concrete.pre.iter().for_each(|id| mark(&mut marks.wanted, id.index()));
                    basis.made(concrete).for_each(|id| mark(&mut marks.given, id.index()));
                }
                Form::Generalised(law) => {
                    marks.linked.extend(law.examples.iter().chain(&law.counter_examples));
                    marks.laws.push(law);
                }
            }
        }
        let wanted: BTreeSet<&Pattern> =
            marks.laws.iter().flat_map(|law| law.pre.iter().chain(&law.target)).collect();
        let made: BTreeSet<&Pattern> = marks.laws.iter().flat_map(|law| made_by_law(law)).collect();
        if !marks.laws.is_empty() {
            for (at, observation) in content.observations.iter().enumerate() {
                if !marks.afford(wanted.len() + made.len()) {
                    break;
                }
                if wanted.iter().any(|pattern| may_be(pattern, observation)) {
                    mark(&mut marks.wanted, at);
                }
                if made.iter().any(|pattern| may_be(pattern, observation)) {
                    mark(&mut marks.given, at);
                }
            }
        }
        marks
    }

    /// Counts so many more comparisons; returns whether they are within the limit.
    fn afford(&self, more: usize) -> bool {
        self.comparisons.set(self.comparisons.get().saturating_add(more));
        self.comparisons.get() < COMPARISONS_MAX
    }

    /// Whether `law` needs or makes one of the marked observations.
    fn meets(&self, basis: Basis<'_>, law: &Generalised) -> bool {
        let wants = |made: &Pattern| law.pre.iter().any(|wanted| may_both_be(made, wanted));
        let own = law.pre.len() + law.post.len();
        if !self.afford(self.laws.len().saturating_mul(own)) {
            return false;
        }
        if self.laws.iter().any(|other| {
            made_by_law(other).any(wants)
                || made_by_law(law).any(|made| other.pre.iter().any(|wanted| may_both_be(made, wanted)))
        }) {
            return true;
        }
        let mut affordable = basis.content.observations.iter().enumerate().take_while(|_| self.afford(0));
        affordable.any(|(at, observation)| {
            let (given, wanted) = (marked(&self.given, at), marked(&self.wanted, at));
            if !(given || wanted) || !self.afford(own) {
                return false;
            }
            let needs = || law.pre.iter().chain(&law.target).any(|pattern| may_be(pattern, observation));
            (given && needs()) || (wanted && made_by_law(law).any(|pattern| may_be(pattern, observation)))
        })
    }
}

fn mark(marks: &mut [bool], at: usize) {
    if let Some(mark) = marks.get_mut(at) {
        *mark = true;
    }
}

fn marked(marks: &[bool], at: usize) -> bool {
    marks.get(at).copied().unwrap_or(false)
}

/// The schemas that are tied to those at the `edge` and not `known` yet, in the order in which they are taken, and whether
/// these are all of them.
fn next(basis: Basis<'_>, edge: &[SchemaId], known: &BTreeSet<SchemaId>) -> (Vec<(bool, SchemaId)>, bool) {
    let marks = Marks::new(basis, edge);
    let mut edge = edge.to_vec();
    edge.sort_unstable();
    let of_edge = |id: &SchemaId| edge.binary_search(id).is_ok();
    let kin = |id: &SchemaId, schema: &Schema| {
        let form = match &schema.form {
            Form::Concrete(concrete) => concrete.contradicts.as_ref().is_some_and(of_edge),
            Form::Generalised(law) => law.examples.iter().chain(&law.counter_examples).any(of_edge),
        };
        form || marks.linked.contains(id) || schema.parent.as_ref().is_some_and(of_edge)
    };
    let mut found = Vec::new();
    for (id, schema) in numbered(basis.content) {
        let near = kin(&id, schema);
        let tied = near
            || match &schema.form {
                Form::Concrete(concrete) => {
                    concrete.pre.iter().any(|id| marked(&marks.given, id.index()))
                        || basis.made(concrete).any(|id| marked(&marks.wanted, id.index()))
                }
                Form::Generalised(law) => marks.meets(basis, law),
            };
        if tied && !known.contains(&id) {
            found.push((!near, id));
        }
    }
    found.sort_unstable();
    (found, marks.afford(0))
}
