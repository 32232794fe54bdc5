//! `pschema view`.

use std::io::IsTerminal;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use clap::Args;
use pschema_process::{Stop, say};

use crate::args::{General, NameArgs};
use crate::failure::Failure;
use crate::output;
use crate::view::{PageOptions, ViewPage, signpost};

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema view\n  pschema view --data ~/arm --no-open\n\n\
    The address is printed on stdout; who knows it can look, and give orders. Ctrl-C ends it.")]
pub(crate) struct ViewArgs {
    #[command(flatten)]
    name: NameArgs,
    /// Look at the memory in this data directory, with or without a daemon on it; nothing in it is changed
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Serve the page on this port of this machine [default: one that is free]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Only print the address: open no browser
    #[arg(long)]
    no_open: bool,
}

pub(crate) fn run(args: ViewArgs, general: &General) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    if let Some(data) = &args.data {
        args.name.instead(data, general)?;
    }
    let wanted = PageOptions { name: args.name.learner(general)?, data: args.data, port: args.port };
    let page = ViewPage::open(&wanted)?;
    let url = page.url();
    output::print(&format!("{url}\n"))?;
    if !general.quiet() {
        say("The page is for this machine, and for whoever knows that address. Ctrl-C ends it.");
        if let Some(why) = page.waits_for() {
            say(&format!("It has nothing to show yet, and waits: {why}"));
        }
    }
    // It is removed when this ends; browsers have read it long before.
    let _signpost = if args.no_open || !has_screen() { None } else { opened(&url) };
    page.serve(&stop)
}

/// Whether there is somebody to open a browser for.
fn has_screen() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    std::io::stderr().is_terminal() && (set("DISPLAY") || set("WAYLAND_DISPLAY"))
}

/// Has the desktop open the page. Where it can't, the address has been printed.
fn opened(url: &str) -> Option<tempfile::NamedTempFile> {
    let file = signpost(url, &std::env::temp_dir())
        .inspect_err(|error| tracing::info!(%error, "no browser is opened"))
        .ok()?;
    let mut open = Command::new("xdg-open");
    open.arg(file.path()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    match open.spawn() {
        Ok(mut child) => {
            // It ends by itself; somebody has to take note of that.
            std::thread::spawn(move || drop(child.wait()));
            Some(file)
        }
        Err(error) => {
            tracing::info!(%error, "no browser is opened");
            None
        }
    }
}
