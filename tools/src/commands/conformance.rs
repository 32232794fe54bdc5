//! `pschema conformance`: whether a body in any language does its duties.

use std::time::Duration;

use clap::Args;
use pschema_process::Stop;
use serde::Serialize;

use crate::args::{General, NameArgs};
use crate::conformance::{self, DutyVerdict, Verdict};
use crate::failure::Failure;
use crate::output::{self, Style};
use crate::render::schema::wrapped;
use crate::render::words::plain;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pschema conformance --command './my_body --name default'\n\n\
    The command is started several times, as a body of the learner `default` (`--name` changes it), in a runtime directory of its \
    own: PSCHEMA_RUNTIME_DIR and PSCHEMA_NAME tell it where. Exit code 0 if no check failed, else 1; advice is no failure.")]
pub(crate) struct ConformanceArgs {
    /// How to start the body, as in a shell
    #[arg(long, value_name = "COMMAND")]
    command: String,
    #[command(flatten)]
    name: NameArgs,
    /// How long the body may take for anything, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 20, value_parser = clap::value_parser!(u16).range(1..=3600))]
    patience: u16,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// The duties of a body, and which of them it does.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Conformance<'a> {
    /// Whether it does all of them.
    ok: bool,
    /// The command that started the body.
    command: &'a str,
    /// One for each duty, in the order in which they were tried.
    checks: Vec<DutyVerdict>,
}

pub(crate) fn run(args: ConformanceArgs, general: &General) -> Result<(), Failure> {
    let stop = Stop::on_signals()?;
    let (name, patience) = (args.name.learner(general)?, Duration::from_secs(args.patience.into()));
    let style = Style::of_stdout();
    let told = |verdict: &DutyVerdict| if args.json { Ok(()) } else { output::print(&line(verdict, style)) };
    let checks = conformance::examine(&args.command, name, patience, &stop, told)?;
    let (conforms, told) = summary(&checks);
    if args.json {
        output::print_json(&Conformance { ok: conforms, command: &args.command, checks })?;
    } else if conforms {
        output::print(&format!("{told}\n"))?;
    }
    if conforms { Ok(()) } else { Err(Failure::Failed(format!("the body does not conform: {told}"))) }
}

/// Whether the body does all its duties, and how many were tried and with which verdict.
fn summary(checks: &[DutyVerdict]) -> (bool, String) {
    let number = |verdict| checks.iter().filter(|check| check.verdict == verdict).count();
    let (all, untried) = (checks.len(), number(Verdict::NotTried));
    let verdicts =
        [(Verdict::Failed, "failed"), (Verdict::Passed, "passed"), (Verdict::Advised, "passed with advice")];
    let counted = verdicts.map(|(verdict, said)| (number(verdict), said));
    let counted: Vec<_> = counted
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, said)| format!("{count} {said}"))
        .collect();
    let mut told = format!("{} of {all} duties were tried: {}", all - untried, counted.join(", "));
    if untried > 0 {
        told.push_str(&format!("; {untried} were not, for it never attached"));
    }
    (number(Verdict::Failed) == 0 && untried == 0, told)
}

fn line(check: &DutyVerdict, style: Style) -> String {
    let verdict = match check.verdict {
        Verdict::Passed => style.good("passed   "),
        Verdict::Advised => style.good("advised  "),
        Verdict::Failed => style.bad("failed   "),
        Verdict::NotTried => "not tried".to_owned(),
    };
    let mut text = format!("{verdict}  {:<14}  {}\n", check.name, check.duty);
    if let Some(problem) = &check.problem {
        text.push_str(&wrapped(&format!("-> {}", plain(problem)), "           "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_check_is_one_line_and_a_problem_stands_below_it() {
        let (name, duty) = ("rest", "rests as long as it is told");
        let passed = DutyVerdict { name, duty, verdict: Verdict::Passed, problem: None };
        assert_eq!(line(&passed, Style::plain()), "passed     rest            rests as long as it is told\n");
        let problem = Some("it came back\x1b[2J after 1 ms".to_owned());
        let failed = DutyVerdict { verdict: Verdict::Failed, problem, ..passed };
        let text = line(&failed, Style::plain());
        assert!(text.starts_with("failed     rest ") && text.contains("\n           -> it came"), "{text}");
        assert!(!text.contains('\x1b'), "{text:?}");
    }

    /// "14 of 14 checks did not pass" was said of a body of which one thing was tried.
    #[test]
    fn what_was_not_tried_is_not_counted_as_failed() {
        let told = |verdicts: &[Verdict]| {
            let check =
                |verdict: &Verdict| DutyVerdict { name: "", duty: "", verdict: *verdict, problem: None };
            summary(&verdicts.iter().map(check).collect::<Vec<_>>())
        };
        use Verdict::{Advised, Failed, NotTried, Passed};
        assert_eq!(told(&[Passed, Passed]), (true, "2 of 2 duties were tried: 2 passed".to_owned()));
        assert_eq!(
            told(&[Passed, Advised, Failed]),
            (false, "3 of 3 duties were tried: 1 failed, 1 passed, 1 passed with advice".to_owned())
        );
        let never = "1 of 3 duties were tried: 1 failed; 2 were not, for it never attached";
        assert_eq!(told(&[Failed, NotTried, NotTried]), (false, never.to_owned()));
    }
}
