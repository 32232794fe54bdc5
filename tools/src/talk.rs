//! What is said on stderr while a command is at it.

use std::io::{self, IsTerminal, Write};

use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

use crate::cli::{Cli, Command};
use crate::failure::Failure;
use crate::output;

/// Starts logging on stderr, as JSON if so asked. `RUST_LOG` decides what is logged when it is set, else `-v`
/// and `-q` do, from what is usual for the command: a daemon or a body tells what it does, everything else is
/// silent while all is well.
pub(crate) fn begin(cli: &Cli) {
    const LEVELS: [LevelFilter; 4] =
        [LevelFilter::WARN, LevelFilter::INFO, LevelFilter::DEBUG, LevelFilter::TRACE];
    let usual = usize::from(matches!(cli.command, Command::Server(_) | Command::Sim(_)));
    let asked = LEVELS.get(usual + usize::from(cli.verbose)).copied().unwrap_or(LevelFilter::TRACE);
    // A log would be written all over what is drawn on the same terminal.
    let drawn_on = matches!(&cli.command, Command::Watch(watch) if !watch.once) && io::stderr().is_terminal();
    let level = match (drawn_on, cli.quiet) {
        (true, _) => LevelFilter::OFF,
        (false, true) => LevelFilter::ERROR,
        (false, false) => asked,
    };
    let json = matches!(&cli.command, Command::Server(server) if server.log_json);
    let filter = EnvFilter::builder().with_default_directive(level.into()).from_env_lossy();
    let coloured = io::stderr().is_terminal() && output::wanted();
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(io::stderr).with_ansi(coloured);
    // A log that nobody reads any more (the other end of the pipe died) must not end a daemon.
    let log = log.log_internal_errors(false);
    let begun = if json { log.json().try_init() } else { log.with_target(false).try_init() };
    if let Err(error) = begun {
        // A process that has a log already keeps it.
        tracing::debug!(error, "the log was begun before");
    }
}

/// Says a line on stderr. Nobody listening there is no reason to stop.
pub(crate) fn say(line: &str) {
    drop(writeln!(io::stderr(), "{line}"));
}

/// Says on stderr why a command could not be done.
pub(crate) fn complain(failure: &Failure) {
    say(&format!("pschema: {failure}"));
}
