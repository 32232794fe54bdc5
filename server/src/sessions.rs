//! The sessions of a daemon: the bodies that are attached, and the last of those that have gone.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

use pschema_inspect::{BodyState, BodyStatus};
use pschema_learner::Learner;
use pschema_learner::effect::Effect;
use pschema_learner::memory::Content;
use pschema_learner::vocabulary::BodyId;
use pschema_protocol::limits::BODIES_MAX;
use pschema_protocol::refusal::Refusal;
use pschema_protocol::wire::message::Introduction;

use crate::described;
use crate::session::{AttachError, Session};

/// Bodies that have gone and are still shown.
const GONE_MAX: usize = 32;

/// The sessions, by their numbers.
#[derive(Debug, Default)]
pub(crate) struct Sessions {
    attached: BTreeMap<u64, Session>,
    gone: VecDeque<Arc<BodyStatus>>,
    /// The number of the last session; each number is used once.
    last: u64,
}

/// A session that was opened, and what it changed in memory.
#[derive(Debug)]
pub(crate) struct Attachment {
    /// The session's number.
    pub(crate) session: u64,
    /// The effects of the declaration.
    pub(crate) declared: Vec<Effect>,
    /// The effects of noting how the body describes itself.
    pub(crate) described: Vec<Effect>,
    /// The change of its declaration that was accepted, as an order; none where it declares what it declared before.
    pub(crate) accepted: Option<String>,
}

impl Sessions {
    /// Opens a session for a body that introduced itself, and has the learner take in what it declares. A body that is known, and
    /// declares otherwise than before, is taken only if `accept_changes` is set: field 4 of another world is another place.
    ///
    /// # Errors
    /// The refusal that the body is told; memory is as it was.
    pub(crate) fn open(
        &mut self,
        hello: &Introduction,
        learner: &mut Learner,
        accept_changes: bool,
    ) -> Result<Attachment, Refusal> {
        let body = &hello.description.name;
        if self.attached.len() >= BODIES_MAX {
            let reason = format!("{BODIES_MAX} bodies are attached, which is all a daemon takes");
            return Err(Refusal::Unwilling { reason });
        }
        if let Some(other) = self.attached.values().map(Session::status).find(|other| other.name == *body) {
            // Mostly the same body, whose end has not been noticed yet: it tries again in a moment.
            let (number, pid) = (other.id, other.pid);
            let reason = format!("body {body} is attached already, in session {number} by process {pid}");
            return Err(Refusal::Unwilling { reason });
        }
        self.last += 1;
        // A declaration that contradicts what was learnt stays wrong however often it is tried.
        let refused = |error: AttachError| Refusal::Declaration {
            place: format!("body {body}"),
            problem: error.to_string(),
        };
        let text = described::text(&hello.description);
        let content = learner.memory().content();
        let known = content.vocabulary.body_named(body).and_then(|known| content.description(known));
        let changed = match known {
            Some(known) => Some(described::differences(known, &text))
                .filter(|differences| !differences.is_empty())
                .map(|differences| {
                    format!("declares otherwise than before: {}", described::told(&differences))
                }),
            None => another_world(content, &text),
        };
        let mut accepted = None;
        if let Some(told) = changed {
            if !accept_changes {
                return Err(refused(AttachError::Changed { told }));
            }
            tracing::warn!(%body, %told, "the body does not agree with this memory; accepted, as asked");
            accepted = Some(format!("accept-changes: body {body} {told}"));
        }
        if known.is_none() {
            warn_of_other_senses(content, body, &text);
        }
        let (session, declared) = Session::attach(self.last, hello, learner).map_err(refused)?;
        let described = learner.describe(session.body(), text);
        self.gone.retain(|gone| gone.name != *body);
        self.attached.insert(self.last, session);
        Ok(Attachment { session: self.last, declared, described, accepted })
    }

    /// Ends a session: its body `left` or was `lost`. None if there is no such session.
    pub(crate) fn close(&mut self, number: u64, state: BodyState) -> Option<Arc<BodyStatus>> {
        let status = self.attached.remove(&number)?.into_status(state);
        if self.gone.len() == GONE_MAX {
            self.gone.pop_front();
        }
        self.gone.push_back(status.clone());
        Some(status)
    }

    /// The session of this number.
    pub(crate) fn get(&self, number: u64) -> Option<&Session> {
        self.attached.get(&number)
    }

    /// The session of this number, to be served.
    pub(crate) fn get_mut(&mut self, number: u64) -> Option<&mut Session> {
        self.attached.get_mut(&number)
    }

    /// The numbers of the sessions.
    pub(crate) fn numbers(&self) -> impl ExactSizeIterator<Item = u64> {
        self.attached.keys().copied()
    }

    /// The session of a body, if it is attached.
    pub(crate) fn of(&self, body: Option<BodyId>) -> Option<&Session> {
        self.attached.values().find(|session| Some(session.body()) == body)
    }

    /// The session whose body tools ask about: that of the student, whom the curriculum leads, or else the first.
    pub(crate) fn shown(&self, student: Option<BodyId>) -> Option<&Session> {
        self.of(student).or_else(|| self.attached.values().next())
    }

    /// How each body is that is attached, and how each was that has gone.
    pub(crate) fn statuses(&self) -> Vec<Arc<BodyStatus>> {
        self.attached.values().map(Session::status).chain(&self.gone).cloned().collect()
    }
}

/// The bodies of a memory by their names, with how each describes itself.
fn descriptions(content: &Content) -> impl Iterator<Item = (&str, &str)> {
    content.vocabulary.bodies().iter().enumerate().filter_map(|(number, body)| {
        let described = content.description(BodyId(u16::try_from(number).ok()?))?;
        Some((body.name.as_str(), described))
    })
}

/// That a body, which is new to a memory and describes itself with `text`, is in another world than another of its kind.
fn another_world(content: &Content, text: &str) -> Option<String> {
    descriptions(content).find_map(|(other, described)| {
        let (there, here) = described::mixed_worlds(described, text)?;
        Some(format!("is in another world than body {other} of this memory: {there} there, {here} here"))
    })
}

/// Tells that a body, which is new to a memory, means something else by a sense than another body of it: it is another arm in the
/// same world, or the same arm in another world under another name, and where they do not both say it only a person knows which.
fn warn_of_other_senses(content: &Content, body: &str, text: &str) {
    for (other, described) in descriptions(content) {
        let senses = described::other_senses(described, text);
        if !senses.is_empty() {
            let told = described::told(&senses);
            tracing::warn!(
                %body, %other, %told,
                "the body means something else by what it senses than another body of this memory: what was learnt in one is \
                 used in the other; begin another memory if they are not in the same world"
            );
        }
    }
}
