//! The thread that asks the daemon: one question after the other, each when the one before it is answered.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use pschema_inspect::{
    Ask, DetailQuery, Live, Report, SayOrder, SchemaQuery, SchemaSort, StageOrder, TracePage, TraceQuery,
};
use pschema_protocol::domain::Place;

use super::event::Event;
use super::eyes::Eyes;
use super::state::News;
use super::{MOST_USED_MAX, Wish, query};
use crate::failure::Failure;
use crate::learner::Learner;
use crate::render::words::plain;

/// The time from one attempt to find a daemon to the next.
const LOOK_AGAIN_EVERY: Duration = Duration::from_millis(500);
/// The shortest time between two questions for the most used schemas.
const MOST_USED_EVERY: Duration = Duration::from_secs(1);
/// How many times longer than the last answer took the pause after it is: the daemon looks at all of memory for it.
const MOST_USED_SHARE: u32 = 10;
/// Records of the trace that are asked for of the time before anybody watched.
const STEPS_BEFORE: u64 = 256;
/// Pages of the trace that are asked for in one round, to catch up with a fast learner.
const PAGES_AT_A_TIME: usize = 8;

/// A connection to a daemon, with how far its trace and schemas have been asked for.
pub(super) struct Link {
    learner: Learner,
    eyes: Eyes,
    /// The number of the next record of the trace to ask for; none before the first answer.
    next: Option<u64>,
    step: Option<u64>,
    most_used: Option<MostUsedTiming>,
    followed: Option<(u32, u64)>,
}

/// The time from which on the most used schemas may be asked for again, and the step of the last answer.
struct MostUsedTiming {
    not_before: Instant,
    step: Option<u64>,
}

impl Link {
    pub(super) fn connect(place: &Place) -> Result<Self, Failure> {
        let (learner, eyes) = (Learner::connect_at(place)?, Eyes::new(place.clone()));
        Ok(Self { learner, eyes, next: None, step: None, most_used: None, followed: None })
    }

    /// Asks for the learner's state and for the trace since the last time, and looks for pictures of its bodies.
    pub(super) fn live(&mut self, tell: &mut dyn FnMut(News)) -> Result<(), Failure> {
        let from = match self.next {
            Some(next) => next,
            None => self.learner.ask(query(u64::MAX))?.trace.total.saturating_sub(STEPS_BEFORE),
        };
        let live: Box<Live> = Box::new(self.learner.ask(query(from))?);
        self.step = Some(live.status.step);
        let looked = self.eyes.look(&live.status.bodies);
        let (end, total) = (end(&live.trace), live.trace.total);
        tell(News::Live(live));
        looked.into_iter().for_each(&mut *tell);
        self.next = Some(self.catch_up(end, total, tell)?);
        Ok(())
    }

    /// Asks for the rest of the trace; when there is more than some pages of it, the oldest records are left out. Returns
    /// the number of the record to go on with.
    fn catch_up(&mut self, mut next: u64, total: u64, tell: &mut dyn FnMut(News)) -> Result<u64, Failure> {
        for _ in 0..PAGES_AT_A_TIME {
            if next >= total {
                break;
            }
            let page = self.learner.ask(TraceQuery { from: next })?;
            if page.records.is_empty() {
                break;
            }
            next = end(&page);
            tell(News::Trace(Box::new(page)));
        }
        Ok(next.max(total.saturating_sub(STEPS_BEFORE)))
    }

    /// Asks for the most used schemas, if the pause is over and the learner has stepped since the last answer.
    pub(super) fn most_used(&mut self, tell: &mut dyn FnMut(News)) -> Result<(), Failure> {
        let due = self
            .most_used
            .as_ref()
            .is_none_or(|last| Instant::now() >= last.not_before && last.step != self.step);
        if !due {
            return Ok(());
        }
        let began = Instant::now();
        let query = SchemaQuery { sort: SchemaSort::Uses, limit: MOST_USED_MAX, ..SchemaQuery::default() };
        let list = self.learner.ask(query)?;
        let rest = MOST_USED_EVERY.max(began.elapsed() * MOST_USED_SHARE);
        self.most_used = Some(MostUsedTiming { not_before: Instant::now() + rest, step: self.step });
        tell(News::MostUsed(list));
        Ok(())
    }

    /// Asks for one schema, if the learner has stepped since the last answer about it.
    pub(super) fn followed(&mut self, id: u32, tell: &mut dyn FnMut(News)) {
        let asked = self.step.map(|step| (id, step));
        if asked.is_some() && self.followed == asked {
            return;
        }
        self.followed = asked;
        // If the daemon has gone, the next question fails too and says so.
        let told = self.learner.ask(DetailQuery { id }).map(Box::new);
        tell(News::FollowedSchema { id, told: told.map_err(|failure| failure.to_string()) });
    }

    /// Whether a first picture of one of the bodies may still come.
    pub(super) fn is_looking(&self) -> bool {
        self.eyes.is_looking()
    }

    /// Gives an order; returns the answer in words.
    fn order(&mut self, wish: &Wish) -> Option<News> {
        let told = match wish {
            Wish::Hold => self.obeyed(StageOrder::Hold, |report| format!("held after step {}", report.step)),
            Wish::Resume => self.obeyed(StageOrder::Resume, |_| "it goes on".to_owned()),
            Wish::Step => self.obeyed(StageOrder::Step, |_| "one action".to_owned()),
            Wish::Say(words) => self.obeyed(SayOrder { words: words.clone() }, |report| {
                format!("said {:?} after step {}: it is heard next", plain(&words.join(" ")), report.step)
            }),
            Wish::Follow(_) | Wish::MostUsed(_) => return None,
        };
        Some(News::Done(told.map_err(|failure| failure.to_string())))
    }

    fn obeyed<O: Ask<Answer = Report>>(
        &mut self,
        order: O,
        tell: impl FnOnce(&Report) -> String,
    ) -> Result<String, Failure> {
        self.learner.ask(order).map(|report| tell(&report))
    }
}

/// The number of the record that follows a page of the trace.
fn end(page: &TracePage) -> u64 {
    page.from.saturating_add(page.records.len() as u64)
}

/// The work of the thread that asks again and again, and passes orders on.
pub(super) struct Asker {
    pub(super) place: Place,
    /// The time from one round of questions to the next.
    pub(super) every: Duration,
    pub(super) wishes: Receiver<Wish>,
    pub(super) events: Sender<Event>,
    pub(super) follow: Option<u32>,
    pub(super) most_used: bool,
}

/// The watching thread has ended, so that no wish can come any more.
struct Hangup;

impl Asker {
    /// Runs until no wish can come any more. Returns at once when there is no daemon to begin with. Either way `begun` is
    /// told first: the connection is made here, because it can't be handed from one thread to another.
    pub(super) fn run(mut self, begun: &Sender<Result<(), Failure>>) {
        let (first, mut link) = match Link::connect(&self.place) {
            Ok(link) => (Ok(()), Some(link)),
            Err(failure) => (Err(failure), None),
        };
        if begun.send(first).is_err() || link.is_none() {
            return;
        }
        self.tell(News::Attached);
        loop {
            let began = Instant::now();
            if let Some(asked) = &mut link
                && let Err(failure) = self.round(asked)
            {
                self.tell(News::Lost(failure.to_string()));
                link = None;
            }
            let every = if link.is_some() { self.every } else { LOOK_AGAIN_EVERY };
            if let Err(Hangup) = self.wait(&mut link, began + every) {
                return;
            }
            if link.is_none() {
                link = self.look_again();
            }
        }
    }

    fn tell(&self, news: News) {
        // Sending fails only when the watching thread has ended.
        drop(self.events.send(Event::News(news)));
    }

    /// Asks everything once.
    fn round(&self, link: &mut Link) -> Result<(), Failure> {
        let mut tell = |news| self.tell(news);
        link.live(&mut tell)?;
        if self.most_used {
            link.most_used(&mut tell)?;
        }
        if let Some(id) = self.follow {
            link.followed(id, &mut tell);
        }
        Ok(())
    }

    fn look_again(&self) -> Option<Link> {
        match Link::connect(&self.place) {
            Ok(link) => {
                self.tell(News::Attached);
                Some(link)
            }
            Err(failure) => {
                self.tell(News::Lost(failure.to_string()));
                None
            }
        }
    }

    /// Takes wishes until it is time to ask again: at the latest at `until`, and at once after an order.
    fn wait(&mut self, link: &mut Option<Link>, until: Instant) -> Result<(), Hangup> {
        loop {
            let wish = match self.wishes.recv_timeout(until.saturating_duration_since(Instant::now())) {
                Ok(wish) => wish,
                Err(RecvTimeoutError::Timeout) => return Ok(()),
                Err(RecvTimeoutError::Disconnected) => return Err(Hangup),
            };
            match (wish, &mut *link) {
                (Wish::Follow(id), _) => self.follow = id,
                (Wish::MostUsed(wanted), _) => self.most_used = wanted,
                (_, None) => {
                    let nobody = "there is no daemon to tell: it was not done".to_owned();
                    self.tell(News::Done(Err(nobody)));
                }
                (order, Some(link)) => {
                    link.order(&order).into_iter().for_each(|news| self.tell(news));
                    return Ok(());
                }
            }
        }
    }
}
