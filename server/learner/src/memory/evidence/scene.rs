//! A scene: a context in which an action is taken, with the values that can be named in it. What holds in it, and what a change
//! makes of it, is said here and nowhere else.

use std::sync::Arc;

use crate::memory::evidence::price::anchor;
use crate::nouns::claim::{Anchor, Change, Condition, Expression, Reference, Sketch};
use crate::nouns::experience::Recalled;
use crate::nouns::observation::{Observation, PropertyId, TypeId, Value};

/// Values that are named in one scene; more are not, so that a crowd can't make a step slow.
const NAMES_MAX: usize = 96;

/// Observations of a context that are asked for: those of the types of which there are fewest. Others are a crowd, of which only
/// what becomes of it is told.
const ASKED_MAX: usize = 128;
/// Observations that come and go together and are still put into words.
const WORDED_MAX: usize = 32;

/// A context, its observations in canonical order, and what can be named in it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Scene {
    pub(super) context: Arc<[Observation]>,
    /// The names with their values, in order: the most direct first.
    names: Vec<(Reference, Value)>,
    /// The observation of which alone it is asked whether it is there afterwards; none where all of its type are told together.
    itself: Option<Observation>,
    /// What was there when the body was last as the action makes it; none where that is not known.
    recalled: Option<Recalled>,
}

/// The runs of observations of one type.
fn runs(context: &[Observation]) -> impl Iterator<Item = &[Observation]> {
    context.chunk_by(|a, b| a.kind() == b.kind())
}

/// The observations of one type.
pub(super) fn of_kind(observations: &[Observation], kind: TypeId) -> &[Observation] {
    let from = observations.partition_point(|o| o.kind() < kind);
    let rest = observations.get(from..).unwrap_or_default();
    rest.get(..rest.partition_point(|o| o.kind() == kind)).unwrap_or_default()
}

fn property(observation: &Observation, property: PropertyId) -> Option<Value> {
    let properties = observation.properties();
    properties.binary_search_by_key(&property, |(p, _)| *p).ok().map(|at| properties[at].1)
}

/// How much more one number is than another of its kind.
fn difference(value: Value, from: Value) -> Option<i64> {
    match (value, from) {
        (Value::Integer(a), Value::Integer(b)) | (Value::Bin(a), Value::Bin(b)) => a.checked_sub(b),
        _ => None,
    }
}

fn more(value: Value, by: i64) -> Option<Value> {
    match value {
        _ if by == 0 => Some(value),
        Value::Integer(n) => n.checked_add(by).map(Value::Integer),
        Value::Bin(n) => n.checked_add(by).map(Value::Bin),
        Value::Symbol(_) | Value::Boolean(_) => None,
    }
}

pub(super) fn number(value: Value) -> Option<i64> {
    match value {
        Value::Integer(n) | Value::Bin(n) => Some(n),
        Value::Symbol(_) | Value::Boolean(_) => None,
    }
}

impl Scene {
    /// `context` in which an action with these parameters, and with this effect of its own, is taken.
    pub(super) fn new(
        context: impl Into<Arc<[Observation]>>,
        parameters: &[Option<Value>],
        effect: &[Observation],
    ) -> Self {
        let context = context.into();
        let mut names: Vec<(Reference, Value)> = Vec::new();
        let places = parameters.iter().zip(0..=u8::MAX);
        names.extend(places.filter_map(|(value, at)| Some((Reference::Parameter(at), (*value)?))));
        for observation in effect {
            let named =
                |(p, value): &(PropertyId, Value)| (Reference::Effect(observation.kind(), *p), *value);
            names.extend(observation.properties().iter().map(named));
        }
        for run in runs(&context) {
            if let [only] = run {
                let named = |(p, value): &(PropertyId, Value)| (Reference::Only(only.kind(), *p), *value);
                names.extend(only.properties().iter().map(named));
            }
        }
        names.sort_unstable();
        names.dedup_by_key(|(reference, _)| *reference);
        names.truncate(NAMES_MAX);
        let tied = names.iter().flat_map(|(from, value)| tied(&context, *from, *value));
        let tied: Vec<_> = tied.take(NAMES_MAX).collect();
        names.extend(tied);
        names.truncate(NAMES_MAX);
        Self { context, names, itself: None, recalled: None }
    }

    /// The same, where this is recalled. How the body is then shows in the type `key`.
    pub(super) fn recalling(mut self, recalled: Option<Recalled>, key: TypeId) -> Self {
        for run in recalled.iter().flat_map(|recalled| runs(&recalled.observations)) {
            if let [only] = run
                && only.kind() != key
            {
                let named = |(p, value): &(PropertyId, Value)| (Reference::Recalled(only.kind(), *p), *value);
                self.names.extend(only.properties().iter().map(named));
            }
        }
        self.names.sort_unstable();
        self.names.truncate(NAMES_MAX);
        self.recalled = recalled;
        self
    }

    /// The same, of which it is asked whether `one` is there afterwards. Its values are named besides those of parameters and of what
    /// there is one of.
    pub(super) fn of(&self, one: &Observation) -> Self {
        let own = one.properties().iter().map(|(p, value)| (Reference::Itself(*p), *value));
        let direct = |(reference, _): &(Reference, Value)| {
            matches!(reference, Reference::Parameter(_) | Reference::Only(..))
        };
        let mut names: Vec<_> = self.names.iter().copied().filter(direct).chain(own).collect();
        names.sort_unstable();
        Self {
            context: self.context.clone(),
            names,
            itself: Some(one.clone()),
            recalled: self.recalled.clone(),
        }
    }

    /// The value of a reference.
    pub(super) fn value(&self, reference: Reference) -> Option<Value> {
        if reference == Reference::Age {
            return self.recalled.as_ref().map(|recalled| Value::Integer(recalled.age.into()));
        }
        let at = self.names.binary_search_by_key(&reference, |(known, _)| *known).ok()?;
        Some(self.names[at].1)
    }

    /// The numbers that can be named directly.
    pub(super) fn numbers(&self) -> impl Iterator<Item = (Anchor, i64)> + '_ {
        let age = self.recalled.iter().map(|recalled| (Anchor::Age, recalled.age.into()));
        let named = |(reference, value): &(Reference, Value)| Some((anchor(*reference)?, number(*value)?));
        self.names.iter().filter_map(named).chain(age)
    }

    /// Whether a condition holds.
    pub(super) fn holds(&self, condition: &Condition) -> bool {
        match condition {
            Condition::Is(anchor, value) => self.value((*anchor).into()) == Some(*value),
            Condition::AtLeast(anchor, least) => {
                self.value((*anchor).into()).and_then(number).is_some_and(|n| n >= *least)
            }
            Condition::Observed(sketch) => {
                of_kind(&self.context, sketch.kind).iter().any(|o| self.fits(sketch, o))
            }
            Condition::Recalled(sketch) => self.recalled.as_ref().is_some_and(|recalled| {
                of_kind(&recalled.observations, sketch.kind).iter().any(|o| self.fits(sketch, o))
            }),
        }
    }

    /// The observation by which a condition holds.
    pub(super) fn relied_on(&self, condition: &Condition) -> Option<&Observation> {
        match condition {
            Condition::Is(Anchor::Only(kind, _), _) | Condition::AtLeast(Anchor::Only(kind, _), _) => {
                of_kind(&self.context, *kind).first()
            }
            Condition::Is(..) | Condition::AtLeast(..) | Condition::Recalled(_) => None,
            Condition::Observed(sketch) => {
                of_kind(&self.context, sketch.kind).iter().find(|o| self.fits(sketch, o))
            }
        }
    }

    /// The observations that give a change the values that it names, and those that it says vanish.
    pub(super) fn named_in<'a>(&'a self, change: &'a Change) -> impl Iterator<Item = Observation> + 'a {
        let expressions = change.sketches().flat_map(|sketch| sketch.properties.iter());
        let named = expressions.filter_map(|(_, expression)| match expression {
            Expression::Named(Reference::Only(kind, _), _) => of_kind(&self.context, *kind).first().cloned(),
            Expression::Named(Reference::Tied { from, kind, at, .. }, _) => {
                let value = self.value((*from).into())?;
                of_kind(&self.context, *kind).iter().find(|o| property(o, *at) == Some(value)).cloned()
            }
            _ => None,
        });
        named.chain(change.vanishes.iter().filter_map(|sketch| self.observation(sketch)))
    }

    /// Whether an observation has all values of a sketch.
    fn fits(&self, sketch: &Sketch, observation: &Observation) -> bool {
        let has = |(p, e): &(PropertyId, Expression)| {
            property(observation, *p).is_some_and(|value| self.express(*e) == Some(value))
        };
        sketch.properties.iter().all(has)
    }

    /// Whether a change makes just `after` of what there is of `kinds`.
    pub(super) fn makes(&self, change: &Change, after: &[Observation], kinds: &[TypeId]) -> bool {
        if let Some(one) = &self.itself {
            return after.binary_search(one).is_ok() == change.vanishes.is_empty();
        }
        // Most changes are of another thing, which is soon seen.
        let comes = |sketch: &Sketch| of_kind(after, sketch.kind).iter().any(|o| self.fits(sketch, o));
        let stays = change.vanishes.is_empty() && change.becomes.is_empty() && change.appears.is_empty();
        if stays {
            let of_kinds = |o: &&Observation| kinds.binary_search(&o.kind()).is_ok();
            return self.context.iter().filter(of_kinds).eq(after);
        }
        change.becomes.iter().chain(&change.appears).all(comes)
            && self.after(change, kinds).is_some_and(|made| made == after)
    }

    fn express(&self, expression: Expression) -> Option<Value> {
        match expression {
            Expression::Constant(value) => Some(value),
            Expression::Named(reference, by) => more(self.value(reference)?, by),
        }
    }

    /// The observation that a sketch of all its properties stands for.
    fn observation(&self, sketch: &Sketch) -> Option<Observation> {
        let properties: Option<Vec<_>> =
            sketch.properties.iter().map(|(p, e)| Some((*p, self.express(*e)?))).collect();
        Some(Observation::new(sketch.kind, properties?))
    }

    /// The observations of `kinds` after a change; none where the change can't be.
    pub(super) fn after(&self, change: &Change, kinds: &[TypeId]) -> Option<Vec<Observation>> {
        let of_kinds = |o: &&Observation| kinds.binary_search(&o.kind()).is_ok();
        let mut after: Vec<_> = self.context.iter().filter(of_kinds).cloned().collect();
        for sketch in &change.vanishes {
            let gone = self.observation(sketch)?;
            let at = after.binary_search(&gone).ok()?;
            after.remove(at);
        }
        for sketch in &change.becomes {
            let new = self.observation(sketch)?;
            let mut same = after.iter().enumerate().filter(|(_, o)| o.kind() == new.kind()).map(|(at, _)| at);
            match (same.next(), same.next()) {
                (Some(at), None) => drop(after.remove(at)),
                (None, _) => (),
                (Some(_), Some(_)) => return None,
            }
            after.push(new);
            after.sort_unstable();
        }
        for sketch in &change.appears {
            let new = self.observation(sketch)?;
            let at = after.binary_search(&new).err()?;
            after.insert(at, new);
        }
        Some(after)
    }

    /// Whether more is there than is asked for.
    pub(super) fn is_crowded(&self) -> bool {
        self.context.len() > ASKED_MAX
    }

    /// The conditions that hold here and may be asked for, each once and in order.
    pub(super) fn conditions(&self) -> Vec<Condition> {
        if let Some(one) = &self.itself {
            return self.conditions_of(one);
        }
        let mut found = Vec::new();
        if self.is_crowded() {
            let mut runs: Vec<_> = runs(&self.context).collect();
            runs.sort_by_key(|run| run.len());
            let asked = runs.into_iter().flatten().take(ASKED_MAX);
            asked.for_each(|observation| self.observed(observation, &mut found));
        } else {
            self.context.iter().for_each(|observation| self.observed(observation, &mut found));
        }
        for (reference, value) in &self.names {
            if let Some(anchor @ (Anchor::Parameter(_) | Anchor::Effect(..))) = anchor(*reference) {
                found.push(Condition::Is(anchor, *value));
            }
        }
        found.extend(self.recalled_kinds());
        for observation in
            self.recalled.iter().flat_map(|recalled| recalled.observations.iter()).take(ASKED_MAX)
        {
            let given = |(p, value): &(PropertyId, Value)| (*p, Expression::Constant(*value));
            for one in observation.properties() {
                found.push(Condition::Recalled(Sketch {
                    kind: observation.kind(),
                    properties: [given(one)].into(),
                }));
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The conditions of one observation by itself: where others of its type are, as seen from it; which others share a value with it;
    /// which values it has; and which those have of which there is one only, the action among them.
    fn conditions_of(&self, one: &Observation) -> Vec<Condition> {
        let mut found = Vec::new();
        let mut push = |kind: TypeId, properties: Vec<(PropertyId, Expression)>| {
            found.push(Condition::Observed(Sketch { kind, properties: properties.into() }));
        };
        for other in of_kind(&self.context, one.kind()).iter().take(ASKED_MAX) {
            if let Some(properties) = from_itself(one, other) {
                push(one.kind(), properties);
            }
        }
        let others = self.context.iter().filter(|o| o.kind() != one.kind()).take(ASKED_MAX);
        for (other, (p, value)) in others.flat_map(|o| o.properties().iter().map(move |own| (o, own))) {
            let same = one.properties().iter().filter(|(_, own)| own == value);
            same.for_each(|(q, _)| {
                push(other.kind(), vec![(*p, Expression::Named(Reference::Itself(*q), 0))]);
            });
        }
        let only = |(reference, value): &(Reference, Value)| match reference {
            Reference::Only(kind, p) if *kind != one.kind() => Some((*kind, *p, *value)),
            _ => None,
        };
        for (kind, p, value) in self.names.iter().filter_map(only) {
            push(kind, vec![(p, Expression::Constant(value))]);
        }
        for (reference, value) in &self.names {
            if let Some(anchor @ (Anchor::Parameter(_) | Anchor::Itself(_))) = anchor(*reference) {
                found.push(Condition::Is(anchor, *value));
            }
        }
        if self.recalled.as_ref().is_some_and(|recalled| recalled.observations.binary_search(one).is_ok()) {
            let own = |(p, _): &(PropertyId, Value)| (*p, Expression::Named(Reference::Itself(*p), 0));
            let properties = one.properties().iter().map(own).collect();
            found.push(Condition::Recalled(Sketch { kind: one.kind(), properties }));
        }
        found.extend(self.recalled_kinds());
        found.sort_unstable();
        found.dedup();
        found
    }

    /// That something of a type is recalled.
    fn recalled_kinds(&self) -> impl Iterator<Item = Condition> + '_ {
        let kinds = self
            .recalled
            .iter()
            .flat_map(|recalled| runs(&recalled.observations))
            .filter_map(|run| run.first());
        kinds.map(|one| Condition::Recalled(Sketch { kind: one.kind(), properties: [].into() }))
    }

    /// That there is such an observation; with one of its values given; with one of them named, and with a value given besides; with
    /// all of them given; and with all named that can be.
    fn observed(&self, observation: &Observation, found: &mut Vec<Condition>) {
        let kind = observation.kind();
        let mut push = |mut properties: Vec<(PropertyId, Expression)>| {
            properties.sort_unstable();
            found.push(Condition::Observed(Sketch { kind, properties: properties.into() }));
        };
        let properties = observation.properties();
        let given = |(p, value): &(PropertyId, Value)| (*p, Expression::Constant(*value));
        push(Vec::new());
        properties.iter().for_each(|one| push(vec![given(one)]));
        if properties.len() > 1 {
            push(properties.iter().map(given).collect());
        }
        let mut first_names = Vec::new();
        for (p, value) in properties {
            // That the only thing of its kind has the value that it has says nothing.
            let own = |reference: &Reference| matches!(reference, Reference::Only(k, _) if *k == kind);
            let names = self.names.iter().filter(|(r, named)| named == value && !own(r));
            for (at, (reference, _)) in names.enumerate() {
                let named = (*p, Expression::Named(*reference, 0));
                push(vec![named]);
                if reference.is_of_action() {
                    properties.iter().filter(|(q, _)| q != p).for_each(|one| push(vec![named, given(one)]));
                }
                first_names.extend((at == 0).then_some(named));
            }
        }
        if first_names.len() > 1 {
            push(first_names);
        }
    }

    /// The changes that make `after` of what there is of `kinds`, each in other words, shortest names first. Some may be the same.
    pub(super) fn changes(&self, after: &[Observation], kinds: &[TypeId]) -> Vec<Change> {
        if let Some(one) = &self.itself {
            return vec![there(one, after.binary_search(one).is_ok())];
        }
        let of_kinds = |o: &&Observation| kinds.binary_search(&o.kind()).is_ok();
        let gone = self.context.iter().filter(of_kinds).filter(|o| after.binary_search(o).is_err());
        let gone: Vec<_> = gone.take(WORDED_MAX + 1).collect();
        let new = after.iter().filter(|o| self.context.binary_search(o).is_err());
        let new: Vec<_> = new.take(WORDED_MAX + 1).collect();
        let mut changes = Vec::new();
        if gone.len() + new.len() > WORDED_MAX {
            return changes;
        }
        for wording in [Wording::Named, Wording::Differing, Wording::Seen, Wording::Given] {
            for single in [true, false] {
                let change = self.change(&gone, &new, after, wording, single);
                if !changes.contains(&change) {
                    changes.push(change);
                }
            }
        }
        changes
    }

    fn change(
        &self,
        gone: &[&Observation],
        new: &[&Observation],
        after: &[Observation],
        wording: Wording,
        single: bool,
    ) -> Change {
        let mut replaced = vec![false; gone.len()];
        let (mut becomes, mut appears) = (Vec::new(), Vec::new());
        for observation in new {
            // What it was before, most likely: that of its type which shares most with it.
            let shared = |o: &Observation| o.shared(observation);
            let before = (0..gone.len())
                .filter(|at| gone[*at].kind() == observation.kind() && !replaced[*at])
                .max_by_key(|at| (shared(gone[*at]), std::cmp::Reverse(*at)));
            let sketch = self.sketch(observation, before.map(|at| gone[at]), wording);
            let kind = observation.kind();
            if single && of_kind(&self.context, kind).len() <= 1 && of_kind(after, kind).len() == 1 {
                before.into_iter().for_each(|at| replaced[at] = true);
                becomes.push(sketch);
            } else {
                appears.push(sketch);
            }
        }
        let left = gone.iter().zip(&replaced).filter(|(_, replaced)| !**replaced);
        let mut vanishes: Vec<_> = left.map(|(o, _)| self.sketch(o, None, wording)).collect();
        vanishes.sort_unstable();
        appears.sort_unstable();
        Change { becomes: becomes.into(), vanishes: vanishes.into(), appears: appears.into() }
    }

    /// An observation in one wording; `before` is what it was.
    fn sketch(&self, observation: &Observation, before: Option<&Observation>, wording: Wording) -> Sketch {
        let kind = observation.kind();
        let expression = |(p, value): &(PropertyId, Value)| {
            let name = |allowed: fn(Reference) -> bool| {
                let named = self.names.iter().find(|(r, known)| known == value && allowed(*r));
                named.map(|(reference, _)| Expression::Named(*reference, 0))
            };
            let named = match wording {
                Wording::Given => None,
                Wording::Named => name(|_| true),
                Wording::Seen => name(|r| !matches!(r, Reference::Parameter(_) | Reference::Effect(..))),
                Wording::Differing => {
                    let old = before.and_then(|before| property(before, *p));
                    old.and_then(|old| self.from(kind, *p, old, *value)).or_else(|| name(|_| true))
                }
            };
            (*p, named.unwrap_or(Expression::Constant(*value)))
        };
        Sketch { kind, properties: observation.properties().iter().map(expression).collect() }
    }

    /// `value` as what the property of the observation was before, and so much more.
    fn from(&self, kind: TypeId, property: PropertyId, old: Value, value: Value) -> Option<Expression> {
        let by = if old == value { 0 } else { difference(value, old)? };
        let itself = Reference::Only(kind, property);
        let reference = if self.value(itself) == Some(old) {
            itself
        } else {
            self.names.iter().find(|(_, known)| *known == old)?.0
        };
        Some(Expression::Named(reference, by))
    }
}

/// That an observation, whatever its values are, is there afterwards, or is not.
fn there(one: &Observation, is_there: bool) -> Change {
    let own = |(p, _): &(PropertyId, Value)| (*p, Expression::Named(Reference::Itself(*p), 0));
    let sketch = Sketch { kind: one.kind(), properties: one.properties().iter().map(own).collect() };
    let (there, gone) = if is_there { (vec![sketch], vec![]) } else { (vec![], vec![sketch]) };
    Change { becomes: there.into(), vanishes: gone.into(), appears: [].into() }
}

/// Another observation of the type of `one`, as far from it as it is: numbers by their difference, other values if they are the same.
fn from_itself(one: &Observation, other: &Observation) -> Option<Vec<(PropertyId, Expression)>> {
    let (one, other) = (one.properties(), other.properties());
    let from = |((p, own), (q, value)): (&(PropertyId, Value), &(PropertyId, Value))| {
        let by = if own == value { 0 } else { difference(*value, *own)? };
        (p == q).then_some((*p, Expression::Named(Reference::Itself(*p), by)))
    };
    (one.len() == other.len()).then(|| one.iter().zip(other).map(from).collect()).flatten()
}

/// The words in which a change is put.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wording {
    /// A value by its most direct name.
    Named,
    /// A number by its difference from the one before.
    Differing,
    /// A value by a name that is no part of the action.
    Seen,
    /// A value as it is.
    Given,
}

/// The values in observations that are tied to `value` and to nothing else of their kind.
fn tied(
    context: &[Observation],
    from: Reference,
    value: Value,
) -> impl Iterator<Item = (Reference, Value)> + '_ {
    let anchored = anchor(from);
    let runs = runs(context).filter(move |run| {
        let kind = run.first().map(Observation::kind);
        // The only one of its kind needs no other name.
        run.first().is_some_and(|o| o.properties().len() > 1)
            && !matches!(from, Reference::Only(k, _) if Some(k) == kind)
    });
    runs.flat_map(move |run| {
        let kind = run.first().map_or(TypeId(0), Observation::kind);
        let at: Vec<_> =
            run.first().map_or(&[][..], Observation::properties).iter().map(|(p, _)| *p).collect();
        at.into_iter()
            .filter_map(move |at| {
                let mut having = run.iter().filter(|o| property(o, at) == Some(value));
                let one = having.next()?;
                having.next().is_none().then_some((at, one))
            })
            .flat_map(move |(at, one)| {
                let others = one.properties().iter().filter(move |(p, _)| *p != at);
                others.filter_map(move |(to, value)| {
                    Some((Reference::Tied { from: anchored?, kind, at, to: *to }, *value))
                })
            })
    })
}
