//! Schemas.

use pschema_learner::schema as live;
use serde::{Deserialize, Serialize};

use super::observation::{Count, Pattern};
use crate::format::mirror::{Mirror, mirror};

/// What is observed after the action, or no longer observed: an observation of a concrete schema, by its number, or a
/// pattern of a generalised one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PostCondition<T> {
    what: T,
    absent: bool,
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
        observation: u32,
        count: Count,
        since_step: u64,
    }

    /// A concrete schema.
    struct Concrete = live::Concrete {
        pre: Vec<u32>,
        action: u32,
        post: Vec<PostCondition<u32>>,
        contradicts: Option<u32>,
    }

    /// A generalised schema.
    struct Generalised = live::Generalised {
        pre: Vec<Pattern>,
        target: Vec<Pattern>,
        post: Vec<PostCondition<Pattern>>,
        examples: Vec<u32>,
        counter_examples: Vec<u32>,
        retired: bool,
    }

    /// What a schema says.
    enum Form = live::Form {
        Concrete(form: Concrete),
        Generalised(form: Box<Generalised>),
    }

    /// A schema with its statistics.
    struct Schema = live::Schema {
        form: Form,
        executions: Count,
        associations: Vec<Association>,
        parent: Option<u32>,
        created_step: u64,
    }
}
