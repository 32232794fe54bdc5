//! Policies: what to do in each context on the way to a goal.

use std::collections::BTreeSet;

use crate::nouns::observation::{Observation, TypeId};
use crate::nouns::vocabulary::PrimitiveId;
use crate::nouns::world_state::WorldState;

/// Contexts of a policy that are kept: those that are reached most surely.
pub const POLICY_ROWS_MAX: usize = 256;

/// What to do in each context on the way to a goal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Policy {
    /// The types whose observations tell contexts apart, in order: those on which the goal depends and that are not left to chance.
    pub kinds: Vec<TypeId>,
    /// The types on which the goal depends and that are left to chance, in order.
    pub chance: Vec<TypeId>,
    /// Their observations when it was made, in canonical order.
    pub circumstances: Vec<Observation>,
    /// The contexts, each once; that in which it was found is the first. At most [`POLICY_ROWS_MAX`].
    pub rows: Vec<PolicyRow>,
    /// What comes of each row, in their order, if it is a policy for most of something; of one that leads to a goal, nothing.
    pub yields: Vec<Yield>,
    /// The number of actions that it takes to the goal, as expected where it gets there; of a policy for most of something, the
    /// number after which it is made anew.
    pub actions: f64,
    /// The number of actions that had been sent for the goal when it was made.
    pub after_actions: u32,
}

/// What to do in one context.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyRow {
    /// The observations of the policy's types, in canonical order.
    pub context: Vec<Observation>,
    /// The primitive to carry out there.
    pub action: PrimitiveId,
    /// The probability with which the goal is reached from there, in 0..=1.
    pub probability: f64,
    /// What the action leads to, the most probable first.
    pub leads: Vec<Lead>,
}

/// What comes of a row of a policy for most of something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Yield {
    /// What is expected to come from there on, what comes with each further action counted 0.99 times as much; nothing after the end of
    /// the episode.
    pub worth: f64,
    /// What comes with its action most likely.
    pub brings: f64,
}

impl PolicyRow {
    /// Whether its action may reach the goal.
    #[must_use]
    pub fn may_arrive(&self) -> bool {
        self.leads.iter().any(|lead| lead.to.is_none())
    }
}

/// Where an action leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lead {
    /// The context, by its row; none is the goal.
    pub to: Option<u32>,
    /// The probability, in 0..=1.
    pub probability: f64,
}

impl Policy {
    /// Whether its parts fit together: its types and contexts are in order, no context is there twice, leads are to rows that there are,
    /// and probabilities and the number of actions are such.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let Self { kinds, chance, circumstances, rows, yields, actions, after_actions: _ } = self;
        let is_of = |observations: &[Observation], kinds: &[TypeId]| {
            observations.is_sorted_by(|a, b| a < b)
                && observations.iter().all(|o| kinds.binary_search(&o.kind()).is_ok())
        };
        let is_probable = |probability: f64| (0.0..=1.0).contains(&probability);
        let is_row = |to: u32| (to as usize) < rows.len();
        let contexts: BTreeSet<_> = rows.iter().map(|row| &row.context).collect();
        let sound = |row: &PolicyRow| {
            let mut leads = row.leads.iter();
            is_probable(row.probability)
                && is_of(&row.context, kinds)
                && row.leads.len() <= rows.len() + 1
                && leads.all(|lead| is_probable(lead.probability) && lead.to.is_none_or(is_row))
        };
        rows.len() <= POLICY_ROWS_MAX
            && contexts.len() == rows.len()
            && kinds.is_sorted_by(|a, b| a < b)
            && chance.is_sorted_by(|a, b| a < b)
            && is_of(circumstances, chance)
            && rows.iter().all(sound)
            && (yields.is_empty() || yields.len() == rows.len())
            && yields.iter().all(|one| one.worth.is_finite() && one.brings.is_finite())
            && (actions.is_finite() && *actions >= 0.0)
    }

    /// What is expected to come from where it was made, if it is a policy for most of something: see [`Yield::worth`].
    #[must_use]
    pub fn worth(&self) -> Option<f64> {
        self.yields.first().map(|first| first.worth)
    }

    /// The row of a context of lasting observations.
    #[must_use]
    pub fn row(&self, context: &WorldState) -> Option<usize> {
        let context = of_kinds(context.observations(), &self.kinds);
        self.rows.iter().position(|row| row.context == context)
    }

    /// Whether the goal should have been reached by it, after so many actions, or it is time to make it anew.
    #[must_use]
    pub fn is_overdue(&self, actions: u32) -> bool {
        f64::from(actions.saturating_sub(self.after_actions)) > self.actions
    }

    /// Whether in a context of lasting observations all that is left to chance is as it was when the policy was made.
    #[must_use]
    pub fn fits(&self, context: &WorldState) -> bool {
        of_kinds(context.observations(), &self.chance) == self.circumstances
    }

    /// The rows that follow each other from one on, when all comes about that is most likely: to the goal, or until a context would
    /// come again.
    #[must_use]
    pub fn course(&self, from: usize) -> Vec<usize> {
        let mut course = Vec::new();
        let mut at = Some(from);
        while let Some(here) = at.filter(|at| !course.contains(at)) {
            let Some(row) = self.rows.get(here) else { break };
            course.push(here);
            at = row.leads.first().and_then(|lead| lead.to).map(|to| to as usize);
        }
        course
    }
}

/// Those of some observations that are of these types.
pub(crate) fn of_kinds(observations: &[Observation], kinds: &[TypeId]) -> Vec<Observation> {
    observations.iter().filter(|o| kinds.binary_search(&o.kind()).is_ok()).cloned().collect()
}
