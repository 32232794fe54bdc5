//! The Adept body as a process.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use pschema_adept::{AdeptArgs, run};
use tracing_subscriber::EnvFilter;

/// The real body of a pschema learner: an Adept arm on a serial line, with a camera.
///
/// Example: `pschema-adept --port /dev/ttyS0 --arm arm.toml --camera 'exec:ffmpeg -loglevel error -f v4l2 -i /dev/video0
/// -f rawvideo -pix_fmt rgb24 -'`
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: AdeptArgs,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new("info"));
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(std::io::stderr);
    // A log that nobody reads any more (the other end of the pipe died) must not end a body.
    log.log_internal_errors(false).init();
    match run(&cli.args) {
        Ok(summary) => {
            if let Some(summary) = summary {
                let (frames, orders, ending) = (summary.frames, summary.orders, summary.ending);
                say(&format!("{frames} frames, {orders} orders; ended: {ending:?}"));
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            say(&format!("pschema-adept: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// Not `eprintln`, which panics when nobody reads any more.
fn say(line: &str) {
    drop(writeln!(std::io::stderr(), "{line}"));
}
