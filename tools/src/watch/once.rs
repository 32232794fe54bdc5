//! One frame as plain text, for scripts and for those without a terminal.

use std::thread;
use std::time::{Duration, Instant};

use pschema_protocol::domain::Place;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Span;

use super::WatchPage;
use super::asker::Link;
use super::draw::draw;
use super::state::{News, State};
use super::theme::Theme;
use crate::failure::Failure;

/// The time to wait for the first pictures of the bodies.
const PICTURES_WITHIN: Duration = Duration::from_secs(3);
/// The time from one look for a picture to the next.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// The frame that a terminal of this size would show.
pub(crate) fn once(
    place: &Place,
    page: WatchPage,
    follow: Option<u32>,
    width: u16,
    height: u16,
) -> Result<String, Failure> {
    let mut link = Link::connect(place)?;
    let mut state = State::new(page);
    state.follow(follow);
    let area = Rect::new(0, 0, width, height);
    let mut frame = Buffer::empty(area);
    state.receive(News::Attached);
    let began = Instant::now();
    loop {
        link.live(&mut |news| state.receive(news))?;
        if !link.is_looking() || began.elapsed() >= PICTURES_WITHIN {
            break;
        }
        thread::sleep(LOOK_EVERY);
    }
    // Drawn once to know which panes are on the screen.
    draw(&state, Theme::new(false), area, &mut frame).note(&mut state);
    if state.looks_at_most_used() {
        link.most_used(&mut |news| state.receive(news))?;
    }
    if let Some(id) = follow {
        link.followed(id, &mut |news| state.receive(news));
    }
    frame.reset();
    draw(&state, Theme::new(false), area, &mut frame);
    Ok(text(&frame))
}

/// The text of a frame, without its styles.
pub(super) fn text(frame: &Buffer) -> String {
    let mut text = String::new();
    for row in frame.area().rows() {
        let mut line = String::new();
        // A wide symbol covers the cell after it as well.
        let mut hidden = 0;
        for cell in row.columns().filter_map(|place| frame.cell(place.as_position())) {
            if hidden > 0 {
                hidden -= 1;
                continue;
            }
            line.push_str(cell.symbol());
            hidden = Span::raw(cell.symbol()).width().saturating_sub(1);
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}
