//! The `pschema` command; all of it is in the library, so that other binaries can be it too.

use std::process::ExitCode;

fn main() -> ExitCode {
    pschema_tools::main()
}
