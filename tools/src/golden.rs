//! Texts compared with the files in `tests/golden`. `UPDATE_EXPECT=1` writes the files anew (see CONTRIBUTING.md).

use std::path::Path;

use expect_test::expect_file;
use serde::Serialize;

/// Compares a text with the file of this name.
pub(crate) fn check(name: &str, text: &str) {
    expect_file![Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name)].assert_eq(text);
}

/// Compares a text for people with the file of this name. It must fit a terminal of 80 columns and need no colour.
pub(crate) fn check_text(name: &str, text: &str) {
    check(name, text);
    let widest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
    assert!(widest <= 80, "{name} is {widest} columns wide");
    assert!(!text.contains('\x1b'), "{name} is readable without colour");
}

/// Compares the JSON of a value with the file of this name.
pub(crate) fn check_json(name: &str, value: &impl Serialize) {
    check(name, &(serde_json::to_string_pretty(value).unwrap() + "\n"));
}
