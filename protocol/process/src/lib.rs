//! The parts that every program around a learner needs beside its work: a log on stderr ([`Log`]), a flag that signals
//! raise ([`Stop`]), threads that end with their owner ([`Worker`]), files that are held open and may be moved away
//! ([`Anchor`]), files that a person named for input ([`input`]) and for output ([`OutputFile`], [`stream()`], [`Stream`]), directories that
//! can't be had ([`no_directory`]), as many open files as are needed ([`require_descriptors`]), and the last line on stderr with the exit code that belongs to it ([`ended`]).
//!
//! ```no_run
//! use pschema_process::{LevelFilter, Log, SignalError, Stop, ended};
//!
//! fn main() -> std::process::ExitCode {
//!     Log::new(LevelFilter::INFO).begin();
//!     ended("my-body", work())
//! }
//!
//! fn work() -> Result<(), SignalError> {
//!     let stop = Stop::on_signals()?;
//!     while !stop.is_raised() {
//!         // One frame after another.
//!     }
//!     Ok(())
//! }
//! ```
#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod anchor;
mod descriptors;
mod directory;
mod input_file;
mod lines;
mod log;
mod output_file;
mod readable;
mod stop;
mod stream;
#[cfg(feature = "clap")]
mod usage;
mod worker;

use std::fmt::Display;
use std::process::ExitCode;

pub use anchor::Anchor;
pub use descriptors::{TooFewDescriptors, require_descriptors};
pub use directory::no_directory;
pub use input_file::input;
pub use log::{LevelFilter, Log, colour_is_wanted, flush, lost_lines, relay, say};
pub use output_file::{Occupied, OutputError, OutputFile, stream};
pub use readable::{number, readable};
pub use stop::{Interrupted, SignalError, Stop};
pub use stream::{Stream, unread};
#[cfg(feature = "clap")]
pub use usage::usage;
pub use worker::Worker;

/// The exit code of the program `name` after its work. A failure is said on stderr, behind the program's name.
pub fn ended<E: Display>(name: &str, result: Result<(), E>) -> ExitCode {
    let code = match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("{name}: {error}"));
            ExitCode::FAILURE
        }
    };
    flush();
    code
}
