//! `pschema graph`.

use std::io::Write;

use pschema_inspect::{Answer, Graph, GraphQuery, Request};
use pschema_protocol::domain::LearnerName;

use crate::cli::{GraphArgs, GraphFormat};
use crate::failure::Failure;
use crate::learner::ask_for;
use crate::output;
use crate::past::asked;
use crate::render::graph::{dot, svg};

pub(crate) fn run(name: &LearnerName, args: GraphArgs) -> Result<(), Failure> {
    let mut learner = asked(name, &args.data)?;
    let query = GraphQuery { around: args.around, depth: args.depth, goal: args.goal, limit: args.limit };
    let graph = ask_for!(learner, &Request::Graph(query), Answer::Graph)?;
    let text = written(&graph, args.format)?;
    let Some(path) = &args.out else { return output::print(&text) };
    let failed = |error| Failure::Failed(format!("cannot write {}: {error}", path.display()));
    let mut file = std::fs::File::create(path).map_err(failed)?;
    file.write_all(text.as_bytes()).and_then(|()| file.sync_all()).map_err(failed)
}

fn written(graph: &Graph, format: GraphFormat) -> Result<String, Failure> {
    Ok(match format {
        GraphFormat::Svg => svg::svg(graph),
        GraphFormat::Dot => dot::dot(graph),
        GraphFormat::Json => serde_json::to_string_pretty(graph).map_err(Failure::of)? + "\n",
    })
}
