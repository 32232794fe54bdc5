//! Files that people name for a program to read.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// Opens what a person named for input: a file, a pipe, or with `-` stdin.
///
/// # Errors
/// What the operating system said when it can't be read.
pub fn input(path: &Path) -> io::Result<Box<dyn BufRead>> {
    Ok(match path.to_str() {
        Some("-") => Box::new(io::stdin().lock()),
        _ => Box::new(BufReader::new(File::open(path)?)),
    })
}
