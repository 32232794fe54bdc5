//! `pschema completions SHELL`.

use clap::{Args, Command};
use clap_complete::Shell;

use crate::failure::Failure;
use crate::output;

#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pschema completions bash > ~/.local/share/bash-completion/completions/pschema"
)]
pub(crate) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Prints the script for the shell; `command` is the tree of all commands.
pub(crate) fn run(args: CompletionsArgs, mut command: Command) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "pschema", &mut script);
    output::print(&String::from_utf8_lossy(&script))
}
