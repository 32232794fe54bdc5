//! The world state: the observations of the last frame.

use ratatui::style::Style;

use super::super::state::State;
use super::canvas::Canvas;
use super::text::{WrappedText, clipped};
use crate::render::words::{count, plain};

/// A word that was heard is shown for this many steps.
const HEARD_FOR_STEPS: u64 = 200;

pub(super) fn title(state: &State) -> String {
    let count = state.live.as_ref().map_or(0, |live| live.status.world.len());
    format!("perceived: {count}, * new")
}

/// The action that followed.
pub(super) fn then(state: &State, canvas: Canvas) -> String {
    let explanation = state.live.as_ref().and_then(|live| live.explanation.as_ref());
    let then =
        explanation.map_or_else(String::new, |explanation| format!("then {}", plain(&explanation.action)));
    clipped(&then, usize::from(canvas.area.width.saturating_sub(2)))
}

pub(super) fn text(state: &State, canvas: Canvas) -> WrappedText {
    let theme = canvas.theme;
    let mut text = canvas.text();
    let Some(live) = &state.live else { return text };
    for (told, observation) in live.status.world.iter().zip(&live.observations) {
        let (mark, style) = if observation.new { ("*", theme.new_thing()) } else { (" ", Style::new()) };
        text.wrapped(mark, &format!("{} N{}", plain(told), observation.attention), style);
    }
    if live.status.world.is_empty() {
        text.wrapped(" ", "nothing", theme.quiet());
    }
    if let Some((step, words)) = heard(state) {
        let ago = live.status.step.saturating_sub(step);
        let when = if ago == 0 { "just now".to_owned() } else { format!("{} ago", count(ago, "step")) };
        text.wrapped("heard ", &format!("{}, {when}", plain(&words.join(" "))), theme.mark());
    }
    text
}

/// The words heard last, with the step in which they were heard.
fn heard(state: &State) -> Option<(u64, &[String])> {
    let last = state.steps.iter().rev().find(|step| !step.heard.is_empty())?;
    let now = state.live.as_ref()?.status.step;
    (now.saturating_sub(last.step) <= HEARD_FOR_STEPS).then_some((last.step, &last.heard))
}
