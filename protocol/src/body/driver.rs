//! A body's side of a session, without any transport: which frame to send, and how to obey the reply. The same code
//! drives a body over shared memory and inside the daemon's own process.

use std::time::Duration;

use super::{Body, Senses};
use crate::description::Description;
use crate::outcome::Outcome;
use crate::picture::Picture;
use crate::refusal::Refusal;
use crate::wire::message::{OrderReport, RawFrame, RawHello, Reply};
use crate::wire::{WireReply, decode, encode};

/// What remains to be done after a reply, once the body has carried out the order in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Directive {
    /// Send the next frame.
    Continue,
    /// Rest, then send the next frame.
    Wait(Duration),
    /// The frame was refused. Sending another may help, or attaching again.
    Refused {
        /// The number of the refusal.
        code: u32,
        /// Why.
        reason: String,
    },
    /// Leave.
    Detach,
}

/// A body, and where it is in its session.
#[derive(Debug)]
pub struct BodyLoop<B> {
    body: B,
    description: Description,
    frame: RawFrame,
    session: u64,
    sequence: u64,
    report: Option<OrderReport>,
    orders: u64,
}

impl<B: Body> BodyLoop<B> {
    /// Asks the body to describe itself.
    pub fn new(body: B) -> Self {
        Self {
            description: body.describe(),
            body,
            frame: RawFrame::default(),
            session: 0,
            sequence: 0,
            report: None,
            orders: 0,
        }
    }

    /// What the body declared.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// The body.
    pub fn body(&self) -> &B {
        &self.body
    }

    /// How many orders (actions and scene commands) the body was given.
    pub fn orders(&self) -> u64 {
        self.orders
    }

    /// The body's introduction, for [`decode::hello`].
    ///
    /// # Errors
    /// The first thing in the description that the protocol does not allow.
    pub fn hello(&self) -> Result<RawHello, Refusal> {
        encode::hello(&self.description, std::process::id(), 0)
    }

    /// Begins a session. An order of an earlier session is not reported in it.
    pub fn attached(&mut self, session: u64) {
        self.session = session;
        self.sequence = 0;
        self.report = None;
    }

    /// Lets the body sense, and returns the next frame.
    pub fn next_frame(&mut self) -> &RawFrame {
        let mut senses = Senses::reusing(std::mem::take(&mut self.frame.records));
        self.body.sense(&mut senses);
        self.sequence = self.sequence.saturating_add(1);
        self.frame = senses.into_frame(self.session, self.sequence, self.report.as_ref());
        &self.frame
    }

    /// The frame that was made last.
    pub fn frame(&self) -> &RawFrame {
        &self.frame
    }

    /// The picture that the body saw when it made that frame; none if it has no eye.
    pub fn picture(&mut self) -> Option<Picture<'_>> {
        self.body.picture()
    }

    /// Checks the reply to the last frame, and lets the body carry out the order in it.
    ///
    /// # Errors
    /// What is wrong with the reply. The body has done nothing then.
    pub fn obey(&mut self, reply: &WireReply) -> Result<Directive, Refusal> {
        let reply = decode::reply(reply, &self.description, self.session, self.sequence)?;
        let outcome = match reply {
            // The report stays for the next frame, because this frame was not taken.
            Reply::Refused { code, reason } => return Ok(Directive::Refused { code, reason }),
            Reply::Detach => return Ok(Directive::Detach),
            Reply::Wait { ms } => {
                self.report = None;
                return Ok(Directive::Wait(Duration::from_millis(ms.into())));
            }
            Reply::Act(action) => self.body.act(&action),
            Reply::Arrange(command) => self.body.arrange(&command),
        };
        self.ordered(outcome);
        Ok(Directive::Continue)
    }

    fn ordered(&mut self, outcome: Outcome) {
        self.orders = self.orders.saturating_add(1);
        self.report = Some(OrderReport { outcome, answers: self.sequence });
    }
}
