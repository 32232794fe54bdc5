//! The index: tables that make memory fast to ask. Everything here follows from the content and is never part of a digest.

use std::cmp::Reverse;
use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::memory::content::Content;
use crate::memory::groups::{GroupId, Groups, insert};
use crate::memory::matching::{Symmetry, matches};
use crate::memory::outline::{Basis, Classes, Outline, associated};
use crate::memory::pages::Pages;
use crate::memory::shape::Shape;
use crate::nouns::observation::{Observation, Pattern, PropertyId, Substitution, Value};
use crate::nouns::parameters::TypeRules;
use crate::nouns::schema::{
    Association, Form, Generalised, ObservationId, PostCondition, Schema, SchemaId, among,
};
use crate::nouns::vocabulary::PrimitiveId;
use crate::nouns::world_state::WorldState;

/// Bindings of one generalised schema that are considered in one world state.
const BINDINGS_MAX: usize = 64;

/// Inverted indexes over memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct Index {
    ids: FxHashMap<Observation, ObservationId>,
    /// Properties with their values, by number.
    pairs: FxHashMap<(PropertyId, Value), PairId>,
    /// By observation.
    pairs_of: Pages<Pairs>,
    /// By observation: concrete schemas that have it as a post-condition, not as an absence.
    causing: Vec<Vec<SchemaId>>,
    /// By observation: counts changes of the schemas that have it as a post-condition.
    causing_versions: Vec<u64>,
    /// Concrete schemas by their pre-conditions.
    groups: Groups,
    /// By schema; none for a generalised one.
    outlines: Pages<Option<Outline>>,
    classes: Classes,
    /// Generalised schemas in use.
    generalised: Vec<SchemaId>,
    /// By generalised schema: which of its pre-conditions are alike.
    alike: FxHashMap<SchemaId, Symmetry>,
    /// Those of them that are edges of chains.
    generalised_changing: Vec<SchemaId>,
    /// Generalised schemas, retired ones included, by what is the same of those that differ only in the names of variables
    /// and the order of conditions.
    by_shape: FxHashMap<Shape, Vec<SchemaId>>,
    /// Who is associated with an event, the one that leads first.
    events: FxHashMap<ObservationId, BTreeSet<AssociationRank>>,
    /// Counts changes of the edges of chains and of their probabilities, but for what carries a generalised schema.
    edges_version: u64,
}

/// A property with a value, numbered in the order of first mention: comparing two is comparing two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct PairId(u32);

/// The pairs of one observation; those of most lie in place.
#[derive(Clone, Debug)]
enum Pairs {
    Few([PairId; 3], u8),
    Many(Box<[PairId]>),
}

impl Pairs {
    fn as_slice(&self) -> &[PairId] {
        match self {
            Self::Few(pairs, len) => pairs.get(..usize::from(*len)).unwrap_or(pairs),
            Self::Many(pairs) => pairs,
        }
    }
}

impl FromIterator<PairId> for Pairs {
    fn from_iter<I: IntoIterator<Item = PairId>>(pairs: I) -> Self {
        let pairs: Vec<_> = pairs.into_iter().collect();
        let none = PairId(u32::MAX);
        match pairs[..] {
            [] => Self::Few([none; 3], 0),
            [a] => Self::Few([a, none, none], 1),
            [a, b] => Self::Few([a, b, none], 2),
            [a, b, c] => Self::Few([a, b, c], 3),
            _ => Self::Many(pairs.into()),
        }
    }
}

/// How firmly a schema is associated with an event: how often, since when, concrete or not, which; the
/// smaller the firmer.
pub(crate) type AssociationRank = (Reverse<u32>, u64, bool, SchemaId);

/// The standing of one association of `schema`.
pub(crate) fn standing(id: SchemaId, schema: &Schema, occurrences: u32, since_step: u64) -> AssociationRank {
    (Reverse(occurrences), since_step, schema.concrete().is_some(), id)
}

impl Index {
    /// The indexes of `content`.
    pub(crate) fn build(basis: Basis<'_>) -> Self {
        let Basis { content, rules, .. } = basis;
        let mut index = Self::default();
        for (at, observation) in content.observations.iter().enumerate() {
            index.add_observation(observation, ObservationId(u32::try_from(at).unwrap_or(u32::MAX)));
        }
        for (at, schema) in content.schemas.iter().enumerate() {
            let id = SchemaId(u32::try_from(at).unwrap_or(u32::MAX));
            index.add_schema(id, basis);
            for association in &schema.associations {
                index.rank(id, schema, association, content, rules);
            }
            if schema.generalised().is_some_and(|generalised| generalised.retired) {
                index.retire(id);
            }
        }
        index
    }

    pub(crate) fn id(&self, observation: &Observation) -> Option<ObservationId> {
        self.ids.get(observation).copied()
    }

    /// The numbers of the observations of `world` that memory knows, ordered.
    pub(crate) fn known_ids(&self, world: &WorldState) -> Vec<ObservationId> {
        let mut known: Vec<_> = world.observations().iter().filter_map(|o| self.id(o)).collect();
        known.sort_unstable();
        known
    }

    pub(crate) fn add_observation(&mut self, observation: &Observation, id: ObservationId) {
        self.ids.insert(observation.clone(), id);
        let number = |pair: &(PropertyId, Value)| {
            let next = PairId(u32::try_from(self.pairs.len()).unwrap_or(u32::MAX));
            *self.pairs.entry(*pair).or_insert(next)
        };
        self.pairs_of.push(observation.properties().iter().map(number).collect());
        self.causing.push(Vec::new());
        self.causing_versions.push(0);
    }

    pub(crate) fn add_schema(&mut self, id: SchemaId, basis: Basis<'_>) {
        let Basis { content, rules, .. } = basis;
        let Some(schema) = content.schema(id) else { return };
        let concrete = match &schema.form {
            Form::Concrete(concrete) => concrete,
            Form::Generalised(generalised) => {
                self.outlines.push(None);
                self.add_generalised(id, generalised, rules);
                return;
            }
        };
        let group = self.groups.add(id, &concrete.pre, concrete.action);
        let class = self.classes.enter(id, basis, concrete);
        self.outlines.push(Some(Outline::new(basis, schema, concrete, group, class)));
        self.add_outcomes(id, group, basis, &concrete.post);
    }

    fn add_generalised(&mut self, id: SchemaId, generalised: &Generalised, rules: &TypeRules) {
        insert(&mut self.generalised, id);
        let post = generalised.post.iter().map(|p| (&p.what, p.absent));
        self.alike.insert(id, Symmetry::new(&generalised.pre, &generalised.target, post));
        self.by_shape.entry(Shape::of(generalised)).or_default().push(id);
        let kept = |what: &Pattern| generalised.pre.contains(what);
        let changes =
            |p: &PostCondition<Pattern>| rules.of(p.what.kind()).precondition && (p.absent || !kept(&p.what));
        if generalised.post.iter().any(changes) {
            insert(&mut self.generalised_changing, id);
            self.edges_version += 1;
        }
    }

    fn add_outcomes(
        &mut self,
        id: SchemaId,
        group: GroupId,
        Basis { content, rules, .. }: Basis<'_>,
        post: &[PostCondition<ObservationId>],
    ) {
        let pre = self.groups.get(group).pre.clone();
        let is_pre = among(&pre);
        for post in post {
            self.groups.add_outcome(group, id, post.what);
            if !post.absent {
                insert(&mut self.causing[post.what.index()], id);
                self.causing_versions[post.what.index()] += 1;
            }
            let kind = content.observation(post.what).kind();
            let kept = !post.absent && is_pre(post.what);
            if rules.of(kind).precondition && !kept {
                self.groups.add_changing(group, id);
                self.edges_version += 1;
            }
        }
    }

    /// Takes over the last of a schema's post-conditions, which it has gained.
    pub(crate) fn outcome_added(&mut self, id: SchemaId, basis: Basis<'_>) {
        let Some(concrete) = basis.content.concrete(id) else { return };
        let Some(group) = self.outline(id).map(|outline| outline.group) else { return };
        let from = concrete.post.len().saturating_sub(1);
        self.add_outcomes(id, group, basis, &concrete.post[from..]);
        self.refresh(id, basis);
    }

    /// Takes over the changes that an execution made: `before` has the probabilities of the post-conditions before it.
    pub(crate) fn scored(&mut self, id: SchemaId, before: &[f64], basis: Basis<'_>) {
        let Some(schema) = basis.content.schema(id) else { return };
        let differ = |now: &mut dyn Iterator<Item = f64>| !now.eq(before.iter().copied());
        match &schema.form {
            Form::Concrete(concrete) => {
                for post in concrete.post.iter().filter(|post| !post.absent) {
                    self.causing_versions[post.what.index()] += 1;
                }
                // Counts grow at every execution, and the probabilities that excitation and chains depend on seldom change.
                if differ(&mut concrete.post.iter().map(|p| p.count.ratio())) {
                    self.refresh(id, basis);
                    let changing = |outline: &Outline| {
                        self.groups.get(outline.group).changing.binary_search(&id).is_ok()
                    };
                    self.edges_version += u64::from(self.outline(id).is_some_and(changing));
                }
            }
            Form::Generalised(generalised) => {
                let differ = differ(&mut generalised.post.iter().map(|p| p.count.ratio()));
                let changing = self.generalised_changing.binary_search(&id).is_ok();
                self.edges_version += u64::from(differ && changing);
            }
        }
    }

    /// Notes that a primitive is more or less reliable than before, or that a body has others.
    pub(crate) fn edges_changed(&mut self) {
        self.edges_version += 1;
    }

    /// Brings the outline of a concrete schema up to date.
    pub(crate) fn refresh(&mut self, id: SchemaId, basis: Basis<'_>) {
        let Some(schema) = basis.content.schema(id) else { return };
        let Some(concrete) = schema.concrete() else { return };
        let Some(Some(outline)) = self.outlines.get_mut(id.index()) else { return };
        self.classes.leave(id, outline.class);
        let class = self.classes.enter(id, basis, concrete);
        *outline = Outline::new(basis, schema, concrete, outline.group, class);
    }

    /// Takes over how often the observations that a schema is associated with were there.
    pub(crate) fn associations_scored(&mut self, id: SchemaId, basis: Basis<'_>) {
        let associations = basis.content.schema(id).map(|schema| associated(basis, schema));
        if let (Some(associated), Some(Some(outline))) = (associations, self.outlines.get_mut(id.index())) {
            outline.associated = associated;
        }
    }

    /// Takes a schema's association with an event into account, as it is now. Anything but an event has no
    /// ranks.
    pub(crate) fn rank(
        &mut self,
        id: SchemaId,
        schema: &Schema,
        association: &Association,
        content: &Content,
        rules: &TypeRules,
    ) {
        if rules.of(content.observation(association.observation).kind()).transient {
            let ranks = self.events.entry(association.observation).or_default();
            ranks.insert(standing(id, schema, association.count.occurrences, association.since_step));
        }
    }

    /// The opposite of [`Index::rank`], before the association changes.
    pub(crate) fn unrank(&mut self, id: SchemaId, schema: &Schema, association: &Association) {
        if let Some(ranks) = self.events.get_mut(&association.observation) {
            ranks.remove(&standing(id, schema, association.count.occurrences, association.since_step));
        }
    }

    /// The firmest association with an event of any schema but `other`.
    pub(crate) fn leader_beside(&self, event: ObservationId, other: SchemaId) -> Option<&AssociationRank> {
        self.events.get(&event)?.iter().find(|(.., id)| *id != other)
    }

    pub(crate) fn retire(&mut self, id: SchemaId) {
        if let Ok(at) = self.generalised.binary_search(&id) {
            self.generalised.remove(at);
        }
        if let Ok(at) = self.generalised_changing.binary_search(&id) {
            self.generalised_changing.remove(at);
            self.edges_version += 1;
        }
    }

    /// The number of a property with a value; none when no observation in memory has it.
    pub(crate) fn pair(&self, property: PropertyId, value: Value) -> Option<PairId> {
        self.pairs.get(&(property, value)).copied()
    }

    /// The properties of an observation with their values, by number.
    pub(crate) fn pairs_of(&self, observation: ObservationId) -> &[PairId] {
        self.pairs_of.get(observation.index()).map_or(&[], Pairs::as_slice)
    }

    /// Concrete schemas that have the observation as a post-condition (not as an absence).
    pub(crate) fn causing(&self, observation: ObservationId) -> &[SchemaId] {
        self.causing.get(observation.index()).map_or(&[], Vec::as_slice)
    }

    /// Counts changes of how the observation may be caused, and how surely.
    pub(crate) fn causing_version(&self, observation: ObservationId) -> u64 {
        self.causing_versions.get(observation.index()).copied().unwrap_or_default()
    }

    /// The concrete schema with just these pre-conditions (in canonical order) and this action.
    pub(crate) fn exact(&self, pre: &[&Observation], action: PrimitiveId) -> Option<SchemaId> {
        let ids: Option<Vec<_>> = pre.iter().map(|observation| self.id(observation)).collect();
        self.groups.exact(self.groups.with_pre(&ids?)?, action)
    }

    /// Concrete schemas by their pre-conditions.
    pub(crate) fn groups(&self) -> &Groups {
        &self.groups
    }

    /// A concrete schema in outline.
    pub(crate) fn outline(&self, id: SchemaId) -> Option<&Outline> {
        self.outlines.get(id.index())?.as_ref()
    }

    /// Classes of similar schemas.
    pub(crate) fn classes(&self) -> &Classes {
        &self.classes
    }

    pub(crate) fn generalised(&self) -> &[SchemaId] {
        &self.generalised
    }

    /// The bindings of a generalised schema where these are observed, in their order, at most [`BINDINGS_MAX`].
    pub(crate) fn bindings(
        &self,
        id: SchemaId,
        generalised: &Generalised,
        observations: &[Observation],
    ) -> Vec<Substitution> {
        self.matches(id, generalised, observations).into_iter().map(|(binding, _)| binding).collect()
    }

    /// The same, each with which of the observations are matched, in their order.
    pub(crate) fn matches(
        &self,
        id: SchemaId,
        generalised: &Generalised,
        observations: &[Observation],
    ) -> Vec<(Substitution, Vec<usize>)> {
        let alike = self.alike.get(&id);
        alike.map_or_else(Vec::new, |alike| matches(&generalised.pre, alike, observations, BINDINGS_MAX))
    }

    /// Which pre-conditions of a generalised schema are alike.
    pub(crate) fn alike(&self, id: SchemaId) -> Option<&Symmetry> {
        self.alike.get(&id)
    }

    /// Generalised schemas in use that may change a context.
    pub(crate) fn generalised_changing(&self) -> &[SchemaId] {
        &self.generalised_changing
    }

    /// Generalised schemas, retired ones included, that may be the same as one of this shape.
    pub(crate) fn with_shape(&self, shape: &Shape) -> &[SchemaId] {
        self.by_shape.get(shape).map_or(&[], Vec::as_slice)
    }

    pub(crate) fn edges_version(&self) -> u64 {
        self.edges_version
    }
}

#[cfg(test)]
mod tests {
    use crate::memory::apply::Memory;
    use crate::nouns::effect::{Effect, Score};
    use crate::nouns::observation::{Observation, Pattern, PropertyId, Term, TypeId, Value, Variable};
    use crate::nouns::parameters::Parameters;
    use crate::nouns::schema::SchemaId;
    use crate::nouns::vocabulary::{
        Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
    };

    fn block(field: i64) -> Observation {
        Observation::new(TypeId(0), [(PropertyId(0), Value::Integer(field))])
    }

    fn declaration() -> Declaration {
        let property = |name: &str| DeclaredProperty {
            name: name.into(),
            unit: String::new(),
            kind: ValueKind::Integer,
        };
        Declaration {
            body: "table".into(),
            observation_types: vec![DeclaredType {
                name: "block".into(),
                own: false,
                transient: false,
                heard: false,
                value: false,
                properties: vec![property("field")],
            }],
            actions: vec![DeclaredAction { name: "push".into(), parameters: vec![property("from")] }],
            repertoire: (0..3).map(|from| (0, vec![Parameter::Integer(from)])).collect(),
        }
    }

    /// A block is pushed on from each of three fields, from the first not always; a law is made of it and given up.
    fn effects() -> Vec<Effect> {
        let push = |from: i64| Effect::Created {
            pre: vec![block(from)],
            action: PrimitiveId(from as u32),
            post: vec![(block(from), true), (block(from + 1), false)],
            parent: None,
            contradicts: None,
        };
        let at = |term| Pattern::new(TypeId(0), [(PropertyId(0), term)]);
        let any = || at(Term::Variable(Variable(0)));
        let law = Effect::Generalised {
            pre: vec![any()],
            target: vec![at(Term::Constant(Value::Integer(1)))],
            post: vec![(any(), true)],
            parent: SchemaId(0),
            examples: vec![SchemaId(0), SchemaId(1)],
        };
        let missed = || Effect::Executed {
            schema: SchemaId(0),
            success: false,
            post: vec![Score::Missed, Score::Missed],
            associations: Vec::new(),
        };
        vec![
            Effect::Declared(Box::new(declaration())),
            push(0),
            push(1),
            law.clone(),
            push(2),
            missed(),
            missed(),
            Effect::OutcomeAdded { schema: SchemaId(0), observation: block(7), absent: false },
            Effect::Associated { schema: SchemaId(1), observation: block(9), replaces: None },
            law,
            Effect::Retired { generalised: SchemaId(2) },
        ]
    }

    #[test]
    fn what_grew_step_by_step_is_what_is_built_at_once() {
        let mut memory = Memory::new(1, Parameters::default());
        effects().iter().for_each(|effect| memory.apply(effect).unwrap());
        let restored = Memory::restore(memory.content().clone(), Parameters::default());
        let (grown, built) = (memory.index(), restored.index());
        let told = |memory: &Memory, id: u32| {
            memory.index().outline(SchemaId(id)).map(|outline| {
                let size = memory.index().classes().newest(outline.class).count();
                (
                    size,
                    format!(
                        "{:?}",
                        (
                            &outline.action,
                            outline.group,
                            outline.post().collect::<Vec<_>>(),
                            outline.associated
                        )
                    ),
                )
            })
        };
        for id in 0..6 {
            assert_eq!(told(&memory, id), told(&restored, id), "schema {id}");
        }
        // Twice missed in three trials, the first schema is no more like the others.
        assert_eq!([0, 1, 3].map(|id| told(&memory, id).map(|(size, _)| size)), [Some(1), Some(2), Some(2)]);
        for (at, observation) in memory.content().observations.iter().enumerate() {
            let id = grown.id(observation).unwrap();
            assert_eq!((id.index(), built.id(observation)), (at, Some(id)));
            assert_eq!(grown.causing(id), built.causing(id), "{observation:?}");
            assert_eq!(grown.groups().holding(&[id]), built.groups().holding(&[id]), "{observation:?}");
        }
        for (group, known) in grown.groups().since(0) {
            assert_eq!(known.changing, built.groups().get(group).changing);
        }
        assert_eq!([grown.generalised(), grown.generalised_changing()], [&[SchemaId(4)]; 2]);
        assert_eq!([built.generalised(), built.generalised_changing()], [&[SchemaId(4)]; 2]);
    }
}
