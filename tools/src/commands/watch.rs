//! `pschema watch`.

use clap::Args;
use pschema_protocol::domain::{Place, RuntimeDir};

use crate::args::{General, OrderArgs};
use crate::failure::Failure;
use crate::output;
use crate::watch::{WatchPage, once, watch};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema watch\n  pschema watch --rate 2 --page choice\n  \
    pschema watch --once --width 120 --height 40\n\n\
    Keys: space holds the learner and lets it go on, . takes one step, w says words, f follows a schema, ? has the \
    rest, q quits.")]
pub(crate) struct WatchArgs {
    #[command(flatten)]
    order: OrderArgs,
    /// How often a second to look, at most
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=30))]
    rate: u8,
    /// The page to begin with
    #[arg(long, value_enum, default_value_t)]
    page: WatchPage,
    /// Follow the schema of this number
    #[arg(long, value_name = "ID")]
    follow: Option<u32>,
    /// Print one frame as plain text, and end
    #[arg(long, conflicts_with = "rate")]
    once: bool,
    /// Columns of that frame
    #[arg(long, default_value_t = 80, requires = "once", conflicts_with = "rate", value_name = "N", value_parser = clap::value_parser!(u16).range(40..=500))]
    width: u16,
    /// Rows of it
    #[arg(long, default_value_t = 24, requires = "once", conflicts_with = "rate", value_name = "N", value_parser = clap::value_parser!(u16).range(10..=500))]
    height: u16,
}

impl WatchArgs {
    /// Whether the terminal is drawn on, and not only printed to.
    pub(crate) fn draws(&self) -> bool {
        !self.once
    }
}

pub(crate) fn run(args: WatchArgs, general: &General) -> Result<(), Failure> {
    if let Some(data) = &args.order.data {
        let data = data.display();
        return Err(Failure::Usage(format!(
            "`watch` needs a learner that is running: start `pschema server --data {data}` and watch that. What was, \
             `pschema status`, `schemas`, `show` and `explain` tell with --data {data} --until N"
        )));
    }
    let place = Place::new(RuntimeDir::from_environment()?, args.order.name.learner(general)?);
    if args.once {
        return output::print(&once(&place, args.page, args.follow, args.width, args.height)?);
    }
    watch(place, args.rate, args.page, args.follow)
}
