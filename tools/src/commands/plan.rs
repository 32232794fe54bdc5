//! `pschema plan PATTERN...`.

use clap::Args;
use pschema_inspect::PlanQuery;

use crate::args::{AskArgs, General, WantedArgs};
use crate::failure::Failure;
use crate::learner::Asks;
use crate::output;
use crate::past::asked;
use crate::render::goals;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema plan 'touch{}'\n  \
    pschema plan 'object{colour=blue, field=$x}' 'finger{field=$x}'\n  \
    pschema plan --most reward\n\n\
    It exits with 0 when there is a plan or the goal holds already, else with 1.")]
pub(crate) struct PlanArgs {
    #[command(flatten)]
    ask: AskArgs,
    #[command(flatten)]
    wanted: WantedArgs,
}

pub(crate) fn run(args: PlanArgs, general: &General) -> Result<(), Failure> {
    let WantedArgs { goal, again, most } = args.wanted;
    let plan = asked(&args.ask.memory, general)?.ask(PlanQuery { goal, again, most })?;
    output::show(args.ask.json, &plan, goals::plan)?;
    match plan.probability {
        Some(_) => Ok(()),
        None => Err(Failure::Failed(format!("there is no plan for {}", goals::wanted(&plan.wanted)))),
    }
}
