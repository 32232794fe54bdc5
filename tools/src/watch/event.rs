//! What happens to somebody who watches: news of the learner, keys, the terminal.

use std::io;

use ratatui::crossterm::event::KeyEvent;

use super::state::News;

/// What happens to somebody who watches.
#[derive(Debug)]
pub(super) enum Event {
    News(News),
    Key(KeyEvent),
    Resized,
    /// No more keys will come.
    Deaf(io::Error),
}
