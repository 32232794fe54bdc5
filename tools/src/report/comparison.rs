//! Published figures beside ours: over seeds, over variants.

use crate::design::Design;
use crate::render::schema::wrapped;
use crate::render::statistics::{Summary, interval};
use crate::render::table::Columns;
use crate::run::{Results, Unit};

use super::section::{Group, Section};

/// One figure of the paper beside ours.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ComparisonLine {
    /// The experiment.
    pub(crate) experiment: String,
    /// Under which condition, when there are several.
    pub(crate) condition: Option<String>,
    /// What it is a figure of.
    pub(crate) what: String,
    /// What the paper says.
    pub(crate) published: Option<String>,
    /// What we measured.
    pub(crate) ours: Option<Summary>,
    /// How it is shown.
    pub(crate) unit: Unit,
    /// Why it differs.
    pub(crate) why: Option<String>,
}

impl ComparisonLine {
    /// What it is a figure of, and under which condition.
    pub(crate) fn what(&self) -> String {
        match &self.condition {
            Some(condition) => format!("{} ({condition})", self.what),
            None => self.what.clone(),
        }
    }
}

/// Every figure of the experiments as they stand that the paper or the experiment's file speaks of.
pub(crate) fn as_they_stand(sections: &[Section<'_>]) -> Vec<ComparisonLine> {
    sections
        .iter()
        .filter_map(|section| Some(lines(section.design, section.groups.first()?)))
        .flatten()
        .collect()
}

/// Every figure of some runs that the paper or the experiment's file speaks of.
pub(super) fn lines(design: &Design, group: &Group<'_>) -> Vec<ComparisonLine> {
    let line = |what: &str, published, ours, unit, why| ComparisonLine {
        experiment: design.name.clone(),
        condition: group.condition.name.clone(),
        what: what.to_owned(),
        published,
        ours,
        unit,
        why,
    };
    let published = design.published.as_ref();
    let schemas = published.and_then(|p| p.schemas_total).map(|n| n.to_string());
    let ours = group.over(|results| Some(results.schemas_total.into()));
    let mut lines = vec![line("schemas", schemas, ours, Unit::Count, design.why.clone())];
    if let Some(placements) = published.and_then(|p| p.placements) {
        let ours = group.over(|results| results.placements.map(f64::from));
        let published = Some(placements.to_string());
        lines.push(line("placements that learning took", published, ours, Unit::Count, None));
    }
    let measures = group.results().next().map_or(&[][..], |results| &results.measures);
    lines.extend(measures.iter().enumerate().map(|(at, measure)| {
        let (published, why) = (measure.published.clone(), measure.why.clone());
        line(&measure.name, published, group.measured(at), measure.unit, why)
    }));
    lines
}

/// A figure as it is shown, with its interval where that has any width.
pub(crate) fn shown(summary: Option<Summary>, unit: Unit) -> String {
    let Some(summary) = summary else { return "-".to_owned() };
    let [median, low, high] = summary.ends().map(|value| number(value, unit));
    let unit = if unit == Unit::Share { " %" } else { "" };
    if low == high { format!("{median}{unit}") } else { format!("{median}{unit} ({low}-{high})") }
}

/// A figure with as many decimals as it deserves.
fn number(value: f64, unit: Unit) -> String {
    let value = if unit == Unit::Share { value * 100.0 } else { value };
    let worth_it = unit != Unit::Microseconds && value.abs() < 1000.0;
    if unit == Unit::Value && worth_it {
        return format!("{value:.2}");
    }
    let decimals = usize::from(worth_it && (value - value.round()).abs() > 0.05);
    format!("{value:.decimals$}")
}

/// How sure the figures of so many runs are, for those who read a table.
pub(crate) fn footnote(runs: usize) -> String {
    match runs {
        0 | 1 => "one run each".to_owned(),
        n => format!("median of {n} runs; in brackets {}", interval(n)),
    }
}

/// The table of `experiment all`, for people. The reasons stand below it, where there is room for them.
pub(crate) fn table(lines: &[ComparisonLine]) -> String {
    let mut table = Columns::new(&["experiment", "figure", "published", "here", ""]).figures(&[3]);
    let mut reasons: Vec<&str> = Vec::new();
    let mut last = "";
    for line in lines {
        let name = if line.experiment == last { "" } else { &line.experiment };
        last = &line.experiment;
        let [name, what, published, ours, _] = cells(line, name.to_owned());
        let mark = line.why.as_deref().map(|why| {
            let known = reasons.iter().position(|known| *known == why);
            known.map_or_else(
                || {
                    reasons.push(why);
                    reasons.len()
                },
                |at| at + 1,
            )
        });
        table.row([name, what, published, ours, mark.map_or_else(String::new, |mark| format!("[{mark}]"))]);
    }
    let reasons = reasons.iter().enumerate().map(|(at, why)| wrapped(&format!("[{}] {why}", at + 1), ""));
    let reasons: String = reasons.collect();
    let table = table.text(&[0, 3, 4]);
    if reasons.is_empty() { table } else { format!("{table}\nWhy they differ:\n{reasons}") }
}

fn cells(line: &ComparisonLine, experiment: String) -> [String; 5] {
    let or_dash = |text: &Option<String>| text.clone().unwrap_or_else(|| "-".to_owned());
    let ours = shown(line.ours, line.unit);
    [experiment, line.what(), or_dash(&line.published), ours, line.why.clone().unwrap_or_default()]
}

/// The same as Markdown.
pub(crate) fn markdown(lines: &[ComparisonLine]) -> String {
    let head = "| experiment | figure | published | here | why they differ |\n|---|---|---|---|---|\n";
    let row = |line: &ComparisonLine| markdown_row(cells(line, line.experiment.clone()).into());
    head.to_owned() + &lines.iter().map(row).collect::<String>()
}

/// A figure that every run has: its name, how it is shown, and how it is read off.
pub(super) type ComparedFigure = (&'static str, Unit, fn(&Results) -> Option<f64>);

/// What every variant of an experiment is compared by.
pub(super) const COMPARED: [ComparedFigure; 4] = [
    ("schemas", Unit::Count, |f| Some(f.schemas_total.into())),
    ("generalised after", Unit::Count, |f| f.generalised_after_placement.map(f64::from)),
    ("1st try", Unit::Share, |f| {
        let probe = f.probe?;
        Some(f64::from(probe.touched_first_try) / f64::from(probe.placements_tried))
    }),
    #[expect(clippy::cast_precision_loss, reason = "shown, and far below 2^52")]
    ("actions", Unit::Count, |f| Some(f.actions_total as f64)),
];

/// One table of variants side by side: its headings, and a row of cells for each.
struct SideBySide {
    headings: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// What all variants are compared by, and then each measure.
fn side_by_side(section: &Section<'_>) -> Vec<SideBySide> {
    let heading = |rest: Vec<String>| ["variant".to_owned()].into_iter().chain(rest).collect();
    let row =
        |group: &Group<'_>, cells: Vec<String>| [group.name().to_owned()].into_iter().chain(cells).collect();
    let compared =
        |group: &Group<'_>| row(group, COMPARED.map(|(_, unit, of)| shown(group.over(of), unit)).into());
    let names = COMPARED.map(|(name, _, _)| name.to_owned());
    let rows = section.groups.iter().map(compared).collect();
    let mut tables = vec![SideBySide { headings: heading(names.into()), rows }];
    tables.extend(section.measures().iter().enumerate().map(|(at, measure)| {
        let measured = |group: &Group<'_>| row(group, vec![shown(group.measured(at), measure.unit)]);
        let rows = section.groups.iter().map(measured).collect();
        SideBySide { headings: heading(vec![measure.name.clone()]), rows }
    }));
    tables
}

/// Variants side by side, for people.
pub(crate) fn variants(section: &Section<'_>) -> String {
    let drawn = |tables: SideBySide| {
        let headings: Vec<_> = tables.headings.iter().map(String::as_str).collect();
        let figures: Vec<_> = (1..headings.len()).collect();
        let mut table = Columns::new(&headings).figures(&figures);
        tables.rows.into_iter().for_each(|row| table.row(row));
        // A measure's name may be long, and so may a variant's; the figures stay whole.
        table.text(if figures.len() > 1 { &figures } else { &[] })
    };
    side_by_side(section).into_iter().map(drawn).collect::<Vec<_>>().join("\n")
}

/// The same as Markdown.
pub(crate) fn variants_markdown(section: &Section<'_>) -> String {
    let drawn = |table: SideBySide| {
        let rule = vec!["---".to_owned(); table.headings.len()];
        let rows = [table.headings, rule].into_iter().chain(table.rows);
        rows.map(markdown_row).collect::<String>()
    };
    side_by_side(section).into_iter().map(drawn).collect::<Vec<_>>().join("\n")
}

fn markdown_row(cells: Vec<String>) -> String {
    let cells: Vec<_> = cells.into_iter().map(|text| text.replace('|', "\\|").replace('\n', " ")).collect();
    format!("| {} |\n", cells.join(" | "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::statistics::summary;

    #[test]
    fn figures_are_shown_with_their_interval_where_it_has_width() {
        let of = |values: &[f64]| summary(values.to_vec());
        assert_eq!(shown(of(&[228.0, 228.0]), Unit::Count), "228");
        assert_eq!(shown(of(&[1.0, 2.0]), Unit::Count), "1.5 (1-2)");
        assert_eq!(shown(of(&[0.5, 1.0, 1.0]), Unit::Share), "100 % (50-100)");
        assert_eq!(shown(of(&[0.955]), Unit::Share), "95.5 %");
        assert_eq!(shown(None, Unit::Count), "-");
    }

    fn line(what: &str, why: Option<&str>) -> ComparisonLine {
        ComparisonLine {
            experiment: "one".to_owned(),
            condition: None,
            what: what.to_owned(),
            published: Some("227".to_owned()),
            ours: summary(vec![228.0]),
            unit: Unit::Count,
            why: why.map(str::to_owned),
        }
    }

    #[test]
    fn reasons_stand_below_the_table_each_once() {
        let lines =
            [line("schemas", Some("because")), line("placements", None), line("again", Some("because"))];
        let text = table(&lines);
        assert_eq!(text.matches("[1]").count(), 3, "{text}");
        assert!(text.ends_with("\nWhy they differ:\n[1] because\n"), "{text}");
        assert_eq!(text.matches("one").count(), 1, "an experiment is named once: {text}");
        assert!(!table(&lines[1..2]).contains("Why"));
    }

    #[test]
    fn a_bar_in_a_text_does_not_break_the_table() {
        let line = ComparisonLine {
            experiment: "a|b".to_owned(),
            condition: None,
            what: "c".to_owned(),
            published: None,
            ours: None,
            unit: Unit::Count,
            why: Some("two\nlines".to_owned()),
        };
        assert!(markdown(&[line]).ends_with("| a\\|b | c | - | - | two lines |\n"));
    }
}
