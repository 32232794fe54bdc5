//! Command lines that were typed wrongly.

use std::borrow::Cow;
use std::process::ExitCode;

use crate::log::say;
use crate::readable::readable;

/// What clap has to say of a command line, and the code to exit with. Help and version are for stdout and complaints for stderr; a
/// reader that went away is no news. A complaint that quotes more than can be read is cut.
pub fn usage(error: &clap::Error) -> ExitCode {
    let complaint = error.render().to_string();
    match readable(&complaint) {
        Cow::Owned(cut) if error.use_stderr() => say(cut.trim_end()),
        _ => drop(error.print()),
    }
    u8::try_from(error.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from)
}
