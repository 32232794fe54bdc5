//! The learner daemon as a program of its own; `pschema server` is the same.

fn main() -> std::process::ExitCode {
    pschema_server::program()
}
