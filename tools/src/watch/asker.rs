//! Asks the daemon: one question after the other, each only when the one before is answered.

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

/// How soon a daemon that has gone is looked for again.
const LOOK_AGAIN_EVERY: Duration = Duration::from_millis(500);
/// The most used schemas are asked for no more often than this,
const MOST_USED_EVERY: Duration = Duration::from_secs(1);
/// and no more than this share of the time: it takes a look at all of memory.
const MOST_USED_SHARE: u32 = 10;
/// Records of the trace that are shown of what happened before.
const STEPS_BEFORE: u64 = 256;
/// Pages of the trace that are asked for at a time, to catch up with a learner that is fast.
const PAGES_AT_A_TIME: usize = 8;

/// A connection to a daemon, and what is known of it.
pub(super) struct Link {
    learner: Learner,
    eyes: Eyes,
    /// The next record of the trace; none before the first answer.
    next: Option<u64>,
    step: Option<u64>,
    most_used: Option<MostUsedTiming>,
    followed: Option<(u32, u64)>,
}

/// When the most used schemas may be asked for again, and the step of the last answer.
struct MostUsedTiming {
    not_before: Instant,
    step: Option<u64>,
}

impl Link {
    pub(super) fn connect(place: &Place) -> Result<Self, Failure> {
        let (learner, eyes) = (Learner::connect_at(place)?, Eyes::new(place.clone()));
        Ok(Self { learner, eyes, next: None, step: None, most_used: None, followed: None })
    }

    /// How the learner is, the trace since the last time, and its bodies' cameras.
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

    /// Asks for what is left of the trace, and leaves out what there is no time for. Returns where to go on.
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

    /// The most used schemas, when it is time for them and something has happened.
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

    /// One schema, when something has happened since it was told of.
    pub(super) fn followed(&mut self, id: u32, tell: &mut dyn FnMut(News)) {
        let asked = self.step.map(|step| (id, step));
        if asked.is_some() && self.followed == asked {
            return;
        }
        self.followed = asked;
        // What goes wrong with the daemon shows in what is asked for next.
        let told = self.learner.ask(DetailQuery { id }).map(Box::new);
        tell(News::FollowedSchema { id, told: told.map_err(|failure| failure.to_string()) });
    }

    /// Whether a picture of one of the bodies may still come.
    pub(super) fn is_looking(&self) -> bool {
        self.eyes.is_looking()
    }

    /// Gives an order, and says what came of it.
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

/// The number of the record after a page.
fn end(page: &TracePage) -> u64 {
    page.from.saturating_add(page.records.len() as u64)
}

/// A thread that asks again and again, and obeys.
pub(super) struct Asker {
    pub(super) place: Place,
    /// From one question to the next.
    pub(super) every: Duration,
    pub(super) wishes: Receiver<Wish>,
    pub(super) events: Sender<Event>,
    pub(super) follow: Option<u32>,
    pub(super) most_used: bool,
}

/// Nobody listens any more.
struct Hangup;

impl Asker {
    /// Until nobody wishes anything any more, or at once when there is no daemon to begin with. Says which it is to
    /// `begun`: a connection can't be handed from one thread to another.
    pub(super) fn run(mut self, begun: &Sender<Result<(), Failure>>) {
        let (first, connected) = match Link::connect(&self.place) {
            Ok(link) => (Ok(()), Some(link)),
            Err(failure) => (Err(failure), None),
        };
        if begun.send(first).is_err() || connected.is_none() {
            return;
        }
        let mut link = connected;
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
        // Only fails at the end, when nothing is left to be told.
        drop(self.events.send(Event::News(news)));
    }

    /// Everything that is to be known, once.
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

    /// Obeys until it is time to ask again: at the latest at `until`, and at once when an order was given.
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
