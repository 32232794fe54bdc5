//! Schemas.

use pschema_learner::schema as live;
use serde::{Deserialize, Serialize};

use super::observation::{Count, Pattern};
use crate::format::mirror::{Mirror, mirror};

/// What is observed after the action, or no longer observed: an observation of a concrete schema, by its number, or a
/// pattern of a generalised one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PostCondition<T> {
    /// The observation or the pattern.
    what: T,
    /// Whether it is "no longer": a pre-condition that the action takes away.
    absent: bool,
    /// In how many executions it held, of those in which its sense was not constrained.
    count: Count,
}

impl<A: Mirror<B>, B> Mirror<live::PostCondition<B>> for PostCondition<A> {
    fn of(live::PostCondition { what, absent, count }: &live::PostCondition<B>) -> Self {
        Self { what: A::of(what), absent: *absent, count: Mirror::of(count) }
    }

    fn live(self) -> live::PostCondition<B> {
        live::PostCondition { what: self.what.live(), absent: self.absent, count: self.count.live() }
    }
}

mirror! {
    /// An associated observation.
    struct Association = live::Association {
        /// The number of the observation.
        observation: u32,
        /// In how many executions it was there, of those since it was first there.
        count: Count,
        /// The step in which it was first there.
        since_step: u64,
    }

    /// A concrete schema.
    struct Concrete = live::Concrete {
        /// Numbers of the observations that are its pre-conditions.
        pre: Vec<u32>,
        /// The number of its primitive.
        action: u32,
        /// Its post-conditions.
        post: Vec<PostCondition<u32>>,
        /// The generalised schema whose prediction failed here, if this is a counter-example.
        contradicts: Option<u32>,
    }

    /// A generalised schema.
    struct Generalised = live::Generalised {
        /// Its pre-conditions.
        pre: Vec<Pattern>,
        /// The observations that are to be achieved, by whichever schema achieves them most surely.
        target: Vec<Pattern>,
        /// Its post-conditions.
        post: Vec<PostCondition<Pattern>>,
        /// Numbers of the concrete schemas that it represents.
        examples: Vec<u32>,
        /// Numbers of the concrete schemas that were made where it failed.
        counter_examples: Vec<u32>,
        /// Whether it is taken out of use, because it failed too often.
        retired: bool,
    }

    /// What a schema says.
    enum Form = live::Form {
        /// Of observations and one action.
        Concrete(form: Concrete),
        /// Of patterns.
        Generalised(form: Box<Generalised>),
    }

    /// A schema with its statistics.
    struct Schema = live::Schema {
        /// What it says.
        form: Form,
        /// `trials`: how often it was executed; `occurrences`: how often all that it predicts happened.
        executions: Count,
        /// Observations that it is associated with.
        associations: Vec<Association>,
        /// The schema whose execution led to this one.
        parent: Option<u32>,
        /// The step that made it.
        created_step: u64,
    }
}
