//! The Adept body as a process.

use std::process::ExitCode;

use clap::Parser;
use pschema_adept::{AdeptArgs, run};
use pschema_process::{LevelFilter, Log, ended, say, usage};

/// The real body of a pschema learner: an Adept arm on a serial line, with a camera.
///
/// Example: `pschema-adept --port /dev/ttyS0 --arm arm.toml --camera 'exec:ffmpeg -loglevel error -f v4l2 -i
/// /dev/video0 -f rawvideo -pix_fmt rgb24 -'`
#[derive(Parser)]
#[command(version)]
struct Cli {
    #[command(flatten)]
    args: AdeptArgs,
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    Log::new(LevelFilter::INFO).begin();
    ended(
        "pschema-adept",
        run(&cli.args).map(|summary| summary.iter().for_each(|summary| say(&summary.to_string()))),
    )
}
