//! What a learner does beyond the paper: each mechanism has a switch of its own.

/// The mechanisms that are on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Mechanisms {
    /// Whether claims are grown from experiences, and say what a schema's conditions are, what it brings about and which law holds
    /// where. Off, a schema has the whole context as its conditions, and laws come of schemas alone (paper, II-D and II-E).
    pub claims: bool,
}

impl Mechanisms {
    /// None: the learner of the paper.
    pub const PAPER: Self = Self { claims: false };
    /// All of them.
    pub const FULL: Self = Self { claims: true };

    /// Each with its name.
    #[must_use]
    pub fn named(self) -> [(&'static str, bool); 1] {
        [("claims", self.claims)]
    }

    /// The profile by its name, `paper` or `full`; or the names of those that are on.
    #[must_use]
    pub fn profile(self) -> String {
        let on = self.named().into_iter().filter(|(_, on)| *on).map(|(name, _)| name);
        let on: Vec<_> = on.collect();
        match on.len() {
            0 => "paper".to_owned(),
            some if some == self.named().len() => "full".to_owned(),
            _ => on.join(", "),
        }
    }

    /// The switch of this name.
    pub fn switch(&mut self, name: &str) -> Option<&mut bool> {
        match name {
            "claims" => Some(&mut self.claims),
            _ => None,
        }
    }
}
