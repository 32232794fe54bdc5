//! Every number and switch of the learner, each with the sentence of the paper it comes from.

use crate::nouns::observation::TypeId;
use crate::nouns::probability::Count;
use crate::nouns::vocabulary::Vocabulary;

/// Schemas in one chain, whatever [`Parameters::chain_length_max`] says.
pub const CHAIN_LENGTH_MAX: u32 = 64;

/// The learner's parameters. The defaults are the paper's where it gives one; the same values serve every
/// experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// ω: "associated observations being weighted to have less impact than pre-conditions, in our
    /// experiments this weighting (ω) is set to 0.8" (II-C).
    pub association_weight: f64,
    /// Whether Ψ in equation (1) includes post-conditions. The formula names pre-conditions only, but the
    /// worked example (figure 1) selects a schema without pre-conditions through its post-condition.
    pub excite_by_post_conditions: bool,
    /// The excitation of a primitive for which no schema can be executed here: the drive behind motor
    /// babbling (the paper's first stage). Not in the paper's formula, which needs a schema to begin with.
    pub babbling_excitation: f64,
    /// Whether generalisation is attempted: switched off in the paper's scenario 2.
    pub generalisation: bool,
    /// "this threshold is set at 75% for the experiments below" (II-E).
    pub generalisation_share_min: f64,
    /// How many schemas must support a generalisation. The paper's table has two placements.
    pub generalisation_support_min: usize,
    /// A post-condition is what a schema predicts when it held in at least this share of its trials;
    /// rarer outcomes are remembered with their probability (II-A) but their absence surprises nobody.
    pub prediction_ratio_min: f64,
    /// A state that was there alongside a schema becomes an associated observation when the lower end of
    /// the interval of its probability reaches this: the paper's "seen to occur frequently" (II-B). An
    /// event that happened while the schema ran is associated at once.
    pub association_low_min: f64,
    /// Whether attention is counted, so that N(x) lowers excitation (the denominator of equation 1). Off only to
    /// measure its effect.
    pub attention: bool,
    /// Whether what is heard decays like any other sensation: "if a command driven system was desired the excitation from auditory
    /// input could simply be excluded from the decay applied to other forms of sensory input" (VI-B).
    pub heard_decays: bool,
    /// The longest chain of schemas considered.
    pub chain_length_max: u32,
    /// States that one search for chains may expand; a search that used them up says so.
    pub chain_expansions_max: u32,
    /// Types whose part in learning differs from what their flags say.
    pub type_overrides: Vec<TypeOverride>,
}

/// Lifts (or imposes) the default of a type's flags.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TypeOverride {
    /// The observation type's name.
    pub name: String,
    /// Whether it may be a pre-condition; by default unless `own`, `transient` or `heard`.
    pub precondition: Option<bool>,
    /// Whether it may be a post-condition; by default unless `heard`.
    pub postcondition: Option<bool>,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            association_weight: 0.8,
            excite_by_post_conditions: true,
            babbling_excitation: 1.0,
            generalisation: true,
            generalisation_share_min: 0.75,
            generalisation_support_min: 2,
            prediction_ratio_min: 0.5,
            association_low_min: 0.5,
            attention: true,
            heard_decays: true,
            chain_length_max: 8,
            chain_expansions_max: 256,
            type_overrides: Vec::new(),
        }
    }
}

/// Why parameters can't be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value} is outside {range}")]
pub struct ParameterError {
    /// Which parameter.
    pub name: &'static str,
    /// What it was set to.
    pub value: f64,
    /// What it may be.
    pub range: &'static str,
}

impl Parameters {
    /// Checks every range.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn check(&self) -> Result<(), ParameterError> {
        let unit = [
            ("association_weight", self.association_weight),
            ("generalisation_share_min", self.generalisation_share_min),
            ("prediction_ratio_min", self.prediction_ratio_min),
            ("association_low_min", self.association_low_min),
        ];
        for (name, value) in unit {
            if !(0.0..=1.0).contains(&value) {
                return Err(ParameterError { name, value, range: "0..=1" });
            }
        }
        if !(self.babbling_excitation.is_finite() && self.babbling_excitation >= 0.0) {
            let value = self.babbling_excitation;
            return Err(ParameterError { name: "babbling_excitation", value, range: "0.." });
        }
        if self.generalisation_support_min < 2 {
            let value = self.generalisation_support_min as f64;
            return Err(ParameterError { name: "generalisation_support_min", value, range: "2.." });
        }
        if !(1..=CHAIN_LENGTH_MAX).contains(&self.chain_length_max) {
            let value = f64::from(self.chain_length_max);
            return Err(ParameterError { name: "chain_length_max", value, range: "1..=64" });
        }
        if self.chain_expansions_max == 0 {
            return Err(ParameterError { name: "chain_expansions_max", value: 0.0, range: "1.." });
        }
        Ok(())
    }

    /// Whether an outcome with this count is predicted.
    #[must_use]
    pub(crate) fn predicts(&self, count: Count) -> bool {
        count.ratio() >= self.prediction_ratio_min
    }
}

/// What each observation type may be part of: its flags, with the overrides of the parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TypeRules {
    rules: Vec<TypeRule>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct TypeRule {
    own: bool,
    transient: bool,
    heard: bool,
    precondition: bool,
    postcondition: bool,
}

impl TypeRules {
    /// The rules for every type of `vocabulary`.
    #[must_use]
    pub fn new(vocabulary: &Vocabulary, parameters: &Parameters) -> Self {
        let rule = |declared: &crate::nouns::vocabulary::DeclaredType| {
            let given = parameters.type_overrides.iter().find(|o| o.name == declared.name);
            TypeRule {
                own: declared.own,
                transient: declared.transient,
                heard: declared.heard,
                precondition: given
                    .and_then(|o| o.precondition)
                    .unwrap_or(!(declared.own || declared.transient || declared.heard)),
                postcondition: given.and_then(|o| o.postcondition).unwrap_or(!declared.heard),
            }
        };
        Self { rules: vocabulary.types().iter().map(|t| rule(&t.declared)).collect() }
    }

    fn rule(&self, kind: TypeId) -> Option<&TypeRule> {
        self.rules.get(usize::from(kind.0))
    }

    /// May be a pre-condition.
    #[must_use]
    pub fn precondition(&self, kind: TypeId) -> bool {
        self.rule(kind).is_some_and(|rule| rule.precondition)
    }

    /// May be a post-condition.
    #[must_use]
    pub fn postcondition(&self, kind: TypeId) -> bool {
        self.rule(kind).is_some_and(|rule| rule.postcondition)
    }

    /// Holds only for the frame it came in.
    #[must_use]
    pub fn transient(&self, kind: TypeId) -> bool {
        self.rule(kind).is_some_and(|rule| rule.transient)
    }

    /// Comes from others.
    #[must_use]
    pub fn heard(&self, kind: TypeId) -> bool {
        self.rule(kind).is_some_and(|rule| rule.heard)
    }

    /// Caused by the body itself.
    #[must_use]
    pub fn own(&self, kind: TypeId) -> bool {
        self.rule(kind).is_some_and(|rule| rule.own)
    }
}
