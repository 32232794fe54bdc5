//! A command line as a program: read, logged, carried out, and ended with the exit code that belongs to it.

use std::borrow::Cow;
use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;
use pschema_process::{Log, flush, readable, say};

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

/// clap prints help and version on stdout and complaints on stderr; a reader that went away is no news. A complaint that
/// quotes more than can be read is cut.
fn usage(error: &clap::Error) -> ExitCode {
    let complaint = error.render().to_string();
    match readable(&complaint) {
        Cow::Owned(cut) if error.use_stderr() => say(cut.trim_end()),
        _ => drop(error.print()),
    }
    u8::try_from(error.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from)
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
