//! Counts the instructions and the allocations of the work that is done most often, and compares them with the budgets in
//! `tests/budgets.toml`. Unlike times, counts are the same on a busy machine and on an idle one, so a small change of a
//! budget tells of a change of the code.
//!
//! Each work is done twice, each time by a process of its own: once natively, which counts allocations, and once under
//! callgrind, which counts instructions. Learning up to 100,000 schemas would take hours under callgrind. So each life is lived
//! natively, and kept on disk whenever memory has come to a size that is counted at.
#![forbid(unsafe_code)]

mod budgets;
mod callgrind;
mod counted;
mod failure;
mod pool;
mod work;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::{Parser, Subcommand};
use pschema_worlds::Mix;
use tempfile::TempDir;

use budgets::{Budgets, Cost};
use counted::Tally;
use failure::CountFailure;
use work::Work;

/// Count instructions and allocations, and compare them with tests/budgets.toml
#[derive(Debug, Parser)]
#[command(name = "pschema-counts", version)]
struct Cli {
    /// Count only works whose names contain this
    #[arg(long, value_name = "PART", conflicts_with = "rewrite")]
    only: Option<String>,
    /// Write what is counted into the file of budgets, in place of what is there
    #[arg(long)]
    rewrite: bool,
    /// The file of budgets
    #[arg(long, value_name = "FILE", default_value = "tests/budgets.toml")]
    budgets: PathBuf,
    #[command(subcommand)]
    part: Option<Part>,
}

/// What a process of its own does for this program.
#[derive(Debug, Subcommand)]
enum Part {
    /// Lives in a world, and keeps memory in a directory at each size that is counted at
    #[command(hide = true)]
    Live { mix: Mix, directory: PathBuf },
    /// Does one work on what was kept in a directory, and prints its tally
    #[command(hide = true)]
    Work { name: String, directory: PathBuf },
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.part {
        None => count(&cli),
        Some(Part::Live { mix, directory }) => work::step::live(*mix, directory).map(|()| true),
        Some(Part::Work { name, directory }) => tally(name, directory).map(|()| true),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(failure) => {
            eprintln!("pschema-counts: {failure}");
            ExitCode::FAILURE
        }
    }
}

fn tally(name: &str, directory: &Path) -> Result<(), CountFailure> {
    let tally = Work::named(name)?.carry_out(directory)?;
    println!("{}", serde_json::to_string(&tally)?);
    Ok(())
}

/// Counts, and says whether every budget is kept.
fn count(cli: &Cli) -> Result<bool, CountFailure> {
    let began = Instant::now();
    let works: Vec<Work> = Work::all()
        .into_iter()
        .filter(|work| cli.only.as_ref().is_none_or(|part| work.name().contains(part.as_str())))
        .collect();
    let budgets = Budgets::read(&cli.budgets);
    // A file that is about to be rewritten may be missing.
    let budgets = if cli.rewrite { budgets.unwrap_or_default() } else { budgets? };
    let has_callgrind = callgrind::is_here();
    if !has_callgrind && cli.rewrite {
        return Err(CountFailure::NoValgrind);
    }
    let lives = TempDir::with_prefix("pschema-counts-").map_err(CountFailure::Directory)?;
    let counted = count_all(&works, lives.path(), has_callgrind)?;
    let seconds = began.elapsed().as_secs();
    if cli.rewrite {
        Budgets::of(&counted).write(&cli.budgets)?;
        println!("{} budgets written to {} in {seconds} s", counted.len(), cli.budgets.display());
        return Ok(true);
    }
    let comparison = budgets.compare(&counted, cli.only.is_none());
    println!("{}counted in {seconds} s", comparison.text);
    if !has_callgrind {
        println!("Instructions were not counted: {}", CountFailure::NoValgrind);
    }
    Ok(comparison.is_kept)
}

/// The cost of each work, in the order of `works`.
fn count_all(works: &[Work], lives: &Path, has_callgrind: bool) -> Result<Vec<(Work, Cost)>, CountFailure> {
    // The last mix is the one whose life takes longest.
    let mixes = Mix::ALL.into_iter().rev().filter(|mix| works.iter().any(|work| work.life() == Some(*mix)));
    pool::each(mixes, |mix| pool::own_process(&["live", mix.name()], lives, &[]).map(drop))?;
    // Those that take longest come first, so that no core waits for them in the end.
    let mut longest_first = works.to_vec();
    longest_first.sort_by_key(|work| std::cmp::Reverse(work.schemas()));
    let mut costs = pool::each(longest_first.into_iter(), |work| {
        let cost = cost(work, lives, has_callgrind)?;
        Ok((work, cost))
    })?;
    costs.sort_by_key(|(work, _)| works.iter().position(|other| other == work));
    Ok(costs)
}

/// Does one work natively and, when there is callgrind, once more under it.
fn cost(work: Work, lives: &Path, has_callgrind: bool) -> Result<Cost, CountFailure> {
    let name = work.name();
    let arguments = ["work", &name];
    let natively: Tally = serde_json::from_slice(&pool::own_process(&arguments, lives, &[])?)?;
    if !has_callgrind {
        return Ok(Cost::of(&natively, None));
    }
    let profile = lives.join(format!("{}.callgrind", name.replace('/', "-")));
    let callgrind = callgrind::command(&profile, work.elsewhere());
    let watched: Tally = serde_json::from_slice(&pool::own_process(&arguments, lives, &callgrind)?)?;
    if watched != natively {
        return Err(CountFailure::Unrepeatable { work: name, natively, watched });
    }
    let instructions = callgrind::instructions(&profile, work.elsewhere())?;
    Ok(Cost::of(&natively, Some(instructions)))
}
