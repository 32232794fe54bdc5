//! The places of the panes.

use ratatui::layout::{Constraint, Layout, Rect};

use super::super::{Pane, WatchPage};

/// On a screen of at least this size all panes are shown together.
const LARGE_WIDTH: u16 = 130;
const LARGE_HEIGHT: u16 = 36;
/// Columns of the camera: 41 for the fields of the wide world, which lie in 41 columns and 19 rows.
const CAMERA_WIDTH: u16 = 43;
const CAMERA_HEIGHT: u16 = 21;
/// The width that is kept beside the camera, enough for an observation.
const BESIDE_MIN: u16 = 30;

/// The panes of a page with their places, in the order in which the Tab key visits them.
pub(super) fn panes(page: WatchPage, area: Rect, follows: bool) -> Vec<(Pane, Rect)> {
    match page {
        WatchPage::Now if area.width >= LARGE_WIDTH && area.height >= LARGE_HEIGHT => {
            everything(area, follows)
        }
        WatchPage::Now => now(area),
        WatchPage::Excitation => {
            let curve = (area.height / 2).max(8);
            stacked(
                area,
                &[(Pane::Excitation, Constraint::Length(curve)), (Pane::Steps, Constraint::Fill(1))],
            )
        }
        WatchPage::Choice => vec![(Pane::Choice, area)],
        WatchPage::Schemas => {
            stacked(area, &[(Pane::Newest, Constraint::Fill(1)), (Pane::MostUsed, Constraint::Fill(1))])
        }
        WatchPage::Learner => vec![(Pane::Learner, area)],
        WatchPage::Follow => vec![(Pane::Follow, area)],
    }
}

fn now(area: Rect) -> Vec<(Pane, Rect)> {
    let beside = [Constraint::Length(CAMERA_WIDTH), Constraint::Fill(1)];
    if area.width < CAMERA_WIDTH + BESIDE_MIN {
        let half = [Constraint::Fill(1), Constraint::Fill(1)];
        let [camera, world] = Layout::vertical(half).areas(area);
        return vec![(Pane::Camera, camera), (Pane::World, world)];
    }
    let [camera, rest] = Layout::horizontal(beside).areas(area);
    let mut places = vec![(Pane::Camera, camera)];
    let excitation = (area.height / 2).clamp(5, 14);
    places.extend(stacked(
        rest,
        &[(Pane::World, Constraint::Fill(1)), (Pane::Excitation, Constraint::Length(excitation))],
    ));
    places
}

fn everything(area: Rect, follows: bool) -> Vec<(Pane, Rect)> {
    let columns = [Constraint::Length(CAMERA_WIDTH), Constraint::Fill(5), Constraint::Fill(4)];
    let [left, middle, right] = Layout::horizontal(columns).areas(area);
    let mut places = stacked(
        left,
        &[(Pane::Camera, Constraint::Length(CAMERA_HEIGHT)), (Pane::World, Constraint::Fill(1))],
    );
    places.extend(stacked(
        middle,
        &[(Pane::Excitation, Constraint::Length(14)), (Pane::Choice, Constraint::Fill(1))],
    ));
    let last = if follows { Pane::Follow } else { Pane::MostUsed };
    places.extend(stacked(
        right,
        &[
            (Pane::Learner, Constraint::Length(20)),
            (Pane::Newest, Constraint::Fill(1)),
            (last, Constraint::Fill(1)),
        ],
    ));
    places
}

fn stacked(area: Rect, panes: &[(Pane, Constraint)]) -> Vec<(Pane, Rect)> {
    let places = Layout::vertical(panes.iter().map(|(_, height)| *height)).split(area);
    panes.iter().map(|(pane, _)| *pane).zip(places.iter().copied()).collect()
}
