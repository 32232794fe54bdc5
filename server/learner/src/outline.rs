//! What equation (1) and generalisation read of a concrete schema, side by side: looking at every schema that can be
//! reached takes a few cache lines each.

use rustc_hash::FxHashMap;

use crate::bound::predicted;
use crate::groups::GroupId;
use crate::memory::Content;
use crate::observation::TypeId;
use crate::parameters::{Parameters, TypeRules};
use crate::schema::{Concrete, ObservationId, Schema, signature};
use crate::vocabulary::PrimitiveId;

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

/// A concrete schema in outline.
#[derive(Clone, Debug)]
pub(crate) struct Outline {
    pub(crate) action: PrimitiveId,
    pub(crate) group: GroupId,
    /// Which class it is in.
    pub(crate) class: ClassId,
    /// Its post-conditions in Ψ that can excite, in order, with their probabilities: observed, no pre-conditions, and
    /// of some property.
    pub(crate) post: Box<[(ObservationId, f64)]>,
    /// What it predicts that may change a context in which it can be executed.
    pub(crate) changes: Box<[Change]>,
    /// Whether any of its associations, strong or not, has some property.
    pub(crate) associated: bool,
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
        let post = concrete
            .post
            .iter()
            .filter(|p| !p.absent && excites(p.what) && !concrete.pre.contains(&p.what))
            .map(|p| (p.what, p.count.ratio()))
            .collect();
        let changes = concrete
            .post
            .iter()
            .filter(|p| rules.precondition(content.observation(p.what).kind()))
            .filter(|p| predicted(p.count, parameters) && (p.absent || !concrete.pre.contains(&p.what)))
            .map(|p| Change { what: p.what, absent: p.absent, probability: p.count.ratio() })
            .collect();
        let associated = schema.associations.iter().any(|a| excites(a.observation));
        Self { action: concrete.action, group, class, post, changes, associated }
    }
}

/// A class of similar schemas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ClassId(u32);

/// The types of pre-conditions, of predicted observed and of predicted absent post-conditions.
type Likeness = [Vec<TypeId>; 3];

/// Classes of schemas with "the same number of the same type of observations for their pre-conditions and
/// post-conditions" (II-E), and how many schemas each has.
#[derive(Clone, Debug, Default)]
pub(crate) struct Classes {
    by_likeness: FxHashMap<Likeness, ClassId>,
    sizes: Vec<usize>,
}

impl Classes {
    /// The class of a schema as it is now, which is one larger for it.
    pub(crate) fn enter(
        &mut self,
        Basis { content, parameters, .. }: Basis<'_>,
        concrete: &Concrete,
    ) -> ClassId {
        let kind = |id: ObservationId| content.observation(id).kind();
        let post = |absent: bool| {
            let chosen =
                concrete.post.iter().filter(|p| p.absent == absent && predicted(p.count, parameters));
            signature(chosen.map(|p| kind(p.what)))
        };
        let likeness = [signature(concrete.pre.iter().map(|o| kind(*o))), post(false), post(true)];
        let next = ClassId(u32::try_from(self.sizes.len()).unwrap_or(u32::MAX));
        let class = *self.by_likeness.entry(likeness).or_insert(next);
        if class == next {
            self.sizes.push(0);
        }
        self.sizes[class.0 as usize] += 1;
        class
    }

    /// One schema less is in `class`.
    pub(crate) fn leave(&mut self, class: ClassId) {
        self.sizes[class.0 as usize] -= 1;
    }

    /// How many schemas are in `class`.
    pub(crate) fn size(&self, class: ClassId) -> usize {
        self.sizes[class.0 as usize]
    }
}
