//! Matching the pre-conditions of a generalised schema with the observations there: each with a different observation, variables the
//! same wherever they occur. In a crowd most conditions say the same of different things ("some object of some kind in some
//! field"): to exchange what they match says nothing new, and would be done in half a billion ways for a dozen things.

use std::collections::BTreeMap;

use crate::nouns::observation::{
    MATCH_ATTEMPTS_MAX, Observation, Pattern, PropertyId, Substitution, Term, TypeId, Value, Variable,
};

/// How the conditions of a generalised schema stand to one another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Symmetry {
    /// For each pre-condition the last one before it that is alike, if any. Alike are those that differ only in variables that
    /// occur nowhere else, but in the same condition as post-condition or as target.
    before: Box<[Option<u32>]>,
    /// For each pre-condition: the other roles in which it occurs.
    parts: Box<[ConditionRoles]>,
    /// Places of those of the target, and of the post-conditions, that are no pre-conditions.
    target: Box<[usize]>,
    post: Box<[usize]>,
}

/// A condition without the variables that are its own, and the other roles in which it occurs.
type ConditionForm = (TypeId, Vec<(PropertyId, Option<Term>)>, ConditionRoles);

/// The roles of a condition, besides that of a pre-condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct ConditionRoles(u8);

impl ConditionRoles {
    const TARGET: Self = Self(1);

    /// A post-condition.
    pub(crate) fn post(absent: bool) -> Self {
        Self(if absent { 4 } else { 2 })
    }

    /// All of these.
    pub(crate) fn all(parts: impl Iterator<Item = Self>) -> Self {
        Self(parts.fold(0, |all, part| all | part.0))
    }

    fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

impl Symmetry {
    /// Of the pre-conditions of a schema with this target and these post-conditions (each with whether it is an absence).
    pub(crate) fn new<'a>(
        pre: &[Pattern],
        target: &'a [Pattern],
        post: impl Iterator<Item = (&'a Pattern, bool)>,
    ) -> Self {
        let places: BTreeMap<_, _> = pre.iter().enumerate().map(|(at, pattern)| (pattern, at)).collect();
        let mut parts = vec![ConditionRoles::default(); pre.len()];
        // By variable: in how many pre-conditions and in other conditions it occurs.
        let mut occurs: BTreeMap<Variable, usize> = BTreeMap::new();
        let mut count = |pattern: &Pattern| {
            variables(pattern).for_each(|variable| *occurs.entry(variable).or_default() += 1);
        };
        pre.iter().for_each(&mut count);
        // Whether it is no pre-condition as well.
        let mut is_loose = |pattern: &Pattern, part: ConditionRoles| match places.get(pattern) {
            Some(at) => {
                parts[*at].0 |= part.0;
                false
            }
            None => {
                // Twice, so that it is no condition's own.
                (0..2).for_each(|_| count(pattern));
                true
            }
        };
        let target = target.iter().enumerate();
        let target =
            target.filter(|(_, what)| is_loose(what, ConditionRoles::TARGET)).map(|(at, _)| at).collect();
        let post = post.enumerate();
        let post = post.filter(|(_, (what, absent))| is_loose(what, ConditionRoles::post(*absent)));
        let post = post.map(|(at, _)| at).collect();
        let likeness = |(pattern, parts): (&Pattern, &ConditionRoles)| -> ConditionForm {
            let term = |term: &Term| match term {
                Term::Variable(variable) if occurs.get(variable) == Some(&1) => None,
                said => Some(*said),
            };
            let terms = pattern.terms().iter().map(|(property, said)| (*property, term(said))).collect();
            (pattern.kind(), terms, *parts)
        };
        let mut last: BTreeMap<ConditionForm, u32> = BTreeMap::new();
        let likenesses = pre.iter().zip(&parts).map(likeness).zip(0_u32..);
        let before = likenesses.map(|(likeness, at)| last.insert(likeness, at)).collect();
        Self { before, parts: parts.into(), target, post }
    }
}

fn variables(pattern: &Pattern) -> impl Iterator<Item = Variable> + '_ {
    pattern.terms().iter().filter_map(|(_, term)| match term {
        Term::Variable(variable) => Some(*variable),
        Term::Constant(_) => None,
    })
}

/// Every substitution under which each of `patterns` matches a different one of `observations`, which are ordered and each
/// there once: in the order of what the first pattern matches, then the second, and so on; at most `limit` of them. Two
/// objects that both fit `$x` give two substitutions, but of patterns that are `alike` each matches a later observation than
/// the one before. With each substitution come the places of the observations that are matched, in their order.
pub(crate) fn matches(
    patterns: &[Pattern],
    alike: &Symmetry,
    observations: &[Observation],
    limit: usize,
) -> Vec<(Substitution, Vec<usize>)> {
    let observations: Vec<_> = observations.iter().collect();
    let mut found = Vec::new();
    // Bounds work on hostile worlds; ordinary ones never reach it.
    let (mut values, mut budget) = (Assignment::default(), MATCH_ATTEMPTS_MAX);
    if let Some(places) = Domains::new(patterns, &observations, &values, |_, _| true) {
        let order: Vec<_> = (0..patterns.len()).collect();
        let mut search = Search::new(patterns, alike, &observations, &places, &order, &mut budget);
        search.extend(0, &mut values, &mut |values, used| {
            let mut matched = Vec::with_capacity(patterns.len());
            matched.extend(used.iter().enumerate().filter(|(_, used)| **used).map(|(at, _)| at));
            found.push((values.substitution(), matched));
            found.len() >= limit
        });
    }
    found
}

/// Whether each of `patterns` can match a different one of `observations`, variables the same wherever they occur.
pub(crate) fn can_match(patterns: &[Pattern], observations: &[Observation]) -> bool {
    let alike = Symmetry::new(patterns, &[], std::iter::empty());
    !matches(patterns, &alike, observations, 1).is_empty()
}

/// A law, or what may be one.
#[derive(Clone, Copy)]
pub(crate) struct Statement<'a> {
    pub(crate) pre: &'a [Pattern],
    pub(crate) alike: &'a Symmetry,
    pub(crate) target: &'a [Pattern],
    /// Each with whether it is an absence.
    pub(crate) post: &'a [(&'a Pattern, bool)],
}

/// A case that a law may be a statement of.
pub(crate) struct Case<'a> {
    /// Pre-conditions, in canonical order.
    pub(crate) pre: Vec<&'a Observation>,
    /// For each of them, as what it is predicted. What is achieved is found among `target`.
    pub(crate) parts: Vec<ConditionRoles>,
    /// The predictions that are no pre-conditions.
    pub(crate) post: Vec<(&'a Observation, bool)>,
}

impl Case<'_> {
    /// Whether the post-conditions of `law` that are no pre-conditions of it have something here that they may become: what
    /// can be seen without anything being bound.
    pub(crate) fn may_be(&self, law: Statement<'_>) -> bool {
        law.pre.len() == self.pre.len()
            && law.alike.post.iter().all(|at| {
                let (pattern, absent) = law.post[*at];
                self.predicted(absent).any(|observation| pattern.resembles(observation))
            })
    }

    fn predicted(&self, absent: bool) -> impl Iterator<Item = &Observation> {
        let part = ConditionRoles::post(absent);
        let kept =
            self.pre.iter().zip(&self.parts).filter(move |(_, parts)| parts.has(part)).map(|(one, _)| *one);
        kept.chain(self.post.iter().filter(move |(_, known)| *known == absent).map(|(what, _)| *what))
    }
}

/// Whether some substitution turns the pre-conditions of `law` into those of `case`, its target into part of `achieved`, and
/// its post-conditions into just what is predicted there. One is enough, so what leaves least choice is matched first: what
/// the action brings about mostly tells which of a dozen alike things it was done to. False when `budget`, from which the
/// attempts are taken, does not last.
pub(crate) fn represents(
    law: Statement<'_>,
    case: &Case<'_>,
    achieved: &[&Observation],
    budget: &mut usize,
) -> bool {
    if law.pre.len() != case.pre.len() {
        return false;
    }
    let mut outcomes: Vec<(&Pattern, Vec<&Observation>)> = Vec::new();
    for pattern in law.alike.target.iter().map(|at| &law.target[*at]) {
        let among = achieved.iter().filter(|observation| pattern.resembles(observation));
        outcomes.push((pattern, among.copied().collect()));
    }
    for (pattern, absent) in law.alike.post.iter().map(|at| law.post[*at]) {
        let among = case.predicted(absent).filter(|observation| pattern.resembles(observation));
        outcomes.push((pattern, among.collect()));
    }
    outcomes.sort_by_key(|(_, among)| among.len());
    bring_about(law, case, achieved, &outcomes, &mut Assignment::default(), budget)
}

/// Matches the first of `outcomes`, then the rest, then the pre-conditions.
fn bring_about(
    law: Statement<'_>,
    case: &Case<'_>,
    achieved: &[&Observation],
    outcomes: &[(&Pattern, Vec<&Observation>)],
    values: &mut Assignment,
    budget: &mut usize,
) -> bool {
    let Some(((pattern, among), rest)) = outcomes.split_first() else {
        return hold(law, case, achieved, values, budget);
    };
    let mut found = false;
    for observation in among {
        if !spend(budget) {
            return false;
        }
        let mark = values.bound.len();
        found = values.bind(pattern, observation) && bring_about(law, case, achieved, rest, values, budget);
        values.undo(mark);
        if found {
            break;
        }
    }
    found
}

/// Whether the pre-conditions can be matched so that all is as the law states it, whose other conditions are bound.
fn hold(
    law: Statement<'_>,
    case: &Case<'_>,
    achieved: &[&Observation],
    values: &mut Assignment,
    budget: &mut usize,
) -> bool {
    let made = |what: &Observation, absent: bool, values: &Assignment| {
        let mut loose = law.alike.post.iter().map(|at| law.post[*at]);
        loose.any(|(pattern, known)| known == absent && values.makes(pattern, what))
    };
    // What is a post-condition too, or part of the target, must be so in the case; and the case must have nothing else.
    let may = |at: usize, one: usize, values: &Assignment| {
        let (parts, known) = (law.alike.parts[at], case.parts[one]);
        [false, true].into_iter().all(|absent| {
            let part = ConditionRoles::post(absent);
            parts.has(part) == known.has(part) || (!parts.has(part) && made(case.pre[one], absent, values))
        }) && (!parts.has(ConditionRoles::TARGET) || achieved.contains(&case.pre[one]))
    };
    if !case.post.iter().all(|(what, absent)| made(what, *absent, values)) {
        return false;
    }
    let Some(places) = Domains::new(law.pre, &case.pre, values, |at, one| may(at, one, values)) else {
        return false;
    };
    let mut order: Vec<_> = (0..law.pre.len()).collect();
    // Alike ones have as many places each, and stay in their order.
    order.sort_by_key(|at| places.of(*at).len());
    let mut search = Search::new(law.pre, law.alike, &case.pre, &places, &order, budget);
    let mut found = false;
    search.extend(0, values, &mut |_, _| {
        found = true;
        true
    });
    found
}

/// Takes one attempt; false if none is left.
fn spend(budget: &mut usize) -> bool {
    match budget.checked_sub(1) {
        Some(left) => {
            *budget = left;
            true
        }
        None => false,
    }
}

/// Values of variables, while they are being found.
#[derive(Debug, Default)]
struct Assignment {
    of: Vec<Option<Value>>,
    /// In the order in which they were bound.
    bound: Vec<Variable>,
}

impl Assignment {
    fn get(&self, variable: Variable) -> Option<Value> {
        self.of.get(usize::from(variable.0)).copied().flatten()
    }

    /// Matches `pattern` with `observation`; the variables that it binds in vain are left to [`Assignment::undo`].
    fn bind(&mut self, pattern: &Pattern, observation: &Observation) -> bool {
        if !pattern.has_form_of(observation) {
            return false;
        }
        for ((_, term), (_, value)) in pattern.terms().iter().zip(observation.properties()) {
            match term {
                Term::Constant(constant) if constant != value => return false,
                Term::Constant(_) => (),
                Term::Variable(variable) => match self.get(*variable) {
                    Some(known) if known != *value => return false,
                    Some(_) => (),
                    None => {
                        let at = usize::from(variable.0);
                        if self.of.len() <= at {
                            self.of.resize(at + 1, None);
                        }
                        self.of[at] = Some(*value);
                        self.bound.push(*variable);
                    }
                },
            }
        }
        true
    }

    /// Unbinds the variables that were bound since there were so many bound.
    fn undo(&mut self, mark: usize) {
        for variable in self.bound.drain(mark..) {
            self.of[usize::from(variable.0)] = None;
        }
    }

    /// Whether `pattern` could match `observation`, one pair at a time.
    fn agree(&self, pattern: &Pattern, observation: &Observation) -> bool {
        pattern.fits(observation, |variable, value| self.get(variable).is_none_or(|known| known == value))
    }

    /// Whether `pattern` reads as `observation`.
    fn makes(&self, pattern: &Pattern, observation: &Observation) -> bool {
        pattern.fits(observation, |variable, value| self.get(variable) == Some(value))
    }

    fn substitution(&self) -> Substitution {
        let bound = (0_u8..=u8::MAX).zip(&self.of);
        Substitution::of(
            self.bound.len(),
            bound.filter_map(|(name, value)| Some((Variable(name), (*value)?))),
        )
    }
}

/// For each pattern the observations that it may match, as far as one pair at a time tells.
struct Domains {
    all: Vec<usize>,
    /// Where those of each pattern end.
    ends: Vec<usize>,
    /// By observation: the pattern that fits no other one.
    reserved: Vec<Option<usize>>,
}

impl Domains {
    /// None if one of the patterns is left without.
    fn new(
        patterns: &[Pattern],
        observations: &[&Observation],
        values: &Assignment,
        may: impl Fn(usize, usize) -> bool,
    ) -> Option<Self> {
        if patterns.len() > observations.len() {
            return None;
        }
        let mut places = Self { all: Vec::new(), ends: Vec::new(), reserved: vec![None; observations.len()] };
        for (at, pattern) in patterns.iter().enumerate() {
            let from = places.all.len();
            let fits = |one: &usize| values.agree(pattern, observations[*one]) && may(at, *one);
            places.all.extend((0..observations.len()).filter(fits));
            match places.all[from..] {
                [] => return None,
                [only] if places.reserved[only].is_some() => return None,
                [only] => places.reserved[only] = Some(at),
                _ => (),
            }
            places.ends.push(places.all.len());
        }
        Some(places)
    }

    fn of(&self, pattern: usize) -> &[usize] {
        let from = pattern.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.all[from..self.ends[pattern]]
    }
}

/// The function that is given each match that is found, with the observations that it takes, and says whether to stop.
type Visitor<'a> = dyn FnMut(&Assignment, &[bool]) -> bool + 'a;

/// A search that matches patterns with different observations.
struct Search<'a> {
    patterns: &'a [Pattern],
    alike: &'a Symmetry,
    observations: &'a [&'a Observation],
    places: &'a Domains,
    /// In which order patterns are matched.
    order: &'a [usize],
    /// By variable: where in that order it occurs last.
    last: Vec<usize>,
    /// By observation.
    used: Vec<bool>,
    /// By pattern: the observations that it matches.
    matched: Vec<usize>,
    /// By pattern: how many alike ones follow it.
    following: Vec<usize>,
    budget: &'a mut usize,
}

impl<'a> Search<'a> {
    fn new(
        patterns: &'a [Pattern],
        alike: &'a Symmetry,
        observations: &'a [&'a Observation],
        places: &'a Domains,
        order: &'a [usize],
        budget: &'a mut usize,
    ) -> Self {
        let mut last = Vec::new();
        for (place, at) in order.iter().enumerate() {
            for (_, term) in patterns[*at].terms() {
                if let Term::Variable(Variable(variable)) = term {
                    let variable = usize::from(*variable);
                    if last.len() <= variable {
                        last.resize(variable + 1, 0);
                    }
                    last[variable] = place;
                }
            }
        }
        let mut following = vec![0; patterns.len()];
        for (at, before) in alike.before.iter().enumerate().rev() {
            if let Some(before) = before {
                following[*before as usize] = following[at] + 1;
            }
        }
        let (used, matched) = (vec![false; observations.len()], vec![0; patterns.len()]);
        Self { patterns, alike, observations, places, order, last, used, matched, following, budget }
    }

    /// Matches the patterns from `place` on in the order. `found` is given each match of all, and says whether to stop; so
    /// does this, also when the budget is used up.
    fn extend(&mut self, place: usize, values: &mut Assignment, found: &mut Visitor<'_>) -> bool {
        let Some(at) = self.order.get(place).copied() else { return found(values, &self.used) };
        let Self { patterns, observations, places, .. } = *self;
        let after = self.alike.before.get(at).copied().flatten().map(|before| self.matched[before as usize]);
        let all = places.of(at);
        let later = &all[after.map_or(0, |after| all.partition_point(|one| *one <= after))..];
        let free =
            |used: &[bool], one: usize| !used[one] && places.reserved[one].is_none_or(|only| only == at);
        let mut left = later.iter().filter(|one| free(&self.used, **one)).count();
        for one in later.iter().copied() {
            // The alike ones that follow must find room after this one.
            if left <= self.following[at] {
                break;
            }
            if !free(&self.used, one) {
                continue;
            }
            left -= 1;
            if !spend(self.budget) {
                return true;
            }
            let mark = values.bound.len();
            if values.bind(&patterns[at], observations[one]) {
                self.used[one] = true;
                self.matched[at] = one;
                let stop = self.leaves_room(place, mark, values) && self.extend(place + 1, values, found);
                self.used[one] = false;
                if stop {
                    return true;
                }
            }
            values.undo(mark);
        }
        false
    }

    /// Whether each pattern after `place` that shares a variable bound since `mark` can still match something.
    fn leaves_room(&self, place: usize, mark: usize, values: &Assignment) -> bool {
        let new = &values.bound[mark..];
        let last = new.iter().map(|variable| self.last.get(usize::from(variable.0)).copied().unwrap_or(0));
        let last = last.max().unwrap_or(0);
        self.order.iter().take(last + 1).skip(place + 1).all(|at| {
            let pattern = &self.patterns[*at];
            let concerned = pattern
                .terms()
                .iter()
                .any(|(_, term)| matches!(term, Term::Variable(variable) if new.contains(variable)));
            !concerned
                || self
                    .places
                    .of(*at)
                    .iter()
                    .any(|one| !self.used[*one] && values.agree(pattern, self.observations[*one]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nouns::observation::SymbolId;

    const OBJECT: TypeId = TypeId(0);
    const FINGER: TypeId = TypeId(1);
    const COLOUR: PropertyId = PropertyId(0);
    const FIELD: PropertyId = PropertyId(1);

    fn object(colour: u32, field: i64) -> Observation {
        Observation::new(OBJECT, [(COLOUR, Value::Symbol(SymbolId(colour))), (FIELD, Value::Integer(field))])
    }

    fn finger(field: i64) -> Observation {
        Observation::new(FINGER, [(FIELD, Value::Integer(field))])
    }

    fn some_object(colour: u8, field: u8) -> Pattern {
        let variable = |name| Term::Variable(Variable(name));
        Pattern::new(OBJECT, [(COLOUR, variable(colour)), (FIELD, variable(field))])
    }

    fn finger_at(field: u8) -> Pattern {
        Pattern::new(FINGER, [(FIELD, Term::Variable(Variable(field)))])
    }

    fn bindings(
        patterns: &[Pattern],
        alike: &Symmetry,
        observations: &[Observation],
        limit: usize,
    ) -> Vec<Substitution> {
        matches(patterns, alike, observations, limit).into_iter().map(|(binding, _)| binding).collect()
    }

    /// As many as there are, of patterns that nothing makes alike.
    fn all(patterns: &[Pattern], observations: &[Observation]) -> Vec<Substitution> {
        let alike = Symmetry { before: vec![None; patterns.len()].into(), ..Symmetry::default() };
        bindings(patterns, &alike, observations, usize::MAX)
    }

    #[test]
    fn two_objects_give_two_bindings_in_their_order() {
        let found = all(&[some_object(0, 1)], &[object(1, 4), object(2, 5)]);
        let read: Vec<_> = found.iter().map(|binding| some_object(0, 1).apply(binding)).collect();
        assert_eq!(read, [Some(object(1, 4)), Some(object(2, 5))]);
    }

    #[test]
    fn one_object_cannot_stand_for_two_patterns() {
        assert!(all(&[some_object(0, 1), some_object(2, 3)], &[object(1, 4)]).is_empty());
    }

    #[test]
    fn a_variable_keeps_its_value_and_constants_are_checked() {
        let both = [some_object(0, 1), finger_at(1)];
        assert_eq!(all(&both, &[object(1, 4), finger(4)]).len(), 1);
        assert!(all(&both, &[object(1, 4), finger(5)]).is_empty());
        let blue = Term::Constant(Value::Symbol(SymbolId(1)));
        let blue = Pattern::new(OBJECT, [(COLOUR, blue), (FIELD, Term::Variable(Variable(0)))]);
        assert!(all(&[blue], &[object(2, 4)]).is_empty());
    }

    /// "Some objects, and the finger comes to the field of the first of these: touch."
    fn touching(objects: u8, at: usize) -> (Vec<Pattern>, Vec<Pattern>, Vec<(Pattern, bool)>) {
        let pre: Vec<_> = (0..objects).map(|one| some_object(2 * one, 2 * one + 1)).collect();
        let target = vec![finger_at(2 * at as u8 + 1)];
        let post = pre.iter().chain(&target).map(|pattern| (pattern.clone(), false)).collect();
        (pre, target, post)
    }

    #[test]
    fn of_a_dozen_alike_things_each_can_be_touched_in_one_way() {
        let (pre, target, post) = touching(12, 4);
        let alike = Symmetry::new(&pre, &target, post.iter().map(|(pattern, absent)| (pattern, *absent)));
        let table: Vec<_> = (0..12).map(|one| object(one, 100 - i64::from(one))).collect();
        let found = bindings(&pre, &alike, &table, 64);
        let touched: Vec<_> = found.iter().map(|binding| target[0].apply(binding)).collect();
        // Those before it in the schema come before it on the table while there are such.
        assert_eq!(found.len(), 12, "{touched:?}");
        let each: std::collections::BTreeSet<_> = touched.into_iter().collect();
        assert_eq!(each.len(), 12);
    }

    #[test]
    fn what_else_a_condition_is_makes_it_unlike() {
        let (pre, target, mut post) = touching(3, 0);
        let of = |post: &[(Pattern, bool)]| {
            Symmetry::new(&pre, &target, post.iter().map(|(pattern, absent)| (pattern, *absent)))
        };
        assert_eq!(of(&post).before[..], [None, None, Some(1)]);
        // The last one is taken away.
        post[2].1 = true;
        assert_eq!(of(&post).before[..], [None, None, None]);
    }

    #[test]
    fn a_law_represents_what_reads_like_it_and_nothing_else() {
        let (pre, target, post) = touching(12, 11);
        let post: Vec<_> = post.iter().map(|(pattern, absent)| (pattern, *absent)).collect();
        let alike = Symmetry::new(&pre, &target, post.iter().copied());
        let law = Statement { pre: &pre, alike: &alike, target: &target, post: &post };
        let table: Vec<_> = (0..12).map(|one| object(one, 100 - i64::from(one))).collect();
        let at = |field: i64| {
            let there = finger(field);
            let parts = vec![ConditionRoles::post(false); table.len()];
            let case = Case { pre: table.iter().collect(), parts, post: vec![(&there, false)] };
            let mut budget = 200;
            (represents(law, &case, &[&there], &mut budget), budget > 0)
        };
        // Within few attempts, of half a billion ways.
        assert_eq!(at(97), (true, true));
        assert_eq!(at(5), (false, true));
    }
}
