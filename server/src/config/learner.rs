//! `learner.toml`: every number and switch of the learner.

use std::collections::BTreeMap;
use std::path::Path;

use pschema_learner::mechanisms::Mechanisms;
use pschema_learner::parameters::TypeOverride;
use serde::Deserialize;
use toml::Spanned;

use super::source::{ConfigError, Mistake, Source, read};
use crate::setup::LearnerSettings;

/// Observation types that may be given rules of their own.
const TYPE_OVERRIDES_MAX: usize = 1024;

/// Parameters as people write them; one that is not written keeps its value.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields, expecting = "a table")]
pub(super) struct WrittenParameters {
    profile: Option<Profile>,
    without: Option<Vec<Spanned<String>>>,
    association_weight: Option<Spanned<f64>>,
    excite_by_post_conditions: Option<bool>,
    babbling_excitation: Option<Spanned<f64>>,
    generalisation: Option<bool>,
    generalisation_share_min: Option<Spanned<f64>>,
    generalisation_support_min: Option<Spanned<usize>>,
    prediction_ratio_min: Option<Spanned<f64>>,
    association_low_min: Option<Spanned<f64>>,
    attention: Option<bool>,
    heard_decays: Option<bool>,
    chain_length_max: Option<Spanned<u32>>,
    chain_expansions_max: Option<Spanned<u32>>,
    types: BTreeMap<Spanned<String>, WrittenType>,
}

/// What a learner does beyond the paper.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Profile {
    /// Nothing.
    Paper,
    /// All that it can.
    Full,
}

impl From<Profile> for Mechanisms {
    fn from(profile: Profile) -> Self {
        match profile {
            Profile::Paper => Self::PAPER,
            Profile::Full => Self::FULL,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
struct WrittenType {
    precondition: Option<bool>,
    postcondition: Option<bool>,
}

/// The parameters and the profile that the file at `path` gives; the defaults without a file.
///
/// # Errors
/// When the file can't be read, has unknown keys or a value outside its range.
pub fn learner(path: Option<&Path>) -> Result<LearnerSettings, ConfigError> {
    let Some(path) = path else { return Ok(LearnerSettings::default()) };
    let text = read(path)?;
    parse(Source { name: &path.display().to_string(), text: &text })
}

fn parse(source: Source<'_>) -> Result<LearnerSettings, ConfigError> {
    let mut settings = LearnerSettings::default();
    take_over(source, source.parse()?, &mut settings)?;
    Ok(settings)
}

/// Replaces those of the settings that are `written` in `source`.
///
/// # Errors
/// When one is out of its range, or there are too many types.
pub(super) fn take_over(
    source: Source<'_>,
    written: WrittenParameters,
    settings: &mut LearnerSettings,
) -> Result<(), ConfigError> {
    settings.heard_decays = written.heard_decays.or(settings.heard_decays);
    let LearnerSettings { mechanisms, .. } = settings;
    *mechanisms = written.profile.map_or(*mechanisms, Into::into);
    for name in written.without.into_iter().flatten() {
        let known = mechanisms.named().map(|(known, _)| known).join(", ");
        let problem = || format!("there is no mechanism `{}`; there are {known}", name.get_ref());
        let Some(switch) = mechanisms.switch(name.get_ref()) else {
            return Err(source.wrong(Mistake::new(name.span(), problem())));
        };
        *switch = false;
    }
    *mechanisms = mechanisms.sound();
    settings.settle();
    let LearnerSettings { parameters, .. } = settings;
    // Each number, with where it is written: a number out of its range is reported there.
    macro_rules! numbers {
        ($($name:ident),*) => { [$((stringify!($name), take(&written.$name, &mut parameters.$name))),*] };
    }
    let spans = numbers![
        association_weight,
        babbling_excitation,
        generalisation_share_min,
        generalisation_support_min,
        prediction_ratio_min,
        association_low_min,
        chain_length_max,
        chain_expansions_max
    ];
    parameters.excite_by_post_conditions =
        written.excite_by_post_conditions.unwrap_or(parameters.excite_by_post_conditions);
    parameters.generalisation = written.generalisation.unwrap_or(parameters.generalisation);
    parameters.attention = written.attention.unwrap_or(parameters.attention);
    if written.types.len() > TYPE_OVERRIDES_MAX {
        let problem = format!("{} types, at most {TYPE_OVERRIDES_MAX} are allowed", written.types.len());
        return Err(source.wrong(Mistake::new(0..0, problem)));
    }
    let types = written.types.into_iter().map(|(name, rules)| TypeOverride {
        name: name.into_inner(),
        precondition: rules.precondition,
        postcondition: rules.postcondition,
    });
    parameters.type_overrides.extend(types);
    parameters.check().map_err(|error| {
        let at = spans.into_iter().find(|(name, _)| *name == error.name).and_then(|(_, at)| at);
        source.wrong(Mistake::new(at.unwrap_or(0..0), error.to_string()))
    })
}

/// Replaces `into` by the number that is written, if one is, and returns where it is written.
fn take<T: Copy>(written: &Option<Spanned<T>>, into: &mut T) -> Option<std::ops::Range<usize>> {
    let written = written.as_ref()?;
    *into = *written.get_ref();
    Some(written.span())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<LearnerSettings, String> {
        parse(Source { name: "learner.toml", text }).map_err(|error| error.to_string())
    }

    #[test]
    fn the_example_file_says_the_defaults() {
        let text = include_str!("../../learner.toml");
        assert_eq!(parsed(text).unwrap(), LearnerSettings::default());
        // Every key stands in it, so that nobody has to look further.
        let Err(error) = parsed("no_such_key = 1") else { panic!("an unknown key was taken") };
        let keys = error.split('`').skip(3).step_by(2).collect::<Vec<_>>();
        assert!(keys.len() >= 12, "{error}");
        for key in keys {
            assert!(text.contains(key), "learner.toml does not speak of {key}");
            let reference = include_str!("../../../docs/PARAMETERS.md");
            let told = reference.contains(&format!("| `{key}`")) || reference.contains(&format!("| `{key}."));
            assert!(told, "docs/PARAMETERS.md does not speak of {key}");
        }
    }

    #[test]
    fn values_are_taken_over() {
        let text = "association_weight = 0.5\nattention = false\n[types.finger]\nprecondition = true\n";
        let LearnerSettings { parameters, mechanisms, .. } = parsed(text).unwrap();
        assert_eq!(mechanisms, Mechanisms::FULL);
        assert_eq!(parsed("profile = \"paper\"").unwrap().mechanisms, Mechanisms::PAPER);
        let without = parsed("without = [\"curiosity\"]").unwrap().mechanisms;
        assert_eq!(without, Mechanisms { curiosity: false, ..Mechanisms::FULL });
        let without = parsed("profile = \"full\"\nwithout = [\"claims\"]").unwrap().mechanisms;
        let left = Mechanisms { superschemas: true, ..Mechanisms::PAPER };
        assert_eq!(without, left, "what needs claims is off with them");
        assert!((parameters.association_weight - 0.5).abs() < f64::EPSILON && !parameters.attention);
        assert_eq!(parameters.type_overrides.len(), 1);
        assert_eq!(parameters.type_overrides[0].precondition, Some(true));
        assert_eq!(parameters.type_overrides[0].postcondition, None);
    }

    #[test]
    fn words_wear_out_under_the_papers_profile_and_where_that_is_asked_for() {
        let decays = |text: &str| parsed(text).unwrap().parameters.heard_decays;
        assert!(!decays("") && !decays("profile = \"full\""));
        assert!(decays("profile = \"paper\"") && decays("without = [\"curiosity\"]"));
        assert!(decays("heard_decays = true") && !decays("profile = \"paper\"\nheard_decays = false"));
        // What was asked for stands, whatever profile another file names.
        let mut settings = parsed("heard_decays = true").unwrap();
        let later = Source { name: "later.toml", text: "profile = \"full\"" };
        take_over(later, later.parse().unwrap(), &mut settings).unwrap();
        assert!(settings.parameters.heard_decays);
    }

    #[test]
    fn mistakes_are_located() {
        let cases = [
            ("attention = true\nomega = 0.8\n", "learner.toml:2:1:", "unknown field `omega`"),
            ("\nassociation_weight = 1.5\n", "learner.toml:2:22:", "outside 0..=1"),
            ("association_weight = nan\n", "learner.toml:1:22:", "outside 0..=1"),
            ("generalisation_support_min = 1\n", "learner.toml:1:30:", "outside 2.."),
            ("attention = \"yes\"\n", "learner.toml:1:13:", "boolean"),
            ("chain_length_max = -1\n", "learner.toml:1:20:", "u32"),
            ("[types.finger]\nlifted = true\n", "learner.toml:2:1:", "unknown field `lifted`"),
            ("profile = \"some\"\n", "learner.toml:1:11:", "expected `paper` or `full`"),
            (
                "without = [\"claims\", \"clams\"]\n",
                "learner.toml:1:22:",
                "there is no mechanism `clams`; there are claims",
            ),
            ("attention = = true\n", "learner.toml:1:13:", ""),
        ];
        for (text, place, complaint) in cases {
            let error = parsed(text).unwrap_err();
            assert!(error.starts_with(place) && error.contains(complaint), "{text:?} gave {error}");
        }
    }
}
