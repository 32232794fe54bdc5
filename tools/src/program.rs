//! A command line as a program: read, logged, carried out, and ended with the exit code that belongs to it.

use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;
use pschema_process::{Log, flush, say, usage};

use crate::failure::Failure;

/// Runs the command that this process was started with, and gives the code to exit with: 0 done, 1 failed,
/// 2 wrong usage, 3 no daemon running. A failure is said on stderr, behind the program's `name`.
pub fn program<C: Parser>(
    name: &str,
    log: impl FnOnce(&C) -> Log,
    run: impl FnOnce(C) -> Result<(), Failure>,
) -> ExitCode {
    let command = match C::try_parse() {
        Ok(command) => command,
        Err(error) => return usage(&error),
    };
    log(&command).begin();
    let code = match run(command) {
        Ok(()) | Err(Failure::NobodyReads) => ExitCode::SUCCESS,
        Err(failure) => {
            say(&format!("{name}: {failure}"));
            failure.exit_code()
        }
    };
    flush();
    code
}

/// Whether a command line would be accepted: `arguments` begin with the program's name.
///
/// # Errors
/// The complaint about it.
pub fn check_usage<C: Parser>(arguments: &[String]) -> Result<(), String> {
    match C::try_parse_from(arguments) {
        Ok(_) => Ok(()),
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}
