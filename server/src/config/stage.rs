//! One stage of a curriculum, as written and checked.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;

use pschema_learner::curriculum::{
    Absence, Argument, Habituation, Lift, NamedObservation, Pool, Saturation, SceneCommand, Stage,
    UTTERANCES_MAX, Utterance,
};
use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use toml::Spanned;

use super::source::Mistake;
use super::until;
use crate::session::no_word;
use crate::translate::{HEARING, HEARING_TEXT, listed};

const ARRANGE_MAX: usize = 64;
const TRIALS_MAX: u32 = 1_000_000;
const WORDS_MAX: usize = 64;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct WrittenStage {
    pub(super) name: Spanned<String>,
    lift: WrittenLift,
    #[serde(default = "yes")]
    learning: bool,
    trials: Option<Spanned<u32>>,
    #[serde(default)]
    arrange: Vec<WrittenCommand>,
    until: Option<Spanned<String>>,
    until_absent: Option<WrittenAbsence>,
    trial_actions_max: Option<Spanned<u32>>,
    #[serde(default)]
    say: Vec<WrittenUtterance>,
    saturation: Option<WrittenSaturation>,
    habituation: Option<WrittenHabituation>,
}

/// A command and its arguments: a table of one key.
type WrittenCommand = BTreeMap<Spanned<String>, WrittenArguments>;
type WrittenArguments = BTreeMap<Spanned<String>, WrittenArgument>;

fn yes() -> bool {
    true
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { observation = \"touch{}\", actions = 5 }")]
struct WrittenAbsence {
    observation: Spanned<String>,
    actions: Spanned<u32>,
}

/// `{ words = ["touch"], when = "touch{}", probability = "1 - noise", times = 1 }`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { words = [\"touch\"], when = \"touch{}\" }")]
struct WrittenUtterance {
    words: Spanned<Vec<Spanned<String>>>,
    when: Option<Spanned<String>>,
    unless: Option<Spanned<String>>,
    probability: Option<Spanned<WrittenProbability>>,
    times: Option<Spanned<u32>>,
}

/// A number, the name of one of the curriculum's `[values]`, or `1 - NAME`.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a number, the name of one of the [values], or \"1 - NAME\"")]
enum WrittenProbability {
    Number(f64),
    Named(String),
}

/// A whole number, or the name of one of the curriculum's `[values]`.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a whole number, or the name of one of the [values]")]
enum WrittenCount {
    Number(u32),
    Named(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { excitation_below = 0.2, actions = 10 }")]
struct WrittenSaturation {
    excitation_below: Spanned<f64>,
    actions: Spanned<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { executions_min = 10 }")]
struct WrittenHabituation {
    executions_min: Spanned<WrittenCount>,
    interval_max: Option<Spanned<f64>>,
}

/// `"all"`, or a list of names.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected \"all\" or a list of observation types")]
enum WrittenLift {
    All(AllTypes),
    Types(Vec<String>),
}

/// The word `all`.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum AllTypes {
    All,
}

/// `4`, `"blue-block"` or `{ draw = "table" }`.
enum WrittenArgument {
    Integer(i64),
    Symbol(String),
    Draw(Spanned<String>),
}

/// Checks one stage, and adds what its trials draw to `drawn`.
pub(super) fn checked_stage<'a>(
    spanned: &'a Spanned<WrittenStage>,
    pools: &[Pool],
    values: &BTreeMap<String, f64>,
    drawn: &mut BTreeMap<&'a str, u64>,
) -> Result<Stage, Mistake> {
    let stage = spanned.get_ref();
    let name = stage.name.get_ref();
    let here = || stage.name.span();
    if name.trim().is_empty() {
        return Err(Mistake::new(here(), "the stage has an empty name"));
    }
    if let WrittenLift::Types(types) = &stage.lift
        && types.is_empty()
    {
        return Err(Mistake::new(here(), format!("stage {name:?} lifts no sense: it could learn nothing")));
    }
    let trials = trials(stage)?;
    let (trial_actions_max, _) = number(&stage.trial_actions_max, 0);
    let ended = stage.until.is_some() || stage.until_absent.is_some() || trial_actions_max > 0;
    if trials > 0 && !ended && stage.saturation.is_none() {
        let problem = format!(
            "the trials of stage {name:?} never end: give `until`, `until_absent`, `trial_actions_max` or `saturation`"
        );
        return Err(Mistake::new(here(), problem));
    }
    let until = stage.until.as_ref().map(observation).transpose()?;
    if !stage.say.is_empty() && trials == 0 {
        let problem = "what is said in `say` belongs to trials: give `trials`, at least 1";
        return Err(Mistake::new(here(), problem));
    }
    if stage.say.len() > UTTERANCES_MAX {
        let problem = format!("{} entries in `say`, at most {UTTERANCES_MAX} are allowed", stage.say.len());
        return Err(Mistake::new(here(), problem));
    }
    let arrange = arrange(stage)?;
    for pool_name in draws(stage) {
        draw(pool_name, pools, u64::from(trials), drawn)?;
    }
    Ok(Stage {
        name: name.clone(),
        lift: match &stage.lift {
            WrittenLift::All(AllTypes::All) => Lift::All,
            WrittenLift::Types(types) => Lift::Types(types.clone()),
        },
        learning: stage.learning,
        trials,
        arrange,
        until,
        until_absent: stage.until_absent.as_ref().map(absence).transpose()?,
        trial_actions_max,
        saturation: stage.saturation.as_ref().map(saturation).transpose()?,
        habituation: stage.habituation.as_ref().map(|written| habituation(written, values)).transpose()?,
        say: stage.say.iter().map(|written| utterance(written, values)).collect::<Result<_, _>>()?,
    })
}

/// A number that may be left out, with its place.
fn number<T: Copy>(written: &Option<Spanned<T>>, without: T) -> (T, Range<usize>) {
    written.as_ref().map_or((without, 0..0), |written| (*written.get_ref(), written.span()))
}

fn observation(text: &Spanned<String>) -> Result<NamedObservation, Mistake> {
    until::parse(text.get_ref()).map_err(|problem| Mistake::new(text.span(), problem))
}

fn absence(written: &WrittenAbsence) -> Result<Absence, Mistake> {
    let actions = *written.actions.get_ref();
    if actions == 0 {
        return Err(Mistake::new(written.actions.span(), "nothing is absent for 0 actions: give at least 1"));
    }
    Ok(Absence { observation: observation(&written.observation)?, actions })
}

fn utterance(written: &WrittenUtterance, values: &BTreeMap<String, f64>) -> Result<Utterance, Mistake> {
    let words = written.words.get_ref();
    if words.is_empty() || words.len() > WORDS_MAX {
        let problem = format!("give 1 to {WORDS_MAX} words, of which one is said");
        return Err(Mistake::new(written.words.span(), problem));
    }
    let (times_max, at) = number(&written.times, 1);
    if times_max == 0 {
        return Err(Mistake::new(at, "what is said 0 times is never said: give at least 1"));
    }
    Ok(Utterance {
        heard: words.iter().map(word).collect::<Result<_, _>>()?,
        when: written.when.as_ref().map(observation).transpose()?,
        unless: written.unless.as_ref().map(observation).transpose()?,
        probability: written.probability.as_ref().map_or(Ok(1.0), |written| probability(written, values))?,
        times_max,
    })
}

fn word(word: &Spanned<String>) -> Result<NamedObservation, Mistake> {
    let text = word.get_ref();
    if let Some(problem) = no_word(text) {
        return Err(Mistake::new(word.span(), problem));
    }
    let properties = vec![(HEARING_TEXT.to_owned(), Argument::Symbol(text.clone()))];
    Ok(NamedObservation { kind: HEARING.to_owned(), properties })
}

/// The curriculum's value of this name; the mistake is at `at`.
fn named_value(name: &str, at: Range<usize>, values: &BTreeMap<String, f64>) -> Result<f64, Mistake> {
    values.get(name).copied().ok_or_else(|| {
        let known = listed(values.keys().map(String::as_str));
        Mistake::new(at, format!("{name:?} is none of the curriculum's [values]; there are: {known}"))
    })
}

fn probability(
    written: &Spanned<WrittenProbability>,
    values: &BTreeMap<String, f64>,
) -> Result<f64, Mistake> {
    let probability = match written.get_ref() {
        WrittenProbability::Number(number) => *number,
        WrittenProbability::Named(text) => {
            let rest = text.trim();
            let (complement, name) = match rest.strip_prefix("1 -") {
                Some(name) => (true, name.trim()),
                None => (false, rest),
            };
            let value = named_value(name, written.span(), values)?;
            if complement { 1.0 - value } else { value }
        }
    };
    if !(0.0..=1.0).contains(&probability) {
        let problem = format!("a probability of {probability} is outside 0..=1");
        return Err(Mistake::new(written.span(), problem));
    }
    Ok(probability)
}

fn trials(stage: &WrittenStage) -> Result<u32, Mistake> {
    let (trials, at) = number(&stage.trials, 0);
    if trials > TRIALS_MAX {
        return Err(Mistake::new(at, format!("{trials} trials, at most {TRIALS_MAX} are allowed")));
    }
    let per_trial = stage.until.as_ref().map(Spanned::span);
    let per_trial = per_trial.or(stage.until_absent.as_ref().map(|absence| absence.observation.span()));
    let per_trial = per_trial.or(stage.trial_actions_max.as_ref().map(Spanned::span));
    let at = per_trial.or(if stage.arrange.is_empty() { None } else { Some(stage.name.span()) });
    match at {
        Some(at) if trials == 0 => Err(Mistake::new(
            at,
            "`arrange`, `until`, `until_absent` and `trial_actions_max` are about trials: give `trials`, at least 1",
        )),
        _ => Ok(trials),
    }
}

fn arrange(stage: &WrittenStage) -> Result<Vec<SceneCommand>, Mistake> {
    let one = |written: &WrittenCommand| {
        let mut commands = written.iter();
        let (Some((command, arguments)), None) = (commands.next(), commands.next()) else {
            let problem =
                "each entry of `arrange` is one command, such as `{ place = { object = \"blue-block\" } }`";
            return Err(Mistake::new(stage.name.span(), problem));
        };
        let arguments = arguments.iter().map(|(name, value)| {
            let value = match value {
                WrittenArgument::Integer(number) => Argument::Integer(*number),
                WrittenArgument::Symbol(symbol) => Argument::Symbol(symbol.clone()),
                WrittenArgument::Draw(pool) => Argument::Draw(pool.get_ref().clone()),
            };
            (name.get_ref().clone(), value)
        });
        Ok(SceneCommand { command: command.get_ref().clone(), arguments: arguments.collect() })
    };
    if stage.arrange.len() > ARRANGE_MAX {
        let problem =
            format!("{} commands in `arrange`, at most {ARRANGE_MAX} are allowed", stage.arrange.len());
        return Err(Mistake::new(stage.name.span(), problem));
    }
    stage.arrange.iter().map(one).collect()
}

fn draws(stage: &WrittenStage) -> impl Iterator<Item = &Spanned<String>> {
    let arguments = stage.arrange.iter().flat_map(BTreeMap::values).flat_map(BTreeMap::values);
    arguments.filter_map(|argument| match argument {
        WrittenArgument::Draw(pool) => Some(pool),
        _ => None,
    })
}

/// Counts that `pool_name` is drawn from once a trial: there must be enough numbers for the whole curriculum.
fn draw<'a>(
    pool_name: &'a Spanned<String>,
    pools: &[Pool],
    trials: u64,
    drawn: &mut BTreeMap<&'a str, u64>,
) -> Result<(), Mistake> {
    let name = pool_name.get_ref().as_str();
    let Some(pool) = pools.iter().find(|pool| pool.name == name) else {
        let known = listed(pools.iter().map(|pool| pool.name.as_str()));
        return Err(Mistake::new(pool_name.span(), format!("no pool is named {name:?}; there are: {known}")));
    };
    let holds = pool.to.abs_diff(pool.from).saturating_add(1);
    let needed = drawn.entry(name).or_default();
    *needed = needed.saturating_add(trials);
    if *needed > holds {
        let problem = format!("pool {name} holds {holds} numbers, but the stages up to here draw {needed}");
        return Err(Mistake::new(pool_name.span(), problem));
    }
    Ok(())
}

fn saturation(written: &WrittenSaturation) -> Result<Saturation, Mistake> {
    let excitation_below = *written.excitation_below.get_ref();
    if !(excitation_below.is_finite() && excitation_below > 0.0) {
        let problem = format!("{excitation_below} is no excitation to be below of: give a number above 0");
        return Err(Mistake::new(written.excitation_below.span(), problem));
    }
    let actions = *written.actions.get_ref();
    if actions == 0 {
        return Err(Mistake::new(
            written.actions.span(),
            "0 actions would saturate before the first: give at least 1",
        ));
    }
    Ok(Saturation { excitation_below, actions })
}

fn habituation(written: &WrittenHabituation, values: &BTreeMap<String, f64>) -> Result<Habituation, Mistake> {
    let executions_min = match written.executions_min.get_ref() {
        WrittenCount::Number(number) => *number,
        WrittenCount::Named(name) => {
            let value = named_value(name, written.executions_min.span(), values)?;
            if value.fract() != 0.0 || !(0.0..=f64::from(u32::MAX)).contains(&value) {
                let problem = format!("{name} = {value} is no number of executions: give a whole number");
                return Err(Mistake::new(written.executions_min.span(), problem));
            }
            // Whole and within range, as was just seen.
            value as u32
        }
    };
    let (interval_max, at) = number(&written.interval_max, 0.0);
    if !(0.0..=1.0).contains(&interval_max) {
        return Err(Mistake::new(at, format!("interval_max = {interval_max} is outside 0..=1")));
    }
    Ok(Habituation { executions_min, interval_max })
}

impl<'de> Deserialize<'de> for WrittenArgument {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = WrittenArgument;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("a whole number, a symbol, or { draw = \"POOL\" }")
            }

            fn visit_i64<E: de::Error>(self, number: i64) -> Result<WrittenArgument, E> {
                Ok(WrittenArgument::Integer(number))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<WrittenArgument, E> {
                Ok(WrittenArgument::Symbol(text.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<WrittenArgument, A::Error> {
                let key: Option<String> = map.next_key()?;
                if key.as_deref() != Some("draw") {
                    return Err(de::Error::invalid_value(de::Unexpected::Map, &self));
                }
                let pool = map.next_value()?;
                match map.next_key::<String>()? {
                    None => Ok(WrittenArgument::Draw(pool)),
                    Some(_) => Err(de::Error::invalid_value(de::Unexpected::Map, &self)),
                }
            }
        }
        from.deserialize_any(Reader)
    }
}
