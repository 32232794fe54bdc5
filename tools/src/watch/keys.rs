//! The keys, and their effect on the state.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::state::{Input, Message, Prompt, State};
use super::{WatchPage, Wish};

/// Letters of the longest line that can be typed.
const INPUT_CHARS_MAX: usize = 256;
/// Most steps in one column of the excitation trace.
const STEPS_PER_COLUMN_MAX: usize = 64;

/// An effect of a key beyond the screen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Act {
    Quit,
    Wish(Wish),
}

/// The keys with what they do, for the help.
pub(super) const HELP: [(&str, &str); 12] = [
    ("space", "hold the learner, or let it go on"),
    (". or s", "take one action, and hold"),
    ("w or /", "say words: Enter says them, Esc does not"),
    ("f", "follow a schema by its number; no number: none"),
    ("1 to 6", "a page: now, excitation, choice, schemas, learner, follow"),
    ("left right", "the page before, the next one"),
    ("tab", "the next pane of the page, shift-tab the one before"),
    ("up down", "scroll the pane with the thick frame; PgUp PgDn Home End"),
    ("+ -", "less or more of the past in the excitation trace"),
    ("esc", "away with this help, or a message"),
    ("?", "this help"),
    ("q Ctrl-C", "quit; the learner goes on"),
];

impl State {
    /// Applies a key to the state; returns its effect beyond the screen, if it has one.
    pub(super) fn key(&mut self, key: KeyEvent) -> Option<Act> {
        if key.kind == KeyEventKind::Release {
            return None;
        }
        let control = key.modifiers.contains(KeyModifiers::CONTROL);
        if control && matches!(key.code, KeyCode::Char('c' | 'd')) {
            return Some(Act::Quit);
        }
        match self.input.take() {
            Some(input) => self.write(input, key.code, control),
            None => self.press(key.code),
        }
    }

    fn press(&mut self, key: KeyCode) -> Option<Act> {
        self.message = None;
        let help = std::mem::take(&mut self.help);
        match key {
            KeyCode::Char('q') => return Some(Act::Quit),
            KeyCode::Char('?') | KeyCode::F(1) => self.help = !help,
            KeyCode::Char(' ') => {
                return Some(Act::Wish(if self.is_held() { Wish::Resume } else { Wish::Hold }));
            }
            KeyCode::Char('.' | 's') => return Some(Act::Wish(Wish::Step)),
            KeyCode::Char('w' | '/') => self.ask(Prompt::Say),
            KeyCode::Char('f') => self.ask(Prompt::Follow),
            KeyCode::Char(digit @ '1'..='6') => self.turn_to(WatchPage::at(digit as usize - '1' as usize)),
            KeyCode::Right | KeyCode::Char('l') => self.turn_to(self.page.next()),
            KeyCode::Left | KeyCode::Char('h') => self.turn_to(self.page.before()),
            KeyCode::Tab => self.focus = self.focus.wrapping_add(1) % self.shown.len().max(1),
            KeyCode::BackTab => {
                let count = self.shown.len().max(1);
                self.focus = (self.focus % count + count - 1) % count;
            }
            KeyCode::Up | KeyCode::Char('k') => self.scroll_by(-1),
            KeyCode::Down | KeyCode::Char('j') => self.scroll_by(1),
            KeyCode::PageUp => self.scroll_by(-10),
            KeyCode::PageDown => self.scroll_by(10),
            KeyCode::Home => self.scroll_by(isize::MIN),
            KeyCode::End => self.scroll_by(isize::MAX),
            KeyCode::Char('+' | '=') => self.steps_per_column = (self.steps_per_column / 2).max(1),
            KeyCode::Char('-') => {
                self.steps_per_column = (self.steps_per_column * 2).min(STEPS_PER_COLUMN_MAX);
            }
            _ => (),
        }
        None
    }

    fn ask(&mut self, prompt: Prompt) {
        self.input = Some(Input { prompt, text: String::new() });
    }

    fn turn_to(&mut self, page: WatchPage) {
        if page != self.page {
            self.page = page;
            self.focus = 0;
        }
    }

    fn scroll_by(&mut self, lines: isize) {
        let Some(pane) = self.focused() else { return };
        let at = pane as usize;
        let now = self.scroll[at].min(self.scroll_max[at]);
        self.scroll[at] = now.saturating_add_signed(lines).min(self.scroll_max[at]);
    }

    /// Applies a key while a line is being typed.
    fn write(&mut self, mut input: Input, key: KeyCode, control: bool) -> Option<Act> {
        match key {
            KeyCode::Esc => return None,
            KeyCode::Enter => return self.written(&input),
            KeyCode::Backspace => drop(input.text.pop()),
            KeyCode::Char('u') if control => input.text.clear(),
            KeyCode::Char(c) if !control && input.text.chars().count() < INPUT_CHARS_MAX => {
                input.text.push(c)
            }
            _ => (),
        }
        self.input = Some(input);
        None
    }

    fn written(&mut self, input: &Input) -> Option<Act> {
        let text = input.text.trim();
        match input.prompt {
            Prompt::Say if text.is_empty() => None,
            Prompt::Say => Some(Act::Wish(Wish::Say(text.split_whitespace().map(str::to_owned).collect()))),
            Prompt::Follow if text.is_empty() => {
                self.follow(None);
                None
            }
            Prompt::Follow => {
                match text.trim_start_matches('#').parse() {
                    Ok(id) => {
                        self.follow(Some(id));
                        self.turn_to(WatchPage::Follow);
                    }
                    Err(_) => {
                        let text = format!("{text:?} is no number of a schema: page 4 lists some");
                        self.message = Some(Message { text, bad: true });
                    }
                }
                None
            }
        }
    }
}
