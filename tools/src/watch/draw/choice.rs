//! The candidates of the last decision, each with the terms of equation (1) that made it more or less exciting.

use pschema_inspect::{Candidate, ExcitationTerm, Explanation, Reason, TermRole};
use ratatui::style::Style;

use super::super::state::State;
use super::canvas::Canvas;
use super::text::WrappedText;
use crate::render::goals;
use crate::render::words::{count, figure, notation, plain, with_values};

pub(super) fn text(state: &State, canvas: Canvas) -> WrappedText {
    let theme = canvas.theme;
    let mut text = canvas.text();
    let Some(explanation) = state.live.as_ref().and_then(|live| live.explanation.as_ref()) else {
        text.wrapped("", "nothing has been decided yet", theme.quiet());
        return text;
    };
    let did =
        format!("{} by {}, {}", plain(&explanation.action), plain(&explanation.body), because(explanation));
    text.wrapped(&format!("step {}: ", explanation.step), &did, theme.strong());
    let (listed, total) = (explanation.candidates.len(), explanation.candidates_total);
    let all = format!("{listed} of {}, each E = sum of its terms / d:", count(total, "candidate"));
    text.wrapped("", &all, theme.quiet());
    for (at, candidate) in explanation.candidates.iter().enumerate() {
        let chosen = u32::try_from(at).is_ok_and(|at| at == explanation.chosen);
        let style = if chosen { theme.new_thing() } else { Style::new() };
        one(&mut text, candidate, if chosen { "> " } else { "  " }, style);
    }
    text
}

fn because(explanation: &Explanation) -> String {
    match explanation.reason {
        Reason::Excitation => "as nothing else was as exciting".to_owned(),
        Reason::Tie => format!("drawn among {} that were equally exciting", explanation.ties),
        Reason::Chain => "the next of a chain begun before".to_owned(),
        Reason::Goal => explanation.goal.as_ref().map_or_else(|| "for a goal".to_owned(), goals::followed),
    }
}

fn one(text: &mut WrappedText, candidate: &Candidate, mark: &str, style: Style) {
    let who = candidate.schema.map_or_else(|| "new".to_owned(), |id| id.to_string());
    let what = format!("d {}  {}", candidate.distance, with_values(&candidate.text, &candidate.binding));
    text.wrapped(&format!("{mark}E {:<6} {who:>5}  ", figure(candidate.excitation, 3)), &what, style);
    for term in &candidate.terms {
        text.wrapped(&format!("      {:>6}  ", figure(term.value, 3)), &told(term), Style::new());
    }
}

fn told(term: &ExcitationTerm) -> String {
    let weight = figure(term.weight, 2);
    match (&term.observation, &term.seen, term.role) {
        (Some(remembered), Some(seen), role) => {
            let (remembered, seen) = (notation(remembered), notation(seen));
            let like = if remembered == seen { String::new() } else { format!(" like {seen}") };
            format!(
                "{role} {remembered}{like}: {} shared x p {} x w {weight} / (1 + N {})",
                term.shared,
                figure(term.probability, 2),
                term.attention
            )
        }
        (_, _, TermRole::Rest) => "all other terms".to_owned(),
        (_, _, TermRole::Babbling) => {
            format!("babbling: never tried here, w {weight} / (1 + N {})", term.attention)
        }
        (_, _, TermRole::Curiosity) => format!("curiosity: surprise x newness here, w {weight}"),
        (_, _, role) => format!("{role}, w {weight} / (1 + N {})", term.attention),
    }
}
