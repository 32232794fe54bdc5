//! The screen, which follows from the state alone.

mod camera;
mod canvas;
mod choice;
mod excitation;
mod follow;
mod layout;
mod learner;
mod schemas;
mod text;
mod world;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Clear, Widget};

use super::keys::HELP;
use super::state::{Prompt, State};
use super::theme::Theme;
use super::{Pane, WatchPage};
use crate::render::status::state as stage_state;
use crate::render::words::plain;
use canvas::{Canvas, PaneContent};
use text::WrappedText;

/// On a smaller screen nothing could be read.
const WIDTH_MIN: u16 = 40;
const HEIGHT_MIN: u16 = 10;
/// Lines that a message may take, or the reason why the daemon does not answer.
const MESSAGE_LINES_MAX: usize = 3;

/// The panes that were drawn, and how far each of them can be scrolled.
#[derive(Debug)]
pub(super) struct ScrollRange {
    shown: Vec<Pane>,
    scroll_max: [usize; Pane::COUNT],
}

impl ScrollRange {
    /// Keeps them in the state, for the keys that come.
    pub(super) fn note(self, state: &mut State) {
        state.shown = self.shown;
        state.scroll_max = self.scroll_max;
    }
}

/// Draws the whole screen.
pub(super) fn draw(state: &State, theme: Theme, area: Rect, to: &mut Buffer) -> ScrollRange {
    let mut drawn = ScrollRange { shown: Vec::new(), scroll_max: [0; Pane::COUNT] };
    if area.width < WIDTH_MIN || area.height < HEIGHT_MIN {
        let text = format!("too small: {WIDTH_MIN} x {HEIGHT_MIN} at least, 80 x 24 is good; q quits");
        WrappedText::of(usize::from(area.width), &text).draw(area, 0, to);
        return drawn;
    }
    let top = Rect { height: 1, ..area };
    title(state, theme, top, to);
    pages(state, theme, Rect { y: area.y + 1, ..top }, to);
    let bottom = footer(state, theme, usize::from(area.width));
    let bottom_height = u16::try_from(bottom.len()).unwrap_or(1);
    let body = Rect { y: area.y + 2, height: area.height.saturating_sub(2 + bottom_height), ..area };
    let places = layout::panes(state.page, body, state.followed.is_some());
    drawn.shown = places.iter().map(|(pane, _)| *pane).collect();
    let focus = state.focus % places.len().max(1);
    for (at, (pane, place)) in places.iter().enumerate() {
        let focused = at == focus && places.len() > 1;
        drawn.scroll_max[*pane as usize] = draw_pane(state, theme, *pane, focused, *place, to);
    }
    bottom.draw(Rect { y: body.bottom(), height: bottom_height, ..area }, 0, to);
    if state.help {
        help(theme, body, to);
    }
    drawn
}

/// Draws a pane; returns how many lines it can be scrolled.
fn draw_pane(state: &State, theme: Theme, pane: Pane, focused: bool, place: Rect, to: &mut Buffer) -> usize {
    let kind = if focused { BorderType::Thick } else { BorderType::Plain };
    let block = Block::bordered().border_type(kind);
    let canvas = Canvas { area: block.inner(place), theme };
    let (title, bottom, content) = contents(state, pane, canvas, to);
    let mut block = block.title(Span::styled(format!(" {title} "), theme.strong()));
    if !bottom.is_empty() {
        block = block.title_bottom(format!(" {bottom} "));
    }
    let mut scroll_max = 0;
    if let PaneContent::WrappedText(text) = content {
        let rows = usize::from(canvas.area.height);
        scroll_max = text.len().saturating_sub(rows);
        let scroll = state.scroll[pane as usize].min(scroll_max);
        text.draw(canvas.area, scroll, to);
        let below = scroll_max - scroll;
        if below > 0 {
            block = block.title_bottom(Line::from(format!(" {below} more below ")).right_aligned());
        } else if scroll > 0 {
            block = block.title_bottom(Line::from(format!(" {scroll} more above ")).right_aligned());
        }
    }
    block.render(place, to);
    scroll_max
}

/// The title of a pane, the text in its lower border, and its inside.
fn contents(state: &State, pane: Pane, canvas: Canvas, to: &mut Buffer) -> (String, String, PaneContent) {
    let titled =
        |title: &str, text: WrappedText| (title.to_owned(), String::new(), PaneContent::WrappedText(text));
    match pane {
        Pane::Camera => camera::pane(state, canvas, to),
        Pane::World => (
            world::title(state),
            world::then(state, canvas),
            PaneContent::WrappedText(world::text(state, canvas)),
        ),
        Pane::Excitation => {
            let title = excitation::curve(state, canvas, to);
            (title, String::new(), PaneContent::Drawn)
        }
        Pane::Steps => titled("last steps", excitation::steps(state, canvas)),
        Pane::Choice => titled("why it did what it did last", choice::text(state, canvas)),
        Pane::Newest => titled("newest schemas, successes/executions", schemas::newest(state, canvas)),
        Pane::MostUsed => titled(&schemas::most_used_title(state), schemas::most_used(state, canvas)),
        Pane::Learner => titled("learner", learner::text(state, canvas)),
        Pane::Follow => titled(&follow::title(state), follow::text(state, canvas)),
    }
}

/// The line at the top: the name of the learner, its stage, and how many schemas it has.
fn title(state: &State, theme: Theme, place: Rect, to: &mut Buffer) {
    to.set_style(place, theme.reversed());
    let Some(status) = state.live.as_ref().map(|live| &live.status) else {
        to.set_stringn(place.x, place.y, " pschema watch", place.width.into(), theme.reversed());
        return;
    };
    let doing =
        format!(" {}: {} ({})", plain(&status.name), plain(&status.stage), stage_state(&status.stage_state));
    let width = usize::from(place.width);
    let step = format!("step {}  {} schemas", status.step, status.schemas_total);
    let more = format!("{step}, {} general", status.schemas_generalised);
    // The stage comes first; the rest is told as far as there is room.
    let longest = [format!("{more}  {:.1}/s ", status.steps_per_s), format!("{more} ")];
    let fits = |known: &String| text::width(&doing) + 1 + text::width(known) <= width;
    let known = longest.into_iter().find(fits).unwrap_or_else(|| format!("{step} "));
    let left = text::clipped(&doing, width.saturating_sub(text::width(&known) + 1));
    let gap = width.saturating_sub(text::width(&left) + text::width(&known));
    let line = format!("{left}{}{known}", " ".repeat(gap));
    to.set_stringn(place.x, place.y, line, width, theme.reversed());
}

/// The names of the pages; the page that is shown stands in brackets.
fn pages(state: &State, theme: Theme, place: Rect, to: &mut Buffer) {
    let mut spans = Vec::new();
    for (at, page) in WatchPage::ALL.iter().enumerate() {
        let name = format!("{} {}", at + 1, page.name());
        spans.push(if *page == state.page {
            Span::styled(format!("[{name}]"), theme.strong())
        } else {
            Span::raw(format!(" {name} "))
        });
    }
    spans.push(Span::styled("   ? help", theme.quiet()));
    to.set_line(place.x, place.y, &Line::from(spans), place.width);
}

/// The lines at the bottom: the line that is being typed, or a message; else the keys.
fn footer(state: &State, theme: Theme, width: usize) -> WrappedText {
    let mut text = WrappedText::new(width);
    if let Some(why) = &state.lost {
        let told = format!("NO DAEMON ANSWERS, looking for it again and again: {}", plain(why));
        text.wrapped("", &told, theme.bad());
    } else if state.live.is_none() {
        text.wrapped("", "waiting for the daemon to answer", theme.quiet());
    }
    if let Some(input) = &state.input {
        let prompt = match input.prompt {
            Prompt::Say => "say (Enter says it, Esc does not): ",
            Prompt::Follow => "follow schema number (none: follow none): ",
        };
        // Letters are added at the end of the line, so its end is shown.
        let room = width.saturating_sub(text::width(prompt) + 1);
        let count = input.text.chars().count();
        let shown: String = input.text.chars().skip(count.saturating_sub(room)).collect();
        text.push(Line::from(vec![
            Span::styled(prompt, theme.strong()),
            Span::raw(plain(&shown)),
            Span::styled("_", theme.strong()),
        ]));
    } else if let Some(message) = &state.message {
        let (mark, style) = if message.bad { ("! ", theme.bad()) } else { ("", theme.good()) };
        text.wrapped(mark, &plain(&message.text), style);
    } else if text.len() == 0 {
        let held = if state.is_held() { "space resume" } else { "space hold" };
        let keys =
            format!(" {held}  . step  w say  f follow  \u{2190}\u{2192} page  tab pane  ? help  q quit");
        text.push(Line::styled(text::clipped(&keys, width), theme.quiet()));
    }
    text.cut(MESSAGE_LINES_MAX);
    text
}

/// The list of keys, drawn over the panes.
fn help(theme: Theme, body: Rect, to: &mut Buffer) {
    let mut text = WrappedText::new(usize::from(body.width.saturating_sub(4)).min(72));
    for (keys, does) in HELP {
        text.wrapped(&format!("{keys:<12}"), does, ratatui::style::Style::new());
    }
    let notes =
        "In the lists, * is what is new, and > what was chosen. N is how often something had attention.";
    text.wrapped("", "", ratatui::style::Style::new());
    text.wrapped("", notes, ratatui::style::Style::new());
    let height = u16::try_from(text.len() + 2).unwrap_or(u16::MAX).min(body.height);
    let width = 76.min(body.width);
    let place =
        Rect { x: body.x + (body.width - width) / 2, y: body.y + (body.height - height) / 2, width, height };
    Clear.render(place, to);
    let block =
        Block::bordered().border_type(BorderType::Double).title(Span::styled(" keys ", theme.strong()));
    let inner = block.inner(place);
    block.render(place, to);
    text.draw(Rect { x: inner.x + 1, width: inner.width.saturating_sub(1), ..inner }, 0, to);
}
