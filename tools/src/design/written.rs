//! The table `[experiment]` as it is written, and everything that can be wrong with it.

use std::collections::BTreeMap;
use std::ops::Range;

use pschema_server::config::Mistake;
use serde::Deserialize;
use toml::Spanned;

use super::{BodyKind, Design, Earlier, FieldMap, Measure, Peak, Published, Quantity, Sweep, Variant};

const VARIANTS_MAX: usize = 64;
const MEASURES_MAX: usize = 64;
const PEAKS_MAX: usize = 26;
const SWEEP_MAX: usize = 64;

#[derive(Deserialize)]
pub(super) struct WrittenFile {
    name: String,
    #[serde(default)]
    stage: Vec<WrittenStage>,
    #[serde(default)]
    values: BTreeMap<String, f64>,
    pub(super) experiment: Option<Spanned<WrittenExperiment>>,
}

#[derive(Deserialize)]
struct WrittenStage {
    name: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenExperiment {
    title: String,
    world: String,
    #[serde(default)]
    body: BodyKind,
    pub(super) after: Option<Spanned<WrittenEarlier>>,
    #[serde(default = "a_minute")]
    seconds: u32,
    #[serde(default = "an_object")]
    object: String,
    published: Option<Published>,
    why: Option<String>,
    touching: Option<String>,
    figure_from: Option<Spanned<String>>,
    figure_to: Option<Spanned<String>>,
    #[serde(default)]
    peaks: BTreeMap<Spanned<String>, Spanned<WrittenPeak>>,
    map: Option<FieldMap>,
    #[serde(default)]
    measure: Vec<Spanned<WrittenMeasure>>,
    #[serde(default = "as_it_is")]
    base: String,
    #[serde(default)]
    pub(super) variant: Vec<Spanned<WrittenVariant>>,
    #[serde(default)]
    sweep: BTreeMap<Spanned<String>, Spanned<Vec<f64>>>,
}

/// `{ curriculum = "exp1-s1-narrow", body = "sim" }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenEarlier {
    curriculum: String,
    #[serde(default)]
    body: BodyKind,
}

fn a_minute() -> u32 {
    60
}

fn an_object() -> String {
    "object".to_owned()
}

fn as_it_is() -> String {
    "as it is".to_owned()
}

/// `"first touches"`, or `{ stage = "first touches", trial = 2 }`.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a peak is a stage, or { stage = \"NAME\", trial = N }")]
enum WrittenPeak {
    Stage(String),
    Trial { stage: String, trial: u32 },
}

/// `"probe"` or `["probe", "again"]`.
#[derive(Deserialize)]
#[serde(untagged, expecting = "stages are one name, or a list of names")]
enum WrittenStages {
    One(String),
    Several(Vec<String>),
}

impl WrittenStages {
    fn names(written: Option<&Spanned<Self>>) -> Vec<String> {
        match written.map(Spanned::get_ref) {
            None => Vec::new(),
            Some(Self::One(name)) => vec![name.clone()],
            Some(Self::Several(names)) => names.clone(),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenMeasure {
    name: String,
    of: Quantity,
    stage: Option<Spanned<WrittenStages>>,
    against: Option<Spanned<WrittenStages>>,
    pre: Option<String>,
    post: Option<String>,
    except_post: Option<String>,
    published: Option<String>,
    why: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WrittenVariant {
    name: String,
    #[serde(default)]
    learner: toml::Table,
    #[serde(default)]
    values: BTreeMap<String, f64>,
    curriculum: Option<String>,
    world: Option<String>,
    #[serde(default)]
    noise: BTreeMap<String, f64>,
}

/// The experiment that a file says, checked. `source` is what to call its curriculum; `beside` finds a file that it names.
pub(super) fn checked(
    source: &str,
    file: &WrittenFile,
    spanned: &Spanned<WrittenExperiment>,
    beside: &dyn Fn(&str) -> String,
) -> Result<Design, Mistake> {
    let written = spanned.get_ref();
    let whole = || spanned.span();
    if written.measure.len() > MEASURES_MAX || written.variant.len() > VARIANTS_MAX {
        let (measures, variants) = (written.measure.len(), written.variant.len());
        let limits = format!("at most {MEASURES_MAX} and {VARIANTS_MAX} are allowed");
        return Err(Mistake::new(whole(), format!("{measures} measures and {variants} variants: {limits}")));
    }
    let stages: Vec<String> = file.stage.iter().map(|stage| stage.name.clone()).collect();
    let end = |stage: &Option<Spanned<String>>| {
        let stage = stage.as_ref().map(|stage| known_stage(&stages, stage.get_ref(), stage.span()));
        stage.transpose()
    };
    let (figure_from, figure_to) = (end(&written.figure_from)?, end(&written.figure_to)?);
    let variants = written.variant.iter().map(|one| variant(one, beside)).collect::<Result<Vec<_>, _>>()?;
    for (at, one) in variants.iter().enumerate() {
        if one.name == written.base || variants.iter().take(at).any(|before| before.name == one.name) {
            let span = written.variant.get(at).map_or_else(whole, Spanned::span);
            return Err(Mistake::new(span, format!("two variants are named {:?}", one.name)));
        }
    }
    Ok(Design {
        name: file.name.clone(),
        curriculum: source.to_owned(),
        title: written.title.clone(),
        world: beside(&written.world),
        body: written.body,
        after: written.after.as_ref().map(|earlier| Earlier {
            curriculum: beside(&earlier.get_ref().curriculum),
            body: earlier.get_ref().body,
        }),
        seconds: written.seconds,
        object: written.object.clone(),
        published: written.published.clone(),
        why: written.why.clone(),
        touching: written.touching.clone(),
        figure_from,
        figure_to,
        peaks: peaks(&stages, &written.peaks, whole())?,
        map: written.map.clone(),
        measures: written.measure.iter().map(|one| measure(&stages, one)).collect::<Result<_, _>>()?,
        base: written.base.clone(),
        variants,
        sweep: sweep(file, &written.sweep)?,
        stages,
    })
}

fn known_stage(stages: &[String], name: &str, at: Range<usize>) -> Result<String, Mistake> {
    if stages.iter().any(|known| known == name) {
        return Ok(name.to_owned());
    }
    let known = stages.join(", ");
    Err(Mistake::new(at, format!("no stage is named {name:?}; there are: {known}")))
}

fn peaks(
    stages: &[String],
    written: &BTreeMap<Spanned<String>, Spanned<WrittenPeak>>,
    whole: Range<usize>,
) -> Result<Vec<Peak>, Mistake> {
    if written.len() > PEAKS_MAX {
        let problem = format!("{} peaks, at most {PEAKS_MAX} are allowed", written.len());
        return Err(Mistake::new(whole, problem));
    }
    let peak = |(label, peak): (&Spanned<String>, &Spanned<WrittenPeak>)| {
        let (stage, trial) = match peak.get_ref() {
            WrittenPeak::Stage(stage) => (stage, None),
            WrittenPeak::Trial { stage, trial } => (stage, Some(*trial)),
        };
        if trial == Some(0) {
            return Err(Mistake::new(peak.span(), "trials are counted from 1"));
        }
        let stage = known_stage(stages, stage, peak.span())?;
        Ok(Peak { label: label.get_ref().clone(), stage, trial })
    };
    written.iter().map(peak).collect()
}

fn measure(stages: &[String], spanned: &Spanned<WrittenMeasure>) -> Result<Measure, Mistake> {
    let written = spanned.get_ref();
    for list in [&written.stage, &written.against] {
        for name in WrittenStages::names(list.as_ref()) {
            let at = list.as_ref().map_or_else(|| spanned.span(), Spanned::span);
            known_stage(stages, &name, at)?;
        }
    }
    let about_schemas = written.pre.is_some() || written.post.is_some() || written.except_post.is_some();
    let wrong = |problem: &str| Err(Mistake::new(spanned.span(), format!("{:?}: {problem}", written.name)));
    match written.of {
        Quantity::Precision if written.against.is_none() || written.stage.is_none() => {
            wrong("precision needs `stage` and `against`: where the response is right and where it is wrong")
        }
        Quantity::Precision => Ok(()),
        _ if written.against.is_some() => wrong("`against` is for precision only"),
        Quantity::Schemas if written.stage.is_some() => wrong("schemas are counted at the end, not by stage"),
        Quantity::Schemas => Ok(()),
        _ if about_schemas => wrong("`pre`, `post` and `except_post` are for `of = \"schemas\"` only"),
        _ => Ok(()),
    }?;
    Ok(Measure {
        name: written.name.clone(),
        of: written.of,
        stages: WrittenStages::names(written.stage.as_ref()),
        against: WrittenStages::names(written.against.as_ref()),
        pre: written.pre.clone(),
        post: written.post.clone(),
        except_post: written.except_post.clone(),
        published: written.published.clone(),
        why: written.why.clone(),
    })
}

fn variant(spanned: &Spanned<WrittenVariant>, beside: &dyn Fn(&str) -> String) -> Result<Variant, Mistake> {
    let written = spanned.get_ref();
    let wrong = |problem: String| Err(Mistake::new(spanned.span(), problem));
    if written.name.trim().is_empty() {
        return wrong("a variant has an empty name".to_owned());
    }
    if let Some((name, value)) = written.noise.iter().find(|(_, value)| !value.is_finite()) {
        return wrong(format!("variant {:?}: noise {name} = {value} is no number", written.name));
    }
    let learner = written.learner.iter().map(|(name, value)| format!("learner.{name}={value}"));
    let values = written.values.iter().map(|(name, value)| format!("values.{name}={value:?}"));
    Ok(Variant {
        name: written.name.clone(),
        settings: learner.chain(values).collect(),
        curriculum: written.curriculum.as_deref().map(beside),
        world: written.world.as_deref().map(beside),
        noise: written.noise.iter().map(|(name, value)| (name.clone(), *value)).collect(),
    })
}

fn sweep(
    file: &WrittenFile,
    written: &BTreeMap<Spanned<String>, Spanned<Vec<f64>>>,
) -> Result<Option<Sweep>, Mistake> {
    let mut all = written.iter();
    let Some((name, values)) = all.next() else { return Ok(None) };
    if let Some((second, _)) = all.next() {
        return Err(Mistake::new(second.span(), "one value is swept at a time"));
    }
    if !file.values.contains_key(name.get_ref()) {
        let known: Vec<_> = file.values.keys().map(String::as_str).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        let problem = format!("[values] has no {:?}; there are: {known}", name.get_ref());
        return Err(Mistake::new(name.span(), problem));
    }
    let list = values.get_ref();
    if list.is_empty() || list.len() > SWEEP_MAX || list.iter().any(|value| !value.is_finite()) {
        let problem = format!("give 1 to {SWEEP_MAX} numbers, each finite");
        return Err(Mistake::new(values.span(), problem));
    }
    Ok(Some(Sweep { name: name.get_ref().clone(), values: list.clone() }))
}
