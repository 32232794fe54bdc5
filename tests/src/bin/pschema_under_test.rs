//! The `pschema` command again: the binary that cargo builds for these tests to start.

fn main() -> std::process::ExitCode {
    pschema_tools::main()
}
