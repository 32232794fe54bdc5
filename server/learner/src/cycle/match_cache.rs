//! What matched the pre-conditions of laws, kept while it stays: a finger that moves does not change which objects a law of
//! objects is about.

use rustc_hash::FxHashMap;

use crate::memory::index::Index;
use crate::nouns::observation::{Observation, Substitution, TypeId};
use crate::nouns::schema::{Generalised, SchemaId};
use crate::nouns::world_state::WorldState;

/// Laws whose matches are kept; with more of them all are matched anew.
const LAWS_KEPT_MAX: usize = 64;

/// A binding, and which observations of the world state are matched under it, in their order.
pub(crate) type Match = (Substitution, Vec<usize>);

/// The last matches of each law. Follows from what was perceived, and is never part of memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct MatchCache(FxHashMap<SchemaId, LawMatches>);

#[derive(Clone, Debug)]
struct LawMatches {
    /// The types of its pre-conditions, ordered, each once: nothing else can be matched.
    kinds: Vec<TypeId>,
    /// What was perceived of these types.
    among: Vec<Observation>,
    /// With places in `among`.
    matches: Vec<Match>,
}

impl MatchCache {
    /// The matches of a law where just `world` is observed, as [`Index::matches`] gives them.
    pub(crate) fn of(
        &mut self,
        index: &Index,
        id: SchemaId,
        law: &Generalised,
        world: &WorldState,
    ) -> Vec<Match> {
        if self.0.len() >= LAWS_KEPT_MAX && !self.0.contains_key(&id) {
            self.0.clear();
        }
        let last = self.0.entry(id).or_insert_with(|| LawMatches::new(index, id, law));
        let places: Vec<usize> =
            (0..).zip(world.observations()).filter(|(_, o)| last.concerns(o)).map(|(at, _)| at).collect();
        let among = || places.iter().filter_map(|at| world.observations().get(*at));
        if !among().eq(&last.among) {
            last.among = among().cloned().collect();
            last.matches = index.matches(id, law, &last.among);
        }
        let in_world = |at: &usize| places.get(*at).copied();
        let matches = last.matches.iter();
        matches.map(|(binding, at)| (binding.clone(), at.iter().filter_map(in_world).collect())).collect()
    }
}

impl LawMatches {
    /// Before anything was perceived.
    fn new(index: &Index, id: SchemaId, law: &Generalised) -> Self {
        let mut kinds: Vec<_> = law.pre.iter().map(|pattern| pattern.kind()).collect();
        kinds.sort_unstable();
        kinds.dedup();
        Self { kinds, among: Vec::new(), matches: index.matches(id, law, &[]) }
    }

    fn concerns(&self, observation: &Observation) -> bool {
        self.kinds.binary_search(&observation.kind()).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::Memory;
    use crate::nouns::effect::Effect;
    use crate::nouns::observation::{Pattern, PropertyId, Term, Value, Variable};
    use crate::nouns::parameters::Parameters;
    use crate::nouns::random::Random;
    use crate::nouns::vocabulary::{
        Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, PrimitiveId, ValueKind,
    };

    fn seen(kind: u16, values: [i64; 2]) -> Observation {
        let properties = [PropertyId(0), PropertyId(1)].into_iter().zip(values.map(Value::Integer));
        Observation::new(TypeId(kind), properties)
    }

    /// Two laws: of two things of type 1 in one place, and of any two of type 2.
    fn memory() -> Memory {
        let repertoire = vec![(0, Vec::<Parameter>::new())];
        let property = |name: &str| DeclaredProperty {
            name: name.into(),
            unit: String::new(),
            kind: ValueKind::Integer,
        };
        let kind = |number: u16| DeclaredType {
            name: format!("type {number}"),
            own: false,
            transient: false,
            heard: false,
            value: false,
            properties: vec![property("place"), property("size")],
        };
        let declaration = Declaration {
            body: "table".into(),
            observation_types: (0..4).map(kind).collect(),
            actions: vec![DeclaredAction { name: "push".into(), parameters: Vec::new() }],
            repertoire,
        };
        let pattern = |kind: u16, variables: [u8; 2]| {
            let terms = variables.map(|variable| Term::Variable(Variable(variable)));
            Pattern::new(TypeId(kind), [PropertyId(0), PropertyId(1)].into_iter().zip(terms))
        };
        let law = |pre: [Pattern; 2]| Effect::Generalised {
            target: vec![pre[0].clone()],
            pre: pre.into(),
            post: Vec::new(),
            parent: SchemaId(0),
            examples: Vec::new(),
        };
        let action = PrimitiveId(0);
        let first =
            Effect::Created { pre: Vec::new(), action, post: Vec::new(), parent: None, contradicts: None };
        let laws = [[pattern(1, [0, 1]), pattern(1, [2, 1])], [pattern(2, [0, 1]), pattern(2, [2, 3])]];
        let mut memory = Memory::new(1, Parameters::default());
        let effects = [Effect::Declared(Box::new(declaration)), first].into_iter().chain(laws.map(law));
        effects.for_each(|effect| memory.apply(&effect).unwrap());
        memory
    }

    #[test]
    fn what_is_kept_is_what_would_be_matched_anew() {
        let memory = memory();
        let seed = 11;
        let mut random = Random::from_seed(seed);
        let mut matched = MatchCache::default();
        let (mut world, mut found) = (Vec::new(), 0);
        for _ in 0..500 {
            // Something comes, goes or stays; what stays is at other places of the world state when another comes before it.
            match random.below(4) {
                0 | 1 if world.len() < 7 => {
                    let value = |random: &mut Random| random.below(3) as i64;
                    let values = [value(&mut random), value(&mut random)];
                    world.push(seen(random.below(4) as u16, values));
                }
                2 if !world.is_empty() => drop(world.remove(random.below(world.len()))),
                _ => (),
            }
            let now = WorldState::new(world.clone());
            for id in memory.index().generalised() {
                let law = memory.content().schema(*id).unwrap().generalised().unwrap();
                let anew = memory.index().matches(*id, law, now.observations());
                found += anew.len();
                assert_eq!(
                    matched.of(memory.index(), *id, law, &now),
                    anew,
                    "seed {seed}: {law:?} in {now:?}"
                );
            }
        }
        assert!(found > 500, "seed {seed}: {found} matches are too few to tell");
    }
}
