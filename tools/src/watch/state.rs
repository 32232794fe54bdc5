//! The state of a watch: everything that the screen shows follows from it.

use std::collections::{BTreeMap, VecDeque};

use pschema_inspect::{
    BodyState, BodyStatus, Live, SchemaDetail, SchemaList, StageState, TracePage, TraceRecord,
};
use pschema_protocol::picture::FieldMark;

use super::{Pane, STEPS_KEPT_MAX, WatchPage, Wish};

/// News from the daemon or its bodies.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum News {
    /// A daemon answers; if one answered before, it may be another one.
    Attached,
    /// The state of the learner.
    Live(Box<Live>),
    /// More records of the trace.
    Trace(Box<TracePage>),
    /// The schemas executed most often.
    MostUsed(SchemaList),
    /// The places of the fields in a body's camera.
    Fields { session: u64, fields: Vec<FieldMark> },
    /// The reason why there are no pictures.
    Blind(String),
    /// The schema that is followed, or the reason why there is no answer about it.
    FollowedSchema { id: u32, told: Result<Box<SchemaDetail>, String> },
    /// The answer to an order: what was done, or why not.
    Done(Result<String, String>),
    /// The reason why the daemon does not answer any more.
    Lost(String),
}

/// The purpose of a line of text that is being typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Prompt {
    /// Words to say.
    Say,
    /// The number of a schema.
    Follow,
}

/// A line of text that is being typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Input {
    pub(super) prompt: Prompt,
    pub(super) text: String,
}

/// A schema that is followed, with how it was earlier.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FollowedSchema {
    pub(super) id: u32,
    /// The schema in the first answer about it.
    pub(super) first: Option<Box<SchemaDetail>>,
    /// The schema before its last change.
    pub(super) before: Option<Box<SchemaDetail>>,
    pub(super) now: Option<Box<SchemaDetail>>,
    pub(super) problem: Option<String>,
}

/// A message that is shown until the next key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Message {
    pub(super) text: String,
    pub(super) bad: bool,
}

/// Everything known of the learner, and which part of it is on the screen.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct State {
    pub(super) live: Option<Box<Live>>,
    /// The reason why the daemon does not answer; none while it does.
    pub(super) lost: Option<String>,
    pub(super) steps: VecDeque<TraceRecord>,
    /// The number of the first of `steps`.
    pub(super) steps_from: u64,
    pub(super) most_used: Option<SchemaList>,
    /// Fields of the camera of each session that sent a picture.
    pub(super) fields: BTreeMap<u64, Vec<FieldMark>>,
    pub(super) blind: Option<String>,
    pub(super) followed: Option<FollowedSchema>,

    pub(super) page: WatchPage,
    /// Which pane of the page the keys scroll; the remainder by the number of panes counts.
    pub(super) focus: usize,
    pub(super) scroll: [usize; Pane::COUNT],
    /// How far each pane can be scrolled, from the last time it was drawn.
    pub(super) scroll_max: [usize; Pane::COUNT],
    /// The panes that were on the screen when it was last drawn.
    pub(super) shown: Vec<Pane>,
    /// Steps in one column of the excitation trace.
    pub(super) steps_per_column: usize,
    pub(super) input: Option<Input>,
    pub(super) message: Option<Message>,
    pub(super) help: bool,
}

impl State {
    pub(super) fn new(page: WatchPage) -> Self {
        Self {
            live: None,
            lost: None,
            steps: VecDeque::new(),
            steps_from: 0,
            most_used: None,
            fields: BTreeMap::new(),
            blind: None,
            followed: None,
            page,
            focus: 0,
            scroll: [0; Pane::COUNT],
            scroll_max: [0; Pane::COUNT],
            shown: Vec::new(),
            steps_per_column: 1,
            input: None,
            message: None,
            help: false,
        }
    }

    /// Takes news into the state.
    pub(super) fn receive(&mut self, news: News) {
        match news {
            News::Attached => {
                self.lost = None;
                self.live = None;
                self.steps.clear();
                self.most_used = None;
                self.fields.clear();
                self.blind = None;
                if let Some(followed) = &self.followed {
                    self.follow(Some(followed.id));
                }
            }
            News::Live(mut live) => {
                self.trace(std::mem::take(&mut live.trace));
                self.fields.retain(|session, _| live.status.bodies.iter().any(|body| body.id == *session));
                self.live = Some(live);
            }
            News::Trace(page) => self.trace(*page),
            News::MostUsed(list) => self.most_used = Some(list),
            News::Fields { session, fields } => {
                self.blind = None;
                self.fields.insert(session, fields);
            }
            News::Blind(why) => self.blind = Some(why),
            News::FollowedSchema { id, told } => self.told_of_followed(id, told),
            News::Done(Ok(text)) => self.message = Some(Message { text, bad: false }),
            News::Done(Err(text)) => self.message = Some(Message { text, bad: true }),
            News::Lost(why) => self.lost = Some(why),
        }
    }

    /// Adds records of the trace. If there is a gap before them, all earlier records are forgotten.
    fn trace(&mut self, page: TracePage) {
        if page.records.is_empty() {
            return;
        }
        if page.from != self.steps_from + self.steps.len() as u64 {
            self.steps.clear();
            self.steps_from = page.from;
        }
        self.steps.extend(page.records);
        while self.steps.len() > STEPS_KEPT_MAX {
            self.steps.pop_front();
            self.steps_from += 1;
        }
    }

    /// Follows this schema from now on, or none.
    pub(super) fn follow(&mut self, id: Option<u32>) {
        self.followed =
            id.map(|id| FollowedSchema { id, first: None, before: None, now: None, problem: None });
    }

    fn told_of_followed(&mut self, id: u32, told: Result<Box<SchemaDetail>, String>) {
        let Some(followed) = self.followed.as_mut().filter(|followed| followed.id == id) else { return };
        match told {
            Err(problem) => followed.problem = Some(problem),
            Ok(detail) => {
                followed.problem = None;
                followed.first.get_or_insert_with(|| detail.clone());
                if followed.now.as_ref() != Some(&detail) {
                    followed.before = followed.now.replace(detail);
                }
            }
        }
    }

    /// The body whose world is shown: the attached body that acted last, or else the first attached one.
    pub(super) fn body(&self) -> Option<&BodyStatus> {
        let live = self.live.as_deref()?;
        let attached = || live.status.bodies.iter().filter(|body| body.state == BodyState::Attached);
        let acted = live.explanation.as_ref().map(|explanation| explanation.body.as_str());
        attached().find(|body| Some(body.name.as_str()) == acted).or_else(|| attached().next())
    }

    /// Excitation of the most excited candidate of the last decision (paper, figure 6).
    pub(super) fn excitation_top(&self) -> Option<f64> {
        self.steps
            .iter()
            .rev()
            .find_map(|step| step.decision.as_ref())
            .map(|decision| decision.excitation_top)
    }

    /// Whether the learner is held.
    pub(super) fn is_held(&self) -> bool {
        self.live.as_ref().is_some_and(|live| live.status.stage_state == StageState::Held)
    }

    /// The pane that the keys scroll.
    pub(super) fn focused(&self) -> Option<Pane> {
        let count = self.shown.len().max(1);
        self.shown.get(self.focus % count).copied()
    }

    /// Whether the most used schemas are on the screen.
    pub(super) fn looks_at_most_used(&self) -> bool {
        self.shown.contains(&Pane::MostUsed)
    }

    /// The wishes that hold until they change: the schema to follow, and whether the most used schemas are shown.
    pub(super) fn standing_wishes(&self) -> [Wish; 2] {
        [
            Wish::Follow(self.followed.as_ref().map(|followed| followed.id)),
            Wish::MostUsed(self.looks_at_most_used()),
        ]
    }
}
