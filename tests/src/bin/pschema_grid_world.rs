//! The example of how to write a body, as a binary that cargo builds for these tests to start.

#[path = "../../../protocol/examples/grid_world.rs"]
mod grid_world;

fn main() -> std::process::ExitCode {
    grid_world::main()
}
