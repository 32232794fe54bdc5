//! `pschema graph`.

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use pschema_inspect::{Graph, GraphQuery};
use pschema_process::{Occupied, OutputFile};

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::output;
use crate::past::asked;
use crate::render::graph::{dot, svg};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema graph --out schemas.svg\n  \
    pschema graph --around 226 --depth 2 --out touching.svg\n  \
    pschema graph --goal 'touch{}' --format dot | dot -Tpdf -o chain.pdf")]
pub(crate) struct GraphArgs {
    #[command(flatten)]
    memory: MemoryArgs,
    /// Only what is tied to this schema
    #[arg(long, value_name = "ID")]
    around: Option<u32>,
    /// How many ties away from it
    #[arg(long, value_name = "N", default_value_t = 1, requires = "around", conflicts_with = "goal", value_parser = clap::value_parser!(u32).range(1..=8))]
    depth: u32,
    /// Only the chain that would bring this about from the world as it is; several patterns must hold at once
    #[arg(long, value_name = "PATTERN", conflicts_with = "around", num_args = 1..=8)]
    goal: Vec<String>,
    /// Schemas to draw one by one, at most; the others stand together, counted
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(1..=5000))]
    limit: u32,
    /// A picture for browsers, a text for Graphviz, or data
    #[arg(long, value_enum, default_value_t)]
    format: GraphFormat,
    /// Write it to this file, which must not be there yet; to stdout unless named
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace the file if it is there
    #[arg(long, requires = "out")]
    overwrite: bool,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum GraphFormat {
    /// A picture that can be zoomed
    #[default]
    Svg,
    /// The language of Graphviz
    Dot,
    /// Nodes and ties
    Json,
}

pub(crate) fn run(args: GraphArgs, general: &General) -> Result<(), Failure> {
    let occupied = Occupied::overwritten(args.overwrite);
    let file = args
        .out
        .as_deref()
        .map(|path| OutputFile::prepare(output::named(path), occupied, &Arc::default()))
        .transpose()?;
    let mut memory = asked(&args.memory, general)?;
    let query = GraphQuery { around: args.around, depth: args.depth, goal: args.goal, limit: args.limit };
    let graph = memory.ask(query)?;
    let text = written(&graph, args.format)?;
    let Some(file) = file else { return output::print(&text) };
    Ok(file.hold(text.as_bytes())?)
}

fn written(graph: &Graph, format: GraphFormat) -> Result<String, Failure> {
    Ok(match format {
        GraphFormat::Svg => svg::svg(graph),
        GraphFormat::Dot => dot::dot(graph),
        GraphFormat::Json => serde_json::to_string_pretty(graph).map_err(Failure::of)? + "\n",
    })
}
