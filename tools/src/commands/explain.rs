//! `pschema explain`.

use clap::Args;
use pschema_inspect::{ExplanationQuery, WhyNotQuery};

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::output;
use crate::past::answered;
use crate::render::{explanation, why_not};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema explain\n  pschema explain --step 228 --candidates 3\n  \
    pschema explain --why-not 42\n  pschema explain --data ~/arm --step 228")]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    memory: MemoryArgs,
    /// The decision of this step; the last one unless named. A daemon has the latest 64 at hand; older ones are made
    /// again from its data directory, if it has one
    #[arg(long, value_name = "N")]
    step: Option<u64>,
    /// Say what stood in the way of this schema instead
    #[arg(long, value_name = "ID", conflicts_with = "candidates")]
    why_not: Option<u32>,
    /// How many of the things it could have done to list
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    candidates: u32,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: ExplainArgs, general: &General) -> Result<(), Failure> {
    let step = args.step;
    match args.why_not {
        Some(schema) => {
            let answer = answered(&args.memory, general, WhyNotQuery { schema, step })?;
            output::show(args.json, &answer, why_not::why_not)
        }
        None => {
            let query = ExplanationQuery { step, candidates_max: args.candidates };
            output::show(args.json, &answered(&args.memory, general, query)?, explanation::explanation)
        }
    }
}
