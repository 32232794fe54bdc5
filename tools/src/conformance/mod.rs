//! The duties of a body in any language, each tried on its process with this process in the place of the daemon. They are those of
//! `docs/PROTOCOL.md`.

mod examined;

use std::time::Duration;

use pschema_process::Stop;
use pschema_protocol::description::{Action, ActionId};
use pschema_protocol::domain::LearnerName;
use pschema_protocol::refusal::Refusal;
use pschema_protocol::wire::message::Reply;
use pschema_protocol::wire::outcome;
use serde::Serialize;

use crate::failure::Failure;
use examined::{Examined, Problem, described, least};

/// How often a body is given nothing to do, to see whether it counts its frames.
const FRAMES: u32 = 20;
/// Actions tried, spread over the repertoire.
const ACTIONS_MAX: usize = 32;
/// A rest, and how much earlier than told a body may come back from it: clocks differ.
const REST_MS: u32 = 300;
const EARLY: Duration = Duration::from_millis(20);
/// The longest rest that a body may be told, and how soon it must come back from it when it is roused.
const LONG_REST_MS: u32 = 10_000;
const ROUSED_WITHIN: Duration = Duration::from_secs(2);
/// How long a daemon that confirms its steps slowly keeps a body waiting.
const PAUSE: Duration = Duration::from_secs(2);
/// How long a body that was sent away must stay away.
const AWAY: Duration = Duration::from_secs(2);

/// Whether a body does one of its duties.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(crate) enum Verdict {
    /// It does.
    Passed,
    /// It does, and could do better in something that no page demands.
    Advised,
    /// It does not.
    Failed,
    /// It never attached, so that nothing else could be tried.
    NotTried,
}

/// A duty of a body, and whether it does it.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct DutyVerdict {
    /// The name of the check.
    pub(crate) name: &'static str,
    /// What a body has to do.
    pub(crate) duty: &'static str,
    /// Whether it does.
    pub(crate) verdict: Verdict,
    /// What it did instead, or what it could do better; none unless it failed or is advised.
    pub(crate) problem: Option<String>,
}

struct Duty {
    name: &'static str,
    duty: &'static str,
    check: fn(&mut Examined<'_>) -> Result<(), Problem>,
}

const DUTIES: [Duty; 14] = [
    Duty { name: "hello", duty: "attaches with a hello that a daemon takes", check: hello },
    Duty { name: "sequence", duty: "counts its frames, and reports nothing unasked", check: sequence },
    Duty { name: "rest", duty: "rests as long as it is told", check: rest },
    Duty { name: "roused", duty: "ends its rest when it is roused", check: roused },
    Duty { name: "actions", duty: "carries out its actions, and reports each outcome once", check: actions },
    Duty {
        name: "scene-commands",
        duty: "answers each scene command that it declares",
        check: scene_commands,
    },
    Duty {
        name: "refused-frame",
        duty: "reports an outcome again after a refused frame",
        check: refused_frame,
    },
    Duty { name: "pause", duty: "holds still while it waits for a reply", check: pause },
    Duty { name: "session", duty: "attaches again when its session is not open", check: session },
    Duty { name: "unwilling", duty: "tries again when the daemon is not willing", check: unwilling },
    Duty { name: "restart", duty: "attaches anew after the daemon was restarted", check: restart },
    Duty { name: "sigterm", duty: "ends at SIGTERM, with success and a farewell", check: sigterm },
    Duty { name: "sent-away", duty: "leaves when it is sent away", check: sent_away },
    Duty { name: "alone", duty: "ends at SIGTERM, with success, while there is no daemon", check: alone },
];

/// Tries all duties on the body that `command` starts, which attaches to the learner `name`; `told` hears each verdict.
///
/// # Errors
/// When this process is asked to end, or its own side cannot be set up.
pub(crate) fn examine(
    command: &str,
    name: LearnerName,
    patience: Duration,
    stop: &Stop,
    mut told: impl FnMut(&DutyVerdict) -> Result<(), Failure>,
) -> Result<Vec<DutyVerdict>, Failure> {
    let mut examined = Examined::new(command, name, patience, stop)?;
    let mut verdicts: Vec<DutyVerdict> = Vec::new();
    for Duty { name, duty, check } in &DUTIES {
        let never_attached = verdicts.first().is_some_and(|first| first.verdict == Verdict::Failed);
        let (verdict, problem) = if never_attached {
            (Verdict::NotTried, None)
        } else {
            match check(&mut examined) {
                Ok(()) => match examined.advice() {
                    None => (Verdict::Passed, None),
                    advice => (Verdict::Advised, advice),
                },
                Err(problem) => {
                    examined.begin_anew();
                    (Verdict::Failed, Some(problem))
                }
            }
        };
        stop.check()?;
        let verdict = DutyVerdict { name, duty, verdict, problem };
        told(&verdict)?;
        verdicts.push(verdict);
    }
    Ok(verdicts)
}

fn hello(body: &mut Examined<'_>) -> Result<(), Problem> {
    body.attach()
}

fn sequence(body: &mut Examined<'_>) -> Result<(), Problem> {
    (0..FRAMES).try_for_each(|_| body.exchange(&Reply::Wait { ms: 0 }))
}

fn rest(body: &mut Examined<'_>) -> Result<(), Problem> {
    let rested = body.rest(REST_MS, false)?;
    if rested + EARLY >= Duration::from_millis(REST_MS.into()) {
        return Ok(());
    }
    Err(format!("told to rest for {REST_MS} ms, it sent its next frame after {} ms", rested.as_millis()))
}

fn roused(body: &mut Examined<'_>) -> Result<(), Problem> {
    let rested = body.rest(LONG_REST_MS, true)?;
    if rested <= ROUSED_WITHIN {
        return Ok(());
    }
    Err(format!(
        "told to rest for {LONG_REST_MS} ms and roused at once, it sent its next frame after {} ms",
        rested.as_millis()
    ))
}

fn actions(body: &mut Examined<'_>) -> Result<(), Problem> {
    let repertoire = body.description()?.repertoire;
    let every = repertoire.len().div_ceil(ACTIONS_MAX).max(1);
    let mut done = repertoire.is_empty();
    for action in repertoire.iter().step_by(every) {
        body.exchange(&Reply::Act(action.clone()))?;
        done |= body.outcome() == outcome::DONE;
        // After a reply that orders nothing, no outcome is reported.
        body.exchange(&Reply::Wait { ms: 0 })?;
    }
    if done { Ok(()) } else { Err("it carried out none of the actions in its repertoire".to_owned()) }
}

fn scene_commands(body: &mut Examined<'_>) -> Result<(), Problem> {
    for (index, command) in body.description()?.scene_commands.iter().enumerate() {
        let id = ActionId::from_index(u16::try_from(index).unwrap_or(u16::MAX));
        body.exchange(&Reply::Arrange(least(command, Action { id, parameters: Vec::new() })))?;
    }
    Ok(())
}

/// An order that the body offers to obey; none if it offers no action.
fn order(body: &mut Examined<'_>) -> Result<Option<Reply>, Problem> {
    Ok(body.description()?.repertoire.first().cloned().map(Reply::Act))
}

fn refused_frame(body: &mut Examined<'_>) -> Result<(), Problem> {
    order(body)?.map_or(Ok(()), |order| body.refuse_once(&order))
}

fn pause(body: &mut Examined<'_>) -> Result<(), Problem> {
    body.pause(PAUSE)?;
    body.exchange(&Reply::Wait { ms: 0 })
}

fn session(body: &mut Examined<'_>) -> Result<(), Problem> {
    body.close_session()?;
    body.attach()
}

fn unwilling(body: &mut Examined<'_>) -> Result<(), Problem> {
    body.close_session()?;
    let (_, reply) = body.hello()?;
    let reason = "another body of that name has not been missed yet".to_owned();
    let refused = reply.refuse(&Refusal::Unwilling { reason }, "conformance");
    refused.map_err(|error| format!("a refusal could not be delivered: {error}"))?;
    let (hello, reply) = body.hello()?;
    body.welcome(described(&hello)?, reply)
}

fn restart(body: &mut Examined<'_>) -> Result<(), Problem> {
    // An order of an epoch that has ended is not reported in the next: the first frame is looked at for it.
    if let Some(order) = order(body)? {
        body.give(&order)?;
    }
    body.end_daemon();
    body.attach()
}

fn sigterm(body: &mut Examined<'_>) -> Result<(), Problem> {
    body.attach()?;
    if !body.terminate()? {
        body.advise("it ended without a farewell (a frame of purpose 2)");
    }
    Ok(())
}

fn sent_away(body: &mut Examined<'_>) -> Result<(), Problem> {
    body.send_away()?;
    body.stays_away(AWAY)
}

fn alone(body: &mut Examined<'_>) -> Result<(), Problem> {
    body.begin_anew();
    body.attach()?;
    body.end_daemon();
    body.terminate().map(drop)
}
