//! Everything that can be wrong with the table `[experiment]` although it reads well.

use std::collections::BTreeMap;
use std::ops::Range;

use pschema_server::config::{Mistake, lesson};

use super::place::Places;
use super::table::{Design, Measure, Quantity, Variant};

const VARIANTS_MAX: usize = 64;
const MEASURES_MAX: usize = 64;
const PEAKS_MAX: usize = 26;
const SWEEP_MAX: usize = 64;

/// Checks a design that was read from `text`; `values` are those of its curriculum.
pub(super) fn check(design: &Design, values: &BTreeMap<String, f64>, text: &str) -> Result<(), Mistake> {
    let places = Places::of(text);
    let at = |way: &[&str]| places.value(&[&["experiment"], way].concat());
    let (measures, variants) = (design.measures.len(), design.variants.len());
    if measures > MEASURES_MAX || variants > VARIANTS_MAX {
        let limits = format!("at most {MEASURES_MAX} and {VARIANTS_MAX} are allowed");
        return Err(Mistake::new(at(&[]), format!("{measures} measures and {variants} variants: {limits}")));
    }
    for (key, stage) in [("figure_from", &design.figure_from), ("figure_to", &design.figure_to)] {
        stage.iter().try_for_each(|stage| known_stage(design, stage, at(&[key])))?;
    }
    for (number, variant) in design.variants.iter().enumerate() {
        let problem = variant_problem(design, variant, number);
        problem
            .map_or(Ok(()), |problem| Err(Mistake::new(at(&["variant", &number.to_string()]), problem)))?;
    }
    if design.peaks.len() > PEAKS_MAX {
        let problem = format!("{} peaks, at most {PEAKS_MAX} are allowed", design.peaks.len());
        return Err(Mistake::new(at(&[]), problem));
    }
    for peak in &design.peaks {
        let place = at(&["peaks", &peak.label]);
        if peak.trial == Some(0) {
            return Err(Mistake::new(place, "trials are counted from 1"));
        }
        known_stage(design, &peak.stage, place)?;
    }
    for (number, measure) in design.measures.iter().enumerate() {
        let number = number.to_string();
        for (key, names) in [("stage", &measure.stages), ("against", &measure.against)] {
            names.iter().try_for_each(|name| known_stage(design, name, at(&["measure", &number, key])))?;
        }
        if let Some(problem) = measure_problem(design, measure) {
            return Err(Mistake::new(at(&["measure", &number]), format!("{:?}: {problem}", measure.name)));
        }
    }
    if design.map.as_ref().is_some_and(|map| map.reached.is_none()) && design.touching.is_none() {
        let problem = "a map needs `reached`, or `touching` beside it: the observation type that says so";
        return Err(Mistake::new(at(&["map"]), problem));
    }
    swept(design, values, &places)?;
    let lesson = |curriculum: &str, settings: &[String], place: Range<usize>| {
        let known = lesson(curriculum, Default::default(), settings);
        known.map(drop).map_err(|error| Mistake::new(place, error.to_string()))
    };
    if let Some(earlier) = &design.after {
        lesson(&earlier.curriculum, &[], at(&["after"]))?;
    }
    for (number, variant) in design.variants.iter().enumerate() {
        let curriculum = variant.curriculum.as_ref().unwrap_or(&design.curriculum);
        lesson(curriculum, &variant.settings(), at(&["variant", &number.to_string()]))?;
    }
    Ok(())
}

fn known_stage(design: &Design, name: &str, place: Range<usize>) -> Result<(), Mistake> {
    if design.stages.iter().any(|known| known == name) {
        return Ok(());
    }
    let known = design.stages.join(", ");
    Err(Mistake::new(place, format!("no stage is named {name:?}; there are: {known}")))
}

fn measure_problem(design: &Design, measure: &Measure) -> Option<&'static str> {
    let about_schemas = measure.pre.is_some() || measure.post.is_some() || measure.except_post.is_some();
    match measure.of {
        Quantity::Precision if measure.against.is_empty() || measure.stages.is_empty() => {
            Some("precision needs `stage` and `against`: where the response is right and where it is wrong")
        }
        Quantity::Precision => None,
        _ if !measure.against.is_empty() => Some("`against` is for precision only"),
        Quantity::ValueSum | Quantity::ValueMean if measure.value.is_none() => {
            Some("value_sum and value_mean need `value`: the observation type whose numbers are added up")
        }
        Quantity::ValueSum | Quantity::ValueMean if about_schemas => {
            Some("`pre`, `post` and `except_post` are for `of = \"schemas\"` only")
        }
        Quantity::ValueSum | Quantity::ValueMean => None,
        _ if measure.value.is_some() => Some("`value` is for value_sum and value_mean only"),
        Quantity::TouchingShare if design.touching.is_none() => {
            Some("touching_share needs `touching`: the observation type whose prediction is meant")
        }
        Quantity::Schemas if !measure.stages.is_empty() => {
            Some("schemas are counted at the end, not by stage")
        }
        Quantity::Schemas => None,
        _ if about_schemas => Some("`pre`, `post` and `except_post` are for `of = \"schemas\"` only"),
        _ => None,
    }
}

fn variant_problem(design: &Design, variant: &Variant, number: usize) -> Option<String> {
    let name = &variant.name;
    if name.trim().is_empty() {
        return Some("a variant has an empty name".to_owned());
    }
    if let Some((noise, value)) = variant.noise.iter().find(|(_, value)| !value.is_finite()) {
        return Some(format!("variant {name:?}: noise {noise} = {value} is no number"));
    }
    let is_taken =
        *name == design.base || design.variants.iter().take(number).any(|before| before.name == *name);
    is_taken.then(|| format!("two variants are named {name:?}"))
}

fn swept(design: &Design, values: &BTreeMap<String, f64>, places: &Places<'_>) -> Result<(), Mistake> {
    let mut sweeps = design.sweep.iter();
    let Some((name, list)) = sweeps.next() else { return Ok(()) };
    if let Some((second, _)) = sweeps.next() {
        let place = places.key(&["experiment", "sweep", second]);
        return Err(Mistake::new(place, "one value is swept at a time"));
    }
    let way = ["experiment", "sweep", name];
    if !values.contains_key(name) {
        let known: Vec<_> = values.keys().map(String::as_str).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        return Err(Mistake::new(places.key(&way), format!("[values] has no {name:?}; there are: {known}")));
    }
    if list.is_empty() || list.len() > SWEEP_MAX || list.iter().any(|value| !value.is_finite()) {
        return Err(Mistake::new(places.value(&way), format!("give 1 to {SWEEP_MAX} numbers, each finite")));
    }
    Ok(())
}
