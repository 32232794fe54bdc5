//! The learner: its stage, how near the stage is to its end, the time and memory that steps take, and its bodies.

use pschema_inspect::{BodyStatus, Status};
use ratatui::style::Style;

use super::super::state::State;
use super::canvas::Canvas;
use super::text::WrappedText;
use crate::render::goals;
use crate::render::status::{failure_reason, habituation, memory, saturation, state as stage_state, trial};
use crate::render::words::{count, duration, plain};

/// Columns of a bar.
const BAR: u32 = 10;

pub(super) fn text(state: &State, canvas: Canvas) -> WrappedText {
    let mut text = canvas.text();
    let Some(status) = state.live.as_ref().map(|live| &live.status) else { return text };
    let mut fact = |name: &str, value: &str| fact(&mut text, name, value);
    fact(
        "stage",
        &format!(
            "{} ({}) of {}",
            plain(&status.stage),
            stage_state(&status.stage_state),
            plain(&status.curriculum)
        ),
    );
    fact("profile", &plain(&status.profile));
    let top = state.excitation_top().unwrap_or(0.0);
    if let Some(told) = &status.saturation {
        let drawn = bar(told.quiet_actions, told.quiet_actions_wanted);
        fact("saturation", &format!("{drawn} {}", saturation(told, top)));
    }
    if let Some(told) = &status.habituation {
        fact("habituation", &habituation(told));
    }
    if let Some(told) = &status.trial {
        fact("trial", &format!("{} {}", bar(told.trial, told.trials_wanted), trial(told)));
    }
    if let Some(goal) = &status.goal {
        let (wanted, actions) = (goals::wanted(&goal.wanted), goals::done(goal));
        fact("goal", &format!("{wanted} by {}; {actions}", plain(&goal.body)));
    }
    let (total, general) = (status.schemas_total, status.schemas_generalised);
    fact("schemas", &format!("{total}: {} concrete, {general} generalised", total.saturating_sub(general)));
    fact("step", &format!("{}, {}", status.step, durable(status)));
    fact("speed", &format!("{:.1} steps/s", status.steps_per_s));
    fact("to decide", &latency(status.step_latency_us_p50, status.step_latency_us_p99));
    fact("to leave", &latency(status.commit_latency_us_p50, status.commit_latency_us_p99));
    fact("daemon", &format!("up {}, {}", duration(status.uptime_s), memory(status)));
    for body in &status.bodies {
        fact("body", &told(body));
        if let Some(refusal) = &body.last_refusal {
            fact("! refused", &format!("{}, last of all: {}", body.frames_refused, plain(refusal)));
        }
        if let Some(failure) = &body.last_failure {
            let (outcome, step) = (failure.outcome, failure.step);
            fact("! order", &format!("{outcome} in step {step}: {}", failure_reason(failure)));
        }
        if body.episodes_ended > 0 || body.episodes_cut > 0 {
            let (ended, cut) = (count(body.episodes_ended, "episode"), body.episodes_cut);
            fact("episodes", &format!("{ended} ended, {cut} cut short"));
        }
        for warning in &body.warnings {
            fact("! declared", &plain(&warning.to_string()));
        }
    }
    if status.bodies.is_empty() {
        fact("body", "none has attached: start one with `pschema sim`");
    }
    text
}

fn fact(text: &mut WrappedText, name: &str, value: &str) {
    text.wrapped(&format!("{name:<11} "), value, Style::new());
}

/// A bar for a share: `[####......]`.
fn bar(now: u32, wanted: u32) -> String {
    let full = (u64::from(now.min(wanted)) * u64::from(BAR)).checked_div(wanted.into()).unwrap_or(0);
    let full = usize::try_from(full).unwrap_or(0);
    format!("[{}{}]", "#".repeat(full), ".".repeat((BAR as usize).saturating_sub(full)))
}

fn durable(status: &Status) -> String {
    match status.durable_step {
        Some(step) => format!("on disk up to {step}"),
        None => "in RAM only: it ends with the daemon".to_owned(),
    }
}

fn latency(p50: f64, p99: f64) -> String {
    format!("{p50:.0} us median, {p99:.0} us 99th percentile")
}

fn told(body: &BodyStatus) -> String {
    format!(
        "{} ({}), {}, process {}: {}, {} refused",
        plain(&body.name),
        plain(&body.kind),
        body.state,
        body.pid,
        count(body.frames, "frame"),
        body.frames_refused
    )
}
