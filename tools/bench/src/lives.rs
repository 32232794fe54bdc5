//! Lives in the worlds of `pschema-worlds`, measured whenever memory has grown to one of the sizes asked for.

use std::collections::BTreeMap;
use std::process::{Command, Stdio};

use clap::Args;
use pschema_process::say;
use pschema_tools::kit::Failure;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use pschema_worlds::Mix;

/// The lives to measure.
#[derive(Debug, Args)]
pub(crate) struct LivesArgs {
    /// Only this mix: scenario-1, scenario-3 or wide
    #[arg(long, value_name = "MIX")]
    mix: Option<Mix>,
    /// Sizes of memory at which to measure, in schemas; a million takes some minutes
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [100, 1_000, 10_000, 20_000, 100_000], value_parser = size)]
    schemas: Vec<usize>,
    /// Everything drawn by lot follows from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// A size of memory that can be measured.
pub(crate) fn size(text: &str) -> Result<usize, String> {
    let size: usize = text.parse().map_err(|_| format!("{text:?} is no number of schemas"))?;
    match size {
        100..=10_000_000 => Ok(size),
        _ => Err(format!("{size} schemas can't be measured: give 100 to 10000000")),
    }
}

/// Sizes in the order in which one life comes to them.
pub(crate) fn ascending(sizes: &[usize]) -> Vec<usize> {
    let mut sizes = sizes.to_vec();
    sizes.sort_unstable();
    sizes.dedup();
    sizes
}

/// What was measured in lives, one after another; the JSON that `decision` and `memory` print.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Lives<M> {
    pub(crate) rows: Vec<M>,
    /// By mix: the exponent of the power of the number of schemas by which the figure grows; `null` where the sizes
    /// measured are too few to tell.
    pub(crate) growth_exponent: BTreeMap<String, Option<f64>>,
}

/// A figure of a memory at one size.
pub(crate) trait OfLife: DeserializeOwned {
    /// The subcommand that measures it.
    const COMMAND: &'static str;
    /// The smallest memory that this figure says anything about.
    const SCHEMAS_MIN: usize;

    /// One life, measured whenever memory has come to one of `sizes`.
    fn life(mix: Mix, sizes: &[usize], seed: u64) -> Result<Vec<Self>, Failure>;

    /// The exponent of growth over one life.
    fn exponent(life: &[Self]) -> Option<f64>;
}

/// The life in the mix asked for, or one in each.
pub(crate) fn lives<M: OfLife>(args: &LivesArgs, quiet: bool) -> Result<Lives<M>, Failure> {
    let least = M::SCHEMAS_MIN;
    let sizes: Vec<_> = ascending(&args.schemas).into_iter().filter(|size| *size >= least).collect();
    let Some(largest) = sizes.last() else {
        return Err(Failure::Usage(format!(
            "below {least} schemas this figure says nothing: give larger sizes with --schemas"
        )));
    };
    if let Some(mix) = args.mix {
        if !quiet {
            say(&format!("{}: a life up to {largest} schemas", mix.name()));
        }
        let rows = M::life(mix, &sizes, args.seed)?;
        let growth_exponent = BTreeMap::from([(mix.name().to_owned(), M::exponent(&rows))]);
        return Ok(Lives { rows, growth_exponent });
    }
    let mut all = Lives { rows: Vec::new(), growth_exponent: BTreeMap::new() };
    for mix in Mix::ALL {
        let Lives { rows, growth_exponent } = alone(mix, &sizes, args.seed, quiet)?;
        all.rows.extend(rows);
        all.growth_exponent.extend(growth_exponent);
    }
    Ok(all)
}

/// One life in a process of its own: what a life leaves behind in an allocator is not the next one's.
fn alone<M: OfLife>(mix: Mix, sizes: &[usize], seed: u64, quiet: bool) -> Result<Lives<M>, Failure> {
    let what = M::COMMAND;
    let failed = |error: &dyn std::fmt::Display| {
        Failure::Failed(format!("{what} --mix {} in a process of its own: {error}", mix.name()))
    };
    let binary = std::env::current_exe().map_err(|error| failed(&error))?;
    let sizes: Vec<_> = sizes.iter().map(ToString::to_string).collect();
    let mut command = Command::new(binary);
    command.args([what, "--json", "--mix", mix.name(), "--schemas", &sizes.join(",")]);
    command.args(["--seed", &seed.to_string()]).args(quiet.then_some("-q"));
    let output = command.stdin(Stdio::null()).stderr(Stdio::inherit()).output();
    let output = output.map_err(|error| failed(&error))?;
    if !output.status.success() {
        return Err(failed(&output.status));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| failed(&error))
}

/// The exponent of the power by which a figure grew from `before` to `after` while schemas grew `schemas`-fold.
pub(crate) fn growth(before: f64, after: f64, schemas: f64) -> Option<f64> {
    (schemas > 1.5).then(|| (after / before).ln() / schemas.ln())
}

/// Memory of this process that is in RAM; none where the system does not say.
pub(crate) fn resident_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let kilobytes = status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.strip_suffix("kB"))?;
    kilobytes.trim().parse::<u64>().ok()?.checked_mul(1024)
}
