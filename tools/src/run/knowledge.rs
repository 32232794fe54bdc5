//! What a run left in memory that is worth showing.

use pschema_inspect::{DetailQuery, SchemaDetail, SchemaQuery, SchemaSort};

use crate::failure::Failure;
use crate::learner::Asks;

/// Generalised schemas, and counter-examples, shown at most.
const SHOWN_MAX: usize = 4;

/// Generalised schemas and where they do not hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Knowledge {
    /// The most executed generalised schemas.
    pub(crate) generalised: Vec<SchemaDetail>,
    /// Counter-examples of theirs.
    pub(crate) exceptions: Vec<SchemaDetail>,
}

impl Knowledge {
    /// Asks for them.
    pub(crate) fn ask(asked: &mut impl Asks) -> Result<Self, Failure> {
        let query = SchemaQuery {
            generalised: true,
            sort: SchemaSort::Uses,
            limit: SHOWN_MAX as u32,
            ..SchemaQuery::default()
        };
        let list = asked.ask(query)?;
        let mut show = |id: u32| asked.ask(DetailQuery { id });
        let generalised = list.schemas.iter().map(|s| show(s.id)).collect::<Result<Vec<_>, _>>()?;
        let exceptions = generalised.iter().flat_map(|s| s.counter_examples.iter().copied()).take(SHOWN_MAX);
        let exceptions = exceptions.map(&mut show).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { generalised, exceptions })
    }
}
