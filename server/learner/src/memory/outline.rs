//! What equation (1) and generalisation read of a concrete schema, side by side: looking at every schema that can be
//! reached takes a few cache lines each.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::memory::content::Content;
use crate::memory::groups::GroupId;
use crate::nouns::observation::TypeId;
use crate::nouns::parameters::{Parameters, TypeRules};
use crate::nouns::schema::{
    ASSOCIATIONS_MAX, Association, Concrete, ObservationId, PostCondition, Schema, SchemaId, among, signature,
};
use crate::nouns::vocabulary::PrimitiveId;

/// What an index is made from.
#[derive(Clone, Copy)]
pub(crate) struct Basis<'a> {
    pub(crate) content: &'a Content,
    pub(crate) rules: &'a TypeRules,
    pub(crate) parameters: &'a Parameters,
}

/// A predicted change of context.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) what: ObservationId,
    pub(crate) absent: bool,
    pub(crate) probability: f64,
}

/// A post-condition in outline.
#[derive(Clone, Copy, Debug)]
struct OutcomeOutline {
    what: ObservationId,
    absent: bool,
    /// In Ψ, and can excite: observed, no pre-condition, and of some property.
    excites: bool,
    /// May change a context in which the schema can be executed.
    changes: bool,
    probability: f64,
}

/// Most schemas have one such post-condition, which then costs no allocation and no cache line of its own.
#[derive(Clone, Debug)]
enum OutcomeList {
    One(OutcomeOutline),
    Any(Box<[OutcomeOutline]>),
}

impl OutcomeList {
    fn iter(&self) -> std::slice::Iter<'_, OutcomeOutline> {
        match self {
            Self::One(one) => std::slice::from_ref(one).iter(),
            Self::Any(any) => any.iter(),
        }
    }
}

impl FromIterator<OutcomeOutline> for OutcomeList {
    fn from_iter<I: IntoIterator<Item = OutcomeOutline>>(items: I) -> Self {
        let items: Vec<_> = items.into_iter().collect();
        match items[..] {
            [one] => Self::One(one),
            _ => Self::Any(items.into()),
        }
    }
}

/// A concrete schema in outline.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub(crate) action: PrimitiveId,
    pub(crate) group: GroupId,
    /// Which class it is in.
    pub(crate) class: ClassId,
    /// Its post-conditions that matter to either, in order. As probabilities seldom change, so does this.
    predicted: OutcomeList,
    /// Which of its associations, by place, may be strong and can excite: the others make no difference.
    pub(crate) associated: u32,
}

impl Outline {
    pub(crate) fn new(
        Basis { content, rules, parameters }: Basis<'_>,
        schema: &Schema,
        concrete: &Concrete,
        group: GroupId,
        class: ClassId,
    ) -> Self {
        let excites = |id: ObservationId| !content.observation(id).properties().is_empty();
        let changes = |p: &PostCondition<ObservationId>| {
            rules.of(content.observation(p.what).kind()).precondition && parameters.predicts(p.count)
        };
        let is_pre = among(&concrete.pre);
        let predicted = concrete
            .post
            .iter()
            // What it keeps as it was neither excites nor changes anything.
            .filter(|p| p.absent || !is_pre(p.what))
            .map(|p| OutcomeOutline {
                what: p.what,
                absent: p.absent,
                excites: !p.absent && excites(p.what),
                changes: changes(p),
                probability: p.count.ratio(),
            })
            .filter(|p| p.excites || p.changes)
            .collect();
        let associated = associated(Basis { content, rules, parameters }, schema);
        Self { action: concrete.action, group, class, predicted, associated }
    }

    /// Its post-conditions in Ψ that can excite, in order, with their probabilities: observed, no pre-conditions, and
    /// of some property.
    pub(crate) fn post(&self) -> impl Iterator<Item = (ObservationId, f64)> + '_ {
        self.predicted.iter().filter(|p| p.excites).map(|p| (p.what, p.probability))
    }

    /// What it predicts that may change a context in which it can be executed.
    pub(crate) fn changes(&self) -> impl Iterator<Item = Change> + Clone + '_ {
        let changing = self.predicted.iter().filter(|p| p.changes);
        changing.map(|p| Change { what: p.what, absent: p.absent, probability: p.probability })
    }
}

const _: () = assert!(ASSOCIATIONS_MAX <= u32::BITS as usize);

/// Which associations of a schema, by place, are strong for themselves or are events (which are by what other schemas are
/// associated with), and of some property. Most are neither: bystanders, that were there once or twice.
pub(crate) fn associated(Basis { content, rules, parameters }: Basis<'_>, schema: &Schema) -> u32 {
    let may = |association: &Association| {
        let observation = content.observation(association.observation);
        let strong = || association.count.interval().0 >= parameters.association_low_min;
        !observation.properties().is_empty() && (rules.of(observation.kind()).transient || strong())
    };
    let associations = schema.associations.iter().enumerate();
    associations.filter(|(_, association)| may(association)).fold(0, |all, (at, _)| all | 1 << at)
}

/// A class of similar schemas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClassId(u32);

/// The types of pre-conditions, of predicted observed and of predicted absent post-conditions.
type ClassKey = [Vec<TypeId>; 3];

/// Classes of schemas with "the same number of the same type of observations for their pre-conditions and
/// post-conditions" (II-E).
#[derive(Clone, Debug, Default)]
pub(crate) struct Classes {
    by_likeness: FxHashMap<ClassKey, ClassId>,
    /// By class. A tree, for schemas enter and leave large ones.
    members: Vec<BTreeSet<SchemaId>>,
}

impl Classes {
    /// The class of a schema as it is now, of which it is from now on.
    pub(crate) fn enter(
        &mut self,
        id: SchemaId,
        Basis { content, parameters, .. }: Basis<'_>,
        concrete: &Concrete,
    ) -> ClassId {
        let kind = |id: ObservationId| content.observation(id).kind();
        let post = |absent: bool| {
            let chosen = concrete.post.iter().filter(|p| p.absent == absent && parameters.predicts(p.count));
            signature(chosen.map(|p| kind(p.what)))
        };
        let likeness = [signature(concrete.pre.iter().map(|o| kind(*o))), post(false), post(true)];
        let next = ClassId(u32::try_from(self.members.len()).unwrap_or(u32::MAX));
        let class = *self.by_likeness.entry(likeness).or_insert(next);
        if class == next {
            self.members.push(BTreeSet::new());
        }
        self.members[class.0 as usize].insert(id);
        class
    }

    /// The schema is not in `class` any more.
    pub(crate) fn leave(&mut self, id: SchemaId, class: ClassId) {
        self.members[class.0 as usize].remove(&id);
    }

    /// The schemas of `class`, the newest first.
    pub(crate) fn newest(&self, class: ClassId) -> impl Iterator<Item = SchemaId> + '_ {
        self.members[class.0 as usize].iter().rev().copied()
    }
}
