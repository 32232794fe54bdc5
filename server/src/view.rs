//! A learner as it was at one moment, for those who look inside. Taking a view costs the daemon's loop a few pointers,
//! however large memory is; all that is worked out or printed of it is so on the thread of those who look.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Instant;

use pschema_inspect::{BodyState, BodyStatus, RefusalCount, StageState, StorageStatus};
use pschema_learner::decision::Decision;
use pschema_learner::memory::Content;
use pschema_learner::notation;
use pschema_learner::observation::Observation;
use pschema_learner::progress::{Activity, Progress};
use pschema_learner::vocabulary::BodyId;
use pschema_learner::{Frame, Learner};
use pschema_protocol::description::Description;

use crate::growth::Growth;
use crate::latency::Latencies;
use crate::refusals::Refusals;
use crate::setup::Setup;
use crate::trace::Trace;

/// What a process has counted since it began to step its learner. A clone shares it.
#[derive(Clone, Debug)]
pub(crate) struct Account {
    pub(crate) started: Instant,
    /// From a frame to its decision.
    pub(crate) latencies: Latencies,
    /// From a frame to its reply, the disk waited for.
    pub(crate) commits: Latencies,
    pub(crate) growth: Growth,
    pub(crate) trace: Trace,
}

impl Default for Account {
    fn default() -> Self {
        Self {
            started: Instant::now(),
            latencies: Latencies::default(),
            commits: Latencies::default(),
            growth: Growth::default(),
            trace: Trace::default(),
        }
    }
}

/// The process that steps a learner, as tools are told of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Host {
    /// Bodies that are attached, or were.
    pub(crate) bodies: Vec<Arc<BodyStatus>>,
    /// How memory is kept; none when in RAM only.
    pub(crate) storage: Option<StorageStatus>,
    /// What was refused.
    pub(crate) refusals: Refusals,
    /// How many bytes of memory the process may take until nothing new is learnt; none without a limit.
    pub(crate) memory_max: Option<u64>,
}

/// The last frames of the body that questions are about.
#[derive(Clone, Debug)]
pub(crate) struct Senses {
    /// The frame of the last step.
    pub(crate) last: Arc<Frame>,
    /// The frame of the step before it; one in which nothing was perceived where it is not known.
    pub(crate) before: Arc<Frame>,
}

/// A learner as it was at one moment, to be inspected at leisure: it shares what it is of.
#[derive(Clone, Debug)]
pub struct View {
    pub(crate) name: Arc<str>,
    pub(crate) content: Content,
    pub(crate) setup: Arc<Setup>,
    /// The last decisions, the newest last.
    pub(crate) decisions: Arc<VecDeque<Arc<Decision>>>,
    /// None where no body has been attached.
    pub(crate) senses: Option<Senses>,
    /// What the body declares that questions are about; none where only memory is known, which has no ranges.
    pub(crate) declared: Option<Arc<Description>>,
    /// None: a past of which only memory is known.
    pub(crate) host: Option<Host>,
    pub(crate) account: Account,
    pub(crate) taken: Instant,
    /// What the host could not do for the learner, last.
    pub(crate) problem: Option<Arc<str>>,
}

impl View {
    /// A learner without a host, such as a memory on disk at an earlier moment; with its last decision and what its body
    /// perceived then, where they are known.
    #[must_use]
    pub fn alone(
        name: &str,
        learner: &Learner,
        seed: u64,
        decision: Option<Decision>,
        perceived: Option<(BodyId, Vec<Observation>)>,
    ) -> Self {
        let frame = |body, observations| Arc::new(Frame { body, outcome: None, observations });
        Self {
            name: name.into(),
            content: learner.memory().content().clone(),
            setup: Arc::new(Setup::of(learner, seed)),
            decisions: Arc::new(decision.into_iter().map(Arc::new).collect()),
            senses: perceived.map(|(body, observations)| Senses {
                last: frame(body, observations),
                before: frame(body, Vec::new()),
            }),
            declared: None,
            host: None,
            account: Account::default(),
            taken: Instant::now(),
            problem: None,
        }
    }

    /// The same, where it is known what the body declares.
    #[must_use]
    pub fn declared(mut self, description: Option<Arc<Description>>) -> Self {
        self.declared = description;
        self
    }

    /// The body that questions are about and what it perceived last.
    pub(crate) fn perceived(&self) -> Option<(BodyId, &[Observation])> {
        self.senses.as_ref().map(|senses| (senses.last.body, &senses.last.observations[..]))
    }

    /// What is perceived, as it prints.
    pub(crate) fn world(&self) -> Vec<String> {
        let (_, perceived) = self.perceived().unwrap_or((BodyId(0), &[]));
        perceived.iter().map(|one| notation::observation(&self.content.vocabulary, one)).collect()
    }

    /// Why the curriculum can't go on, if it can't.
    pub(crate) fn stuck(&self) -> Option<String> {
        stuck(&self.content.progress, self.problem.as_deref())
    }

    /// What the learner is doing. Where no host is known it is said as if a body were attached.
    pub(crate) fn state(&self) -> StageState {
        let is_attached = |body: &Arc<BodyStatus>| body.state == BodyState::Attached;
        let attached = self.host.as_ref().is_none_or(|host| host.bodies.iter().any(is_attached));
        match state(&self.content.progress, self.problem.as_deref()) {
            StageState::Habituating | StageState::Saturated | StageState::Acting if !attached => {
                StageState::WaitingForBody
            }
            state => state,
        }
    }

    /// How memory is kept, if it is on disk.
    pub(crate) fn storage(&self) -> Option<&StorageStatus> {
        self.host.as_ref()?.storage.as_ref()
    }

    /// How many bytes of memory the process may take until nothing new is learnt; none without a limit.
    pub(crate) fn memory_max(&self) -> Option<u64> {
        self.host.as_ref()?.memory_max
    }

    /// Bodies that are attached, or were.
    pub(crate) fn bodies(&self) -> Vec<BodyStatus> {
        self.host.iter().flat_map(|host| &host.bodies).map(|body| BodyStatus::clone(body)).collect()
    }

    /// What was refused, by reason.
    pub(crate) fn refusals(&self) -> Vec<RefusalCount> {
        self.host.as_ref().map(|host| host.refusals.counts()).unwrap_or_default()
    }

    /// Seconds since the host began.
    pub(crate) fn uptime_s(&self) -> f64 {
        self.taken.saturating_duration_since(self.account.started).as_secs_f64()
    }

    /// Steps a second.
    pub(crate) fn steps_per_s(&self) -> f64 {
        self.account.latencies.rate(self.taken, self.account.started)
    }
}

/// Why the curriculum can't go on, if it can't, with the last `problem` that its host had.
pub(crate) fn stuck(progress: &Progress, problem: Option<&str>) -> Option<String> {
    let reason = progress.stuck.as_ref()?;
    let detail = problem.map_or(String::new(), |problem| format!(" ({problem})"));
    Some(format!("{reason}{detail}"))
}

/// What a learner is doing to which a body is attached, with the last `problem` that its host had.
pub(crate) fn state(progress: &Progress, problem: Option<&str>) -> StageState {
    match progress.activity() {
        Activity::Stuck => StageState::Stuck(stuck(progress, problem).unwrap_or_default()),
        Activity::Held => StageState::Held,
        Activity::Finished => StageState::Finished,
        Activity::Habituating => StageState::Habituating,
        Activity::Saturated => StageState::Saturated,
        Activity::Acting => StageState::Acting,
    }
}
