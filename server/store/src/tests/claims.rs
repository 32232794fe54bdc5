//! Claims come back from a snapshot as they were, and forged ones are refused.

use std::sync::Arc;

use pschema_learner::Learner;
use pschema_learner::digest::{self, digest};
use pschema_learner::effect::Effect;
use pschema_learner::evidence::{About, Evidence};
use pschema_learner::experience::{Experience, Recalled};
use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::memory::{Content, Memory};
use pschema_learner::observation::{Observation, PropertyId, SymbolId, TypeId, Value};
use pschema_learner::parameters::Parameters;
use pschema_learner::random::Random;
use pschema_learner::vocabulary::{BodyId, PrimitiveId};

use crate::Options;
use crate::format::v1::Setting;
use crate::journal::Place;
use crate::past::export;
use crate::snapshot;
use crate::tests::store::{World, attach, curriculum, declaration, opened_as, options, settled, step};
use crate::tests::twin::Twin;

/// A memory that keeps claims, of a body that has lived nothing.
fn memory() -> Memory {
    let mut learner = Learner::new(1, Parameters::default(), curriculum()).unwrap();
    learner.set_mechanisms(Mechanisms::FULL);
    learner.declare(declaration()).unwrap();
    learner.symbol("red");
    learner.symbol("blue");
    learner.into_memory()
}

fn at(kind: u16, field: usize) -> Observation {
    let number = Value::Integer(i64::try_from(field).unwrap());
    Observation::new(TypeId(kind), [(PropertyId(0), number)])
}

fn block(colour: usize, field: usize) -> Observation {
    let colour = SymbolId(u32::try_from(colour).unwrap());
    let number = Value::Integer(i64::try_from(field).unwrap());
    Observation::new(TypeId(1), [(PropertyId(0), number), (PropertyId(1), Value::Symbol(colour))])
}

/// A move among blocks. Mostly the finger is where it was moved to, and there is a touch if a block is there; in a `lame` body nothing
/// moves, and in a `shaky` one finger and touch come and go together, whatever is done.
fn lived(random: &mut Random, lame: bool, shaky: bool) -> Experience {
    let to = random.below(12);
    let blocks: Vec<_> = (0..2).map(|_| block(random.below(2), random.below(12))).collect();
    let before: Vec<_> = blocks.iter().cloned().chain([at(0, random.below(12))]).collect();
    let there = blocks.iter().any(|one| one.shared(&at(0, to)) > 0);
    let mut after = blocks;
    if lame {
        after.clone_from(&before);
    } else if !shaky || random.below(2) == 0 {
        after.push(at(0, if shaky { 11 } else { to }));
        after.extend((shaky || there).then(|| Observation::new(TypeId(2), [])));
    }
    let ordered = |mut list: Vec<Observation>| -> Arc<[Observation]> {
        list.sort_unstable();
        list.dedup();
        list.into()
    };
    Experience {
        body: BodyId(0),
        recalled: None,
        primitive: PrimitiveId(u32::try_from(to).unwrap()),
        parameters: [Some(Value::Integer(i64::try_from(to).unwrap()))].into(),
        before: ordered(before),
        after: ordered(after),
        sensed: [TypeId(0), TypeId(1), TypeId(2)].into(),
    }
}

/// The memory after a snapshot of it was written and read.
fn back(memory: &Memory) -> Content {
    let (twin, content, place) = (Twin::new(), memory.content(), Place { number: 1, crc: 0 });
    let setting = Setting::new(memory.parameters(), &curriculum());
    snapshot::write(&twin, content, &setting, place, &digest(content), || false).unwrap().unwrap();
    snapshot::sound(&twin, 1).unwrap().unwrap().0.content
}

/// A life in which own effects are named anew, types are joined and parted, and much is forgotten.
#[test]
fn claims_come_back_as_they_were() {
    for seed in 0..2 {
        let (mut memory, mut random) = (memory(), Random::from_seed(seed));
        for number in 0..1_060 {
            let (lame, shaky) = ((30..60).contains(&number), (100..180).contains(&number));
            let experience = lived(&mut random, lame, shaky);
            memory.apply(&Effect::Experienced(Box::new(experience.clone()))).unwrap();
            if number % 37 == 0 || number == 767 || number == 1_024 {
                let (now, then) = (back(&memory), memory.content());
                assert_eq!(now.evidence, then.evidence, "seed {seed}, {number}");
                let foretell = |content: &Content, primitive| {
                    content.evidence.foretell(
                        &content.vocabulary,
                        Some(BodyId(0)),
                        PrimitiveId(primitive),
                        &experience.before,
                    )
                };
                (0..12).for_each(|one| assert_eq!(foretell(&now, one), foretell(then, one)));
            }
        }
        assert!(memory.content().evidence.kept().count() < 2 * 1_024, "nothing was forgotten");
    }
}

/// Where episodes ended, and what was to be learnt where they began.
#[test]
fn ends_and_beginnings_come_back_as_they_were() {
    let (mut memory, mut random) = (memory(), Random::from_seed(5));
    for number in 0..400 {
        let experience = lived(&mut random, false, false);
        memory.apply(&Effect::Experienced(Box::new(experience.clone()))).unwrap();
        if number % 7 == 0 {
            let there = Recalled { observations: experience.before.clone(), age: 0 };
            let end =
                Experience { after: experience.before.clone(), recalled: Some(there), ..experience.clone() };
            memory.apply(&Effect::Experienced(Box::new(end))).unwrap();
            memory.apply(&Effect::Experienced(Box::new(Experience::beginning(BodyId(0))))).unwrap();
        }
        if number % 50 == 0 || number == 399 {
            let (now, then) = (back(&memory), memory.content());
            assert_eq!(now.evidence, then.evidence, "{number}");
            assert_eq!(digest(&now), digest(then), "{number}");
        }
    }
    let evidence = &memory.content().evidence;
    let of_ends = |(kinds, _): &(&[TypeId], _)| *kinds == [TypeId::ENDED];
    assert!(evidence.claims(&memory.content().vocabulary, About::Anything).iter().any(of_ends));
    assert!(evidence.beginnings().any(|(_, beginnings)| beginnings.learnable.1 > 1.0));
    let text = text_of(&memory);
    let (before, written) = text.split_once("{\"beginnings\":").unwrap();
    let (_, after) = written.split_once('\n').unwrap();
    for (forged, says) in [
        ("{\"body\":7,\"is_next\":true,\"learnable\":[0.0,0.0]}}", "it refers to body 7"),
        ("{\"body\":0,\"is_next\":true,\"learnable\":[2.0,1.0]}}", "how much was to be learnt"),
        ("{\"body\":0,\"is_next\":true,\"learnable\":[-1.0,1.0]}}", "how much was to be learnt"),
        ("{\"body\":0,\"is_next\":true,\"learnable\":[1.0,1e300]}}", "how much was to be learnt"),
    ] {
        let told = read(&format!("{before}{{\"beginnings\":{forged}\n{after}")).map(drop);
        assert!(told.as_ref().is_err_and(|told| told.contains(says)), "{forged}: {told:?}");
    }
}

/// An export of a short life, as text.
fn exported() -> (Memory, String) {
    let (mut memory, mut random) = (memory(), Random::from_seed(7));
    for _ in 0..150 {
        memory.apply(&Effect::Experienced(Box::new(lived(&mut random, false, false)))).unwrap();
    }
    let text = text_of(&memory);
    (memory, text)
}

fn text_of(memory: &Memory) -> String {
    let (curriculum, parameters) = (curriculum(), memory.parameters());
    let identity = export::Identity { learner: "it", seed: 5, parameters, curriculum: &curriculum };
    let mut bytes = Vec::new();
    export::write(memory.content(), identity, &mut bytes, |_| ()).unwrap();
    String::from_utf8(bytes).unwrap()
}

fn read(text: &str) -> Result<Content, String> {
    export::read(&mut text.as_bytes(), |_| ()).map(|read| read.content).map_err(|error| error.to_string())
}

/// A look to one side or the other along a row of twelve places, of which two to each side are in view. Now and then a block moves.
fn looked(memory: &Memory, random: &mut Random, row: &mut [bool; 12], at: &mut usize) -> Experience {
    let seen = |row: &[bool; 12], place: usize| -> Arc<[Observation]> {
        let block = |offset: usize| {
            let there = (place + offset).checked_sub(2).and_then(|place| row.get(place));
            there.is_some_and(|there| *there).then(|| block(0, offset))
        };
        [super::claims::at(0, place)].into_iter().chain((0..5).filter_map(block)).collect()
    };
    let (to, before) = (random.below(12), seen(row, *at));
    *at = if to < 6 { at.saturating_sub(1) } else { (*at + 1).min(11) };
    if random.below(20) == 0 {
        row.swap(random.below(12), random.below(12));
    }
    let (after, primitive) = (seen(row, *at), PrimitiveId(u32::try_from(to).unwrap()));
    let content = memory.content();
    Experience {
        body: BodyId(0),
        recalled: content.evidence.recalled(&content.vocabulary, BodyId(0), primitive, &after),
        primitive,
        parameters: [Some(Value::Integer(i64::try_from(to).unwrap()))].into(),
        before,
        after,
        sensed: [TypeId(0), TypeId(1), TypeId(2)].into(),
    }
}

/// A life in which blocks are told one by one, and what was seen is recalled.
#[test]
fn what_is_told_one_by_one_and_recalled_comes_back() {
    let (mut memory, mut random) = (memory(), Random::from_seed(4));
    let (mut row, mut at) = ([false; 12], 5);
    [1, 4, 5, 9].into_iter().for_each(|place: usize| row[place] = true);
    let (mut singly, mut tried, mut recalled) = (0, 0, 0);
    for number in 0..500 {
        let experience = looked(&memory, &mut random, &mut row, &mut at);
        memory.apply(&Effect::Experienced(Box::new(experience))).unwrap();
        if number % 19 == 0 {
            let (now, then) = (back(&memory), memory.content());
            assert!(now.evidence == then.evidence, "{number}");
            assert_eq!(digest(&now), digest(then), "{number}");
            for (_, found) in then.evidence.found() {
                singly += found.facets.iter().filter(|facet| facet.each.is_some()).count();
                tried += found.facets.iter().filter(|facet| facet.trial.is_some()).count();
                recalled += usize::from(found.key.is_some());
            }
        }
    }
    assert!(singly > 0 && tried > 0 && recalled > 0, "{singly} {tried} {recalled}");
    assert!(memory.content().evidence.recollections().any(|(_, recalled)| recalled.all().count() > 3));
}

/// Under the profile of the paper nothing of it is written.
#[test]
fn the_paper_has_no_claims() {
    let (memory, _) = exported();
    let paper = Content { evidence: Evidence::default(), ..memory.content().clone() };
    assert_eq!(digest::claims(&paper), Vec::<String>::new());
    assert_eq!(paper.evidence.found().count(), 0);
}

/// Each number that was written otherwise is refused with its line, whatever else the file says.
#[test]
fn forged_claims_are_refused_one_by_one() {
    let (_, text) = exported();
    let (before, found) = text.split_once("{\"found\"").unwrap();
    let (found, mut wrong) = (format!("{{\"found\"{found}"), Vec::new());
    for (number, forged, says) in [
        ("{\"found\":{\"pool\":0", "{\"found\":{\"pool\":3", "of a pool that has no experiences"),
        ("{\"found\":{\"pool\":null", "{\"found\":{\"pool\":0", "a second `found`"),
        ("\"facets\":3", "\"facets\":4", "there are more than 3 facets"),
        ("\"facets\":3", "\"facets\":2", "it refers to facet 2, and there are 2"),
        ("\"digest\":\"", "\"digest\":\"0", "what was found of experiences has digest"),
        ("\"effect\":{\"primitive\":0", "\"effect\":{\"primitive\":12", "it is of primitive 12"),
        (
            "\"effect\":{\"primitive\":1,",
            "\"effect\":{\"primitive\":0,",
            "own effects of a pool are out of order",
        ),
        ("{\"own_effect\":{\"pool\":0", "{\"own_effect\":{\"pool\":1", "of a pool that has no experiences"),
        ("\"brought\":[[{\"kind\":0", "\"brought\":[[{\"kind\":7", "was never declared"),
        ("]]}],1],\"doubtful\"", "]]}],1000],\"doubtful\"", "tries with this primitive"),
        ("\"doubtful\":false", "\"doubtful\":true", "what was found of experiences has digest"),
        ("{\"facet\":{\"pool\":0", "{\"facet\":{\"pool\":9", "of a pool that has no experiences"),
        ("\"kinds\":[0]", "\"kinds\":[3]", "it refers to observation type 3"),
        ("\"kinds\":[1]", "\"kinds\":[0]", "the types of a facet are none, out of order"),
        ("\"kinds\":[0]", "\"kinds\":[]", "the types of a facet are none, out of order"),
        ("\"surprise\":[0.0", "\"surprise\":[99.0", "how much surprised"),
        ("\"surprise\":[0.0", "\"surprise\":[-0.5", "how much surprised"),
        ("{\"change\":{\"facet\":0", "{\"change\":{\"facet\":6", "it refers to facet 6, and there are 6"),
        ("\"becomes\":[{\"kind\":0", "\"becomes\":[{\"kind\":1", "that is not one of its own"),
        ("\"becomes\":[{\"kind\":0", "\"becomes\":[{\"kind\":8", "it refers to observation type 8"),
        (
            "\"named\":[{\"parameter\":0}",
            "\"named\":[{\"parameter\":1}",
            "it refers to parameter 1, and there are 1",
        ),
        ("{\"only\":[0,0]}", "{\"only\":[4,0]}", "it refers to observation type 4"),
        ("{\"only\":[0,0]}", "{\"only\":[0,2]}", "it refers to property 2"),
        ("\"properties\":[[0,{\"named\"", "\"properties\":[[5,{\"named\"", "it refers to property 5"),
        ("{\"tree\":{\"facet\":0", "{\"tree\":{\"facet\":7", "it refers to facet 7"),
        ("{\"tree\":{\"facet\":1", "{\"tree\":{\"facet\":0", "the trees of a facet are out of order"),
        ("\"primitive\":2,\"scores\"", "\"primitive\":55,\"scores\"", "it is of primitive 55"),
        ("\"primitive\":2,\"scores\"", "\"primitive\":0,\"scores\"", "the trees of a facet are out of order"),
        ("\"scores\":null", "\"scores\":[0.0,0.0,0.0]", "a score is out of range"),
        ("\"examples\":", "\"examples\":9", "experiences of the pool"),
        ("\"exceptional\":", "\"exceptional\":999", "experiences of the pool"),
        ("\"unforetold\":", "\"unforetold\":999", "experiences of the pool"),
        ("\"claims\":1}", "\"claims\":2}", "there is no `claim`"),
        ("\"claims\":1}", "\"claims\":0}", "the trees of a facet are out of order"),
        ("\"claims\":1}", "\"claims\":77777}", "claims of a tree"),
        ("{\"claim\":{\"tree\":0", "{\"claim\":{\"tree\":777", "it refers to tree 777"),
        ("{\"claim\":{\"tree\":1,", "{\"claim\":{\"tree\":0,", "it refers to claim 1, and there are 1"),
        ("\"depth\":0", "\"depth\":1", "claims above this one"),
        ("\"depth\":1", "\"depth\":9", "claims above this one"),
        ("\"depth\":1", "\"depth\":0", "the first claim of a tree, and no other"),
        ("\"gain\":0.0", "\"gain\":0.5", "what was found of experiences has digest"),
        ("\"outcomes\":[[0,", "\"outcomes\":[[64,", "it refers to change 64"),
        ("\"outcomes\":[[0,", "\"outcomes\":[[0,9", "something happened"),
        ("\"outcomes\":[[0,", "\"outcomes\":[[0,0],[0,", "an outcome twice, or one that never came"),
        ("\"trials\":", "\"trials\":4000000", "experiences of the pool"),
        ("{\"places\":{\"facet\":0", "{\"places\":{\"facet\":6", "it refers to facet 6"),
        ("\"places\":[{\"claim\":0", "\"places\":[{\"claim\":500", "it refers to claim 500"),
        ("\"change\":0}", "\"change\":64}", "it refers to change 64"),
        ("\"places\":[{", "\"places\":[null,null,{", "experiences of the pool"),
        ("{\"recalling\":{\"body\":0", "{\"recalling\":{\"body\":7", "it refers to body 7"),
        ("\"experiences\":150", "\"experiences\":18446744073709551615", "how many experiences a body had"),
    ] {
        let forged = format!("{before}{}", found.replacen(number, forged, 1));
        assert_ne!(forged, text, "{number} is not there");
        let told = match read(&forged) {
            Ok(_) => "it was taken in".to_owned(),
            Err(error) => error,
        };
        if !(told.starts_with("line ") && told.contains(says)) {
            wrong.push(format!("{number} to be refused by {says:?}: {told}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Whoever forges numbers can forge digests. What is taken in then is wrong, and still nothing comes to an end by it.
#[test]
fn what_is_forged_throughout_does_no_harm() {
    let (memory, text) = exported();
    let start = text.find("{\"found\"").unwrap();
    let end = text.find("{\"end\"").unwrap();
    let digits: Vec<_> = text
        .bytes()
        .enumerate()
        .filter(|(at, byte)| (start..end).contains(at) && byte.is_ascii_digit())
        .collect();
    let (mut random, mut taken) = (Random::from_seed(3), 0);
    for _ in 0..200 {
        let (at, _) = digits[random.below(digits.len())];
        let number = ["0", "1", "2", "9", "150", "4294967295", "18446744073709551615"][random.below(7)];
        let mut forged = format!("{}{number}{}", &text[..at], &text[at + 1..]);
        let mut content = read(&forged);
        for _ in 0..2 {
            let Err(error) = &content else { break };
            if let Some((_, digests)) = error.split_once("has digest ")
                && let Some((found, written)) = digests.split_once(", and what was written had ")
            {
                forged = forged.replace(written.trim(), found);
                content = read(&forged);
            }
        }
        let Ok(content) = content else { continue };
        taken += 1;
        let mut memory = Memory::restore(content, memory.parameters().clone());
        for _ in 0..6 {
            let experience = lived(&mut random, false, false);
            for primitive in 0..12 {
                let content = memory.content();
                let foretold = content.evidence.foretell(
                    &content.vocabulary,
                    Some(BodyId(0)),
                    PrimitiveId(primitive),
                    &experience.before,
                );
                assert!(foretold.len() <= 3);
            }
            memory.apply(&Effect::Experienced(Box::new(experience))).unwrap();
        }
        back(&memory);
    }
    assert!(taken > 10, "only {taken} forgeries were taken in");
}

/// A snapshot with other claims than those that its journal leads to is found.
#[test]
fn claims_that_the_journal_does_not_lead_to_are_found() {
    let twin = lived_twin();
    let past = crate::past::tests::past(&twin);
    assert!(past.verify(false, &mut |_| ()).unwrap().sound);
    let number = *snapshot::numbers(&twin).unwrap().last().unwrap();
    let (whole, place) = snapshot::sound(&twin, number).unwrap().unwrap();
    let mut content = whole.content;
    let (pool, mut found) = content.evidence.found().next().unwrap();
    found.facets[0].surprise[0] = 0.0;
    found.facets[0].surprise[1] += 1.0;
    let experiences = content.evidence.kept().filter(|(of, _)| *of == pool);
    let experiences = experiences.map(|(_, experience)| experience.clone()).collect();
    content.evidence.restore(&content.vocabulary, pool, experiences, found);
    snapshot::write(&twin, &content, &whole.setting, place, &whole.memory_digest, || false).unwrap();
    let checked = past.verify(false, &mut |_| ()).unwrap();
    let [finding] = &checked.findings[..] else { panic!("{checked:?}") };
    assert!(finding.problem.contains("other claims"), "{finding:?}");
}

/// A life under the full profile, on disk.
fn lived_twin() -> Twin {
    let (twin, mut world) = (Twin::new(), World::new(5));
    let (parameters, curriculum) = (Parameters::default(), curriculum());
    let options = Options { mechanisms: Mechanisms::FULL, ..options(5, &parameters, &curriculum) };
    let (mut learner, mut store, _) = opened_as(&twin, options).unwrap();
    attach(&mut learner, &mut store).unwrap();
    for _ in 0..100 {
        let frame = world.frame();
        let taken = learner.step(&frame);
        let batch = store.append(&step(&frame, &taken), learner.memory().content()).unwrap();
        settled(&store, batch).unwrap();
        world.follow(&taken.output);
    }
    store.finish(learner.memory()).unwrap();
    twin
}
