//! Shapes of generalised schemas: the key by which those that may be the same are found.

use crate::nouns::observation::{Pattern, PropertyId, Term, TypeId, Value};
use crate::nouns::schema::Generalised;

/// What generalised schemas that differ only in the names of variables and the order of conditions have in common:
/// their pre-conditions, targets and post-conditions, each without its variables.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Shape([Vec<VariableFreePattern>; 3]);

/// A pattern, whether it is an absence, and where it has variables.
type VariableFreePattern = (TypeId, bool, Vec<(PropertyId, Option<Value>)>);

impl Shape {
    pub(crate) fn new<'a>(
        pre: &[Pattern],
        target: &[Pattern],
        post: impl Iterator<Item = (&'a Pattern, bool)>,
    ) -> Self {
        let nameless = |(pattern, absent): (&Pattern, bool)| {
            let value = |term: Term| match term {
                Term::Constant(value) => Some(value),
                Term::Variable(_) => None,
            };
            (pattern.kind(), absent, pattern.terms().iter().map(|(p, term)| (*p, value(*term))).collect())
        };
        let mut lists: [Vec<VariableFreePattern>; 3] = [
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
