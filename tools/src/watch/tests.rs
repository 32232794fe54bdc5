//! What people see, compared with files in `tests/golden`, and what keys do.

mod sample;

use pschema_inspect::{LiveQuery, StageState, TracePage};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use ratatui::style::{Color, Modifier};

use super::draw::draw;
use super::keys::Act;
use super::state::{News, State};
use super::theme::Theme;
use super::{Pane, STEPS_KEPT_MAX, WatchPage, Wish, once, query};
use crate::golden::check;
use sample::{detail, live, state, trace};

/// The screen that `state` makes on a terminal of this size.
fn screen(state: &mut State, colour: bool, width: u16, height: u16) -> TestBackend {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    let draw = |frame: &mut ratatui::Frame<'_>| {
        let area = frame.area();
        draw(state, Theme::new(colour), area, frame.buffer_mut()).note(state);
    };
    terminal.draw(draw).unwrap();
    terminal.backend().clone()
}

fn read(state: &mut State, width: u16, height: u16) -> String {
    once::text(screen(state, false, width, height).buffer())
}

#[test]
fn each_page_on_a_terminal_of_80_by_24() {
    for page in WatchPage::ALL {
        let mut state = state(page);
        if page == WatchPage::Follow {
            state.follow(Some(226));
            for executions in [2, 2, 3] {
                state.receive(News::FollowedSchema { id: 226, told: Ok(Box::new(detail(executions))) });
            }
        }
        check(&format!("watch-80x24-{}.txt", page.name()), &read(&mut state, 80, 24));
    }
}

#[test]
fn everything_on_a_large_terminal() {
    check("watch-160x50.txt", &read(&mut state(WatchPage::Now), 160, 50));
}

/// The curve was drawn in thousandths, and figures had two decimals: after some thousand steps both were gone.
#[test]
fn a_small_excitation_has_a_curve_and_figures() {
    let mut small = live();
    for decision in small.trace.records.iter_mut().filter_map(|record| record.decision.as_mut()) {
        decision.excitation_top *= 1e-5;
        decision.excitation *= 1e-5;
    }
    let mut state = State::new(WatchPage::Excitation);
    state.receive(News::Live(Box::new(small)));
    let text = read(&mut state, 80, 24);
    assert!(text.contains('█') && text.contains("0.000025"), "{text}");
}

#[test]
fn nothing_known_yet_and_the_help() {
    let mut state = State::new(WatchPage::Now);
    check("watch-80x24-waiting.txt", &read(&mut state, 80, 24));
    let mut state = sample::state(WatchPage::Now);
    press(&mut state, KeyCode::Char('?'));
    check("watch-80x24-help.txt", &read(&mut state, 80, 24));
}

#[test]
fn a_body_without_pictures_and_one_that_is_not_there() {
    let mut without = State::new(WatchPage::Now);
    without.receive(News::Live(Box::new(live())));
    check("watch-80x24-blind.txt", &read(&mut without, 80, 24));
    let mut nobody = live();
    nobody.status.bodies.clear();
    nobody.status.world.clear();
    nobody.observations.clear();
    nobody.explanation = None;
    without.receive(News::Live(Box::new(nobody)));
    let text = read(&mut without, 80, 24);
    assert!(text.contains("no body is attached") && text.contains("pschema sim"), "{text}");
}

#[test]
fn no_size_of_terminal_is_a_problem() {
    for page in WatchPage::ALL {
        for (width, height) in
            [(1, 1), (10, 3), (39, 9), (40, 10), (60, 15), (79, 23), (130, 36), (300, 9), (40, 200)]
        {
            let mut state = state(page);
            state.follow(Some(226));
            state.receive(News::FollowedSchema { id: 226, told: Ok(Box::new(detail(2))) });
            let text = read(&mut state, width, height);
            assert_eq!(text.lines().count(), usize::from(height), "{width} x {height}");
        }
    }
}

#[test]
fn colour_says_nothing_that_is_not_said_without() {
    for page in WatchPage::ALL {
        let (mut plain, mut coloured) = (state(page), state(page));
        let plain = screen(&mut plain, false, 160, 50);
        let coloured = screen(&mut coloured, true, 160, 50);
        assert_eq!(once::text(plain.buffer()), once::text(coloured.buffer()));
        let uncoloured = |cell: &ratatui::buffer::Cell| (cell.fg, cell.bg) == (Color::Reset, Color::Reset);
        assert!(plain.buffer().content().iter().all(uncoloured), "NO_COLOR means none");
        let colours = page == WatchPage::Now;
        assert!(!colours || !coloured.buffer().content().iter().all(uncoloured), "where there are colours");
    }
}

#[test]
fn what_is_new_is_marked_and_bold() {
    let screen = screen(&mut state(WatchPage::Now), false, 80, 24);
    let text = once::text(screen.buffer());
    let (row, line) =
        text.lines().enumerate().find(|(_, line)| line.contains("*touch{}")).expect("touch is new");
    let column = line.chars().position(|c| c == '*').unwrap() + 1;
    let cell = screen.buffer().cell((u16::try_from(column).unwrap(), u16::try_from(row).unwrap())).unwrap();
    assert!(cell.modifier.contains(Modifier::BOLD), "{cell:?}");
    assert!(text.contains(" object{colour=blue, field=104} N12"), "what was there before is not:\n{text}");
}

#[test]
fn a_name_that_would_steer_the_terminal_is_shown_and_not_obeyed() {
    let mut evil = live();
    "\x1b[2J".clone_into(&mut evil.status.name);
    "\x1b[31mstage\n".clone_into(&mut evil.status.stage);
    evil.status.stage_state = StageState::Stuck("\x1b[2J".to_owned());
    evil.status.world[0] = "\x07bell".to_owned();
    evil.status.bodies[0].name = "\x1b]0;title\x07".to_owned();
    evil.status.bodies[0].last_refusal = Some("\r\n".to_owned());
    let mut state = State::new(WatchPage::Now);
    state.receive(News::Live(Box::new(evil)));
    for page in WatchPage::ALL {
        state.page = page;
        let screen = screen(&mut state, true, 160, 50);
        let steers = |cell: &ratatui::buffer::Cell| cell.symbol().chars().any(char::is_control);
        assert!(!screen.buffer().content().iter().any(steers), "{page:?}");
    }
}

#[test]
fn a_daemon_that_has_gone_is_told_of_and_what_was_known_stays() {
    let mut state = state(WatchPage::Now);
    state.receive(News::Lost("no daemon serves learner default".to_owned()));
    let text = read(&mut state, 80, 24);
    assert!(text.contains("NO DAEMON ANSWERS") && text.contains("object{colour=blue"), "{text}");
    state.receive(News::Attached);
    state.receive(News::Live(Box::new(live())));
    assert!(!read(&mut state, 80, 24).contains("NO DAEMON"));
}

#[test]
fn another_daemon_has_another_trace() {
    let mut state = state(WatchPage::Excitation);
    assert_eq!(state.steps.len(), 100);
    state.receive(News::Attached);
    assert_eq!(state.steps.len(), 0);
    state.receive(News::Trace(Box::new(trace(0, 10))));
    state.receive(News::Trace(Box::new(trace(10, 30))));
    assert_eq!((state.steps_from, state.steps.len()), (0, 30), "pages are put together");
    state.receive(News::Trace(Box::new(trace(50, 60))));
    assert_eq!((state.steps_from, state.steps.len()), (50, 10), "a gap is not drawn as none");
    let many = STEPS_KEPT_MAX as u64 + 60;
    state.receive(News::Trace(Box::new(trace(60, many + 50))));
    assert_eq!(state.steps.len(), STEPS_KEPT_MAX);
    assert_eq!(state.steps_from + STEPS_KEPT_MAX as u64, many + 50);
    state.receive(News::Trace(Box::new(TracePage { records: Vec::new(), ..trace(0, 1) })));
    assert_eq!(state.steps.len(), STEPS_KEPT_MAX, "no news is no gap");
}

#[test]
fn the_excitation_trace_shows_words_touches_and_touching() {
    let mut state = state(WatchPage::Excitation);
    let text = read(&mut state, 120, 30);
    let row = |label: &str| {
        text.lines().find(|line| line.contains(label)).unwrap_or_else(|| panic!("{label}:\n{text}"))
    };
    // Of 100 steps, two or three hear a word, and five after each touch.
    let marks = |label: &str, mark: char| row(label).chars().skip(10).filter(|c| *c == mark).count();
    assert_eq!(marks("heard", 'w'), 2, "{text}");
    assert_eq!(marks("touched", 'T'), marks("touching", '\u{2580}'), "{text}");
    assert_eq!(marks("touched", 'T'), 10, "{text}");
    press(&mut state, KeyCode::Char('-'));
    let halved = read(&mut state, 120, 30);
    assert!(halved.contains("2 steps/column") && halved.contains('w'), "{halved}");
}

fn press(state: &mut State, key: KeyCode) -> Option<Act> {
    state.key(KeyEvent::new(key, KeyModifiers::NONE))
}

fn write(state: &mut State, text: &str) -> Option<Act> {
    text.chars().for_each(|letter| assert_eq!(press(state, KeyCode::Char(letter)), None));
    press(state, KeyCode::Enter)
}

#[test]
fn keys_order_the_learner() {
    let mut state = state(WatchPage::Now);
    assert_eq!(press(&mut state, KeyCode::Char(' ')), Some(Act::Wish(Wish::Hold)));
    let mut held = live();
    held.status.stage_state = StageState::Held;
    state.receive(News::Live(Box::new(held)));
    assert_eq!(press(&mut state, KeyCode::Char(' ')), Some(Act::Wish(Wish::Resume)));
    assert_eq!(press(&mut state, KeyCode::Char('.')), Some(Act::Wish(Wish::Step)));
    assert_eq!(press(&mut state, KeyCode::Char('s')), Some(Act::Wish(Wish::Step)));
    assert_eq!(press(&mut state, KeyCode::Char('q')), Some(Act::Quit));
    let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    assert_eq!(state.key(interrupt), Some(Act::Quit));
}

#[test]
fn a_line_is_written_shown_and_given_up() {
    let mut state = state(WatchPage::Now);
    press(&mut state, KeyCode::Char('w'));
    for letter in "touch  itq".chars() {
        assert_eq!(press(&mut state, KeyCode::Char(letter)), None, "letters are no orders now");
    }
    press(&mut state, KeyCode::Backspace);
    assert!(read(&mut state, 80, 24).contains("touch  it_"));
    let words = ["touch", "it"].map(str::to_owned).to_vec();
    assert_eq!(press(&mut state, KeyCode::Enter), Some(Act::Wish(Wish::Say(words))));
    state.receive(News::Done(Err("nobody would hear it".to_owned())));
    assert!(read(&mut state, 80, 24).contains("! nobody would hear it"));
    press(&mut state, KeyCode::Char('/'));
    press(&mut state, KeyCode::Char('x'));
    assert_eq!(press(&mut state, KeyCode::Esc), None);
    assert_eq!(state.input, None);
    press(&mut state, KeyCode::Char('w'));
    assert_eq!(write(&mut state, ""), None, "nothing is not said");
    press(&mut state, KeyCode::Char('w'));
    for _ in 0..1000 {
        press(&mut state, KeyCode::Char('x'));
    }
    assert!(state.input.as_ref().unwrap().text.len() < 1000, "a line has an end");
    let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
    assert_eq!(state.key(interrupt), Some(Act::Quit), "Ctrl-C quits from a line as well");
}

#[test]
fn a_schema_is_followed_and_what_changes_is_marked() {
    let mut state = state(WatchPage::Now);
    press(&mut state, KeyCode::Char('f'));
    assert_eq!(write(&mut state, "x1"), None);
    assert!(state.message.as_ref().unwrap().bad, "{:?}", state.message);
    press(&mut state, KeyCode::Char('f'));
    assert_eq!(write(&mut state, "226"), None);
    assert_eq!(state.page, WatchPage::Follow);
    assert!(state.standing_wishes().contains(&Wish::Follow(Some(226))));
    let told = |state: &mut State, id, executions| {
        state.receive(News::FollowedSchema { id, told: Ok(Box::new(detail(executions))) });
        read(state, 80, 24)
    };
    let first = told(&mut state, 226, 2);
    assert!(first.contains("2/2") && !first.contains("\u{2502}* "), "{first}");
    let second = told(&mut state, 226, 3);
    assert!(
        second.contains("3/3") && second.contains("+1/+1 since") && second.contains("\u{2502}* "),
        "{second}"
    );
    assert_eq!(told(&mut state, 226, 3), second, "an answer that says the same changes nothing");
    assert_eq!(told(&mut state, 7, 9), second, "an answer about another is late");
    state.receive(News::FollowedSchema { id: 226, told: Err("there is no schema 226".to_owned()) });
    assert!(read(&mut state, 80, 24).contains("! there is no schema 226"));
    press(&mut state, KeyCode::Char('f'));
    assert_eq!(write(&mut state, ""), None);
    assert!(state.standing_wishes().contains(&Wish::Follow(None)));
}

#[test]
fn pages_are_turned_and_panes_scrolled_as_far_as_they_go() {
    let mut state = state(WatchPage::Now);
    read(&mut state, 80, 24);
    assert_eq!(state.shown, [Pane::Camera, Pane::World, Pane::Excitation]);
    assert!(
        !state.looks_at_most_used(),
        "what takes a look at all of memory is asked for only when it is seen"
    );
    press(&mut state, KeyCode::Left);
    assert_eq!(state.page, WatchPage::Follow);
    press(&mut state, KeyCode::Right);
    press(&mut state, KeyCode::Char('2'));
    assert_eq!(state.page, WatchPage::Excitation);
    press(&mut state, KeyCode::Tab);
    let before = read(&mut state, 80, 24);
    assert_eq!(state.focused(), Some(Pane::Steps));
    press(&mut state, KeyCode::End);
    press(&mut state, KeyCode::Down);
    let end = read(&mut state, 80, 24);
    assert!(before.contains("more below") && end.contains("more above"), "{before}\n{end}");
    assert!(end.contains("  1135 "), "the oldest step kept is at the end:\n{end}");
    press(&mut state, KeyCode::Home);
    assert_eq!(read(&mut state, 80, 24), before);
    press(&mut state, KeyCode::BackTab);
    read(&mut state, 80, 24);
    assert_eq!(state.focused(), Some(Pane::Excitation));
    press(&mut state, KeyCode::Char('4'));
    read(&mut state, 80, 24);
    assert!(state.looks_at_most_used());
}

#[test]
fn fields_of_a_camera_that_is_no_more_are_forgotten() {
    let mut state = state(WatchPage::Now);
    let mut other = live();
    other.status.bodies.remove(0);
    state.receive(News::Live(Box::new(other)));
    assert!(state.fields.is_empty());
}

#[test]
fn what_is_asked_for_is_within_the_daemons_limits() {
    let LiveQuery { trace_from, candidates_max, terms_max, newest_max } = query(7);
    assert_eq!(trace_from, 7);
    assert!(candidates_max <= 32 && newest_max <= 100 && terms_max > 0);
}
