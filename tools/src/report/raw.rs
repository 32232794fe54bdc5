//! The raw figures: CSV for tables, JSON Lines for runs.

use std::fmt::Display;
use std::io::{self, Write};

use crate::run::Outcome;

use super::comparison::lines;
use super::section::Section;

/// Every step of every run.
pub(super) fn steps(to: &mut dyn Write, section: &Section<'_>) -> io::Result<()> {
    writeln!(
        to,
        "variant,seed,step,stage,trial,actions,schemas_total,schemas_generalised,excitation_top,excitation,schema,\
         generalised,distance,action,reason,predicts,heard,perceived,quiet_actions,habituating,latency_us"
    )?;
    for (run, outcome) in runs(section) {
        for step in &outcome.trace.steps {
            let record = &step.record;
            let (trial, actions) = (record.trial, record.actions);
            let (total, generalised) = (record.schemas_total, record.schemas_generalised);
            let stage = outcome.trace.stage(record.stage);
            write!(to, "{run},{},{},{trial},{actions},{total},{generalised},", record.step, field(stage))?;
            match &record.decision {
                None => write!(to, ",,,,,,,")?,
                Some(decision) => write!(
                    to,
                    "{},{},{},{},{},{},{},{}",
                    decision.excitation_top,
                    decision.excitation,
                    or_nothing(decision.schema),
                    decision.generalised,
                    decision.distance,
                    field(&decision.action),
                    decision.reason,
                    field(&decision.predicts.join(" "))
                )?,
            }
            let (heard, perceived) = (field(&record.heard.join(" ")), field(&step.perceived));
            let (quiet, latency) = (record.quiet_actions, record.latency_us);
            writeln!(to, ",{heard},{perceived},{quiet},{},{latency:.1}", record.habituating)?;
        }
    }
    Ok(())
}

/// Every trial of every run.
pub(super) fn trials(to: &mut dyn Write, section: &Section<'_>) -> io::Result<()> {
    writeln!(to, "variant,seed,stage,trial,drawn,actions,met,object_at,reached_after,covered")?;
    for (run, outcome) in runs(section) {
        for trial in outcome.trace.trials() {
            let drawn: Vec<_> = trial.drawn.iter().map(i64::to_string).collect();
            writeln!(
                to,
                "{run},{},{},{},{},{},{},{},{}",
                field(outcome.trace.stage(trial.stage)),
                trial.number,
                drawn.join(" "),
                trial.actions,
                or_nothing(trial.met),
                or_nothing(trial.object_at),
                or_nothing(trial.reached_after),
                trial.covered
            )?;
        }
    }
    Ok(())
}

/// What `experiment --json` prints of each run, one object a line.
pub(super) fn runs_lines(to: &mut dyn Write, sections: &[Section<'_>]) -> io::Result<()> {
    for results in sections.iter().flat_map(Section::results) {
        writeln!(to, "{}", serde_json::to_string(results).map_err(io::Error::other)?)?;
    }
    Ok(())
}

/// Published figures beside ours.
pub(super) fn comparison(to: &mut dyn Write, sections: &[Section<'_>]) -> io::Result<()> {
    writeln!(to, "experiment,variant,figure,published,median,low,high,runs,why")?;
    let groups =
        sections.iter().flat_map(|section| section.groups.iter().map(|group| (section.design, group)));
    for line in groups.flat_map(|(design, group)| lines(design, group)) {
        let ends =
            line.ours.map_or_else(|| ",,".to_owned(), |s| format!("{},{},{}", s.median, s.low, s.high));
        writeln!(
            to,
            "{},{},{},{},{ends},{},{}",
            field(&line.experiment),
            field(line.condition.as_deref().unwrap_or("")),
            field(&line.what),
            field(line.published.as_deref().unwrap_or("")),
            line.ours.map_or(0, |summary| summary.n),
            field(line.why.as_deref().unwrap_or(""))
        )?;
    }
    Ok(())
}

/// Every run, with its variant and its seed as the first two fields of a line.
fn runs<'a>(section: &'a Section<'a>) -> impl Iterator<Item = (String, &'a Outcome)> {
    section.groups.iter().flat_map(|group| {
        let variant = field(group.condition.name.as_deref().unwrap_or(""));
        group.outcomes.iter().map(move |outcome| (format!("{variant},{}", outcome.results.seed), outcome))
    })
}

fn or_nothing(value: Option<impl Display>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// A text as a field: quoted where it has to be. One that a spreadsheet would take for a formula is kept from it.
fn field(text: &str) -> String {
    let guarded =
        if text.starts_with(['=', '+', '-', '@', '\t']) { format!("'{text}") } else { text.to_owned() };
    if guarded.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", guarded.replace('"', "\"\""))
    } else {
        guarded
    }
}

#[cfg(test)]
mod tests {
    use super::field;

    #[test]
    fn fields_are_quoted_where_they_have_to_be() {
        assert_eq!(field("plain text"), "plain text");
        assert_eq!(field("finger{field=4, colour=green}"), "\"finger{field=4, colour=green}\"");
        assert_eq!(field("say \"hi\"\n"), "\"say \"\"hi\"\"\n\"");
        assert_eq!(field("=1+1"), "'=1+1");
    }
}
