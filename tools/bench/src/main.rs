//! The `pschema-bench` program.

fn main() -> std::process::ExitCode {
    pschema_bench::main()
}
