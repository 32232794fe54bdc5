//! Claims against a plain search, and evidence within its bounds.

use std::sync::Arc;

use super::columns::{Column, Conditions};
use super::facet::ANYTHING;
use super::found::OwnEffect;
use super::growth::Ground;
use super::pool::Pool;
use super::price::{Likelihood, Tier};
use super::scene::Scene;
use super::values::Values;
use crate::nouns::claim::{Change, Claim, Condition};
use crate::nouns::experience::{Experience, Recalled};
use crate::nouns::observation::{Observation, PropertyId, TypeId, Value};
use crate::nouns::random::Random;
use crate::nouns::vocabulary::{BodyId, PrimitiveId};

const LIGHT: TypeId = TypeId(0);
const PLACE: TypeId = TypeId(1);
const BELL: TypeId = TypeId(2);
const NUMBER: PropertyId = PropertyId(0);
const SIDE: PropertyId = PropertyId(1);

fn light(number: i64, side: i64) -> Observation {
    Observation::new(LIGHT, [(NUMBER, Value::Integer(number)), (SIDE, Value::Integer(side))])
}

/// The primitive goes to a place. A bell rings, mostly, if a light of that number is there; lights change as they like.
fn experience(random: &mut Random, primitives: usize) -> Experience {
    let primitive = random.below(primitives);
    let number = |random: &mut Random| i64::try_from(random.below(4)).unwrap();
    let lights = |random: &mut Random| [light(number(random), 0), light(number(random), 1)];
    let place = |number: i64| Observation::new(PLACE, [(NUMBER, Value::Integer(number))]);
    let at = i64::try_from(primitive).unwrap();
    let (before, after) = (lights(random), lights(random));
    let rings = before.iter().any(|o| o.properties()[0].1 == Value::Integer(at)) && random.below(8) > 0;
    let sorted = |mut list: Vec<Observation>| -> Arc<[Observation]> {
        list.sort_unstable();
        list.dedup();
        list.into()
    };
    let was = place(number(random));
    let bell = rings.then(|| Observation::new(BELL, []));
    Experience {
        body: BodyId(0),
        primitive: PrimitiveId(u32::try_from(primitive).unwrap()),
        parameters: [Some(Value::Integer(at))].into(),
        before: sorted([&before[..], &[was]].concat()),
        after: sorted(after.into_iter().chain([place(at)]).chain(bell).collect()),
        sensed: [LIGHT, PLACE, BELL].into(),
        recalled: None,
    }
}

/// The plain search: sets of numbers instead of columns, and every likelihood worked out anew.
struct Plain<'a> {
    scenes: &'a [Scene],
    made: &'a dyn Fn(&Change, usize) -> bool,
    changes: &'a [Change],
    conditions: &'a [Condition],
    outcomes: usize,
    /// How many conditions may be needed until they pay together.
    together: usize,
}

impl Plain<'_> {
    fn part(&self, examples: &[usize]) -> Vec<Vec<usize>> {
        let mut rest = examples.to_vec();
        let mut parts: Vec<Vec<usize>> = Vec::new();
        loop {
            let best = self.changes.iter().enumerate().max_by_key(|(at, change)| {
                let count = rest.iter().filter(|example| (self.made)(change, **example)).count();
                (count, std::cmp::Reverse(change.constants()), std::cmp::Reverse(*at))
            });
            let Some((_, change)) = best else { break };
            let (hit, left): (Vec<_>, Vec<_>) =
                rest.iter().partition(|example| (self.made)(change, **example));
            if hit.is_empty() {
                break;
            }
            parts.push(hit);
            rest = left;
        }
        parts.push(rest);
        parts
    }

    fn told(&self, counts: &[usize]) -> f64 {
        let trials = counts.iter().sum();
        let likelihood = Likelihood::new(trials, self.outcomes);
        counts.iter().map(|count| likelihood.rising(*count)).sum::<f64>() - likelihood.factorial(trials)
    }

    /// The conditions that part the examples, each with its net gain and the examples in which it holds.
    fn choices(&self, examples: &[usize]) -> Vec<(f64, &Condition, Vec<usize>)> {
        let parts = self.part(examples);
        let mut choices: Vec<(f64, &Condition, Vec<usize>)> = Vec::new();
        for condition in self.conditions {
            let holding: Vec<_> =
                examples.iter().copied().filter(|at| self.scenes[*at].holds(condition)).collect();
            let is_known = choices.iter().any(|(_, _, known)| *known == holding);
            if holding.is_empty() || holding.len() == examples.len() || is_known {
                continue;
            }
            let inside = |part: &Vec<usize>| part.iter().filter(|at| holding.contains(at)).count();
            let inside: Vec<_> = parts.iter().map(inside).collect();
            let all: Vec<_> = parts.iter().map(Vec::len).collect();
            let outside: Vec<_> = all.iter().zip(&inside).map(|(all, inside)| all - inside).collect();
            choices.push((self.told(&inside) + self.told(&outside) - self.told(&all), condition, holding));
        }
        let among = |tier| choices.iter().filter(|(_, condition, _)| Tier::of(condition) == tier).count();
        let prices: Vec<_> = choices.iter().map(|(_, c, _)| Tier::of(c).price(among(Tier::of(c)))).collect();
        choices.iter_mut().zip(prices).for_each(|((gain, ..), price)| *gain -= price);
        choices
    }

    /// The exception that is best, though it may not pay.
    fn best(
        &self,
        examples: &[usize],
        together: usize,
        firsts: usize,
    ) -> Option<(f64, Condition, Vec<usize>)> {
        let first_of_best = |choices: &[(f64, Condition, Vec<usize>)]| {
            let better = |best: Option<usize>, at: usize| match best {
                Some(best) if choices[at].0 <= choices[best].0 + 1e-9 => Some(best),
                _ => Some(at),
            };
            (0..choices.len()).fold(None, better).map(|at| choices[at].clone())
        };
        let choices = self.choices(examples).into_iter();
        let mut choices: Vec<_> = choices.map(|(gain, c, holding)| (gain, c.clone(), holding)).collect();
        let best = first_of_best(&choices)?;
        if best.0 > 1e-9 || together == 1 {
            return Some(best);
        }
        choices.sort_by_key(|(gain, ..)| std::cmp::Reverse((gain * 1e9).round() as i64));
        choices.truncate(firsts);
        choices.retain_mut(|(gain, _, holding)| {
            let is_open = self.part(holding).iter().filter(|part| !part.is_empty()).count() > 1;
            let more = is_open.then(|| self.best(holding, together - 1, firsts / 2)).flatten();
            let more = more.map_or(0.0, |(more, ..)| more);
            *gain += more;
            more > 1e-9
        });
        first_of_best(&choices)
    }

    /// The exceptions to a claim about these examples, and those that are left to it.
    fn claims(&self, mut examples: Vec<usize>, depth: usize) -> (Vec<Claim>, Vec<usize>) {
        let mut exceptions = Vec::new();
        while depth < 8 && self.part(&examples).iter().filter(|part| !part.is_empty()).count() > 1 {
            let best = self.best(&examples, self.together, 8).filter(|(gain, ..)| *gain > 1e-9);
            let Some((gain, condition, holding)) = best else { break };
            examples.retain(|at| !holding.contains(at));
            let (below, left) = self.claims(holding, depth + 1);
            exceptions.push(Claim {
                condition: Some(condition),
                gain,
                exceptions: below,
                outcomes: Vec::new(),
                trials: u32::try_from(left.len()).unwrap(),
            });
        }
        (exceptions, examples)
    }
}

fn bare(claim: &Claim) -> Claim {
    let exceptions = claim.exceptions.iter().map(bare).collect();
    Claim { condition: claim.condition.clone(), exceptions, trials: claim.trials, ..Claim::default() }
}

/// The claims about the bell that these experiences make: those of the fast growth, those of the plain search, and of one that looks at
/// single conditions only. Numbers are left out of it: no bounds are asked for.
fn grown(experiences: &[Experience]) -> [Claim; 3] {
    let named = |e: &Experience| Scene::new(e.before.clone(), &[], &[]);
    let scenes: Vec<_> = experiences.iter().map(named).collect();
    let kinds = [BELL];
    let bell = |e: &Experience| e.after.iter().filter(|o| o.kind() == BELL).cloned().collect::<Vec<_>>();
    let mut changes: Vec<Change> = Vec::new();
    for (scene, experience) in scenes.iter().zip(experiences) {
        for change in scene.changes(&bell(experience), &kinds) {
            if !changes.contains(&change) {
                changes.push(change);
            }
        }
    }
    let made = |change: &Change, at: usize| scenes[at].after(change, &kinds) == Some(bell(&experiences[at]));
    let mut conditions = Conditions::default();
    (0..scenes.len()).for_each(|at| conditions.enter(at, None, |at| &scenes[at]));
    conditions.put_in_order();
    let of_change = |change: &Change| {
        let mut column = Column::default();
        (0..scenes.len()).filter(|at| made(change, *at)).for_each(|at| column.insert(at));
        (change.clone(), column)
    };
    let with_examples: Vec<_> = changes.iter().map(of_change).collect();
    let mut all = Column::default();
    (0..scenes.len()).for_each(|at| all.insert(at));
    let nothing = Scene::new([], &[], &[]);
    let ground =
        Ground { conditions: &conditions, changes: &with_examples, is_blind: false, scene: &|_| &nothing };
    let ordered: Vec<_> = conditions.iter().map(|asked| asked.condition.clone()).collect();
    let outcomes = changes.iter().filter(|change| (0..scenes.len()).any(|at| made(change, at))).count();
    let plain = |together: usize| {
        // Two outcomes: the bell rings, or it does not.
        let outcomes = outcomes.min(2) + 1;
        let (scenes, changes, conditions) = (&scenes[..], &changes[..], &ordered[..]);
        let plain = Plain { scenes, made: &made, changes, conditions, outcomes, together };
        let (exceptions, left) = plain.claims((0..scenes.len()).collect(), 0);
        Claim { exceptions, trials: u32::try_from(left.len()).unwrap(), ..Claim::default() }
    };
    [ground.grow(all).claim, plain(3), plain(1)]
}

fn assert_same(fast: &Claim, slow: &Claim, seed: u64) {
    assert_eq!(bare(fast), bare(slow), "seed {seed}");
    // The sums are the same but for their order.
    let gains = fast.all().zip(slow.all()).map(|(fast, slow)| (fast.gain, slow.gain));
    gains.for_each(|(fast, slow)| assert!((fast - slow).abs() < 1e-6, "seed {seed}: {fast} and {slow}"));
}

/// The fast growth is the plain search, on random examples.
#[test]
fn claims_grow_as_a_plain_search_finds_them() {
    let mut exceptions = 0;
    for seed in 0..40 {
        let mut random = Random::from_seed(seed);
        let count = if seed % 2 == 0 { 60 } else { 100 };
        let experiences: Vec<_> = (0..count).map(|_| experience(&mut random, 3)).collect();
        let [fast, slow, _] = grown(&experiences);
        assert_same(&fast, &slow, seed);
        exceptions += fast.exceptions.len();
    }
    assert!(exceptions > 0, "no claim had an exception");
}

/// A bell that rings where one of two lights is on and the other is not: no condition pays for itself, and two together do.
#[test]
fn conditions_that_pay_only_together_are_found() {
    let rings = |lit: usize| {
        let is_lit = |number: usize| lit >> number & 1 == 1;
        let side = |number: usize| light(i64::try_from(number).unwrap(), i64::from(is_lit(number)));
        let bell = (is_lit(0) != is_lit(1)).then(|| Observation::new(BELL, []));
        let (before, after) = ((0..3).map(side).collect(), bell.into_iter().collect());
        Experience { before, after, ..experience(&mut Random::from_seed(0), 1) }
    };
    let experiences: Vec<_> = (0..64).map(|number| rings(number % 8)).collect();
    let [fast, slow, single] = grown(&experiences);
    assert_same(&fast, &slow, 0);
    assert!(single.exceptions.is_empty(), "{single:?}");
    assert!(
        fast.all().all(|claim| claim.outcomes.len() == 1 && claim.outcomes[0].1 == claim.trials),
        "{fast:?}"
    );
}

/// A long life is kept within bounds, and what is known is what the experiences that are kept make; but for what was forgotten of
/// how it is told best, all together or one by one.
#[test]
fn a_pool_forgets_and_stays_what_its_experiences_make_of_it() {
    let mut compared = 0;
    for seed in 0..6 {
        compared += usize::from(forgets(seed));
    }
    assert!(compared > 2, "{compared} pools");
}

/// Whether the pool of a long life tells the same one by one as one that lived through what is kept of it. Then both are equal.
fn forgets(seed: u64) -> bool {
    let mut random = Random::from_seed(seed);
    let mut pool = Pool::default();
    for _ in 0..1_100 {
        pool.experience(Arc::new(experience(&mut random, 4)), false);
    }
    let kept: Vec<_> = pool.experiences().cloned().collect();
    assert!((768..=1_024).contains(&kept.len()), "{} are kept", kept.len());
    let mut again = Pool::default();
    kept.into_iter().for_each(|experience| again.experience(Arc::new(experience), false));
    let is_told_alike = again.singly.keys().eq(pool.singly.keys());
    assert!(!is_told_alike || again == pool, "seed {seed}");
    // The law of the bell is still known: the light tells, and the place that is gone to.
    for at in 0..4 {
        let context = [light(at, 0), light(at, 1)];
        let primitive = PrimitiveId(u32::try_from(at).unwrap());
        let told = pool.foretell(primitive, &[Some(Value::Integer(at))], &context, &|_| None, &|_| true);
        let bell = told.iter().find(|facet| facet.kinds == [BELL]).unwrap();
        let rings = bell.outcomes.iter().find(|(after, _)| !after.is_empty()).map_or(0, |(_, count)| *count);
        assert!(f64::from(rings) > 0.75 * f64::from(bell.trials), "{at}: {rings} of {}", bell.trials);
    }
    is_told_alike
}

/// What was met once, long ago, is not forgotten for what is met all the time.
#[test]
fn what_is_rare_is_kept() {
    let mut random = Random::from_seed(11);
    let often: Vec<_> = (0..6).map(|_| experience(&mut random, 3)).collect();
    let rare: Vec<_> = (0..40).map(|_| experience(&mut random, 9)).collect();
    let mut pool = Pool::default();
    rare.iter().for_each(|one| pool.experience(Arc::new(one.clone()), false));
    for _ in 0..3_000 {
        pool.experience(Arc::new(often[random.below(often.len())].clone()), false);
    }
    let kept = |one: &Experience| pool.experiences().any(|known| known.before == one.before);
    let forgotten = rare.iter().filter(|one| !kept(one)).count();
    assert_eq!(forgotten, 0, "of {}", rare.len());
}

/// What holds in an example is what holds in its scene, though it was taken over from another with the same.
#[test]
fn examples_with_the_same_scene_are_entered_as_if_each_were_the_first() {
    let (mut random, mut pool) = (Random::from_seed(5), Pool::default());
    let few: Vec<_> = (0..40).map(|_| experience(&mut random, 3)).collect();
    let mut taken_over = 0;
    for _ in 0..400 {
        pool.experience(Arc::new(few[random.below(few.len())].clone()), false);
        let at = pool.experiences().count() - 1;
        taken_over += usize::from(pool.examples().twin(at, |_| true).is_some());
    }
    for (at, (experience, scene)) in pool.examples.iter().enumerate() {
        for asked in pool.conditions.iter() {
            assert_eq!(asked.column.contains(at), scene.holds(&asked.condition), "{at}: {asked:?}");
        }
        for facet in pool.facets.iter().filter(|facet| !facet.is_singly) {
            let after = facet.after(experience);
            assert_eq!(facet.outcomes.of(at), facet.outcomes.number(&after));
            for (change, makes) in &facet.changes {
                assert_eq!(makes.contains(at), scene.makes(change, &after, &facet.kinds), "{at}: {change:?}");
            }
        }
    }
    assert!(taken_over > 200, "{taken_over}");
}

/// Where all actions are looked at as one, nothing is kept of any one of them.
#[test]
fn the_background_has_no_primitives() {
    let mut random = Random::from_seed(4);
    let mut pool = Pool::default();
    for _ in 0..50 {
        pool.experience(
            Arc::new(Experience { primitive: ANYTHING, parameters: [].into(), ..experience(&mut random, 3) }),
            false,
        );
    }
    assert!(pool.is_background());
}

/// Eight moves with these senses, then one with all of them that meets a light and rings; what is foretold of the bell for another
/// move, to a light or past it: how often it rings, of how many.
fn after_one_ring(senses: &[TypeId], light_there: bool) -> [(u32, u32); 2] {
    let place = |number: i64| Observation::new(PLACE, [(NUMBER, Value::Integer(number))]);
    let moved = |to: i64, sensed: &[TypeId], light: Option<i64>, rings: bool| {
        let light = light.map(|number| Observation::new(LIGHT, [(NUMBER, Value::Integer(number))]));
        let bell = rings.then(|| Observation::new(BELL, []));
        let mut after: Vec<_> = light.iter().cloned().chain([place(to)]).chain(bell).collect();
        after.sort_unstable();
        Arc::new(Experience {
            body: BodyId(0),
            recalled: None,
            primitive: PrimitiveId(u32::try_from(to).unwrap()),
            parameters: [Some(Value::Integer(to))].into(),
            before: light.into_iter().collect(),
            after: after.into(),
            sensed: sensed.into(),
        })
    };
    let mut pool = Pool::default();
    for to in 0..8 {
        pool.experience(moved(to, senses, light_there.then_some(to), false), false);
    }
    pool.experience(moved(3, &[LIGHT, PLACE, BELL], Some(3), true), false);
    [5, 6].map(|light| {
        let context = [Observation::new(LIGHT, [(NUMBER, Value::Integer(light))])];
        let foretold =
            pool.foretell(PrimitiveId(5), &[Some(Value::Integer(5))], &context, &|_| None, &|_| true);
        let bell = foretold.iter().find(|facet| facet.kinds == [BELL]).unwrap();
        let rings = bell.outcomes.iter().filter(|(after, _)| !after.is_empty()).map(|(_, count)| count).sum();
        (rings, bell.trials)
    })
}

/// What was learnt without a sense stands for a world without it.
#[test]
fn what_comes_with_a_new_sense_comes_of_what_the_sense_shows() {
    let [to_light, past_it] = after_one_ring(&[PLACE], false);
    assert_eq!(to_light, (1, 1), "the bell rings for a light at the place that is moved to");
    assert_eq!(past_it.0, 0, "and is silent where the light is elsewhere");
}

/// All was there before, but for the sense: then the moves without it tell nothing.
#[test]
fn what_could_not_be_sensed_is_not_held_against_what_could_be_seen() {
    let [to_light, _] = after_one_ring(&[LIGHT, PLACE], true);
    assert_eq!(to_light, (1, 1));
}

/// A life in which own effects are found, named anew and lost again, types are joined and parted, and much is forgotten: at each of its
/// moments a pool is what its experiences and what was found of them make.
#[test]
fn a_pool_is_put_back_as_it_was() {
    let (mut joined, mut renamed, mut forgotten) = (0, 0, 0);
    for seed in 0..3 {
        let (mut random, mut pool) = (Random::from_seed(seed), Pool::default());
        for number in 0..1_100 {
            let mut next = experience(&mut random, if number % 3 == 0 { 12 } else { 3 });
            // The first background: all actions as one.
            if seed == 0 {
                next = Experience { primitive: ANYTHING, parameters: [].into(), ..next };
            }
            // For a while nothing is brought about, or a bell and a place that come and go together.
            match number {
                30..60 => next.after = next.before.clone(),
                100..160 => {
                    let both =
                        [Observation::new(PLACE, [(NUMBER, Value::Integer(9))]), Observation::new(BELL, [])];
                    next.after = if random.below(2) == 0 { both.into() } else { [].into() };
                }
                _ => (),
            }
            let before = (pool.found(), pool.experiences().count());
            pool.experience(Arc::new(next), false);
            let found = pool.found();
            joined += usize::from(found.facets.iter().any(|facet| facet.kinds.len() > 1));
            let known = |now: &OwnEffect| {
                before.0.effects.iter().any(|then| {
                    then.primitive == now.primitive && then.brought != now.brought && then.brought.is_some()
                })
            };
            renamed += found.effects.iter().filter(|now| known(now)).count();
            forgotten += usize::from(pool.experiences().count() < before.1);
            if number < 200 || number % 97 == 0 || number == 767 || number == 1_024 {
                let experiences = pool.experiences().cloned().collect();
                assert_eq!(
                    Pool::restored(experiences, found, Values::default()),
                    pool,
                    "seed {seed}, {number}"
                );
            }
        }
    }
    println!("{joined} {renamed} {forgotten}");
    assert!(joined > 0 && renamed > 0 && forgotten > 0, "{joined} {renamed} {forgotten}");
}

/// Memories that were written when an end was an experience of each action have them among those of the actions.
#[test]
fn an_end_among_the_experiences_of_an_action_tells_nothing() {
    let (mut random, mut pool) = (Random::from_seed(9), Pool::default());
    for number in 0..1_100 {
        let lived = experience(&mut random, 4);
        let recalled = (number % 5 == 0).then(|| Recalled { observations: lived.before.clone(), age: 0 });
        pool.experience(Arc::new(Experience { recalled, ..lived }), false);
    }
    assert!(pool.experiences().any(Experience::is_end), "none is kept");
    assert!(pool.facets.iter().all(|facet| facet.kinds != [TypeId::ENDED]));
}
