//! `pschema explain`.

use clap::Args;
use pschema_inspect::{ExplanationQuery, WhyNotQuery};

use crate::args::{AskArgs, General};
use crate::failure::Failure;
use crate::output;
use crate::past::answered;
use crate::render::{explanation, why_not};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema explain\n  pschema explain --step 228 --candidates 3\n  \
    pschema explain --why-not 42\n  pschema explain --data ~/arm --step 228")]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    ask: AskArgs,
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
}

pub(crate) fn run(args: ExplainArgs, general: &General) -> Result<(), Failure> {
    let (AskArgs { memory, json }, step) = (&args.ask, args.step);
    if let Some(schema) = args.why_not {
        let answer = answered(memory, general, WhyNotQuery { schema, step })?;
        return output::show(*json, &answer, why_not::why_not);
    }
    let query = ExplanationQuery { step, candidates_max: args.candidates };
    output::show(*json, &answered(memory, general, query)?, explanation::explanation)
}
