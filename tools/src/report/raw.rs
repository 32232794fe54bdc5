//! The raw figures: CSV for tables, JSON Lines for runs.

use std::io::{self, Write};

use crate::render::comparison::lines;
use crate::run::Outcome;

use super::{Group, Section};

/// Every step of every run.
pub(super) fn steps(to: &mut dyn Write, section: &Section<'_>) -> io::Result<()> {
    writeln!(
        to,
        "variant,seed,step,stage,trial,actions,schemas_total,schemas_generalised,excitation_top,excitation,schema,\
         generalised,distance,action,reason,predicts,heard,perceived,quiet_actions,habituating,latency_us"
    )?;
    for (group, outcome) in runs(section) {
        let variant = group.condition.name.as_deref().unwrap_or("");
        for row in &outcome.trace.rows {
            let stage = outcome.trace.stages.get(row.stage).map_or("", String::as_str);
            let mut line =
                vec![field(variant), outcome.figures.seed.to_string(), row.step.to_string(), field(stage)];
            line.extend([row.trial.to_string(), row.actions.to_string()]);
            line.extend([row.schemas_total.to_string(), row.schemas_generalised.to_string()]);
            match &row.decision {
                None => line.extend(std::iter::repeat_n(String::new(), 8)),
                Some(decision) => line.extend([
                    decision.excitation_top.to_string(),
                    decision.excitation.to_string(),
                    decision.schema.map_or_else(String::new, |schema| schema.to_string()),
                    decision.generalised.to_string(),
                    decision.distance.to_string(),
                    field(&decision.action),
                    field(decision.reason.as_str()),
                    field(&decision.predicts),
                ]),
            }
            line.extend([field(&row.heard), field(&row.perceived), row.quiet_actions.to_string()]);
            line.extend([row.habituating.to_string(), format!("{:.1}", row.latency_us)]);
            writeln!(to, "{}", line.join(","))?;
        }
    }
    Ok(())
}

/// Every trial of every run.
pub(super) fn trials(to: &mut dyn Write, section: &Section<'_>) -> io::Result<()> {
    writeln!(to, "variant,seed,stage,trial,drawn,actions,met,object_at,reached_after,covered")?;
    for (group, outcome) in runs(section) {
        let variant = group.condition.name.as_deref().unwrap_or("");
        for trial in outcome.trace.trials() {
            let stage = outcome.trace.stages.get(trial.stage).map_or("", String::as_str);
            let drawn: Vec<_> = trial.drawn.iter().map(i64::to_string).collect();
            let line = [
                field(variant),
                outcome.figures.seed.to_string(),
                field(stage),
                trial.number.to_string(),
                drawn.join(" "),
                trial.actions.to_string(),
                trial.met.map_or_else(String::new, |met| met.to_string()),
                trial.object_at.map_or_else(String::new, |at| at.to_string()),
                trial.reached_after.map_or_else(String::new, |after| after.to_string()),
                trial.covered.to_string(),
            ];
            writeln!(to, "{}", line.join(","))?;
        }
    }
    Ok(())
}

/// What `experiment --json` prints of each run.
fn runs_of(section: &Section<'_>) -> impl Iterator<Item = io::Result<String>> {
    section.figures().map(|figures| serde_json::to_string(figures).map_err(io::Error::other))
}

/// The same of all sections, one object a line.
pub(super) fn runs_lines(to: &mut dyn Write, sections: &[Section<'_>]) -> io::Result<()> {
    for line in sections.iter().flat_map(runs_of) {
        writeln!(to, "{}", line?)?;
    }
    Ok(())
}

/// Published figures beside ours.
pub(super) fn comparison(to: &mut dyn Write, sections: &[Section<'_>]) -> io::Result<()> {
    writeln!(to, "experiment,variant,figure,published,median,low,high,runs,why")?;
    for runs in sections.iter().flat_map(Section::runs) {
        for line in lines(runs) {
            let of = |get: fn(&crate::render::statistics::Summary) -> f64| {
                line.ours.as_ref().map_or_else(String::new, |summary| get(summary).to_string())
            };
            let cells = [
                field(&line.experiment),
                field(runs.condition.unwrap_or("")),
                field(&line.what),
                field(line.published.as_deref().unwrap_or("")),
                of(|s| s.median),
                of(|s| s.low),
                of(|s| s.high),
                line.ours.as_ref().map_or(0, |summary| summary.n).to_string(),
                field(line.why.as_deref().unwrap_or("")),
            ];
            writeln!(to, "{}", cells.join(","))?;
        }
    }
    Ok(())
}

fn runs<'a>(section: &'a Section<'a>) -> impl Iterator<Item = (&'a Group<'a>, &'a Outcome)> {
    section.groups.iter().flat_map(|group| group.outcomes.iter().map(move |outcome| (group, outcome)))
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
