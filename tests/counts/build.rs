//! Tells the program which compiler compiles it.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let rustc = std::env::var_os("RUSTC").expect("cargo says which compiler it uses");
    let version = Command::new(rustc).arg("--version").output().expect("a compiler says its version");
    println!("cargo::rustc-env=PSCHEMA_COUNTS_RUSTC={}", String::from_utf8_lossy(&version.stdout).trim());
}
