//! `pschema view`: the page over HTTP, as anybody may try it, and in a real browser.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod browser;
mod forged;
mod house;
mod http;
mod late;
mod measured;
mod page;
mod pictures;
