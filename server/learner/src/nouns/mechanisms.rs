//! What a learner does beyond the paper: each mechanism has a switch of its own.

/// The mechanisms that are on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Mechanisms {
    /// Whether claims are grown from experiences, and say what a schema's conditions are, what it brings about and which law holds
    /// where. Off, a schema has the whole context as its conditions, and laws come of schemas alone (paper, II-D and II-E).
    pub claims: bool,
    /// Whether what drives the learner knows what claims do not know: where an action surprised of late, it is tried where that is new;
    /// and equation 1 is taken as a share of what is perceived, so that it does not grow with how much that is. It needs claims.
    pub curiosity: bool,
    /// Whether it is recalled what was there when the body was last as an action makes it, so that what is out of sight is expected where
    /// it was. It needs claims.
    pub recall: bool,
    /// Whether synthetic items are supposed where an action's outcomes differ and nothing that is sensed tells why. It needs claims.
    pub items: bool,
    /// Whether a goal is pursued by a policy that is made of what claims foretell. Off, it is pursued by chains of schemas (II-A). It
    /// needs claims.
    pub policies: bool,
    /// Whether the target of a generalised schema that no single schema achieves is achieved by several, one after another.
    pub superschemas: bool,
}

impl Mechanisms {
    /// None: the learner of the paper.
    pub const PAPER: Self = Self {
        claims: false,
        curiosity: false,
        recall: false,
        items: false,
        policies: false,
        superschemas: false,
    };
    /// All of them.
    pub const FULL: Self =
        Self { claims: true, curiosity: true, recall: true, items: true, policies: true, superschemas: true };

    /// The same without those that need one that is off.
    #[must_use]
    pub fn sound(self) -> Self {
        Self {
            claims: self.claims,
            curiosity: self.is_curious(),
            recall: self.recalls(),
            items: self.supposes(),
            policies: self.makes_policies(),
            superschemas: self.superschemas,
        }
    }

    /// Whether curiosity has the claims that it needs.
    #[must_use]
    pub fn is_curious(self) -> bool {
        self.claims && self.curiosity
    }

    /// Whether recall has the claims that it needs.
    #[must_use]
    pub fn recalls(self) -> bool {
        self.claims && self.recall
    }

    /// Whether items have the claims that they need.
    #[must_use]
    pub fn supposes(self) -> bool {
        self.claims && self.items
    }

    /// Whether policies have the claims that they need.
    #[must_use]
    pub fn makes_policies(self) -> bool {
        self.claims && self.policies
    }

    /// Each with its name.
    #[must_use]
    pub fn named(self) -> [(&'static str, bool); 6] {
        [
            ("claims", self.claims),
            ("curiosity", self.curiosity),
            ("recall", self.recall),
            ("items", self.items),
            ("policies", self.policies),
            ("superschemas", self.superschemas),
        ]
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
            "curiosity" => Some(&mut self.curiosity),
            "recall" => Some(&mut self.recall),
            "items" => Some(&mut self.items),
            "policies" => Some(&mut self.policies),
            "superschemas" => Some(&mut self.superschemas),
            _ => None,
        }
    }
}
