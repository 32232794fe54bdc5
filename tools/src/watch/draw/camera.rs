//! The camera pane: each perceived thing is a letter in its field, of those into which the camera divides the picture
//! (paper, III-A).

use pschema_inspect::{ObservationText, ValueText, WorldObservation};
use pschema_protocol::picture::FieldMark;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::super::state::State;
use super::super::theme::Theme;
use super::canvas::{Canvas, PaneContent};
use super::text::{WrappedText, clipped};
use crate::render::words::plain;

/// The symbol of a field with nothing in it.
const EMPTY: &str = "\u{b7}";

/// A thing perceived in a field, and how it is drawn.
struct CameraMark {
    field: i64,
    letter: char,
    /// The thing in words: `blue object`.
    what: String,
    /// The thing in as few words as can be understood: `blue`.
    short: String,
    new: bool,
    style: Style,
}

/// The fields, each in its place; a list of them where their places are not known.
pub(super) fn pane(state: &State, canvas: Canvas, to: &mut Buffer) -> (String, String, PaneContent) {
    let theme = canvas.theme;
    let world = state.live.as_ref().map(|live| live.observations.as_slice()).unwrap_or_default();
    let seen = seen(world, theme);
    let body = state.body();
    let name = body.map_or_else(String::new, |body| format!(": {}", plain(&body.name)));
    let title = format!("camera{}", clipped(&name, 24));
    let below = legend(&seen, world, usize::from(canvas.area.width.saturating_sub(2)));
    let fields = body.and_then(|body| state.fields.get(&body.id)).filter(|fields| !fields.is_empty());
    match fields {
        Some(fields) => {
            draw(fields, &seen, canvas, to);
            (title, below, PaneContent::Drawn)
        }
        None => (title, below, PaneContent::WrappedText(list(state, &seen, canvas))),
    }
}

fn seen(world: &[WorldObservation], theme: Theme) -> Vec<CameraMark> {
    let mut letters: Vec<(String, char)> = Vec::new();
    let mut all = Vec::new();
    for perceived in world {
        let observation = &perceived.observation;
        let Some(field) = field(observation) else { continue };
        let colour = colour(observation).unwrap_or_default();
        let what = format!("{colour} {}", plain(&observation.kind)).trim().to_owned();
        let letter = match letters.iter().find(|(known, _)| *known == what) {
            Some((_, letter)) => *letter,
            None => {
                let letter = letter(observation, &colour, &letters);
                letters.push((what.clone(), letter));
                letter
            }
        };
        let is_object = observation.kind == "object" && !colour.is_empty();
        let short = if is_object { colour.clone() } else { plain(&observation.kind) };
        all.push(CameraMark {
            field,
            letter,
            what,
            short,
            new: perceived.new,
            style: theme.of_colour(&colour),
        });
    }
    all
}

fn field(observation: &ObservationText) -> Option<i64> {
    match observation.properties.get("field")? {
        ValueText::Integer(field) => Some(*field),
        _ => None,
    }
}

fn colour(observation: &ObservationText) -> Option<String> {
    match observation.properties.get("colour")? {
        ValueText::Symbol(colour) => Some(plain(colour)),
        _ => None,
    }
}

/// The letter of a thing: for an object the first letter of its colour, in lower case; for everything else the first
/// letter of its type, in upper case. Where another thing has that letter already, the next letter of the name is taken.
fn letter(observation: &ObservationText, colour: &str, taken: &[(String, char)]) -> char {
    let name = if observation.kind == "object" && !colour.is_empty() {
        colour.to_lowercase()
    } else {
        plain(&observation.kind).to_uppercase()
    };
    let free =
        |letter: &char| letter.is_ascii_alphanumeric() && taken.iter().all(|(_, other)| other != letter);
    name.chars().find(free).unwrap_or('?')
}

/// Whether another thing is in the same field, as when the finger covers the object that it touches.
fn is_shared(seen: &[CameraMark], at: usize) -> bool {
    let one = &seen[at];
    seen[..at].iter().any(|other| other.field == one.field && other.letter != one.letter)
}

/// The meaning of the letters, and whether a touch is felt.
fn legend(seen: &[CameraMark], world: &[WorldObservation], width: usize) -> String {
    let mut parts: Vec<String> = Vec::new();
    for one in seen {
        let told = format!("{} {}", one.letter, one.short);
        if !parts.contains(&told) {
            parts.push(told);
        }
    }
    if seen.iter().enumerate().any(|(at, _)| is_shared(seen, at)) {
        parts.push("@ both".to_owned());
    }
    if world.iter().any(|perceived| perceived.observation.kind == "touch") {
        parts.insert(0, "TOUCH".to_owned());
    }
    clipped(&parts.join("  "), width)
}

/// Draws the fields. They lie in a few rows and columns; each of these has a row or column of the screen where the screen
/// is large enough.
fn draw(fields: &[FieldMark], seen: &[CameraMark], canvas: Canvas, to: &mut Buffer) {
    let Canvas { area, theme } = canvas;
    let columns = Grid::new(fields.iter().map(|field| field.x_px), area.width);
    let rows = Grid::new(fields.iter().map(|field| field.y_px), area.height);
    let place = |field: &FieldMark| {
        Rect { x: area.x + columns.at(field.x_px), y: area.y + rows.at(field.y_px), width: 1, height: 1 }
            .as_position()
    };
    for field in fields {
        if let Some(cell) = to.cell_mut(place(field)) {
            cell.set_symbol(EMPTY).set_style(theme.quiet());
        }
    }
    for (at, one) in seen.iter().enumerate() {
        let field = usize::try_from(one.field).ok().and_then(|field| fields.get(field));
        let Some(cell) = field.and_then(|field| to.cell_mut(place(field))) else { continue };
        let style = if one.new { one.style.patch(theme.reversed()) } else { one.style };
        cell.set_char(if is_shared(seen, at) { '@' } else { one.letter }).set_style(style);
    }
}

/// Maps coordinates of the picture to rows, or columns, of the screen.
struct Grid {
    /// The different coordinates of the fields, in ascending order.
    lines: Vec<f32>,
    room: u16,
}

impl Grid {
    fn new(coordinates: impl Iterator<Item = f32>, room: u16) -> Self {
        let mut lines: Vec<f32> = coordinates.collect();
        lines.sort_by(f32::total_cmp);
        lines.dedup_by(|a, b| (*a - *b).abs() < 1.0);
        Self { lines, room }
    }

    fn at(&self, coordinate: f32) -> u16 {
        let count = self.lines.len().max(1);
        let room = usize::from(self.room.max(1));
        let index = self.lines.partition_point(|line| *line < coordinate - 0.5).min(count - 1);
        // The lines are spread evenly where there is room; where there is not, some share a place.
        let at = match room / count {
            0 => index * room / count,
            spread => index * spread + (room - count * spread) / 2,
        };
        u16::try_from(at).unwrap_or(u16::MAX)
    }
}

/// The things in each field, in words: for a body that shows no picture.
fn list(state: &State, seen: &[CameraMark], canvas: Canvas) -> WrappedText {
    let mut text = canvas.text();
    let why = match (&state.blind, state.body()) {
        (Some(why), _) => format!("no picture: {}", plain(why)),
        (None, None) => "no body is attached: start one with `pschema sim`".to_owned(),
        (None, Some(_)) => {
            "no picture has come from this body, so where its fields are is not known".to_owned()
        }
    };
    text.wrapped("", &why, canvas.theme.quiet());
    let mut fields: Vec<i64> = seen.iter().map(|one| one.field).collect();
    fields.sort_unstable();
    fields.dedup();
    for field in fields {
        let there: Vec<&str> =
            seen.iter().filter(|one| one.field == field).map(|one| one.what.as_str()).collect();
        text.wrapped(&format!("field {field}: "), &there.join(", "), canvas.theme.strong());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_fields_have_a_row_each_where_there_is_room() {
        let grid = Grid::new([0.0, 30.0, 60.0, 60.2].into_iter(), 7);
        assert_eq!([0.0, 30.0, 60.0].map(|line| grid.at(line)), [0, 2, 4]);
        let tight = Grid::new((0..10).map(|line| line as f32 * 10.0), 5);
        assert_eq!(tight.at(0.0), 0);
        assert_eq!(tight.at(90.0), 4);
    }
}
