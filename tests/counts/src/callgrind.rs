//! Callgrind, of Debian's valgrind: it runs a program on a processor of its own and counts each instruction.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::counted::REGION;
use crate::failure::CountFailure;

/// Crates that choose among functions by what the processor at hand can do, and the one that counts allocations: which of
/// their instructions are run says nothing of our code.
const NOT_OURS: [&str; 6] =
    ["allocation_counter", "blake3", "crc32fast", "matrixmultiply", "memchr", "std_detect"];

/// Whether valgrind is installed.
pub(crate) fn is_here() -> bool {
    let mut valgrind = Command::new("valgrind");
    valgrind.arg("--version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    valgrind.status().is_ok_and(|status| status.success())
}

/// The command under which a process is counted; `profile` is the file that tells of it. What is counted is the region of
/// `counted.rs`, and the function `elsewhere` on whatever thread it runs.
pub(crate) fn command(profile: &Path, elsewhere: Option<&str>) -> Vec<String> {
    let mut command = ["valgrind", "--tool=callgrind", "--collect-atstart=no", "--dump-line=no"]
        .map(str::to_owned)
        .to_vec();
    command.push("--compress-strings=no".to_owned());
    command.push(format!("--callgrind-out-file={}", profile.display()));
    command.push(format!("--toggle-collect=*{REGION}*"));
    command.extend(elsewhere.map(|function| format!("--toggle-collect=*{function}*")));
    command
}

/// The instructions that a profile tells of, those of the C library and of [`NOT_OURS`] left out: the C library chooses its
/// functions by the processor too, and what it is asked for most, memory, is counted as allocations.
pub(crate) fn instructions(profile: &Path, elsewhere: Option<&'static str>) -> Result<u64, CountFailure> {
    let text = std::fs::read_to_string(profile).map_err(CountFailure::file(profile))?;
    let by_function = by_function(&text);
    for function in [Some(REGION), elsewhere].into_iter().flatten() {
        if !by_function.keys().any(|(_, name)| name.contains(function)) {
            return Err(CountFailure::Uncounted { path: profile.to_owned(), function });
        }
    }
    let program = std::env::current_exe().map_err(CountFailure::file(profile))?;
    let program = program.display().to_string();
    let ours = by_function.iter().filter(|((object, function), _)| {
        *object == program && !NOT_OURS.iter().any(|name| function.contains(name))
    });
    Ok(ours.map(|(_, instructions)| instructions).sum())
}

/// The instructions of each function itself, by the file of machine code that it is in and its name.
///
/// A profile is a text: `ob=` and `fn=` say which function the lines after them are of, and a line of two numbers is a place and the
/// instructions spent there. `calls=` is followed by such a line with the instructions of the function that is called, which are
/// told once more under that function itself.
fn by_function(profile: &str) -> BTreeMap<(&str, &str), u64> {
    let mut costs = BTreeMap::new();
    let (mut object, mut function) = ("", "");
    let mut is_of_a_call = false;
    for line in profile.lines() {
        if let Some(name) = line.strip_prefix("ob=") {
            object = name;
        } else if let Some(name) = line.strip_prefix("fn=") {
            function = name;
        } else if line.starts_with("calls=") {
            is_of_a_call = true;
        } else if line.starts_with(|first: char| first.is_ascii_digit() || "+-*".contains(first)) {
            let cost = line.split_whitespace().nth(1).and_then(|cost| cost.parse::<u64>().ok());
            if !std::mem::take(&mut is_of_a_call) {
                *costs.entry((object, function)).or_default() += cost.unwrap_or(0);
            }
        }
    }
    costs
}

#[cfg(test)]
mod tests {
    use super::by_function;

    #[test]
    fn what_is_called_is_not_counted_twice() {
        let profile = "\
version: 1
events: Ir

ob=/bin/counts
fl=???
fn=counts::counted_region
0 12
cob=/lib/libc.so.6
cfn=malloc
calls=2 0
0 80
0 3

ob=/lib/libc.so.6
fl=???
fn=malloc
0 80

totals: 95
";
        let costs = by_function(profile);
        assert_eq!(costs[&("/bin/counts", "counts::counted_region")], 15);
        assert_eq!(costs[&("/lib/libc.so.6", "malloc")], 80);
        assert_eq!(costs.values().sum::<u64>(), 95);
    }
}
