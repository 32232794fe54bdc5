//! The styles of the screen. Nothing is told by colour alone: without colours everything can still be read.

use ratatui::style::{Color, Modifier, Style};

/// Styles for a terminal with colours or without.
#[derive(Clone, Copy, Debug)]
pub(super) struct Theme {
    colour: bool,
}

impl Theme {
    pub(super) fn new(colour: bool) -> Self {
        Self { colour }
    }

    fn coloured(self, style: Style, colour: Color) -> Style {
        if self.colour { style.fg(colour) } else { style }
    }

    /// The style of things that are new or chosen.
    pub(super) fn strong(self) -> Style {
        Style::new().add_modifier(Modifier::BOLD)
    }

    /// The style of things that matter less.
    pub(super) fn quiet(self) -> Style {
        Style::new().add_modifier(Modifier::DIM)
    }

    /// The style of the line at the top and of the chosen page.
    pub(super) fn reversed(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    pub(super) fn new_thing(self) -> Style {
        self.coloured(self.strong(), Color::Green)
    }

    pub(super) fn bad(self) -> Style {
        self.coloured(self.strong(), Color::Red)
    }

    pub(super) fn good(self) -> Style {
        self.coloured(self.strong(), Color::Green)
    }

    pub(super) fn curve(self) -> Style {
        self.coloured(Style::new(), Color::Cyan)
    }

    pub(super) fn mark(self) -> Style {
        self.coloured(self.strong(), Color::Yellow)
    }

    /// The style of a thing whose colour has this name.
    pub(super) fn of_colour(self, name: &str) -> Style {
        let colour = match name {
            "red" => Color::Red,
            "green" => Color::Green,
            "blue" => Color::LightBlue,
            "yellow" => Color::Yellow,
            "magenta" | "purple" => Color::Magenta,
            "cyan" => Color::Cyan,
            _ => return self.strong(),
        };
        self.coloured(self.strong(), colour)
    }
}
