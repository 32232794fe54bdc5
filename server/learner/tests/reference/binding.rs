//! Matching patterns with observations: every way is tried, and of those that only exchange what alike pre-conditions match,
//! the one is kept in which they match in canonical order.

use pschema_learner::observation::{Observation, Pattern, Substitution, Term, Variable};

use super::schema::Schema;

/// Every way to match all of `patterns` with different ones of `observations`: what each matches, and the binding; in the
/// order of what the first matches, then the second, and so on.
pub(crate) fn ways(
    patterns: &[Pattern],
    observations: &[Observation],
) -> Vec<(Vec<Observation>, Substitution)> {
    let mut found = vec![(Vec::new(), Substitution::new())];
    for pattern in patterns {
        let mut longer = Vec::new();
        for (matched, binding) in &found {
            for observation in observations.iter().filter(|one| !matched.contains(*one)) {
                let mut binding = binding.clone();
                if matches(pattern, observation, &mut binding) {
                    let mut matched = matched.clone();
                    matched.push(observation.clone());
                    longer.push((matched, binding));
                }
            }
        }
        found = longer;
    }
    found
}

/// Whether `pattern` matches `observation` under `binding`, to which the values are added that this takes.
fn matches(pattern: &Pattern, observation: &Observation, binding: &mut Substitution) -> bool {
    let (terms, seen) = (pattern.terms(), observation.properties());
    pattern.kind() == observation.kind()
        && terms.len() == seen.len()
        && terms.iter().zip(seen).all(|((property, term), (other, value))| {
            property == other
                && match term {
                    Term::Constant(constant) => constant == value,
                    Term::Variable(variable) => binding.bind(*variable, *value),
                }
        })
}

impl Schema {
    /// The bindings of a generalised schema among `observations`, at most `limit`.
    pub(crate) fn bindings(&self, observations: &[Observation], limit: usize) -> Vec<Substitution> {
        let pairs = |(later, pattern): (usize, &Pattern)| {
            let before = self.pre[..later].iter().enumerate();
            before
                .filter(|(_, other)| self.alike(other, pattern))
                .map(|(at, _)| (at, later))
                .collect::<Vec<_>>()
        };
        let alike: Vec<(usize, usize)> = self.pre.iter().enumerate().flat_map(pairs).collect();
        let ways = ways(&self.pre, observations).into_iter();
        let ordered = ways.filter(|(matched, _)| alike.iter().all(|(a, b)| matched[*a] < matched[*b]));
        ordered.map(|(_, binding)| binding).take(limit).collect()
    }

    /// Whether two pre-conditions differ only in variables that occur nowhere else, but in the same condition as
    /// post-condition or as target.
    fn alike(&self, one: &Pattern, other: &Pattern) -> bool {
        let also = |pattern: &Pattern| {
            let post: Vec<bool> =
                self.post.iter().filter(|post| post.what == *pattern).map(|post| post.absent).collect();
            (self.target.contains(pattern), post)
        };
        one.kind() == other.kind()
            && one.terms().len() == other.terms().len()
            && also(one) == also(other)
            && one.terms().iter().zip(other.terms()).all(|((p, a), (q, b))| {
                let own = match (a, b) {
                    (Term::Variable(a), Term::Variable(b)) => self.is_of(one, *a) && self.is_of(other, *b),
                    _ => false,
                };
                p == q && (a == b || own)
            })
    }

    /// Whether a variable occurs in no other condition than this.
    fn is_of(&self, pattern: &Pattern, variable: Variable) -> bool {
        let speaks =
            |other: &Pattern| other.terms().iter().any(|(_, term)| *term == Term::Variable(variable));
        let conditions = self.pre.iter().chain(&self.target).chain(self.post.iter().map(|post| &post.what));
        conditions.filter(|other| *other != pattern).all(|other| !speaks(other))
    }
}
