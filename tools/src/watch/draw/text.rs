//! Text broken into lines that fit the width of a pane.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

/// The number of columns that a text takes.
pub(super) fn width(text: &str) -> usize {
    Span::raw(text).width()
}

/// The text, cut to at most `max` columns; an ellipsis marks the cut.
pub(super) fn clipped(text: &str, max: usize) -> String {
    if width(text) <= max {
        return text.to_owned();
    }
    let mut kept = String::new();
    let mut columns = 1;
    for letter in text.chars() {
        columns += width(letter.encode_utf8(&mut [0; 4]));
        if columns > max {
            break;
        }
        kept.push(letter);
    }
    if max > 0 {
        kept.push('\u{2026}');
    }
    kept
}

/// Lines of text, none wider than a given number of columns.
#[derive(Debug)]
pub(super) struct WrappedText {
    width: usize,
    lines: Vec<Line<'static>>,
}

impl WrappedText {
    pub(super) fn new(width: usize) -> Self {
        Self { width, lines: Vec::new() }
    }

    pub(super) fn of(width: usize, text: &str) -> Self {
        let mut all = Self::new(width);
        all.wrapped("", text, Style::new());
        all
    }

    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    pub(super) fn push(&mut self, line: Line<'static>) {
        self.lines.push(line);
    }

    /// Keeps the first `max` lines.
    pub(super) fn cut(&mut self, max: usize) {
        self.lines.truncate(max);
    }

    /// Adds a text, over as many lines as it takes. `first` stands before its first line, and as many spaces before the
    /// others.
    pub(super) fn wrapped(&mut self, first: &str, text: &str, style: Style) {
        // Where the label leaves no room beside it, the text begins on the next line.
        let indent = if width(first) * 2 > self.width { 2 } else { width(first) };
        let room = self.width.saturating_sub(indent).max(1);
        let mut before = first.to_owned();
        let mut line = String::new();
        if width(first) > indent {
            self.lines.push(Line::from(std::mem::take(&mut before)));
            before = " ".repeat(indent);
        }
        for word in text.split(' ') {
            for piece in pieces(word, room) {
                if !line.is_empty() && width(&line) + 1 + width(&piece) > room {
                    self.finish(&mut before, &mut line, indent, style);
                }
                if !line.is_empty() {
                    line.push(' ');
                }
                line.push_str(&piece);
            }
        }
        self.finish(&mut before, &mut line, indent, style);
    }

    fn finish(&mut self, before: &mut String, line: &mut String, indent: usize, style: Style) {
        let before = std::mem::replace(before, " ".repeat(indent));
        self.lines.push(Line::from(vec![Span::raw(before), Span::styled(std::mem::take(line), style)]));
    }

    /// Draws the lines from `scroll` on.
    pub(super) fn draw(&self, area: Rect, scroll: usize, to: &mut Buffer) {
        for (row, line) in area.rows().zip(self.lines.iter().skip(scroll)) {
            to.set_line(row.x, row.y, line, row.width);
        }
    }
}

/// A word cut into pieces that fit; nearly always one piece.
fn pieces(word: &str, room: usize) -> Vec<String> {
    if width(word) <= room {
        return vec![word.to_owned()];
    }
    let mut pieces = vec![String::new()];
    for letter in word.chars() {
        let columns = width(letter.encode_utf8(&mut [0; 4]));
        let Some(last) = pieces.last_mut() else { break };
        if !last.is_empty() && width(last) + columns > room {
            pieces.push(letter.to_string());
        } else {
            last.push(letter);
        }
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &WrappedText) -> Vec<String> {
        text.lines.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn a_text_is_broken_at_spaces_and_hangs_under_its_label() {
        let mut text = WrappedText::new(12);
        text.wrapped("a: ", "one two three", Style::new());
        assert_eq!(lines(&text), ["a: one two", "   three"]);
    }

    #[test]
    fn a_word_that_is_too_long_is_broken_and_all_of_it_is_there() {
        let mut text = WrappedText::new(6);
        text.wrapped("", "abcdefghij kl", Style::new());
        assert_eq!(lines(&text), ["abcdef", "ghij", "kl"]);
        let mut label = WrappedText::new(6);
        label.wrapped("a label: ", "x", Style::new());
        assert_eq!(lines(&label), ["a label: ", "  x"]);
    }

    #[test]
    fn what_is_cut_off_is_marked() {
        assert_eq!(clipped("abcdef", 6), "abcdef");
        assert_eq!(clipped("abcdefg", 6), "abcde\u{2026}");
        assert_eq!(clipped("\u{4e00}\u{4e01}\u{4e02}", 4), "\u{4e00}\u{2026}");
        assert_eq!(clipped("abc", 0), "");
    }
}
