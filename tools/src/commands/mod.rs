//! The subcommands, one file each: what can be typed behind the command, and what it does.

pub(crate) mod achieve;
pub(crate) mod adept;
pub(crate) mod claims;
pub(crate) mod completions;
pub(crate) mod conformance;
pub(crate) mod demo;
pub(crate) mod doctor;
pub(crate) mod emulator;
pub(crate) mod experiment;
pub(crate) mod explain;
pub(crate) mod export;
pub(crate) mod graph;
pub(crate) mod import;
pub(crate) mod journal;
pub(crate) mod plan;
pub(crate) mod predict;
pub(crate) mod record;
pub(crate) mod repair;
pub(crate) mod replay;
pub(crate) mod say;
pub(crate) mod schemas;
pub(crate) mod server;
pub(crate) mod show;
pub(crate) mod sim;
pub(crate) mod stage;
pub(crate) mod status;
pub(crate) mod verify;
pub(crate) mod view;
pub(crate) mod watch;

#[cfg(test)]
mod tests;
