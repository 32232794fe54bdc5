//! `pschema say WORD...`.

use clap::Args;
use pschema_inspect::{SayOrder, StageState};

use crate::args::{General, OrderArgs};
use crate::failure::Failure;
use crate::learner::Learner;
use crate::output;
use crate::render::words::plain;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema say touch")]
pub(crate) struct SayArgs {
    #[command(flatten)]
    order: OrderArgs,
    /// The words, heard together in the learner's next frame
    #[arg(required = true, value_name = "WORD")]
    words: Vec<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: SayArgs, general: &General) -> Result<(), Failure> {
    let name = args.order.learner(general, "`say`")?;
    let said = args.words.join(" ");
    let report = Learner::connect_as_operator(&name)?.ask(SayOrder { words: args.words })?;
    if args.json {
        output::print_json(&report)
    } else {
        let when = if report.stage_state == StageState::Held {
            "is held, and hears it when it steps or goes on"
        } else {
            "hears it next"
        };
        output::print(&format!("Said {:?} after step {}; {name} {when}.\n", plain(&said), report.step))
    }
}
