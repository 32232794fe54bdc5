//! `status` and `stage` for people.

use pschema_inspect::{
    BodyStatus, Durability, GrowthStatus, HabituationStatus, OrderFailure, Report, SaturationStatus,
    StageState, Status, TrialStatus,
};

use super::goals;
use super::schema::wrapped;
use super::table::Columns;
use super::words::{bytes, count, duration, figure, plain};

/// Doublings of memory that are shown, the last ones.
const GROWTH_MAX: usize = 3;

/// A daemon and its learner, as a table.
pub(crate) fn status(s: &Status) -> String {
    let mut facts = Columns::new(&[]);
    facts.fact("learner", format!("{}: process {}, up {}", plain(&s.name), s.pid, duration(s.uptime_s)));
    facts.fact("step", format!("{}, {}", s.step, durability(s)));
    learnt(s, &mut facts);
    facts.fact("speed", format!("{:.1} steps/s", s.steps_per_s));
    facts.fact("latency", latency(s));
    facts.fact("memory", memory(s));
    if let Some(told) = growth(&s.growth) {
        facts.fact("growth", told);
    }
    if s.log_lines_lost > 0 {
        let lost = count(s.log_lines_lost, "line");
        facts.fact("log", format!("{lost} lost: nobody reads the daemon's stderr"));
    }
    if let Some(storage) = &s.storage {
        let snapshot = storage.snapshot_step.map_or("none yet".to_owned(), |step| format!("of step {step}"));
        let (journal, oldest) = (bytes(storage.journal_bytes), storage.oldest_step);
        let directory = plain(&storage.directory);
        let data = format!("{directory}; journal {journal}, back to step {oldest}; snapshot {snapshot}");
        facts.fact("data", data);
    }
    doing(s, &mut facts);
    format!("{}\n{}", facts.text(&[0]), bodies(&s.bodies))
}

/// How much memory the daemon takes and may take.
pub(crate) fn memory(s: &Status) -> String {
    let limit = s.memory_max_bytes.map_or(String::new(), |max| format!(" of at most {}", bytes(max)));
    let full = if s.memory_full { "; it is full, and nothing new is learnt" } else { "" };
    format!("{} resident{limit}{full}", bytes(s.memory_bytes))
}

/// The time of steps and the memory at the last doublings; none before the first doubling.
fn growth(rows: &[GrowthStatus]) -> Option<String> {
    let told = rows.get(rows.len().saturating_sub(GROWTH_MAX)..).filter(|_| rows.len() > 1)?;
    let row = |row: &GrowthStatus| {
        let (p50, p99) = (row.step_latency_us_p50, row.step_latency_us_p99);
        format!("from {} schemas {p50:.0}/{p99:.0} us and {}", row.schemas, bytes(row.memory_bytes))
    };
    let told: Vec<_> = told.iter().map(row).collect();
    Some(format!("{} (median/99 % of a step; memory when it got there)", told.join(", ")))
}

/// The state of a stage, without control characters: the reason why it is stuck may quote a body.
pub(crate) fn state(state: &StageState) -> String {
    plain(&state.to_string())
}

/// Adds the stage of the curriculum and the numbers of schemas to a table.
pub(crate) fn learnt(s: &Status, facts: &mut Columns) {
    let mut fact = |name: &str, value: String| facts.fact(name, value);
    fact("profile", plain(&s.profile));
    fact("stage", format!("{} ({}) of {}", plain(&s.stage), state(&s.stage_state), plain(&s.curriculum)));
    if let Some(told) = &s.trial {
        fact("trial", trial(told));
    }
    if let Some(told) = &s.saturation {
        fact("saturation", saturation(told, s.excitation_top));
    }
    if let Some(told) = &s.habituation {
        fact("habituation", habituation(told));
    }
    let (concrete, generalised) = (s.schemas_concrete, s.schemas_generalised);
    fact("schemas", format!("{}: {concrete} concrete, {generalised} generalised", s.schemas_total));
}

/// Adds the digest of memory, the goal, the excitation and the world state to a table.
pub(crate) fn doing(s: &Status, facts: &mut Columns) {
    let mut fact = |name: &str, value: String| facts.fact(name, value);
    if let Some(digest) = &s.memory_digest {
        fact("digest", plain(digest));
    }
    if let Some(goal) = &s.goal {
        let (number, wanted, body) = (goal.number, goals::wanted(&goal.wanted), plain(&goal.body));
        let actions = goals::done(goal);
        fact("goal", format!("{number}, pursued by {body}: {wanted}; {actions}"));
    }
    fact("excitation", format!("{} at the last decision", figure(s.excitation_top, 2)));
    let world: Vec<_> = s.world.iter().map(|o| plain(o)).collect();
    fact("perceived", if world.is_empty() { "nothing".to_owned() } else { world.join(" ") });
}

/// `2 of 3, after 4 actions of at most 20`.
pub(crate) fn trial(t: &TrialStatus) -> String {
    let most = t.actions_max.map_or(String::new(), |max| format!(" of at most {max}"));
    let actions = format!("{}{most}", count(t.actions, "action"));
    match (t.trial, t.open) {
        (0, _) => format!("none yet of {}", t.trials_wanted),
        (trial, true) => format!("{trial} of {}, after {actions}", t.trials_wanted),
        (trial, false) => format!("{trial} of {}, over after {actions}", t.trials_wanted),
    }
}

/// How near the stage is to saturation, with the top excitation of the last decision.
pub(crate) fn saturation(s: &SaturationStatus, top: f64) -> String {
    let (quiet, wanted) = (s.quiet_actions, s.quiet_actions_wanted);
    let (below, top) = (figure(s.saturation_below, 2), figure(top, 2));
    if quiet >= wanted {
        return format!("reached: {} in a row brought nothing new or exciting", count(quiet, "action"));
    }
    format!(
        "{quiet} of {wanted} quiet actions in a row: no new schema, and an excitation below {below} (it was {top} \
         at the last decision)"
    )
}

/// The schemas that are still to be executed before the next constraint is lifted.
pub(crate) fn habituation(h: &HabituationStatus) -> String {
    let times = match h.executions_min {
        1 => "once".to_owned(),
        times => format!("{times} times"),
    };
    let known = match h.interval_max {
        width if width > 0.0 => format!(", or known to an interval of {}", figure(width, 2)),
        _ => String::new(),
    };
    match h.habituation_left {
        None => format!("follows saturation: each schema of this stage is to be executed {times}{known}"),
        Some(left) => format!("{} of this stage left to be executed {times}{known}", count(left, "schema")),
    }
}

fn durability(s: &Status) -> String {
    match &s.storage {
        Some(storage) => {
            let relaxed = match storage.durability {
                Durability::Relaxed => "; RELAXED: actions do not wait for the disk, so steps can be lost",
                Durability::Strict => "",
            };
            let waiting = match storage.changes_waiting {
                0 => String::new(),
                1 => "; 1 change waits for the disk".to_owned(),
                changes => format!("; {changes} changes wait for the disk"),
            };
            format!("durable up to {}{waiting}{relaxed}", storage.durable_step)
        }
        None => "in RAM only: it ends with the daemon".to_owned(),
    }
}

/// `55 us to decide, 175 us until the action leaves (median); 180 us and 311 us (99th percentile)`.
fn latency(s: &Status) -> String {
    let (decide, leave) = (s.step_latency_us_p50, s.commit_latency_us_p50);
    let (decide_p99, leave_p99) = (s.step_latency_us_p99, s.commit_latency_us_p99);
    format!(
        "{decide:.0} us to decide, {leave:.0} us until the action leaves (median); {decide_p99:.0} us and {leave_p99:.0} us \
         (99th percentile)"
    )
}

fn bodies(bodies: &[BodyStatus]) -> String {
    if bodies.is_empty() {
        return "No body has attached. Start one with `pschema sim`.\n".to_owned();
    }
    let mut table =
        Columns::new(&["body", "kind", "process", "state", "frames", "refused"]).figures(&[2, 4, 5]);
    for b in bodies {
        let (frames, refused) = (b.frames.to_string(), b.frames_refused.to_string());
        table.row([plain(&b.name), plain(&b.kind), b.pid.to_string(), b.state.to_string(), frames, refused]);
    }
    let mut text = table.text(&[]);
    for b in bodies {
        if let Some(refusal) = &b.last_refusal {
            let last = format!("The last frame of {} refused: {}", plain(&b.name), plain(refusal));
            text.push_str(&format!("\n{}", wrapped(&last, "")));
        }
        if let Some(failure) = &b.last_failure {
            let (name, outcome, step) = (plain(&b.name), failure.outcome, failure.step);
            let reason = failure_reason(failure);
            let last =
                format!("The last order that {name} did not carry out ({outcome}, step {step}): {reason}");
            text.push_str(&format!("\n{}", wrapped(&last, "")));
        }
        if b.episodes_ended > 0 || b.episodes_cut > 0 {
            let (ended, cut) = (count(b.episodes_ended, "episode"), b.episodes_cut);
            let episodes = format!("{}: {ended} ended, {cut} cut short", plain(&b.name));
            text.push_str(&format!("\n{}", wrapped(&episodes, "")));
        }
        for warning in &b.warnings {
            let warning =
                format!("{} can't be learnt as it is: {}", plain(&b.name), plain(&warning.to_string()));
            text.push_str(&format!("\n{}", wrapped(&warning, "")));
        }
    }
    text
}

/// Why a body did not carry out an order, in its own words.
pub(crate) fn failure_reason(failure: &OrderFailure) -> String {
    failure.reason.as_deref().map_or_else(|| "no reason given".to_owned(), plain)
}

/// The report of a curriculum, as a table.
pub(crate) fn report(r: &Report) -> String {
    let state = if r.finished { StageState::Finished.to_string() } else { state(&r.stage_state) };
    let mut text = format!("{}: stage {}, {state}\n\n", plain(&r.curriculum), plain(&r.stage));
    if let Some(stuck) = &r.stuck {
        text.push_str(&format!("It cannot go on: {}\n\n", plain(stuck)));
    }
    let headings = ["stage", "actions", "schemas", "trials", "met", "at once", "state"];
    let mut table = Columns::new(&headings).figures(&[1, 2, 3, 4, 5]);
    for s in &r.stages {
        let state = match (s.ended, s.saturated) {
            (false, _) => "now",
            (true, true) => "saturated",
            (true, false) => "over",
        };
        let figures = [
            s.actions,
            s.schemas_new.into(),
            s.trials.into(),
            s.trials_met.into(),
            s.trials_met_first.into(),
        ];
        let name = if s.learning { plain(&s.name) } else { format!("{} (not learning)", plain(&s.name)) };
        table.row([name].into_iter().chain(figures.map(|n| n.to_string())).chain([state.to_owned()]));
    }
    text.push_str(&table.text(&[1, 2, 3, 4, 5, 6]));
    let total = count(r.schemas_total, "schema");
    text.push_str(&format!("\n{total} after {}\n", count(r.actions_total, "action")));
    text
}
