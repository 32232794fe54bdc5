//! Lives in worlds of all kinds: what is told of each of their decisions adds up, in JSON as in text.

use std::collections::BTreeSet;

use pschema_inspect::{Candidate, Explanation, ExplanationQuery, Verdict, WhyNot, WhyNotQuery};
use pschema_learner::schema::SchemaId;
use pschema_server::inspect::Inspect;
use pschema_tools::kit::{explanation, notation, why_not};
use serde_json::Value;

use super::Life;
use pschema_worlds::Mix;

/// A decision and what is said of some schemas that it did not choose.
fn told(life: &Life) -> Option<(Explanation, Vec<WhyNot>)> {
    let view = life.view();
    let explained = ExplanationQuery { step: None, candidates_max: 1000 }.answer(&view).ok()?;
    let schemas = u32::try_from(life.world.schemas()).unwrap();
    let memory = life.world.learner().memory().content();
    let is_law = |id: &u32| memory.schema(SchemaId(*id)).is_some_and(|schema| schema.generalised().is_some());
    let some = (0..schemas).rev().step_by(1 + life.world.schemas() / 7);
    let others: BTreeSet<u32> = some.chain((0..schemas).filter(is_law).take(5)).collect();
    let others = others.into_iter();
    let why = others.map(|schema| {
        let why = WhyNotQuery { schema, step: None }.answer(&view);
        why.unwrap_or_else(|problem| panic!("schema {schema} of {schemas}: {problem}"))
    });
    Some((explained, why.collect()))
}

/// E, and the sum of the values over the distance, both as JSON has them.
fn adds_up(candidate: &Value) {
    let number = |value: &Value| value.as_f64().unwrap();
    let sum: f64 = candidate["terms"].as_array().unwrap().iter().map(|term| number(&term["value"])).sum();
    let (said, made) = (number(&candidate["excitation"]), sum / number(&candidate["distance"]));
    assert!((said - made).abs() <= 1e-12 * (1.0 + made.abs()) * 64.0, "{said} is not {made}: {candidate}");
    for term in candidate["terms"].as_array().unwrap().iter().filter(|term| !term["seen"].is_null()) {
        let [shared, probability, weight, attention, value] =
            ["shared", "probability", "weight", "attention", "value"].map(|field| number(&term[field]));
        let made = shared * probability * weight / (1.0 + attention);
        assert!((made - value).abs() <= 1e-12 * (1.0 + made), "{term}");
    }
}

/// The figures at the ends of the lines of a table of terms, and what is said below it.
fn in_text(text: &str, candidate: &Candidate) {
    let figures = |line: &str| -> Option<Vec<f64>> {
        let words: Vec<_> = line.split_whitespace().collect();
        let figure = |word: &&str| if *word == "-" { Some(0.0) } else { word.parse().ok() };
        words.get(words.len().checked_sub(5)?..)?.iter().map(figure).collect()
    };
    let below = text.lines().find(|line| line.starts_with("value = ")).unwrap();
    let words: Vec<_> = below.split_whitespace().collect();
    let after = |name: &str| -> f64 {
        let at = words.iter().rposition(|word| *word == name).unwrap();
        words[at + 1..].iter().find_map(|word| word.parse().ok()).unwrap()
    };
    let (sum, distance, excitation) = (after("sum"), after("distance"), after("E"));
    assert!((sum / distance - excitation).abs() <= 0.0005 + 0.0005 / distance + 1e-9, "{below}");
    let table: Vec<_> = text
        .lines()
        .skip_while(|line| !line.starts_with("TERM"))
        .skip(1)
        .take_while(|line| !line.is_empty())
        .filter_map(figures)
        .collect();
    assert_eq!(table.len(), candidate.terms.len(), "{text}");
    for row in &table {
        let [shared, probability, weight, attended, value] = row[..] else { panic!("{row:?}") };
        if shared > 0.0 {
            let made = shared * probability * weight / attended;
            // Each factor is rounded in its fourth decimal.
            let error = 0.0005 * (1.0 + shared * (probability + weight) / attended);
            assert!((made - value).abs() <= error + 1e-9, "{row:?}");
        }
    }
    let added: f64 = table.iter().filter_map(|row| row.last()).sum();
    assert!(text.contains("\nFigures are rounded"), "{text}");
    match text.split_once("as shown, the values add up to ") {
        Some((_, said)) => {
            let said = said.lines().next().unwrap();
            let number: f64 = said.trim_end_matches('.').parse().unwrap();
            assert!((number - added).abs() < 1e-6 && (number - sum).abs() > 1e-9, "{said} {added} {sum}");
        }
        None => assert!((added - sum).abs() < 1e-6, "{added} is not {sum}: {text}"),
    }
}

#[test]
fn every_excitation_is_the_sum_of_its_terms_over_its_distance_as_it_is_shown() {
    let (mut excited, mut stood_in) = (0, 0);
    for (mix, seed) in Mix::ALL.into_iter().flat_map(|mix| [(mix, 1), (mix, 2), (mix, 3)]) {
        let mut life = Life::begin(mix, seed).unwrap();
        for step in 0..700 {
            life.step();
            if step % 50 != 49 {
                continue;
            }
            let Some((explained, others)) = told(&life) else { continue };
            let shown = format!("{mix:?}, seed {seed}, step {step}");
            let value = serde_json::to_value(&explained).unwrap();
            value["candidates"].as_array().unwrap().iter().for_each(adds_up);
            let chosen = &explained.candidates[explained.chosen as usize];
            // A crowded table is wrapped beyond what a test can read.
            if chosen.terms.len() < 40 {
                in_text(&explanation(&explained), chosen);
            }
            for why in &others {
                if let Verdict::StoodInFor { by, .. } = why.verdict {
                    // What is selected instead is a concrete schema that says what to do right here.
                    let by = life.world.learner().memory().content().schema(SchemaId(by)).unwrap();
                    let pre = &by.concrete().unwrap().pre;
                    let content = life.world.learner().memory().content();
                    let seen = |text: &str| explained.world.iter().any(|one| notation(one) == text);
                    let texts = pre.iter().map(|id| {
                        pschema_learner::notation::observation(&content.vocabulary, content.observation(*id))
                    });
                    assert!(texts.clone().all(|text| seen(&text)), "{shown}: {why:?}");
                    stood_in += 1;
                }
                let value = serde_json::to_value(why).unwrap();
                [&value["candidate"], &value["chosen"]]
                    .into_iter()
                    .filter(|c| c.is_object())
                    .for_each(adds_up);
                assert!(why_not(why).contains(&format!("chema {}", why.schema)), "{shown}");
            }
            excited += explained.candidates.iter().filter(|candidate| !candidate.terms.is_empty()).count();
        }
    }
    assert!(excited > 100 && stood_in > 0, "only {excited} excitations and {stood_in} stand-ins were seen");
}
