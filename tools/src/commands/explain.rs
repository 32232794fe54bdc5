//! `pschema explain`.

use clap::Args;
use pschema_inspect::{Answer, Request};

use crate::args::{General, MemoryArgs};
use crate::failure::Failure;
use crate::learner::unexpected;
use crate::output;
use crate::past::answered;
use crate::render::{explanation, json, why_not};

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
    let request = match args.why_not {
        Some(schema) => Request::WhyNot { schema, step: args.step },
        None => Request::Explain { step: args.step, candidates_max: args.candidates },
    };
    match (answered(&args.memory, general, &request)?, args.json) {
        (Answer::Explanation(told), true) => output::print_json(&json::Reasons::from(&*told)),
        (Answer::Explanation(told), false) => output::print(&explanation::explanation(&told)),
        (Answer::WhyNot(told), true) => output::print_json(&why_not::Json::from(&*told)),
        (Answer::WhyNot(told), false) => output::print(&why_not::why_not(&told)),
        (other, _) => Err(unexpected(&other)),
    }
}
