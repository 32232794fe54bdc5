//! The `pschema` command: one binary for people, one file a subcommand.
//!
//! It prints the result on stdout, and what it says meanwhile on stderr. `docs/CLI.md` has the
//! commands, the exit codes and the JSON.

mod args;
mod bar;
mod cli;
mod commands;
mod conformance;
mod design;
mod failure;
#[cfg(test)]
mod golden;
mod learner;
mod output;
mod past;
mod program;
mod record;
mod render;
mod report;
mod run;
mod view;
mod watch;

use std::process::ExitCode;

use cli::Cli;

/// Runs the command that this process was started with, and gives the code to exit with: 0 done, 1 failed,
/// 2 wrong usage, 3 no daemon running.
#[must_use]
pub fn main() -> ExitCode {
    program::program("pschema", Cli::log, Cli::run)
}

/// Whether a command line would be accepted: `arguments` begin with the program's name. For a test of the commands that the
/// documentation shows.
///
/// # Errors
/// The complaint about it.
pub fn check_usage(arguments: &[String]) -> Result<(), String> {
    program::check_usage::<Cli>(arguments)
}

/// The parts of this command that `pschema-bench` is made of as well. They are no interface for anyone else, and change
/// without notice.
#[doc(hidden)]
pub mod kit {
    pub use crate::args::{Loudness, ParentArgs};
    pub use crate::bar::Bar;
    pub use crate::commands::server::serve;
    pub use crate::failure::Failure;
    pub use crate::output::show;
    pub use crate::past::MemoryOnDisk;
    pub use crate::program::{check_usage, program};
    pub use crate::render::explanation::explanation;
    pub use crate::render::graph::svg::svg as graph_svg;
    pub use crate::render::schema::wrapped;
    pub use crate::render::statistics::{Summary, interval, percentile, summary};
    pub use crate::render::table::Columns;
    pub use crate::render::why_not::why_not;
    pub use crate::render::words::{bytes, duration, notation};
    pub use crate::run::{Child, Seeds, follow_parent, runtime_directory};
}
