//! Claims: under these conditions, an action changes the world in one of these ways, so often. A condition and a change may name a
//! value by its part in the action instead of giving it, and then speak of all places alike.

use crate::nouns::observation::{PropertyId, TypeId, Value};

/// A value named by its part in what is done, or by its tie to a value that has such a part ("the thing under the one picked up").
/// References are ordered by how direct they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Reference {
    /// The value of the action's parameter of this place.
    Parameter(u8),
    /// The value that the primitive brings about of itself: in the last observation of this type that its own effect has.
    Effect(TypeId, PropertyId),
    /// The value in the only observation of this type.
    Only(TypeId, PropertyId),
    /// The value in the observation that the claim is about, where it is about each of its type.
    Itself(PropertyId),
    /// The value in the only observation of this type that is recalled: that was there when the body was last as the action makes it.
    Recalled(TypeId, PropertyId),
    /// How many experiences ago it was that is recalled.
    Age,
    /// The value of the property `to` in the only observation of type `kind` that has the value of `from` in its property `at`.
    Tied {
        /// The value that it is tied to.
        from: Anchor,
        /// The type of the observation.
        kind: TypeId,
        /// The property that has the value of `from`.
        at: PropertyId,
        /// The property whose value is meant.
        to: PropertyId,
    },
}

/// A reference that others may be tied to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Anchor {
    /// See [`Reference::Parameter`].
    Parameter(u8),
    /// See [`Reference::Effect`].
    Effect(TypeId, PropertyId),
    /// See [`Reference::Only`].
    Only(TypeId, PropertyId),
    /// See [`Reference::Itself`].
    Itself(PropertyId),
    /// See [`Reference::Age`].
    Age,
}

impl From<Anchor> for Reference {
    fn from(anchor: Anchor) -> Self {
        match anchor {
            Anchor::Parameter(at) => Self::Parameter(at),
            Anchor::Effect(kind, property) => Self::Effect(kind, property),
            Anchor::Only(kind, property) => Self::Only(kind, property),
            Anchor::Itself(property) => Self::Itself(property),
            Anchor::Age => Self::Age,
        }
    }
}

impl Reference {
    /// Whether it is a value of the action, or tied to one.
    #[must_use]
    pub fn is_of_action(self) -> bool {
        match self {
            Self::Parameter(_) | Self::Effect(..) => true,
            Self::Only(..) | Self::Itself(_) | Self::Recalled(..) | Self::Age => false,
            Self::Tied { from, .. } => !matches!(from, Anchor::Only(..) | Anchor::Itself(_) | Anchor::Age),
        }
    }

    /// The types of the observations in the context that have the value, or to which it is tied.
    fn kinds(self) -> impl Iterator<Item = TypeId> {
        let kinds = match self {
            Self::Only(kind, _) => [Some(kind), None],
            Self::Tied { from, kind, .. } => [Some(kind), from.kind()],
            Self::Parameter(_) | Self::Effect(..) | Self::Itself(_) | Self::Recalled(..) | Self::Age => {
                [None, None]
            }
        };
        kinds.into_iter().flatten()
    }

    /// Whether it is a value of what is recalled.
    fn is_recalled(self) -> bool {
        matches!(self, Self::Recalled(..) | Self::Age | Self::Tied { from: Anchor::Age, .. })
    }
}

impl Anchor {
    /// The type of the observation in the context that has the value.
    fn kind(self) -> Option<TypeId> {
        match self {
            Self::Only(kind, _) => Some(kind),
            Self::Parameter(_) | Self::Effect(..) | Self::Itself(_) | Self::Age => None,
        }
    }
}

/// The value of a property in a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Expression {
    /// What the reference names, and this much more; 0 for values that are not numbers. Of a real the difference is in bins.
    Named(Reference, i64),
    /// This value.
    Constant(Value),
}

/// An observation in a claim: a type with some of its properties. Those left out may have any value.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Sketch {
    /// The type.
    pub kind: TypeId,
    /// The properties, ordered.
    pub properties: Box<[(PropertyId, Expression)]>,
}

/// A condition of a claim.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Condition {
    /// Such an observation is made.
    Observed(Sketch),
    /// The reference names this value.
    Is(Anchor, Value),
    /// Such an observation is recalled: it was there when the body was last as the action makes it.
    Recalled(Sketch),
    /// The reference names a number that is at least this one; of a real, a bin.
    AtLeast(Anchor, i64),
}

impl Sketch {
    /// Whether it names a value of the action.
    pub(crate) fn is_of_action(&self) -> bool {
        let named =
            |(_, e): &(PropertyId, Expression)| matches!(e, Expression::Named(r, _) if r.is_of_action());
        self.properties.iter().any(named)
    }

    fn references(&self) -> impl Iterator<Item = Reference> + '_ {
        self.properties.iter().filter_map(|(_, expression)| match expression {
            Expression::Named(reference, _) => Some(*reference),
            Expression::Constant(_) => None,
        })
    }

    /// The types of what has the values that it names.
    pub(crate) fn named_kinds(&self) -> impl Iterator<Item = TypeId> + '_ {
        self.references().flat_map(Reference::kinds)
    }

    /// Whether it names a value of what is recalled.
    pub(crate) fn is_recalled(&self) -> bool {
        self.references().any(Reference::is_recalled)
    }

    /// Whether it has a number so much more or less than another.
    pub(crate) fn differs(&self) -> bool {
        let differs = |(_, e): &(PropertyId, Expression)| matches!(e, Expression::Named(_, by) if *by != 0);
        self.properties.iter().any(differs)
    }
}

impl Condition {
    /// Whether it names a value of the action, so that it holds of one action and not of another.
    pub(crate) fn is_of_action(&self) -> bool {
        match self {
            Self::Observed(sketch) | Self::Recalled(sketch) => sketch.is_of_action(),
            Self::Is(anchor, _) | Self::AtLeast(anchor, _) => Reference::from(*anchor).is_of_action(),
        }
    }

    /// The types of what it asks for, and of what has the values that it names.
    pub(crate) fn kinds(&self) -> Box<dyn Iterator<Item = TypeId> + '_> {
        match self {
            Self::Is(anchor, _) | Self::AtLeast(anchor, _) => Box::new(Reference::from(*anchor).kinds()),
            Self::Observed(sketch) | Self::Recalled(sketch) => {
                Box::new(std::iter::once(sketch.kind).chain(sketch.named_kinds()))
            }
        }
    }

    /// Whether it names a value of the observation that its claim is about.
    pub(crate) fn is_of_itself(&self) -> bool {
        match self {
            Self::Observed(sketch) | Self::Recalled(sketch) => {
                let of_itself = |(_, e): &(PropertyId, Expression)| {
                    matches!(e, Expression::Named(Reference::Itself(_), _))
                };
                sketch.properties.iter().any(of_itself)
            }
            Self::Is(anchor, _) | Self::AtLeast(anchor, _) => matches!(anchor, Anchor::Itself(_)),
        }
    }

    /// Whether it asks for what is recalled.
    pub(crate) fn is_recalled(&self) -> bool {
        matches!(self, Self::Recalled(_))
    }

    /// Whether it depends on what is recalled.
    pub(crate) fn rests_on_recall(&self) -> bool {
        match self {
            Self::Recalled(_) => true,
            Self::Is(anchor, _) | Self::AtLeast(anchor, _) => Reference::from(*anchor).is_recalled(),
            Self::Observed(sketch) => sketch.is_recalled(),
        }
    }

    /// How many values it names.
    pub(crate) fn names(&self) -> usize {
        let Self::Observed(sketch) = self else { return 0 };
        sketch.properties.iter().filter(|(_, e)| matches!(e, Expression::Named(..))).count()
    }
}

/// How observations change. What it does not mention stays as it is; events are over with their frame.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Change {
    /// The only observation of its type becomes this one, or this one appears where there is none of its type.
    pub becomes: Box<[Sketch]>,
    /// These are observed no longer.
    pub vanishes: Box<[Sketch]>,
    /// These are observed besides.
    pub appears: Box<[Sketch]>,
}

impl Change {
    /// All that it mentions.
    pub fn sketches(&self) -> impl Iterator<Item = &Sketch> {
        self.becomes.iter().chain(&self.vanishes).chain(&self.appears)
    }

    /// How many values it gives instead of naming them.
    pub(crate) fn constants(&self) -> usize {
        let given = |(_, e): &&(PropertyId, Expression)| matches!(e, Expression::Constant(_));
        self.sketches().flat_map(|sketch| sketch.properties.iter()).filter(given).count()
    }
}

/// A claim with those that are exceptions to it. Of the claims whose conditions hold, the one in force is found from the top: the
/// first exception whose condition holds, and so on within it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Claim {
    /// The condition that it has besides those of the claim that it is an exception to; none at the top.
    pub condition: Option<Condition>,
    /// How much better its outcomes and the others were told apart than together when it was grown, with the price of its condition
    /// taken off: ln of the odds; 0 at the top.
    pub gain: f64,
    /// The exceptions, in their order.
    pub exceptions: Vec<Claim>,
    /// The changes that followed where it was in force and no exception was, each with how often, the most frequent first.
    pub outcomes: Vec<(Change, u32)>,
    /// How often it was in force; more often than the outcomes add up to where some followed no form.
    pub trials: u32,
}

impl Claim {
    /// Whether it is about each observation of a type by itself.
    #[must_use]
    pub fn is_of_each(&self) -> bool {
        let sketches = self.all().flat_map(|claim| &claim.outcomes).flat_map(|(change, _)| change.sketches());
        let mut expressions = sketches.flat_map(|sketch| sketch.properties.iter());
        expressions.any(|(_, e)| matches!(e, Expression::Named(Reference::Itself(_), _)))
    }

    /// This claim and all exceptions below it, the claim before its exceptions.
    pub fn all(&self) -> Box<dyn Iterator<Item = &Self> + '_> {
        Box::new(std::iter::once(self).chain(self.exceptions.iter().flat_map(Self::all)))
    }

    /// The evidence for the condition of its exception `at`: how often each change followed where the condition holds, and where it
    /// does not though all of this claim's do and none of the exceptions before is in force. The most frequent ones come first.
    #[must_use]
    pub fn evidence(&self, at: usize) -> Evidence<'_> {
        let mut evidence = Evidence::default();
        for claim in self.exceptions.get(at).into_iter().flat_map(Self::all) {
            evidence.with += claim.trials;
            claim.outcomes.iter().for_each(|(change, count)| evidence.outcome(change).1 += count);
        }
        let later = self.exceptions.get(at + 1..).into_iter().flatten().flat_map(Self::all);
        let own = (self.trials, &self.outcomes);
        for (trials, outcomes) in
            std::iter::once(own).chain(later.map(|claim| (claim.trials, &claim.outcomes)))
        {
            evidence.without += trials;
            outcomes.iter().for_each(|(change, count)| evidence.outcome(change).2 += count);
        }
        evidence.outcomes.sort_by_key(|(_, with, without)| std::cmp::Reverse(with + without));
        evidence
    }
}

/// How often changes followed where a condition holds, and where it does not.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Evidence<'a> {
    /// How often it held.
    pub with: u32,
    /// How often it did not.
    pub without: u32,
    /// Each change, with how often it followed where the condition held, and where it did not.
    pub outcomes: Vec<(&'a Change, u32, u32)>,
}

impl<'a> Evidence<'a> {
    fn outcome(&mut self, change: &'a Change) -> &mut (&'a Change, u32, u32) {
        let known = self.outcomes.iter().position(|(known, ..)| *known == change);
        let at = known.unwrap_or_else(|| {
            self.outcomes.push((change, 0, 0));
            self.outcomes.len() - 1
        });
        &mut self.outcomes[at]
    }
}
