//! The place of a pane on the screen, and what is drawn there.

use ratatui::layout::Rect;

use super::super::theme::Theme;
use super::text::WrappedText;

/// The inside of a pane.
pub(super) enum PaneContent {
    /// Lines of text, drawn from the line on to which the pane is scrolled.
    WrappedText(WrappedText),
    /// Nothing that is left to draw: the pane has drawn itself.
    Drawn,
}

/// The inner area of a pane, and the styles to draw with.
#[derive(Clone, Copy)]
pub(super) struct Canvas {
    pub(super) area: Rect,
    pub(super) theme: Theme,
}

impl Canvas {
    /// An empty text, as wide as the pane.
    pub(super) fn text(self) -> WrappedText {
        WrappedText::new(usize::from(self.area.width))
    }
}
