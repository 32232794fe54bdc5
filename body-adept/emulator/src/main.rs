//! The emulated controller as a process.

use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use pschema_vplus_emulator::{EmulatorArgs, run, teach};
use tracing_subscriber::EnvFilter;

/// A V+ controller on a pseudo-terminal, with a simulated arm behind it.
///
/// Example: `pschema-vplus-emulator --link /tmp/adept --camera /tmp/adept-camera --operator /tmp/adept-operator`
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: Option<EmulatorArgs>,
    /// Print the tables that teaching the arm in this world gives, for an arm's file, and end.
    #[arg(long, value_name = "WORLD", exclusive = true)]
    teach: Option<String>,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    log.log_internal_errors(false).init();
    if let Some(world) = &cli.teach {
        return ended(teach::tables(world).map(|text| drop(std::io::stdout().write_all(text.as_bytes()))));
    }
    let Some(args) = cli.args else {
        say("pschema-vplus-emulator: --link PATH is missing: where drivers shall find the line");
        return ExitCode::from(2);
    };
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM] {
        let registered = signal_hook::flag::register_conditional_shutdown(signal, 1, stop.clone())
            .and_then(|_| signal_hook::flag::register(signal, stop.clone()));
        if let Err(error) = registered {
            say(&format!("pschema-vplus-emulator: cannot handle signals: {error}"));
            return ExitCode::FAILURE;
        }
    }
    let ready = || tracing::info!(line = %args.link.display(), world = %args.world, "ready");
    ended(run(&args, &stop, ready))
}

fn ended<E: std::fmt::Display>(result: Result<(), E>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("pschema-vplus-emulator: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Not `eprintln`, which panics when nobody reads any more.
fn say(line: &str) {
    drop(writeln!(std::io::stderr(), "{line}"));
}
