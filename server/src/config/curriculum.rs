//! Curricula: developmental stages (paper, II-F) as a TOML file, or one of those built in.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use pschema_learner::curriculum::{
    Afterwards, Argument, Curriculum, Habituation, Lift, POOL_NUMBERS_MAX, Pool, Saturation, SceneCommand,
    Stage,
};
use pschema_learner::parameters::Parameters;
use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use toml::Spanned;

use super::learner::{Written as WrittenLearner, take_over};
use super::{ConfigError, Mistake, Source, read, until};

/// The curricula that come with the daemon: names and texts.
pub const BUILT_IN: [(&str, &str); 4] = [
    ("free", include_str!("../../curricula/free.toml")),
    ("exp1-s1", include_str!("../../curricula/exp1-s1.toml")),
    ("exp1-s1-narrow", include_str!("../../curricula/exp1-s1-narrow.toml")),
    ("exp1-s2", include_str!("../../curricula/exp1-s2.toml")),
];

const STAGES_MAX: usize = 256;
const POOLS_MAX: usize = 64;
const ARRANGE_MAX: usize = 64;
const TRIALS_MAX: u32 = 1_000_000;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenCurriculum {
    name: String,
    #[serde(default)]
    pools: BTreeMap<Spanned<String>, WrittenPool>,
    #[serde(default)]
    stage: Vec<Spanned<WrittenStage>>,
    afterwards: WrittenAfterwards,
    /// Parameters that the curriculum is about, such as generalisation switched off.
    #[serde(default)]
    learner: WrittenLearner,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WrittenAfterwards {
    Continue,
    Hold,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenPool {
    from: i64,
    to: i64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenStage {
    name: Spanned<String>,
    lift: WrittenLift,
    #[serde(default = "yes")]
    learning: bool,
    trials: Option<Spanned<u32>>,
    #[serde(default)]
    arrange: Vec<WrittenCommand>,
    until: Option<Spanned<String>>,
    trial_actions_max: Option<Spanned<u32>>,
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
#[serde(deny_unknown_fields)]
struct WrittenSaturation {
    excitation_below: Spanned<f64>,
    actions: Spanned<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenHabituation {
    executions_min: u32,
    interval_max: Option<Spanned<f64>>,
}

/// `"all"`, or a list of names.
enum WrittenLift {
    All,
    Types(Vec<String>),
}

/// `4`, `"blue-block"` or `{ draw = "table" }`.
enum WrittenArgument {
    Integer(i64),
    Symbol(String),
    Draw(Spanned<String>),
}

/// The curriculum built in under `name`, or in the file of that name.
///
/// # Errors
/// When there is neither, or what is wrong in it and where.
pub fn curriculum(name: &str) -> Result<Curriculum, ConfigError> {
    lesson(name, Parameters::default()).map(|(curriculum, _)| curriculum)
}

/// The curriculum, and `parameters` with those changed that it sets itself in its table `[learner]`.
///
/// # Errors
/// As [`curriculum`].
pub fn lesson(name: &str, parameters: Parameters) -> Result<(Curriculum, Parameters), ConfigError> {
    if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
        return parse(Source { name: &format!("built-in curriculum {name}"), text }, parameters);
    }
    let path = Path::new(name);
    if !path.is_file() {
        let built_in = BUILT_IN.map(|(known, _)| known).join(", ");
        return Err(ConfigError::NoCurriculum { name: name.to_owned(), built_in });
    }
    let text = read(path)?;
    parse(Source { name, text: &text }, parameters)
}

fn parse(source: Source<'_>, mut parameters: Parameters) -> Result<(Curriculum, Parameters), ConfigError> {
    let written: WrittenCurriculum = source.parse()?;
    let curriculum = checked(&written).map_err(|mistake| source.wrong(mistake))?;
    // What the learner asks beyond the checks above has no place in the text that could be named.
    curriculum.check().map_err(|error| source.wrong(Mistake::new(0..0, error.to_string())))?;
    take_over(source, written.learner, &mut parameters)?;
    Ok((curriculum, parameters))
}

fn checked(written: &WrittenCurriculum) -> Result<Curriculum, Mistake> {
    let whole = 0..0;
    if written.name.trim().is_empty() {
        return Err(Mistake::new(whole, "the curriculum has an empty name"));
    }
    if written.stage.is_empty() {
        return Err(Mistake::new(whole, "the curriculum has no stages: add at least one [[stage]]"));
    }
    if written.stage.len() > STAGES_MAX || written.pools.len() > POOLS_MAX {
        let (stages, pools) = (written.stage.len(), written.pools.len());
        let limits = format!("at most {STAGES_MAX} and {POOLS_MAX} are allowed");
        return Err(Mistake::new(whole, format!("{stages} stages and {pools} pools: {limits}")));
    }
    let pools =
        written.pools.iter().map(|(name, pool)| checked_pool(name, pool)).collect::<Result<Vec<_>, _>>()?;
    let mut stages: Vec<Stage> = Vec::with_capacity(written.stage.len());
    let mut drawn: BTreeMap<&str, u64> = BTreeMap::new();
    for stage in &written.stage {
        let name = &stage.get_ref().name;
        if stages.iter().any(|known| known.name == *name.get_ref()) {
            return Err(Mistake::new(name.span(), format!("a second stage is named {:?}", name.get_ref())));
        }
        stages.push(checked_stage(stage, &pools, &mut drawn)?);
    }
    let afterwards = match written.afterwards {
        WrittenAfterwards::Continue => Afterwards::Continue,
        WrittenAfterwards::Hold => Afterwards::Hold,
    };
    Ok(Curriculum { name: written.name.clone(), pools, stages, afterwards })
}

fn checked_pool(name: &Spanned<String>, pool: &WrittenPool) -> Result<Pool, Mistake> {
    let WrittenPool { from, to } = *pool;
    let name_text = name.get_ref();
    let wrong = |problem| Err(Mistake::new(name.span(), format!("pool {name_text}: {problem}")));
    if from > to {
        return wrong(format!("it is empty, for {from} is above {to}"));
    }
    if to.saturating_sub(from) >= POOL_NUMBERS_MAX {
        return wrong(format!("{from} to {to} are more than {POOL_NUMBERS_MAX} numbers"));
    }
    Ok(Pool { name: name_text.clone(), from, to })
}

/// Checks one stage, and adds what its trials draw to `drawn`.
fn checked_stage<'a>(
    spanned: &'a Spanned<WrittenStage>,
    pools: &[Pool],
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
    let trial_actions_max = stage.trial_actions_max.as_ref().map_or(0, |max| *max.get_ref());
    if trials > 0 && stage.until.is_none() && trial_actions_max == 0 && stage.saturation.is_none() {
        let problem = format!(
            "the trials of stage {name:?} never end: give `until`, `trial_actions_max` or `saturation`"
        );
        return Err(Mistake::new(here(), problem));
    }
    let until = match &stage.until {
        None => None,
        Some(text) => {
            Some(until::parse(text.get_ref()).map_err(|problem| Mistake::new(text.span(), problem))?)
        }
    };
    let arrange = arrange(stage)?;
    for pool_name in draws(stage) {
        draw(pool_name, pools, u64::from(trials), drawn)?;
    }
    Ok(Stage {
        name: name.clone(),
        lift: match &stage.lift {
            WrittenLift::All => Lift::All,
            WrittenLift::Types(types) => Lift::Types(types.clone()),
        },
        learning: stage.learning,
        trials,
        arrange,
        until,
        trial_actions_max,
        saturation: stage.saturation.as_ref().map(saturation).transpose()?,
        habituation: stage.habituation.as_ref().map(habituation).transpose()?,
    })
}

fn trials(stage: &WrittenStage) -> Result<u32, Mistake> {
    let trials = stage.trials.as_ref().map_or(0, |trials| *trials.get_ref());
    if trials > TRIALS_MAX {
        let at = stage.trials.as_ref().map_or(0..0, Spanned::span);
        return Err(Mistake::new(at, format!("{trials} trials, at most {TRIALS_MAX} are allowed")));
    }
    let per_trial =
        stage.until.as_ref().map(Spanned::span).or(stage.trial_actions_max.as_ref().map(Spanned::span));
    let at = per_trial.or(if stage.arrange.is_empty() { None } else { Some(stage.name.span()) });
    match at {
        Some(at) if trials == 0 => Err(Mistake::new(
            at,
            "`arrange`, `until` and `trial_actions_max` are about trials: give `trials`, at least 1",
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
        let known: Vec<_> = pools.iter().map(|pool| pool.name.as_str()).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
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

fn habituation(written: &WrittenHabituation) -> Result<Habituation, Mistake> {
    let interval_max = written.interval_max.as_ref().map_or(0.0, |interval| *interval.get_ref());
    if !(0.0..=1.0).contains(&interval_max) {
        let at = written.interval_max.as_ref().map_or(0..0, Spanned::span);
        return Err(Mistake::new(at, format!("interval_max = {interval_max} is outside 0..=1")));
    }
    Ok(Habituation { executions_min: written.executions_min, interval_max })
}

impl<'de> Deserialize<'de> for WrittenLift {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = WrittenLift;

            fn expecting(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
                to.write_str("\"all\" or a list of observation types")
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<WrittenLift, E> {
                if text == "all" {
                    Ok(WrittenLift::All)
                } else {
                    Err(E::invalid_value(de::Unexpected::Str(text), &self))
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<WrittenLift, A::Error> {
                let mut types = Vec::new();
                while let Some(name) = list.next_element()? {
                    types.push(name);
                }
                Ok(WrittenLift::Types(types))
            }
        }
        from.deserialize_any(Reader)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Curriculum, String> {
        let parsed = parse(Source { name: "c.toml", text }, Parameters::default());
        parsed.map(|(curriculum, _)| curriculum).map_err(|error| error.to_string())
    }

    #[test]
    fn every_built_in_curriculum_is_sound_and_named_as_it_is_called() {
        for (name, _) in BUILT_IN {
            assert_eq!(curriculum(name).unwrap().name, name);
        }
    }

    #[test]
    fn the_first_scenario_is_the_papers() {
        let one = curriculum("exp1-s1").unwrap();
        assert_eq!(one.afterwards, Afterwards::Hold);
        let names: Vec<_> = one.stages.iter().map(|stage| stage.name.as_str()).collect();
        assert_eq!(names, ["motor babbling", "first touches", "a new place", "out of reach", "probe"]);
        assert_eq!(one.stages[0].lift, Lift::Types(vec!["finger".to_owned()]));
        let touches = &one.stages[1];
        assert_eq!((touches.trials, touches.trial_actions_max, touches.learning), (2, 20, true));
        let place = &touches.arrange[0];
        assert_eq!(place.command, "place");
        let position = ("position".to_owned(), Argument::Draw("table".to_owned()));
        assert!(place.arguments.contains(&position), "{place:?}");
        let probe = &one.stages[4];
        assert_eq!((probe.trials, probe.learning), (97, false));
        assert_eq!(probe.until.as_ref().map(|until| until.kind.as_str()), Some("touch"));
    }

    #[test]
    fn a_name_that_is_neither_built_in_nor_a_file_is_answered_with_those_there_are() {
        let error = curriculum("exp9").unwrap_err().to_string();
        assert!(error.contains("exp1-s1") && error.contains("free"), "{error}");
    }

    #[test]
    fn mistakes_are_located() {
        let head = "name = \"c\"\nafterwards = \"hold\"\npools = { table = { from = 0, to = 2 } }\n";
        let stage = "[[stage]]\nname = \"one\"\nlift = \"all\"\n";
        let cases = [
            ("name = \"c\"\nafterwards = \"hold\"\n".to_owned(), "c.toml:1:1:", "no stages"),
            (format!("{head}{stage}surprise = 1\n"), "c.toml:7:1:", "unknown field `surprise`"),
            (format!("{head}{stage}until = \"touch\"\ntrials = 1\n"), "c.toml:7:9:", "such as `touch{}`"),
            (format!("{head}{stage}until = \"touch{{}}\"\n"), "c.toml:7:9:", "give `trials`"),
            (format!("{head}{stage}trials = 1\n"), "c.toml:5:8:", "never end"),
            (format!("{head}{stage}{stage}"), "c.toml:8:8:", "second stage"),
            (
                format!(
                    "{head}{stage}trials = 1\nuntil = \"touch{{}}\"\narrange = [{{ place = {{ at = {{ draw = \"floor\" }} }} }}]\n"
                ),
                "c.toml:9:38:",
                "there are: table",
            ),
            (
                format!(
                    "{head}{stage}trials = 4\nuntil = \"touch{{}}\"\narrange = [{{ place = {{ at = {{ draw = \"table\" }} }} }}]\n"
                ),
                "c.toml:9:38:",
                "holds 3 numbers, but the stages up to here draw 4",
            ),
            (
                format!("{head}{stage}saturation = {{ excitation_below = -1.0, actions = 5 }}\n"),
                "c.toml:7:35:",
                "above 0",
            ),
            (format!("{head}{stage}saturation = {{ actions = 0 }}\n"), "c.toml:7:14:", "excitation_below"),
            (
                format!("{head}[[stage]]\nname = \"one\"\nlift = \"most\"\n"),
                "c.toml:6:8:",
                "\"all\" or a list",
            ),
            (format!("{head}[[stage]]\nname = \"one\"\nlift = []\n"), "c.toml:5:8:", "lifts no sense"),
            (
                format!(
                    "name = \"c\"\nafterwards = \"hold\"\npools = {{ a = {{ from = 3, to = 2 }} }}\n{stage}"
                ),
                "c.toml:3:11:",
                "it is empty",
            ),
            (format!("name = \"c\"\nafterwards = \"stop\"\n{stage}"), "c.toml:2:14:", "stop"),
        ];
        for (text, place, complaint) in cases {
            let error = parsed(&text).unwrap_err();
            assert!(error.starts_with(place) && error.contains(complaint), "{text}\ngave {error}");
        }
    }

    #[test]
    fn a_curriculum_may_set_parameters_that_it_is_about() {
        let given = Parameters { association_weight: 0.5, ..Parameters::default() };
        let (_, parameters) = lesson("exp1-s2", given.clone()).unwrap();
        assert_eq!(parameters, Parameters { generalisation: false, ..given.clone() });
        assert_eq!(lesson("exp1-s1", given.clone()).unwrap().1, given);
        let wrong = "name = \"x\"\nafterwards = \"hold\"\n[[stage]]\nname = \"a\"\nlift = \"all\"\n\
                     [learner]\nassociation_weight = 7.0\n";
        let error = parsed(wrong).unwrap_err();
        assert!(error.starts_with("c.toml:7:22:") && error.contains("outside 0..=1"), "{error}");
    }
}
