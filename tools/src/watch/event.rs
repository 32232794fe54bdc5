//! Events of a watch: news of the learner, keys, changes of the terminal.

use std::io;

use ratatui::crossterm::event::KeyEvent;

use super::state::News;

/// An event of a watch.
#[derive(Debug)]
pub(super) enum Event {
    News(News),
    Key(KeyEvent),
    Resized,
    /// No more keys will come.
    Deaf(io::Error),
}
