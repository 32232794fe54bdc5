//! Experiences, from which claims are grown, synthetic items, and the mechanisms of a learner beyond the paper.

use pschema_learner::experience as live;
use pschema_learner::item as items;
use pschema_learner::mechanisms::Mechanisms;
use serde::{Deserialize, Serialize};

use super::observation::{Observation, Value};
use crate::format::mirror::{Mirror, mirror};

mirror! {
    /// One action that was carried out, with the world before and after it.
    struct Experience = live::Experience {
        /// The number of the body.
        body: u16,
        /// The number of the primitive; 4294967295 in the background, where all experiences are as if with one action.
        primitive: u32,
        /// The values of its parameters, as they are compared with observations; `null` where nothing can be the same.
        parameters: Vec<Option<Value>>,
        /// The lasting observations before it, in canonical order.
        before: Vec<Observation>,
        /// The observations after it, in canonical order.
        after: Vec<Observation>,
        /// The numbers of the observation types that were sensed, in order.
        sensed: Vec<u16>,
        /// What was there when the body was last as it was afterwards; `null` where that is not known.
        recalled: Option<Recalled>,
    }

    /// What was there at another time.
    struct Recalled = live::Recalled {
        /// The observations, in canonical order.
        observations: Vec<Observation>,
        /// How many experiences of the body ago.
        age: u32,
    }
}

mirror! {
    /// What becomes of a synthetic item.
    #[derive(Copy)]
    enum Update = items::Update {
        On,
        Off,
        Turn,
    }

    /// What was done, and what was there afterwards of the types that an item is about.
    struct Event = items::Event {
        /// The number of the primitive.
        primitive: u32,
        /// The observations, in canonical order.
        after: Vec<Observation>,
    }

    /// Something that is supposed to be so or not, though no sense shows it.
    struct SyntheticItem = items::Item {
        /// The number of the type by which it is perceived.
        kind: u16,
        /// The number of the property that says whether it is supposed.
        property: u16,
        /// The number of the primitive whose outcomes it tells apart.
        primitive: u32,
        /// The numbers of the types of these outcomes, in order.
        kinds: Vec<u16>,
        /// What becomes of it at each event, in their order; at others it stays as it is.
        updates: Vec<(Event, Update)>,
        /// Whether it is kept no longer.
        dropped: bool,
    }
}

/// A mechanism beyond the paper. A release that does not know one by this name can't go on with the memory, and refuses it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(crate) enum Mechanism {
    /// Claims are grown from experiences.
    Claims,
    /// Curiosity drives the learner.
    Curiosity,
    /// It is recalled what was there.
    Recall,
    /// Synthetic items are supposed.
    Items,
    /// Goals are pursued by policies.
    Policies,
    /// Targets are achieved by several schemas together.
    Superschemas,
}

/// The mechanisms that are on.
impl Mirror<Mechanisms> for Vec<Mechanism> {
    fn of(live: &Mechanisms) -> Self {
        let Mechanisms { claims, curiosity, recall, items, policies, superschemas } = *live;
        let all = [
            (claims, Mechanism::Claims),
            (curiosity, Mechanism::Curiosity),
            (recall, Mechanism::Recall),
            (items, Mechanism::Items),
            (policies, Mechanism::Policies),
            (superschemas, Mechanism::Superschemas),
        ];
        all.into_iter().filter_map(|(on, mechanism)| on.then_some(mechanism)).collect()
    }

    fn live(self) -> Mechanisms {
        let mut live = Mechanisms::PAPER;
        for mechanism in self {
            match mechanism {
                Mechanism::Claims => live.claims = true,
                Mechanism::Curiosity => live.curiosity = true,
                Mechanism::Recall => live.recall = true,
                Mechanism::Items => live.items = true,
                Mechanism::Policies => live.policies = true,
                Mechanism::Superschemas => live.superschemas = true,
            }
        }
        live
    }
}
