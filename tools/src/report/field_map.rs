//! The visual fields as circles in the picture, and what came of a block in each.

use std::collections::BTreeMap;

use maud::{Markup, html};
use pschema_sim::config::WorldFile;
use pschema_sim::workspace::Workspace;

use crate::run::Trial;

use super::plot::{drawing, px};
use super::section::Section;

/// How far the effector got with the placements in one field, the better before the worse.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Reach {
    AtOnce,
    Later,
    Pointed,
    Never,
}

const KINDS: [(Reach, &str, &str); 4] = [
    (Reach::AtOnce, "at-once", "reached at the first try"),
    (Reach::Later, "later", "reached, but later"),
    (Reach::Pointed, "pointed", "pointed at: seen in its field, not reached"),
    (Reach::Never, "never", "neither"),
];

/// The figure, of the first seed of the experiment as it stands; none when the experiment asks for none.
pub(super) fn figure(section: &Section<'_>) -> Option<Markup> {
    let map = section.design.map.as_ref()?;
    let outcome = section.first()?;
    let world = &outcome.results.world;
    // The page is still worth having where the world has gone since.
    let workspace = WorldFile::load(world).and_then(|file| Workspace::new(world, file)).ok()?;
    let reached = reached(&outcome.trace.trials());
    if reached.is_empty() {
        return None;
    }
    let (fields, camera) = (&workspace.fields, &workspace.file.camera);
    let (width, height) = (camera.width_px.get(), camera.height_px.get());
    let radius = fields.pitch_px() * 0.46;
    let content = html! {
        rect.picture x="0" y="0" width=(px(width)) height=(px(height)) {}
        @for (at, (u, v)) in fields.centres_px().iter().enumerate() {
            @let found = i64::try_from(at).ok().and_then(|at| reached.get(&at));
            @let class = found.map_or("field", |reach| class(*reach));
            g.field {
                circle class=(class) cx=(px(*u)) cy=(px(*v)) r=(px(radius)) {}
                (mark(found.copied(), *u, *v, radius))
            }
        }
    };
    let count = |kind: Reach| reached.values().filter(|reach| **reach == kind).count();
    Some(html! {
        figure {
            div.map { (drawing(width, height, "what came of a block in each visual field", &content)) }
            ul.legend {
                @for (kind, class, name) in KINDS.iter().filter(|(kind, _, _)| count(*kind) > 0) {
                    li {
                        svg.key viewBox="-13 -13 26 26" aria-hidden="true" {
                            circle class=(class) r="11" {}
                            (mark(Some(*kind), 0.0, 0.0, 11.0))
                        }
                        (name) " (" (count(*kind)) ")"
                    }
                }
                li {
                    svg.key viewBox="-13 -13 26 26" aria-hidden="true" { circle.field r="11" {} }
                    "never placed there (" (fields.count().saturating_sub(reached.len())) ")"
                }
            }
            figcaption {
                b { "The visual fields, as the camera sees them." }
                " Seed " (outcome.results.seed) ": what came of “" (map.object) "” in each field that it was first seen \
                 in; of several placements in one field, the best."
            }
        }
    })
}

fn class(reach: Reach) -> &'static str {
    KINDS.iter().find(|(kind, _, _)| *kind == reach).map_or("field", |(_, class, _)| class)
}

/// Kinds are told apart without colour as well.
fn mark(reach: Option<Reach>, u: f64, v: f64, radius: f64) -> Markup {
    let r = radius * 0.42;
    let (left, right, top, bottom) = (px(u - r), px(u + r), px(v - r), px(v + r));
    html! {
        @match reach {
            Some(Reach::Later) => circle.mark cx=(px(u)) cy=(px(v)) r=(px(r * 0.8)) {},
            Some(Reach::Pointed) => path.mark d=(format!("M{left} {bottom}H{right}L{} {top}Z", px(u))) {},
            Some(Reach::Never) => path.mark d=(format!("M{left} {top}L{right} {bottom}M{left} {bottom}L{right} {top}")) {},
            Some(Reach::AtOnce) | None => {},
        }
    }
}

/// How far the effector got in each field, at best.
fn reached(trials: &[Trial]) -> BTreeMap<i64, Reach> {
    let mut all = BTreeMap::new();
    for trial in trials.iter().filter(|trial| trial.met.is_some() && !trial.drawn.is_empty()) {
        let Some(field) = trial.object_at else { continue };
        let reach = match trial.reached_after {
            Some(0 | 1) => Reach::AtOnce,
            Some(_) => Reach::Later,
            None if trial.covered => Reach::Pointed,
            None => Reach::Never,
        };
        let known = all.entry(field).or_insert(reach);
        *known = reach.min(*known);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(field: i64, reached_after: Option<u64>, covered: bool) -> Trial {
        Trial {
            stage: 0,
            number: 1,
            drawn: vec![1],
            begun_at: 0,
            actions: 5,
            met: Some(true),
            reached_after,
            object_at: Some(field),
            covered,
        }
    }

    #[test]
    fn the_best_of_several_placements_counts() {
        let trials = [
            trial(4, None, false),
            trial(4, Some(2), false),
            trial(5, Some(1), true),
            trial(6, None, true),
            trial(7, None, false),
        ];
        let expected = [(4, Reach::Later), (5, Reach::AtOnce), (6, Reach::Pointed), (7, Reach::Never)];
        assert_eq!(reached(&trials), BTreeMap::from(expected));
    }
}
