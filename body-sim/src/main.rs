//! The simulated body as a process.

use std::process::ExitCode;

use clap::Parser;
use pschema_process::{LevelFilter, Log, ended, say, usage};
use pschema_sim::{SimArgs, run};

/// The simulated body of a pschema learner: an arm, a table, blocks, a camera.
///
/// Example: `pschema-sim --name default --world wide --seed 7`
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: SimArgs,
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    Log::new(LevelFilter::INFO).begin();
    ended(
        "pschema-sim",
        run(&cli.args).map(|summary| summary.iter().for_each(|summary| say(&summary.to_string()))),
    )
}
