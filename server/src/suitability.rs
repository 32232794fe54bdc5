//! Whether what a body declares can be learnt. Some declarations keep a learner from ever meeting the same thing twice, and it is hard to
//! see why nothing comes of it: so it is told, as soon as enough frames show it.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::hash::{BuildHasher, BuildHasherDefault, DefaultHasher, Hash};

use pschema_inspect::DeclarationWarning;
use pschema_learner::observation::{Observation, TypeId};
use pschema_learner::vocabulary::{PrimitiveId, Vocabulary};
use pschema_learner::{ActionOutcome, Frame};

/// Observations of a type that are counted until it is judged whether its values repeat.
const OBSERVATIONS_ENOUGH: u64 = 500;
/// Primitives from which on it is asked whether any is tried twice, and the actions until it is judged.
const PRIMITIVES_MANY: usize = 1_000;
const ACTIONS_ENOUGH: u64 = 1_000;
/// Less than one repeated in so many is as good as none.
const REPEATED_SHARE: u64 = 20;
/// Actions after which it is not asked any more whether what is the body's own decides what they do.
const ACTIONS_MAX: u64 = 20_000;
/// Contexts in which that is asked, and what is the body's own in each, at most.
const CONTEXTS_MAX: usize = 2_048;
const OWN_MAX: usize = 16;
/// Contexts in which it must be so.
const CONTEXTS_ENOUGH: usize = 8;

/// What the frames of one body show about its declaration.
#[derive(Debug, Default)]
pub(crate) struct Suitability {
    values: BTreeMap<TypeId, Repetition>,
    actions: Repetition,
    own: OwnInfluence,
    /// The context of the last action, if it is still to be seen what it does.
    last: Option<(PrimitiveId, Context)>,
    /// The types that are the body's own, as far as any was there.
    own_kinds: BTreeSet<TypeId>,
}

/// How often the same came again.
#[derive(Debug, Default)]
struct Repetition {
    seen: HashSet<u64>,
    all: u64,
    repeated: u64,
    is_judged: bool,
}

impl Repetition {
    /// Counts one more, by its hash. Returns whether it is judged now, once, that hardly anything is repeated.
    fn counts(&mut self, one: u64, enough: u64) -> bool {
        if self.is_judged {
            return false;
        }
        self.all += 1;
        self.repeated += u64::from(!self.seen.insert(one));
        if self.all < enough {
            return false;
        }
        (self.is_judged, self.seen) = (true, HashSet::new());
        self.repeated * REPEATED_SHARE < self.all
    }
}

/// A context, by what is the body's own and by the rest.
#[derive(Clone, Copy, Debug)]
struct Context {
    own: u64,
    rest: u64,
}

/// What came of a primitive in contexts that differ in what is the body's own.
#[derive(Debug, Default)]
struct OwnInfluence {
    contexts: BTreeMap<(PrimitiveId, u64), Vec<Outcome>>,
    actions: u64,
    is_judged: bool,
}

/// What came where the body's own was so.
#[derive(Debug)]
struct Outcome {
    own: u64,
    came: u64,
    times: u32,
    /// Whether the same came each time.
    is_one: bool,
}

impl OwnInfluence {
    /// Counts one more outcome. Returns in how many contexts the outcome goes by the body's own, if it is judged now, once, that this is
    /// so in most that tell.
    fn counts(&mut self, primitive: PrimitiveId, context: Context, came: u64) -> Option<usize> {
        if self.is_judged {
            return None;
        }
        self.actions += 1;
        let key = (primitive, context.rest);
        if self.contexts.len() < CONTEXTS_MAX || self.contexts.contains_key(&key) {
            let outcomes = self.contexts.entry(key).or_default();
            if let Some(known) = outcomes.iter_mut().find(|known| known.own == context.own) {
                known.times += 1;
                known.is_one &= known.came == came;
            } else if outcomes.len() < OWN_MAX {
                outcomes.push(Outcome { own: context.own, came, times: 1, is_one: true });
            }
        }
        if !self.actions.is_power_of_two() && self.actions != ACTIONS_MAX {
            return None;
        }
        let (mut by_own, mut otherwise) = (0, 0);
        for outcomes in self.contexts.values() {
            let mut told = outcomes.iter().filter(|outcome| outcome.times > 1).peekable();
            let Some(first) = told.peek().map(|first| first.came) else { continue };
            let (mut count, mut is_one, mut differs) = (0, true, false);
            for outcome in told {
                count += 1;
                is_one &= outcome.is_one;
                differs |= outcome.came != first;
            }
            match (count > 1, is_one && differs) {
                (false, _) => (),
                (true, true) => by_own += 1,
                (true, false) => otherwise += 1,
            }
        }
        let found = by_own >= CONTEXTS_ENOUGH && by_own > otherwise;
        if found || self.actions == ACTIONS_MAX {
            (self.is_judged, self.contexts) = (true, BTreeMap::new());
        }
        found.then_some(by_own)
    }
}

/// The hash of whatever is compared here, the same in each run.
fn hash(of: impl Hash) -> u64 {
    BuildHasherDefault::<DefaultHasher>::default().hash_one(of)
}

impl Suitability {
    /// Takes a frame in, and the action that follows; returns what became certain by it. What is the body's own is looked at if
    /// `own_is_no_condition`.
    pub(crate) fn note(
        &mut self,
        vocabulary: &Vocabulary,
        frame: &Frame,
        action: Option<PrimitiveId>,
        own_is_no_condition: bool,
    ) -> Vec<DeclarationWarning> {
        let mut found = Vec::new();
        let declared = |o: &Observation| vocabulary.types().get(usize::from(o.kind().0)).map(|k| &k.declared);
        let sensed = frame.observations.iter().filter(|o| declared(o).is_some_and(|d| !d.heard));
        for observation in sensed.clone().filter(|o| !o.properties().is_empty()) {
            let values = self.values.entry(observation.kind()).or_default();
            if values.counts(hash(observation), OBSERVATIONS_ENOUGH) {
                found.push(DeclarationWarning::ValuesNeverRepeat {
                    sense: declared(observation).map(|d| d.name.clone()).unwrap_or_default(),
                    observations: values.all,
                    repeated: values.repeated,
                });
            }
        }
        let repertoire = vocabulary.bodies().get(usize::from(frame.body.0)).map_or(0, |b| b.repertoire.len());
        if let Some(action) = action.filter(|_| repertoire >= PRIMITIVES_MANY)
            && self.actions.counts(hash(action), ACTIONS_ENOUGH)
        {
            let Repetition { all, repeated, .. } = self.actions;
            found.push(DeclarationWarning::ActionsNeverRepeat {
                primitives: u64::try_from(repertoire).unwrap_or(u64::MAX),
                actions: all,
                repeated,
            });
        }
        let of = |own: bool| {
            let of = sensed.clone().filter(move |o| declared(o).is_some_and(|d| d.own == own));
            of.collect::<Vec<_>>()
        };
        let own = of(true);
        if let Some((primitive, context)) = self.last.take()
            && frame.outcome == Some(ActionOutcome::Done)
            && let Some(contexts) = self.own.counts(primitive, context, hash(of(false)))
        {
            let types = vocabulary.types();
            let name = |kind: &TypeId| Some(types.get(usize::from(kind.0))?.declared.name.clone());
            found.push(DeclarationWarning::OwnDecides {
                senses: self.own_kinds.iter().filter_map(name).collect(),
                contexts: u64::try_from(contexts).unwrap_or(u64::MAX),
            });
        }
        if own_is_no_condition && !own.is_empty() {
            let lasting: Vec<_> =
                of(false).into_iter().filter(|o| declared(o).is_some_and(|d| !d.transient)).collect();
            self.own_kinds.extend(own.iter().map(|o| o.kind()));
            self.last = action.map(|action| (action, Context { own: hash(own), rest: hash(lasting) }));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use pschema_learner::Learner;
    use pschema_learner::curriculum::Curriculum;
    use pschema_learner::observation::{PropertyId, Value};
    use pschema_learner::parameters::Parameters;
    use pschema_learner::vocabulary::{
        BodyId, Declaration, DeclaredAction, DeclaredProperty, DeclaredType, Parameter, ValueKind,
    };

    use super::*;

    fn property(name: &str) -> DeclaredProperty {
        DeclaredProperty { name: name.into(), unit: String::new(), kind: ValueKind::Integer }
    }

    /// A body with a posture of its own, a reading and so many primitives.
    fn learner(primitives: i64) -> Learner {
        let kind = |name: &str, own: bool| DeclaredType {
            own,
            properties: vec![property("at")],
            ..DeclaredType::state(name)
        };
        let action = DeclaredAction { name: "go".into(), parameters: vec![property("to")] };
        let declaration = Declaration {
            body: "one".into(),
            observation_types: vec![kind("posture", true), kind("reading", false)],
            actions: vec![action],
            repertoire: (0..primitives).map(|to| (0, vec![Parameter::Integer(to)])).collect(),
        };
        let mut learner = Learner::new(1, Parameters::default(), Curriculum::free("play")).unwrap();
        learner.declare(declaration).unwrap();
        learner
    }

    fn frame(posture: i64, reading: i64) -> Frame {
        let one = |kind: u16, at: i64| Observation::new(TypeId(kind), [(PropertyId(0), Value::Integer(at))]);
        let observations = vec![one(0, posture), one(1, reading)];
        Frame { body: BodyId(0), outcome: Some(ActionOutcome::Done), observations }
    }

    /// All warnings in a life of frames and actions.
    fn warnings(
        primitives: i64,
        frames: impl Iterator<Item = (Frame, u32)>,
        own_is_no_condition: bool,
    ) -> Vec<DeclarationWarning> {
        let (learner, mut suitability) = (learner(primitives), Suitability::default());
        let vocabulary = &learner.memory().content().vocabulary;
        let note = |(frame, action): (Frame, u32)| {
            suitability.note(vocabulary, &frame, Some(PrimitiveId(action)), own_is_no_condition)
        };
        frames.flat_map(note).collect()
    }

    #[test]
    fn a_reading_that_is_never_the_same_is_told_once() {
        let told = warnings(2, (0..3_000).map(|n| (frame(n % 7, n), 0)), true);
        let wanted =
            DeclarationWarning::ValuesNeverRepeat { sense: "reading".into(), observations: 500, repeated: 0 };
        assert_eq!(told, [wanted]);
        assert_eq!(warnings(2, (0..3_000).map(|n| (frame(n % 7, n % 100), 0)), true), []);
    }

    #[test]
    fn primitives_of_which_none_is_tried_twice_are_told_once() {
        let told = warnings(5_000, (0..3_000).map(|n| (frame(0, 0), n)), true);
        let wanted =
            DeclarationWarning::ActionsNeverRepeat { primitives: 5_000, actions: 1_000, repeated: 0 };
        assert_eq!(told, [wanted]);
        assert_eq!(warnings(5_000, (0..3_000).map(|n| (frame(0, 0), n % 500)), true), []);
    }

    /// A life in which the reading becomes `next` of posture, reading and action; all else is by lot.
    fn life(next: impl Fn(i64, i64, u32, u64) -> i64) -> impl Iterator<Item = (Frame, u32)> {
        let mut lot = 7_u64;
        let mut draw = move |below: u64| {
            lot = lot.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (lot >> 33) % below
        };
        let (mut posture, mut reading) = (0, 0);
        (0..4_000).map(move |_| {
            let action = u32::try_from(draw(4)).unwrap();
            let now = (frame(posture, reading), action);
            reading = next(posture, reading, action, draw(2));
            posture = i64::try_from(draw(3)).unwrap();
            now
        })
    }

    #[test]
    fn it_is_told_when_the_bodys_own_decides_what_actions_do_and_may_be_no_condition() {
        let by_posture =
            |posture: i64, reading: i64, action: u32, _| (reading + posture * i64::from(action)) % 5;
        let told = warnings(4, life(by_posture), true);
        let [DeclarationWarning::OwnDecides { senses, contexts }] = &told[..] else { panic!("{told:?}") };
        assert_eq!(senses, &["posture"]);
        assert!(*contexts >= 8);
        assert_eq!(warnings(4, life(by_posture), false), [], "claims may ask for it");
        let by_itself = |_, reading: i64, action: u32, _| (reading + i64::from(action)) % 5;
        assert_eq!(warnings(4, life(by_itself), true), []);
        let by_chance = |_, _, _, lot: u64| i64::try_from(lot).unwrap();
        assert_eq!(warnings(4, life(by_chance), true), []);
    }
}
