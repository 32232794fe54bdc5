//! `pschema schemas`.

use pschema_inspect::{Answer, Request, SchemaQuery};
use pschema_protocol::domain::LearnerName;

use crate::cli::SchemasArgs;
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::schema;

pub(crate) fn run(name: &LearnerName, args: SchemasArgs) -> Result<(), Failure> {
    let mut learner = asked(name, &args.data)?;
    let query = SchemaQuery {
        action: args.action,
        pre: args.pre,
        post: args.post,
        generalised: args.generalised,
        sort: args.sort.into(),
        limit: args.limit,
        offset: args.offset,
    };
    let answer = ask_for!(learner, &Request::Schemas(query), Answer::Schemas)?;
    if args.json { output::print_json(&answer) } else { output::print(&schema::list(&answer, args.offset)) }
}
