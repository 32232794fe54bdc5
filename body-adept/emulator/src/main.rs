//! The emulated controller as a process.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use pschema_process::{LevelFilter, Log, Stop, ended, say, usage};
use pschema_vplus_emulator::{EmulatorArgs, run, teach};

const NAME: &str = "pschema-vplus-emulator";

/// A V+ controller on a pseudo-terminal, with a simulated arm behind it.
///
/// Example: `pschema-vplus-emulator --link /tmp/adept --camera /tmp/adept-camera --operator /tmp/adept-operator`
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: Option<EmulatorArgs>,
    /// Print the tables that come of teaching the arm in this world, for an arm file, and end.
    #[arg(long, value_name = "WORLD", exclusive = true)]
    teach: Option<String>,
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    Log::new(LevelFilter::INFO).begin();
    if let Some(world) = &cli.teach {
        return ended(
            NAME,
            teach::tables(world).map(|text| drop(std::io::stdout().write_all(text.as_bytes()))),
        );
    }
    let Some(args) = cli.args else {
        say(&format!("{NAME}: --link PATH is missing: where drivers shall find the line"));
        return ExitCode::from(2);
    };
    let stop = match Stop::on_signals() {
        Ok(stop) => stop.flag(),
        Err(error) => return ended(NAME, Err(error)),
    };
    let ready = || tracing::info!(line = %args.link.display(), world = %args.world, "ready");
    ended(NAME, run(&args, &stop, ready))
}
