//! The terms of equation (1) that explain a decision. Most decisions are never looked at, and their terms are many: one for
//! each pair of what is remembered and what is perceived. So a decision keeps the values of its moment, and its terms are made
//! of them when somebody looks.

use std::fmt;
use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use crate::nouns::observation::Observation;
use crate::nouns::world_state::WorldState;

/// Terms that a decision keeps one by one, those of the most excited candidate first. Their number grows with the
/// square of what is perceived, so a crowded world would else fill memory with explanations.
pub const TERMS_KEPT_MAX: usize = 8_192;

/// A term of equation (1), or a drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// The part of the remembered observation in the schema, or the drive.
    pub role: Role,
    /// The remembered observation (Ψ or α) and the perceived one (Υ) that resembles it; none for a drive and for the rest.
    pub pair: Option<(Observation, Observation)>,
    /// |Υ ∩ Ψ|: the number of properties with the same value that the two share.
    pub shared: u32,
    /// N of the remembered observation (II-C).
    pub attention: u32,
    /// p: the probability of the remembered observation in the schema, in 0..=1; 1 but for post-conditions.
    pub probability: f64,
    /// The reliability of the action, in 0..=1; for an association times ω.
    pub weight: f64,
    /// shared × probability × weight / (1 + attention): what the term adds to the sum.
    pub value: f64,
}

/// The part of a term's observation in the schema, or the drive that the term is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A pre-condition.
    PreCondition,
    /// A post-condition.
    PostCondition,
    /// An associated observation.
    Association,
    /// The drive to try what no schema covers.
    Babbling,
    /// The drive to repeat what is not yet known well enough (II-G).
    Habituation,
    /// The drive to do what may surprise here, of a learner that keeps claims.
    Curiosity,
    /// The terms beyond [`TERMS_KEPT_MAX`], added up.
    Rest,
}

/// The terms of a candidate: a list of [`Term`], made when it is first looked at, and the same whenever that is.
#[derive(Clone)]
pub struct Terms {
    of: Arc<TermSource>,
    /// The place of the candidate in `of`.
    at: usize,
}

impl Deref for Terms {
    type Target = [Term];

    fn deref(&self) -> &[Term] {
        let made = self.of.made.get_or_init(|| self.of.make());
        made.get(self.at).map_or(&[], Vec::as_slice)
    }
}

impl fmt::Debug for Terms {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.iter()).finish()
    }
}

impl PartialEq for Terms {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<'a> IntoIterator for &'a Terms {
    type Item = &'a Term;
    type IntoIter = std::slice::Iter<'a, Term>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// A remembered observation, as equation (1) weighed it.
#[derive(Clone)]
pub(crate) struct Recollection {
    pub(crate) role: Role,
    pub(crate) observation: Observation,
    pub(crate) attention: u32,
    pub(crate) probability: f64,
    pub(crate) weight: f64,
}

impl Recollection {
    /// The term that it adds to the sum when it shares so many values with the perceived observations.
    pub(crate) fn value(&self, shared: u32) -> f64 {
        value(shared, self.attention, self.probability, self.weight)
    }
}

/// How often an observation has attention until a term of equation 1 for it is half as heavy as equation 1 has it, where terms wear.
const WORN: f64 = 100.0;

/// What the terms of equation 1 for a candidate are weighed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weight {
    of: f64,
    /// Whether the terms wear: they grow lighter with attention than equation 1 has them.
    wears: bool,
}

impl Weight {
    /// As equation 1 has it.
    pub(crate) fn new(of: f64) -> Self {
        Self { of, wears: false }
    }

    /// The same for terms that wear.
    pub(crate) fn worn(of: f64) -> Self {
        Self { of, wears: true }
    }

    pub(crate) fn times(self, factor: f64) -> Self {
        Self { of: self.of * factor, ..self }
    }

    /// That of a term for an observation that had so much attention.
    pub(crate) fn at(self, attention: u32) -> f64 {
        if self.wears { self.of * WORN / (WORN + f64::from(attention)) } else { self.of }
    }
}

/// A term of equation (1).
pub(crate) fn value(shared: u32, attention: u32, probability: f64, weight: f64) -> f64 {
    f64::from(shared) * probability * weight / (1.0 + f64::from(attention))
}

/// A drive that adds to a candidate's sum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive {
    pub(crate) role: Role,
    pub(crate) weight: f64,
    pub(crate) value: f64,
}

/// The values of its moment from which the terms of a decision's candidates are made.
pub(crate) struct TermSource {
    world: WorldState,
    /// The observations that the candidates remember, one candidate after another.
    remembered: Vec<Recollection>,
    /// For each candidate the place where its observations end, and its drives.
    candidates: Vec<(usize, [Option<Drive>; 2])>,
    made: OnceLock<Vec<Vec<Term>>>,
}

impl TermSource {
    /// Of no candidate yet, of a decision in `world`; with room for so many candidates that remember so many observations.
    pub(crate) fn new(world: &WorldState, candidates: usize, remembered: usize) -> Self {
        Self {
            world: world.clone(),
            remembered: Vec::with_capacity(remembered.min(TERMS_KEPT_MAX)),
            candidates: Vec::with_capacity(candidates),
            made: OnceLock::new(),
        }
    }

    /// Adds a candidate: `remember` lists the observations that it remembers, in the schema's order.
    pub(crate) fn add(&mut self, drives: [Option<Drive>; 2], remember: impl FnOnce(&mut Vec<Recollection>)) {
        remember(&mut self.remembered);
        self.candidates.push((self.remembered.len(), drives));
    }

    /// The terms of each candidate, in the order in which they were added.
    pub(crate) fn terms(mut self) -> impl Iterator<Item = Terms> {
        // Values that would take more room than the terms are allowed are made into terms at once.
        if self.remembered.len() > TERMS_KEPT_MAX {
            self.made = OnceLock::from(self.make());
            self.remembered = Vec::new();
        }
        let count = self.candidates.len();
        let of = Arc::new(self);
        (0..count).map(move |at| Terms { of: of.clone(), at })
    }

    fn make(&self) -> Vec<Vec<Term>> {
        let (mut room, mut from) = (TERMS_KEPT_MAX, 0);
        let of_one = |(end, drives): &(usize, [Option<Drive>; 2])| {
            let mut terms = self.of_one(self.remembered.get(from..*end).unwrap_or_default(), room);
            let drives = drives.iter().flatten();
            terms.extend(drives.map(|Drive { role, weight, value }| lone(*role, *weight, *value)));
            room = room.saturating_sub(terms.len());
            from = *end;
            terms
        };
        self.candidates.iter().map(of_one).collect()
    }

    /// The terms of one candidate: at most `room` of them, and the rest as one.
    fn of_one(&self, remembered: &[Recollection], room: usize) -> Vec<Term> {
        let mut terms = Vec::new();
        let mut rest: Option<f64> = None;
        for known in remembered {
            for seen in self.world.observations() {
                let shared = known.observation.shared(seen);
                if shared == 0 {
                    continue;
                }
                let value = known.value(shared);
                if terms.len() < room {
                    let Recollection { role, observation, attention, probability, weight } = known.clone();
                    let pair = Some((observation, seen.clone()));
                    terms.push(Term { role, pair, shared, attention, probability, weight, value });
                } else {
                    *rest.get_or_insert(0.0) += value;
                }
            }
        }
        terms.extend(rest.map(|value| lone(Role::Rest, 1.0, value)));
        terms
    }
}

/// A term without a pair.
fn lone(role: Role, weight: f64, value: f64) -> Term {
    Term { role, pair: None, shared: 0, attention: 0, probability: 1.0, weight, value }
}
