//! The terminal: keys that come from it, the screen that is drawn on it, and its state, which is restored however the
//! program ends.

use std::io::{self, IsTerminal};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use pschema_process::{Stop, colour_is_wanted};
use pschema_protocol::domain::Place;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event as Typed};

use crate::failure::Failure;

use super::asker::Asker;
use super::draw::draw;
use super::event::Event;
use super::keys::Act;
use super::state::State;
use super::theme::Theme;
use super::{WatchPage, Wish};

/// The time within which a signal is noticed.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// The time that the asking thread has, at the end, to leave the daemon's shared memory in order.
const FAREWELL_MAX: Duration = Duration::from_secs(1);

/// Watches the learner at `place` until the person quits or a signal comes.
pub(crate) fn watch(place: Place, rate: u8, page: WatchPage, follow: Option<u32>) -> Result<(), Failure> {
    must_be_a_terminal()?;
    let stop = Stop::on_signals_without_haste()?;
    let mut state = State::new(page);
    state.follow(follow);
    let (events, happening) = mpsc::channel();
    let (wishes, wished) = mpsc::channel();
    let asker = Asker {
        place,
        every: Duration::from_secs(1) / u32::from(rate.max(1)),
        wishes: wished,
        events: events.clone(),
        follow,
        most_used: false,
    };
    let (begun, beginning) = mpsc::channel();
    let asking = start("asker", move || asker.run(&begun))?;
    let gone = |_| Failure::Failed("asking the daemon failed; the reason was said above".to_owned());
    beginning.recv().map_err(gone)??;
    let screen = Screen::open()?;
    listen(events)?;
    let theme = Theme::new(colour_is_wanted());
    let seen = WatchLoop { state, theme, screen, happening, wishes, standing: Vec::new() };
    let ended = seen.run(&stop, &asking);
    // The terminal is restored by now, and no wish can come any more.
    let began = Instant::now();
    while !asking.is_finished() && began.elapsed() < FAREWELL_MAX {
        thread::sleep(Duration::from_millis(5));
    }
    ended
}

fn must_be_a_terminal() -> Result<(), Failure> {
    let dumb = std::env::var_os("TERM").is_some_and(|term| term == "dumb");
    let problem = match (io::stdout().is_terminal(), dumb) {
        (true, false) => return Ok(()),
        (false, _) => "stdout is no terminal",
        (_, true) => "this terminal can't be drawn on (TERM is \"dumb\")",
    };
    Err(Failure::Usage(format!(
        "{problem}, and `pschema watch` draws on one: use `pschema watch --once` to print one frame as plain text"
    )))
}

/// Reads keys on a thread of its own, which ends with the process: when a terminal hangs up, a read may never return.
fn listen(events: Sender<Event>) -> Result<(), Failure> {
    let reader = move || {
        loop {
            let event = match event::read() {
                Ok(Typed::Key(key)) => Event::Key(key),
                Ok(Typed::Resize(..)) => Event::Resized,
                Ok(_) => continue,
                Err(error) => Event::Deaf(error),
            };
            let deaf = matches!(event, Event::Deaf(_));
            if events.send(event).is_err() || deaf {
                return;
            }
        }
    };
    start("keys", reader).map(drop)
}

fn start(name: &str, work: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>, Failure> {
    let started = thread::Builder::new().name(name.to_owned()).spawn(work);
    started.map_err(|error| Failure::Failed(format!("cannot start a thread: {error}")))
}

/// The terminal while it is drawn on. Dropping this restores it; a panic restores it as well.
struct Screen {
    terminal: DefaultTerminal,
}

impl Screen {
    fn open() -> Result<Self, Failure> {
        let opened = ratatui::try_init();
        let terminal = opened.map_err(|error| {
            // It may have been changed in part.
            drop(ratatui::try_restore());
            Failure::Failed(format!("the terminal can't be drawn on: {error}; try `pschema watch --once`"))
        })?;
        Ok(Self { terminal })
    }

    fn draw(&mut self, state: &mut State, theme: Theme) -> Result<(), Failure> {
        let drawn = self.terminal.draw(|frame| {
            let area = frame.area();
            draw(state, theme, area, frame.buffer_mut()).note(state);
        });
        drawn.map(drop).map_err(|error| Failure::Failed(format!("cannot draw on the terminal: {error}")))
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // This fails for a terminal that has hung up, which need not be restored.
        drop(self.terminal.show_cursor());
        drop(ratatui::try_restore());
    }
}

/// The loop that takes events and draws.
struct WatchLoop {
    state: State,
    theme: Theme,
    screen: Screen,
    happening: Receiver<Event>,
    wishes: Sender<Wish>,
    /// The standing wishes that were sent last.
    standing: Vec<Wish>,
}

impl WatchLoop {
    fn run(mut self, stop: &Stop, asking: &JoinHandle<()>) -> Result<(), Failure> {
        self.screen.draw(&mut self.state, self.theme)?;
        loop {
            if stop.is_raised() {
                return Ok(());
            }
            if asking.is_finished() {
                return Err(Failure::Failed(
                    "asking the daemon failed; the reason was said above".to_owned(),
                ));
            }
            let first = match self.happening.recv_timeout(LOOK_EVERY) {
                Ok(event) => event,
                Err(RecvTimeoutError::Timeout) => continue,
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            };
            if self.take(first)? {
                return Ok(());
            }
            // All events that have come are taken before the screen is drawn.
            while let Ok(event) = self.happening.try_recv() {
                if self.take(event)? {
                    return Ok(());
                }
            }
            self.screen.draw(&mut self.state, self.theme)?;
            self.tell_standing_wishes();
        }
    }

    /// Takes an event; returns whether it was the last.
    fn take(&mut self, event: Event) -> Result<bool, Failure> {
        match event {
            Event::News(news) => self.state.receive(news),
            Event::Resized => (),
            Event::Key(key) => match self.state.key(key) {
                Some(Act::Quit) => return Ok(true),
                Some(Act::Wish(wish)) => self.wish(wish),
                None => (),
            },
            Event::Deaf(error) => {
                return Err(Failure::Failed(format!("no more keys can be read from the terminal: {error}")));
            }
        }
        Ok(false)
    }

    fn wish(&self, wish: Wish) {
        // Sending fails only when the asking thread has ended, which is noticed before long.
        drop(self.wishes.send(wish));
    }

    fn tell_standing_wishes(&mut self) {
        let standing = self.state.standing_wishes().to_vec();
        if standing != self.standing {
            standing.iter().cloned().for_each(|wish| self.wish(wish));
            self.standing = standing;
        }
    }
}
