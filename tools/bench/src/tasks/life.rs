//! One life of a learner in an exact world, and how far its foretelling is from the truth on the way.

use fastrand::Rng;
use pschema_exact::declaration::Primitive;
use pschema_exact::{Distribution, Situation, chances, open};
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::vocabulary::PrimitiveId;
use pschema_learner::world_state::WorldState;
use pschema_tools::kit::Failure;

use super::foretelling::{FirstOrder, Foretelling, Unchanging};
use super::returning::Returning;
use super::student::Student;

/// Random states in which the foretelling is compared with the truth.
const TESTS: usize = 400;
/// The seed of those states: they are the same in all lives.
const TESTS_SEED: u64 = 999;
/// A life is looked at after all its actions, after half of them, and so on.
const HALVINGS: u32 = 4;

/// Who chooses the actions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Manner {
    /// The learner itself.
    Own,
    /// Chance: one of the legal actions.
    Led,
    /// Chance, and each time in a fresh random state.
    Scattered,
}

/// A world to live in, and to be tested in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Task<'a> {
    pub(crate) world: &'a str,
    /// The world of the tests, when it is another. It declares all that the first does.
    pub(crate) tested: Option<&'a str>,
    pub(crate) manner: Manner,
    pub(crate) actions: usize,
    /// The sense whose returns to what it showed before are looked at, if there is one.
    pub(crate) returning: Option<&'a str>,
}

impl<'a> Task<'a> {
    pub(crate) const fn new(world: &'a str, manner: Manner, actions: usize) -> Self {
        Self { world, tested: None, manner, actions, returning: None }
    }

    /// What people see of it.
    pub(crate) fn title(&self) -> String {
        self.tested.map_or(self.world.to_owned(), |tested| format!("{}, tested in {tested}", self.world))
    }
}

/// Distances from the truth after so many actions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Distances {
    pub(crate) actions: usize,
    pub(crate) ours: f64,
    pub(crate) bound: f64,
    pub(crate) nothing_changes: f64,
    pub(crate) first_order: f64,
}

/// How far what is foretold of one sense is from the truth.
#[derive(Clone, Debug)]
pub(crate) struct SenseDistance {
    pub(crate) sense: String,
    pub(crate) ours: f64,
}

impl Distances {
    /// Adds the distance of each foreteller, as `distance` gives it, and of the truth itself. Noise is left out.
    fn add(
        &mut self,
        known: &Knowledge,
        (world, primitive): (&WorldState, PrimitiveId),
        truth: &Distribution<WorldState>,
        distance: impl Fn(&Distribution<WorldState>) -> f64,
    ) {
        let measured = |foretold: &Distribution<WorldState>| {
            distance(&foretold.map(|world| known.student.lexicon.measured(world)))
        };
        self.ours += measured(&known.student.foretell(world, primitive));
        self.bound += distance(truth);
        self.nothing_changes += measured(&Unchanging.foretell(world, primitive));
        self.first_order += measured(&known.table.foretell(world, primitive));
    }

    /// The means of so many.
    fn mean(self, actions: usize, count: usize) -> Self {
        let mean = |sum: f64| sum / count.max(1) as f64;
        Self {
            actions,
            ours: mean(self.ours),
            bound: mean(self.bound),
            nothing_changes: mean(self.nothing_changes),
            first_order: mean(self.first_order),
        }
    }
}

/// What came of a life.
#[derive(Debug)]
pub(crate) struct Life {
    /// What the distances are.
    pub(crate) figure: &'static str,
    pub(crate) course: Vec<Distances>,
    pub(crate) schemas: usize,
    pub(crate) laws: usize,
    pub(crate) step_us: f64,
    /// Sense by sense at the end; none in worlds with hidden states.
    pub(crate) senses: Vec<SenseDistance>,
    /// With what probability it was expected, in the second half of the life, that what was there before a sense changed is there when
    /// it changes back, and what was not; none where that is not looked at.
    pub(crate) returned: Option<[f64; 2]>,
}

/// Those who live through the same.
struct Knowledge {
    student: Student,
    table: FirstOrder,
}

/// Lives through `task` with these mechanisms. In a world with hidden states each next observation is foretold as it comes; elsewhere random states are
/// tested whenever the life is looked at.
pub(crate) fn live(task: &Task<'_>, seed: u64, mechanisms: Mechanisms) -> Result<Life, Failure> {
    let mut world = open(task.world, seed).map_err(Failure::of)?;
    let tested = || open(task.tested.unwrap_or(task.world), TESTS_SEED).map_err(Failure::of);
    let declaration = tested()?.declaration().clone();
    let led = task.manner != Manner::Own;
    let student = Student::new(&declaration, seed, led, mechanisms)?;
    let mut known = Knowledge { student, table: FirstOrder::default() };
    let spell = if task.manner == Manner::Scattered { Some(1) } else { world.spell() };
    // Not the generator of the world, which begins with the seed itself.
    let mut random = chances(!seed);
    let (mut course, mut online) = (Vec::new(), Distances::default());
    let (mut carried_out, mut since) = (false, 0);
    let mut returning =
        task.returning.and_then(|sense| known.student.lexicon.sense(sense)).map(Returning::to);
    let mut senses = Vec::new();
    for action in 1..=task.actions {
        let before = known.student.lexicon.world_state(&world.percept());
        let chosen = known.student.step(&before, carried_out);
        let Some((number, primitive)) = next(&*world, &known.student, chosen, &mut random) else {
            return Err(Failure::Failed(format!("{}: the learner holds still", task.world)));
        };
        if led {
            known.student = known.student.led_to(number, &before)?;
        }
        let truth = world.is_hidden().then(|| truth(&*world, &known.student, &primitive));
        let looked_at = returning.is_some() && action * 2 > task.actions;
        let expected = looked_at.then(|| known.student.foretell(&before, number));
        world.act(&primitive);
        let after = known.student.lexicon.world_state(&world.percept());
        if let Some(returning) = &mut returning {
            returning.note(&after, expected.as_ref());
        }
        if let Some(truth) = truth {
            let wrong =
                |foretold: &Distribution<WorldState>| f64::from(foretold.most_probable() != Some(&after));
            online.add(&known, (&before, number), &truth, wrong);
        }
        known.table.count(before, number, after.clone());
        carried_out = true;
        since += 1;
        if spell.is_some_and(|spell| since >= spell) {
            known.student.step(&after, true);
            match task.manner {
                Manner::Scattered => world.scatter(),
                _ => world.renew(),
            }
            (carried_out, since) = (false, 0);
        }
        if (0..=HALVINGS).any(|halvings| task.actions >> halvings == action) {
            let last = course.last().map_or(0, |earlier: &Distances| earlier.actions);
            course.push(if world.is_hidden() {
                std::mem::take(&mut online).mean(action, action - last)
            } else {
                let twin = world.twin(chances(TESTS_SEED));
                let (distances, by_sense) =
                    test(if task.tested.is_some() { tested()? } else { twin }, &known, action);
                senses = by_sense;
                distances
            });
        }
    }
    let figure = if world.is_hidden() { "wrong predictions" } else { "total variation" };
    let Knowledge { student, .. } = known;
    let returned = returning.and_then(|returning| returning.means());
    let (schemas, laws, step_us) = (student.schemas(), student.laws(), student.step_us());
    Ok(Life { figure, course, schemas, laws, step_us, senses, returned })
}

/// The action to come: as chosen, or by chance.
fn next(
    world: &dyn Situation,
    student: &Student,
    chosen: Option<PrimitiveId>,
    random: &mut Rng,
) -> Option<(PrimitiveId, Primitive)> {
    match chosen {
        Some(number) => Some((number, student.lexicon.primitive(number)?.clone())),
        None => {
            let drawn = random.choice(world.legal())?;
            Some((student.lexicon.number(&drawn)?, drawn))
        }
    }
}

/// What `primitive` brings about, with its exact probabilities; noise left out.
fn truth(world: &dyn Situation, student: &Student, primitive: &Primitive) -> Distribution<WorldState> {
    let Student { lexicon, .. } = student;
    world.outcomes(primitive).map(|percept| lexicon.measured(&lexicon.world_state(percept)))
}

/// Total variation from the truth, on average over random states with a random legal action each; of all that is sensed, and of each
/// sense.
fn test(mut world: Box<dyn Situation>, known: &Knowledge, actions: usize) -> (Distances, Vec<SenseDistance>) {
    let mut random = chances(!TESTS_SEED);
    let mut distances = Distances::default();
    let senses: Vec<_> = known.student.lexicon.measured_senses().collect();
    let mut sums = vec![0.0; senses.len()];
    let mut count = 0;
    for _ in 0..TESTS {
        world.scatter();
        let before = known.student.lexicon.world_state(&world.percept());
        let Some((number, primitive)) = next(&*world, &known.student, None, &mut random) else { continue };
        let truth = truth(&*world, &known.student, &primitive);
        distances.add(known, (&before, number), &truth, |foretold| truth.distance(foretold));
        for (sum, (_, kind)) in sums.iter_mut().zip(&senses) {
            let part = truth.map(|world| world.filter(|o| o.kind() == *kind));
            *sum += part.distance(&known.student.foretell_of(*kind, &before, number));
        }
        count += 1;
    }
    let mean =
        |((sense, _), sum): ((String, _), f64)| SenseDistance { sense, ours: sum / count.max(1) as f64 };
    (distances.mean(actions, count), senses.into_iter().zip(sums).map(mean).collect())
}
