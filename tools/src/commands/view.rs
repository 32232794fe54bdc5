//! `pschema view`.

use std::io::IsTerminal;
use std::process::{Command, Stdio};

use pschema_protocol::domain::LearnerName;

use crate::cli::ViewArgs;
use crate::failure::Failure;
use crate::run::Stop;
use crate::view::{Page, Wanted, signpost};
use crate::{output, talk};

pub(crate) fn run(name: &LearnerName, args: &ViewArgs, quiet: bool) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let wanted = Wanted { name: name.clone(), data: args.data.clone(), port: args.port };
    let page = Page::open(&wanted)?;
    let url = page.url();
    output::print(&format!("{url}\n"))?;
    if !quiet {
        talk::say("The page is for this machine, and for whoever knows that address. Ctrl-C ends it.");
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
