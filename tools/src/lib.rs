//! The `pschema` command: one binary for people, one file a subcommand.
//!
//! What it prints on stdout is the result; what it says while at it goes to stderr. `docs/CLI.md` has the
//! commands, the exit codes and the JSON.

mod bar;
mod bench;
mod cli;
mod commands;
mod failure;
mod learner;
mod output;
mod past;
mod record;
mod render;
mod report;
mod run;
mod talk;
mod view;
mod watch;

use std::process::ExitCode;

use clap::Parser;

use failure::Failure;

/// Runs the command that this process was started with, and gives the code to exit with: 0 done, 1 failed,
/// 2 wrong usage, 3 no daemon running.
#[must_use]
pub fn main() -> ExitCode {
    let cli = match cli::Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    talk::begin(&cli);
    match commands::run(cli) {
        Ok(()) | Err(Failure::NobodyReads) => ExitCode::SUCCESS,
        Err(failure) => {
            talk::complain(&failure);
            failure.exit_code()
        }
    }
}

/// Whether a command line would be taken: `arguments` begin with the program's name. For those who check what is written about
/// the commands.
///
/// # Errors
/// What the command would say about it.
pub fn check_usage(arguments: &[String]) -> Result<(), String> {
    use clap::error::ErrorKind::{DisplayHelp, DisplayVersion};
    match cli::Cli::try_parse_from(arguments) {
        Ok(_) => Ok(()),
        Err(error) if matches!(error.kind(), DisplayHelp | DisplayVersion) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}

/// clap prints help and version on stdout and complaints on stderr; a reader that went away is no news.
fn usage(error: &clap::Error) -> ExitCode {
    drop(error.print());
    u8::try_from(error.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from)
}
