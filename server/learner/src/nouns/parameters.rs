//! Every number and switch of the learner, each with the sentence of the paper it comes from. `docs/PARAMETERS.md` has them in a
//! table.

use crate::nouns::observation::TypeId;
use crate::nouns::probability::Count;
use crate::nouns::vocabulary::{DeclaredType, Vocabulary};

/// The largest [`Parameters::chain_length_max`]: no chain has more schemas.
pub const CHAIN_LENGTH_MAX: u32 = 64;

/// The learner's parameters. A default is the paper's where the paper gives one; the same defaults serve every experiment.
///
/// ```
/// use pschema_learner::parameters::Parameters;
///
/// // The paper's scenario 2: nothing is generalised.
/// let parameters = Parameters { generalisation: false, ..Parameters::default() };
/// assert_eq!(parameters.check(), Ok(()));
/// let error = Parameters { association_weight: 1.5, ..parameters }.check().unwrap_err();
/// assert_eq!(error.to_string(), "association_weight = 1.5 is outside 0..=1");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// ω of equation (1), in 0..=1; 0.8 by default: "associated observations being weighted to have less impact than
    /// pre-conditions, in our experiments this weighting (ω) is set to 0.8" (II-C).
    pub association_weight: f64,
    /// Whether Ψ in equation (1) includes post-conditions; true by default. The formula names pre-conditions only, but the worked
    /// example (figure 1) selects a schema without pre-conditions through its post-condition.
    pub excite_by_post_conditions: bool,
    /// The excitation of a primitive for which no schema can be executed here, in the unit of equation (1); finite, 0 or more; 1 by
    /// default. It is the drive behind motor babbling, the paper's first stage. The paper's formula does not have it, for it needs
    /// a schema to begin with.
    pub babbling_excitation: f64,
    /// Whether generalisation is attempted; true by default. The paper switches it off in its scenario 2 (IV-A).
    pub generalisation: bool,
    /// The share of similar schemas that a generalised one must represent, in 0..=1; 0.75 by default: "this threshold is set at 75%
    /// for the experiments below" (II-E).
    pub generalisation_share_min: f64,
    /// How many schemas must support a generalisation; 2 or more, 2 by default. The paper's tables have two placements.
    pub generalisation_support_min: usize,
    /// The share of trials in which a post-condition must have held for the schema to predict it, in 0..=1; 0.5 by default. Rarer
    /// outcomes are remembered with their probability (II-A), but their absence is no surprise.
    pub prediction_ratio_min: f64,
    /// A lasting observation that was there alongside a schema becomes an associated observation when the lower end of the 95 %
    /// interval of its probability reaches this, in 0..=1; 0.5 by default: the paper's "seen to occur frequently" (II-B). An event
    /// that happened while the schema ran is associated at once.
    pub association_low_min: f64,
    /// Whether attention is counted, so that N(x) lowers excitation (II-C, the denominator of equation (1)); true by default. Off
    /// only to measure its effect.
    pub attention: bool,
    /// Whether heard observations lose excitation with repetition like all others; true by default: "if a command driven system was
    /// desired the excitation from auditory input could simply be excluded from the decay applied to other forms of sensory
    /// input" (VI-B).
    pub heard_decays: bool,
    /// The number of schemas in the longest chain that is considered, in 1..=64; 8 by default. The paper is silent.
    pub chain_length_max: u32,
    /// The number of contexts that one search for chains may expand, 1 or more; 256 by default. A search that used them up says so.
    /// The paper is silent.
    pub chain_expansions_max: u32,
    /// The observation types whose part in learning differs from the default for their flags; none by default.
    pub type_overrides: Vec<TypeOverride>,
}

/// The part of one observation type in learning, where it differs from the default for its flags.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TypeOverride {
    /// The name of the observation type.
    pub name: String,
    /// Whether its observations may be pre-conditions. By default they may, unless the type is `own`, `transient` or `heard`.
    pub precondition: Option<bool>,
    /// Whether its observations may be post-conditions. By default they may, unless the type is `heard` or a value.
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

/// A parameter that is outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{name} = {value} is outside {range}")]
pub struct ParameterError {
    /// The name of the parameter.
    pub name: &'static str,
    /// The value that was given.
    pub value: f64,
    /// The range, as Rust writes it.
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

    /// Whether a post-condition with this count is predicted.
    #[must_use]
    pub(crate) fn predicts(&self, count: Count) -> bool {
        count.ratio() >= self.prediction_ratio_min
    }
}

/// What each observation type may be part of: its flags, with the overrides of the parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TypeRules(Vec<TypeRule>);

/// What an observation type may be part of. Of a type that is not known, nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TypeRule {
    /// It is caused by the body itself.
    pub own: bool,
    /// It holds only for the frame it came in.
    pub transient: bool,
    /// It comes from others.
    pub heard: bool,
    /// It is a number that comes with a frame and may be wanted.
    pub value: bool,
    /// It may be a pre-condition.
    pub precondition: bool,
    /// It may be a post-condition.
    pub postcondition: bool,
}

impl TypeRule {
    /// Whether only claims and goals are told of it: a value that no parameter makes a condition.
    #[must_use]
    pub fn is_apart(self) -> bool {
        self.value && !self.precondition && !self.postcondition
    }
}

impl TypeRules {
    /// The rules for every type of `vocabulary`.
    #[must_use]
    pub fn new(vocabulary: &Vocabulary, parameters: &Parameters) -> Self {
        let rule = |declared: &DeclaredType| {
            let given = parameters.type_overrides.iter().find(|o| o.name == declared.name);
            let DeclaredType { own, transient, heard, value, .. } = *declared;
            let precondition = given.and_then(|o| o.precondition).unwrap_or(!(own || transient || heard));
            let postcondition = given.and_then(|o| o.postcondition).unwrap_or(!(heard || value));
            TypeRule { own, transient, heard, value, precondition, postcondition }
        };
        Self(vocabulary.types().iter().map(|t| rule(&t.declared)).collect())
    }

    /// The rule for the type `kind`.
    #[must_use]
    pub fn of(&self, kind: TypeId) -> TypeRule {
        self.0.get(usize::from(kind.0)).copied().unwrap_or_default()
    }
}
