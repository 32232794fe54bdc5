//! The page: everything in one file, without scripts and without anything from elsewhere.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use pschema_inspect::SchemaDetail;

use crate::render::schema::capital;
use crate::render::words::{missing, probability, schema_notation, schema_sentence};
use crate::run::Knowledge;

use super::comparison::{COMPARED, as_they_stand, footnote, shown};
use super::provenance::Provenance;
use super::section::Section;
use super::table::table;
use super::{excitation, field_map, growth, stages, sweep, timing};

const STYLE: &str = include_str!("style.css");

/// The whole page.
pub(super) fn page(sections: &[Section<'_>], provenance: &Provenance) -> String {
    let title = match sections {
        [only] => only.design.title.clone(),
        _ => "Experiments".to_owned(),
    };
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { (title) }
                p.facts {
                    (provenance.date) " · pschema " (provenance.version) " · " (provenance.machine) br;
                    code { (provenance.command) }
                }
                (compared(sections))
                @if sections.len() > 1 { (contents(sections)) }
                @for section in sections { (one(section, sections.len() > 1)) }
            }
        }
    };
    page.into_string()
}

fn contents(sections: &[Section<'_>]) -> Markup {
    html! {
        nav {
            ul {
                @for (at, section) in sections.iter().enumerate() {
                    li { a href=(format!("#experiment-{}", at + 1)) { (section.design.title) } }
                }
            }
        }
    }
}

fn one(section: &Section<'_>, several: bool) -> Markup {
    let heading = html! { @if several { h2 { (section.design.title) } } };
    html! {
        section {
            (heading)
            @if section.groups.len() > 1 { (variants(section)) }
            @if let Some(figures) = sweep::figures(section) { (figures) }
            @if let Some(figure) = growth::figure(section) { (figure) }
            @if let Some(figure) = excitation::figure(section) { (figure) }
            @if let Some(figure) = field_map::figure(section) { (figure) }
            @if let Some(tables) = stages::tables(section) { (tables) }
            @if let Some(figure) = timing::figure(section) { (figure) }
            (learnt(section))
            (made_of(section))
        }
    }
}

/// The table of published figures and ours.
fn compared(sections: &[Section<'_>]) -> Markup {
    let runs = sections.iter().filter_map(|section| Some(section.groups.first()?.outcomes.len())).max();
    let or_dash = |text: &Option<String>| text.clone().unwrap_or_else(|| "–".to_owned());
    let several = sections.len() > 1;
    table(
        &html! { b { "Published and here." } " Here: " (footnote(runs.unwrap_or(0))) "." },
        &html! {
            @if several { th { "experiment" } }
            th { "figure" } th { "published" } th.n { "here" } th { "why they differ" }
        },
        &html! {
            @for line in as_they_stand(sections) {
                tr {
                    @if several { td { (line.experiment) } }
                    td { (line.what()) }
                    td { (or_dash(&line.published)) }
                    td.n { (shown(line.ours, line.unit)) }
                    td { (line.why.as_deref().unwrap_or("")) }
                }
            }
        },
    )
}

/// Variants side by side.
fn variants(section: &Section<'_>) -> Markup {
    let variants = table(
        &html! {
            b { "The same run with something changed." } " " (capital(&footnote(section.seeds())))
            " Generalised after so many placements; 1st try: the share of places touched with the first action, \
            learning frozen."
        },
        &html! { th { "variant" } @for (heading, _, _) in COMPARED { th.n { (heading) } } },
        &html! {
            @for group in &section.groups {
                tr {
                    td { (group.name()) }
                    @for (_, unit, of) in COMPARED { td.n { (shown(group.over(of), unit)) } }
                }
            }
        },
    );
    html! { (variants) (measures(section)) }
}

/// The measures of the experiment, by variant.
fn measures(section: &Section<'_>) -> Markup {
    let measures = section.measures();
    if measures.is_empty() {
        return html! {};
    }
    table(
        &html! { b { "Measures." } " Of each variant, as above." },
        &html! { th { "measure" } @for group in &section.groups { th.n { (group.name()) } } },
        &html! {
            @for (at, measure) in measures.iter().enumerate() {
                tr {
                    td { (measure.name) }
                    @for group in &section.groups { td.n { (shown(group.measured(at), measure.unit)) } }
                }
            }
        },
    )
}

/// What the first run left in memory, in words.
fn learnt(section: &Section<'_>) -> Markup {
    let Some(outcome) = section.first() else { return html! {} };
    let Knowledge { generalised, exceptions } = &outcome.learnt;
    let general = |exception: &SchemaDetail| generalised.iter().find(|g| Some(g.id) == exception.contradicts);
    html! {
        h3 { "What it learnt (seed " (outcome.results.seed) ")" }
        @if generalised.is_empty() { p { "Nothing was generalised." } }
        ul.learnt {
            @for schema in generalised { li { (told(schema, "")) } }
            @for schema in exceptions {
                @let missing = general(schema).map_or_else(String::new, |general| missing(general, schema));
                li { "Exception: " (told(schema, &missing)) }
            }
        }
    }
}

fn told(schema: &SchemaDetail, missing: &str) -> Markup {
    let (n, of) = (schema.successes, schema.executions);
    html! {
        (capital(&(schema_sentence(schema) + missing)))
        br;
        code { "schema " (schema.id) ": " (schema_notation(schema)) }
        br;
        span.facts { @if of > 0 { "succeeds " } (probability(schema.probability, n, of, schema.low, schema.high)) }
    }
}

/// All that is needed to run it again.
fn made_of(section: &Section<'_>) -> Markup {
    let seeds = section.groups.first().into_iter().flat_map(|group| group.results());
    let seeds: Vec<_> = seeds.map(|results| results.seed.to_string()).collect();
    let outcomes = section.groups.iter().flat_map(|group| group.outcomes);
    let lost: u64 = outcomes.map(|outcome| outcome.trace.lost).sum();
    html! {
        h3 { "How it was run" }
        p.facts { "Curriculum " code { (section.design.curriculum) } ", world " code { (section.design.world) } ", seeds " (seeds.join(", ")) "." }
        @if lost > 0 {
            p { (lost) " steps were no longer kept when they were asked for: the figures above leave them out." }
        }
        @for group in &section.groups {
            details {
                summary { "Parameters of the learner" @if let Some(name) = &group.condition.name { ": " (name) } }
                pre { (group.parameters) }
            }
        }
        details {
            summary { "Memory digests" }
            pre {
                @for results in section.results() {
                    (results.variant.as_deref().map_or_else(String::new, |name| format!("{name}, ")))
                    "seed " (results.seed) ": " (results.memory_digest) "\n"
                }
            }
        }
    }
}
