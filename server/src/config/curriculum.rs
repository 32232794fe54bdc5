//! Curricula: developmental stages (paper, II-F) as a TOML file, or one of those built in.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use pschema_learner::curriculum::{Afterwards, Curriculum, POOL_NUMBERS_MAX, Pool, Stage};
use serde::Deserialize;
use serde::de::IgnoredAny;
use toml::Spanned;

use super::learner::{WrittenParameters, take_over};
use super::source::{ConfigError, Mistake, Source, read};
use super::stage::{WrittenStage, checked_stage};
use crate::setup::LearnerSettings;
use crate::translate::listed;

/// The curricula that come with the daemon: names and texts.
pub const BUILT_IN: [(&str, &str); 13] = [
    ("free", include_str!("../../curricula/free.toml")),
    ("exp1-s1", include_str!("../../curricula/exp1-s1.toml")),
    ("exp1-s1-narrow", include_str!("../../curricula/exp1-s1-narrow.toml")),
    ("exp1-s2", include_str!("../../curricula/exp1-s2.toml")),
    ("exp1-s3", include_str!("../../curricula/exp1-s3.toml")),
    ("exp1-s3-relevance", include_str!("../../curricula/exp1-s3-relevance.toml")),
    ("exp2", include_str!("../../curricula/exp2.toml")),
    ("exp2-noise", include_str!("../../curricula/exp2-noise.toml")),
    ("exp4-transfer", include_str!("../../curricula/exp4-transfer.toml")),
    ("habituation", include_str!("../../curricula/habituation.toml")),
    ("ablations", include_str!("../../curricula/ablations.toml")),
    ("ablations-timed", include_str!("../../curricula/ablations-timed.toml")),
    ("ablations-unstaged", include_str!("../../curricula/ablations-unstaged.toml")),
];

const STAGES_MAX: usize = 256;
const POOLS_MAX: usize = 64;

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct WrittenCurriculum {
    name: String,
    #[serde(default)]
    pools: BTreeMap<Spanned<String>, WrittenPool>,
    #[serde(default)]
    stage: Vec<Spanned<WrittenStage>>,
    #[serde(with = "WrittenAfterwards")]
    afterwards: Afterwards,
    /// Parameters that the curriculum is about, such as generalisation switched off.
    #[serde(default)]
    learner: WrittenParameters,
    /// Numbers that its stages name, so that a run can be repeated with others.
    #[serde(default)]
    values: BTreeMap<String, f64>,
    /// What makes it an experiment means nothing to the learner. The tools read this table, and report its mistakes; the
    /// daemon accepts whatever stands in it.
    #[serde(default, rename = "experiment")]
    _experiment: IgnoredAny,
}

/// `KEY=VALUE` given beside a curriculum, as a little text of its own.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct WrittenSetting {
    #[serde(default)]
    learner: WrittenParameters,
    #[serde(default)]
    values: BTreeMap<Spanned<String>, f64>,
}

/// [`Afterwards`] as people write it.
#[derive(Deserialize)]
#[serde(remote = "Afterwards", rename_all = "kebab-case")]
enum WrittenAfterwards {
    Continue,
    Hold,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct WrittenPool {
    from: i64,
    to: i64,
}

/// The curriculum built in under `name`, or in the file of that name.
///
/// # Errors
/// When there is neither, or what is wrong in it and where.
pub fn curriculum(name: &str) -> Result<Curriculum, ConfigError> {
    lesson(name, LearnerSettings::default(), &[]).map(|(curriculum, _)| curriculum)
}

/// The curriculum, and the settings of `learner` with those changed that it sets itself in its table `[learner]`. `settings`
/// replace what it says: each is `learner.PARAMETER=VALUE` or `values.NAME=NUMBER`, as TOML writes it.
///
/// # Errors
/// As [`curriculum`], and when a setting names what is not there.
pub fn lesson(
    name: &str,
    learner: LearnerSettings,
    settings: &[String],
) -> Result<(Curriculum, LearnerSettings), ConfigError> {
    let (name, text) = named(name)?;
    parse(Source { name: &name, text: &text }, learner, settings)
}

/// The text of the curriculum that is built in under `name`, or of the file of that name; with what to call it in
/// complaints.
///
/// # Errors
/// When there is neither, or the file can't be read.
pub fn named(name: &str) -> Result<(String, Cow<'static, str>), ConfigError> {
    if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
        return Ok((format!("built-in curriculum {name}"), Cow::Borrowed(text)));
    }
    let path = Path::new(name);
    // A pipe will do as well: `--curriculum <(…)`, or `-` for stdin.
    if name != "-" && !path.exists() {
        let built_in = BUILT_IN.map(|(known, _)| known).join(", ");
        return Err(ConfigError::NoCurriculum { name: name.to_owned(), built_in });
    }
    Ok((name.to_owned(), Cow::Owned(read(path)?)))
}

fn parse(
    source: Source<'_>,
    mut learner: LearnerSettings,
    settings: &[String],
) -> Result<(Curriculum, LearnerSettings), ConfigError> {
    let mut written: WrittenCurriculum = source.parse()?;
    let mut replaced = Vec::new();
    let settings: Vec<_> = settings.iter().map(|text| quoted(text)).collect();
    for text in &settings {
        let setting = Source { name: "setting", text };
        let WrittenSetting { learner, values } = setting.parse()?;
        for (name, value) in values {
            let Some(known) = written.values.get_mut(name.get_ref()) else {
                let known = listed(written.values.keys().map(String::as_str));
                let problem = format!("{} has no such value; its values are: {known}", source.name);
                return Err(setting.wrong(Mistake::new(name.span(), problem)));
            };
            *known = value;
        }
        replaced.push((setting, learner));
    }
    let curriculum = checked(&written).map_err(|mistake| source.wrong(mistake))?;
    // What the learner asks beyond the checks above has no place in the text that could be named.
    curriculum.check().map_err(|error| source.wrong(Mistake::new(0..0, error.to_string())))?;
    take_over(source, written.learner, &mut learner)?;
    for (setting, written) in replaced {
        take_over(setting, written, &mut learner)?;
    }
    Ok((curriculum, learner))
}

/// A setting whose value is one word, as TOML writes it: nobody expects to quote it twice, for TOML and for the shell.
fn quoted(setting: &str) -> Cow<'_, str> {
    let is_word = |value: &str| {
        value.starts_with(|c: char| c.is_ascii_alphabetic())
            && value.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_'))
            && !matches!(value, "true" | "false" | "nan" | "inf")
    };
    match setting.split_once('=') {
        Some((key, value)) if is_word(value.trim()) => Cow::Owned(format!("{key}=\"{}\"", value.trim())),
        _ => Cow::Borrowed(setting),
    }
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
        stages.push(checked_stage(stage, &pools, &written.values, &mut drawn)?);
    }
    Ok(Curriculum { name: written.name.clone(), pools, stages, afterwards: written.afterwards })
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

#[cfg(test)]
mod tests {
    use pschema_learner::curriculum::{Argument, Lift};
    use pschema_learner::mechanisms::Mechanisms;
    use pschema_learner::parameters::Parameters;

    use super::*;
    use crate::translate::HEARING_TEXT;

    fn parsed(text: &str) -> Result<Curriculum, String> {
        let parsed = parse(Source { name: "c.toml", text }, LearnerSettings::default(), &[]);
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
    fn mistakes_in_what_is_said_and_waited_for_and_named_are_located() {
        let head = "name = \"c\"\nafterwards = \"hold\"\nvalues = { noise = 0.5, half = 0.5, many = 40.0, odd = 1.5 }\n";
        let stage =
            format!("{head}[[stage]]\nname = \"one\"\nlift = \"all\"\ntrials = 1\ntrial_actions_max = 9\n");
        let say = |inside: &str| format!("say = [{{ {inside} }}]\n");
        let word = |rest: &str| say(&format!("words = [\"touch\"], {rest}"));
        let settled = |rule: &str| {
            format!("saturation = {{ excitation_below = 1.0, actions = 5 }}\nhabituation = {{ {rule} }}\n")
        };
        let cases = [
            (say("words = []"), "9:18:", "give 1 to 64 words"),
            (say("words = [\"touch it\"]"), "9:19:", "without spaces"),
            (say("words = [\"\"]"), "9:19:", "\"\" is no word"),
            (say("when = \"touch{}\""), "9:8:", "missing field `words`"),
            (word("when = \"touch\""), "9:36:", "such as `touch{}`"),
            (word("unless = \"touch{\""), "9:38:", "such as `touch{}`"),
            (word("times = 0"), "9:37:", "give at least 1"),
            (word("probability = 1.5"), "9:43:", "outside 0..=1"),
            (word("probability = \"nois\""), "9:43:", "there are: half, many, noise, odd"),
            (word("probability = \"1 - many\""), "9:43:", "a probability of -39 is outside 0..=1"),
            (word("often = true"), "9:29:", "unknown field `often`"),
            (
                "until_absent = { observation = \"touch\", actions = 5 }\n".to_owned(),
                "9:32:",
                "such as `touch{}`",
            ),
            (
                "until_absent = { observation = \"touch{}\", actions = 0 }\n".to_owned(),
                "9:53:",
                "give at least 1",
            ),
            ("until_absent = { observation = \"touch{}\" }\n".to_owned(), "9:16:", "missing field `actions`"),
            // The names of this program's types were told.
            (
                "until_absent = \"tuch{}\"\n".to_owned(),
                "9:16:",
                "expected a table such as { observation = \"touch{}\", actions = 5 }",
            ),
            ("say = [\"touch\"]\n".to_owned(), "9:8:", "expected a table such as { words = [\"touch\"]"),
            ("saturation = 5\n".to_owned(), "9:14:", "expected a table such as { excitation_below = 0.2"),
            ("habituation = 5\n".to_owned(), "9:15:", "expected a table such as { executions_min = 10 }"),
            (settled("executions_min = \"few\""), "10:34:", "there are: half, many, noise, odd"),
            (settled("executions_min = \"odd\""), "10:34:", "give a whole number"),
            (settled("executions_min = -1"), "10:34:", "a whole number, or the name of one of the [values]"),
            (settled("executions_min = 4, interval_max = 2.0"), "10:52:", "outside 0..=1"),
        ];
        for (lines, place, complaint) in cases {
            let error = parsed(&format!("{stage}{lines}")).unwrap_err();
            let located = error.strip_prefix("c.toml:").is_some_and(|rest| rest.starts_with(place));
            assert!(located && error.contains(complaint), "{lines}gave {error}");
        }
        // Without trials there is nothing for it to belong to; and a value must be a number.
        let untimely =
            format!("{head}[[stage]]\nname = \"one\"\nlift = \"all\"\n{}", say("words = [\"touch\"]"));
        let error = parsed(&untimely).unwrap_err();
        assert!(error.starts_with("c.toml:5:8:") && error.contains("give `trials`"), "{error}");
        let absent = format!(
            "{head}[[stage]]\nname = \"one\"\nlift = \"all\"\nuntil_absent = {{ observation = \"touch{{}}\", actions = 5 }}\n"
        );
        let error = parsed(&absent).unwrap_err();
        assert!(error.starts_with("c.toml:7:32:") && error.contains("give `trials`"), "{error}");
        let error = parsed(&stage.replace("noise = 0.5", "noise = \"loud\"")).unwrap_err();
        assert!(error.starts_with("c.toml:3:20:") && error.contains("\"loud\""), "{error}");
        // Named and right.
        let right = format!(
            "{stage}{}{}",
            word("probability = \"1 - noise\", times = 3"),
            settled("executions_min = \"many\"")
        );
        let one = &parsed(&right).unwrap().stages[0];
        let said = &one.say[0];
        assert!((said.probability - 0.5).abs() < f64::EPSILON && said.times_max == 3, "{said:?}");
        assert_eq!(one.habituation.as_ref().unwrap().executions_min, 40);
    }

    #[test]
    fn mistakes_in_settings_are_located_in_the_setting() {
        let set = |setting: &str| {
            let settings = [setting.to_owned()];
            lesson("habituation", LearnerSettings::default(), &settings).map_err(|error| error.to_string())
        };
        let (curriculum, learner) = set("values.executions=7").unwrap();
        assert_eq!(curriculum.stages[0].habituation.as_ref().unwrap().executions_min, 7);
        let paper = LearnerSettings::of(Mechanisms::PAPER);
        assert_eq!(learner, paper);
        assert!(!set("learner.attention=false").unwrap().1.parameters.attention);
        for full in ["learner.profile=full", "learner.profile = \"full\""] {
            assert_eq!(set(full).unwrap().1.mechanisms, Mechanisms::FULL);
        }
        let cases = [
            ("learner.profile=some", "setting:1:17:", "expected `paper` or `full`"),
            ("values.exections=7", "setting:1:8:", "its values are: executions"),
            ("values.executions=\"seven\"", "setting:1:19:", "\"seven\""),
            ("values.executions=", "setting:1:19:", ""),
            ("value.executions=7", "setting:1:1:", "expected `learner` or `values`"),
            ("learner.atention=false", "setting:1:9:", "unknown field `atention`"),
            ("learner.association_weight=8.0", "setting:1:28:", "outside 0..=1"),
            // The value is used where the curriculum names it, and there it is wrong.
            ("values.executions=1.5", "built-in curriculum habituation:", "give a whole number"),
        ];
        for (setting, place, complaint) in cases {
            let error = set(setting).unwrap_err();
            assert!(error.starts_with(place) && error.contains(complaint), "{setting}\ngave {error}");
        }
    }

    #[test]
    fn the_second_experiment_is_the_papers() {
        let two = curriculum("exp2").unwrap();
        let word =
            |stage: &Stage| matches!(&stage.lift, Lift::Types(types) if types.iter().any(|t| t == "word"));
        let at = |name: &str| {
            two.stages.iter().position(|stage| stage.name == name).expect("a stage of that name")
        };
        let (a, b, c, d) = (
            at("a: the first word"),
            at("b: the word again"),
            at("c: a new place, no word"),
            at("d: the word at the new place"),
        );
        assert!(a < b && b < c && c < d);
        // It starts in the end condition of scenario 1, and hearing is lifted last.
        assert!(two.stages[..a].iter().all(|stage| !word(stage) && stage.say.is_empty()));
        assert!(two.stages[a..].iter().all(|stage| word(stage) && stage.learning));
        let said = |at: usize| two.stages[at].say.iter().map(|say| &say.heard[..]).collect::<Vec<_>>();
        let heard = [(HEARING_TEXT.to_owned(), Argument::Symbol("touch".to_owned()))];
        for at in [a, b, d] {
            assert!(matches!(said(at)[..], [[touch]] if touch.properties == heard), "{:?}", said(at));
            assert_eq!(two.stages[at].say[0].times_max, 1);
        }
        assert!(said(c).is_empty(), "moved into a new position, without any linguistic input");
        // First said as the block is felt, then alone; the block is moved for a and c only.
        assert_eq!(two.stages[a].say[0].when.as_ref().map(|when| when.kind.as_str()), Some("touch"));
        assert!([b, d].iter().all(|at| two.stages[*at].say[0].when.is_none()));
        let placed: Vec<_> = (a..two.stages.len()).filter(|at| !two.stages[*at].arrange.is_empty()).collect();
        assert_eq!(placed, [a, c]);
        // Before each word alone it has lost interest: five actions in a row about something else.
        for stage in [&two.stages[b - 1], &two.stages[d - 1]] {
            let absence = stage.until_absent.as_ref().unwrap();
            assert_eq!((absence.observation.kind.as_str(), absence.actions), ("touch", 5));
        }
        let last = two.stages.last().unwrap();
        assert_eq!((last.trial_actions_max, last.say[0].times_max), (600, 600), "over and over");
    }

    #[test]
    fn a_curriculum_may_set_parameters_that_it_is_about() {
        let set = |mechanisms| {
            let settings = LearnerSettings::of(mechanisms);
            let parameters = Parameters { association_weight: 0.5, ..settings.parameters };
            LearnerSettings { parameters, ..settings }
        };
        let given = set(Mechanisms::FULL);
        let (_, learner) = lesson("exp1-s2", given.clone(), &[]).unwrap();
        let paper = set(Mechanisms::PAPER);
        assert_eq!(lesson("exp1-s1", given.clone(), &[]).unwrap().1, paper);
        let parameters = Parameters { generalisation: false, ..paper.parameters.clone() };
        assert_eq!(learner, LearnerSettings { parameters, ..paper });
        assert_eq!(lesson("free", given.clone(), &[]).unwrap().1, given);
        let wrong = "name = \"x\"\nafterwards = \"hold\"\n[[stage]]\nname = \"a\"\nlift = \"all\"\n\
                     [learner]\nassociation_weight = 7.0\n";
        let error = parsed(wrong).unwrap_err();
        assert!(error.starts_with("c.toml:7:22:") && error.contains("outside 0..=1"), "{error}");
    }
}
