//! `status` and `stage` for people.

use pschema_protocol::inspect::{BodyStatus, Report, Status};

use super::goals;
use super::schema::wrapped;
use super::table::Columns;
use super::words::{bytes, count, duration, plain};

/// A daemon and its learner.
pub(crate) fn status(s: &Status) -> String {
    let mut facts = Columns::new(&[]);
    let mut fact = |name: &str, value: String| facts.row([name.to_owned(), value]);
    fact("learner", format!("{}: process {}, up {}", plain(&s.name), s.pid, duration(s.uptime_s)));
    fact("step", format!("{}, {}", s.step, durability(s)));
    fact("stage", format!("{} ({}) of {}", plain(&s.stage), plain(&s.stage_state), plain(&s.curriculum)));
    let (concrete, generalised) = (s.schemas_concrete, s.schemas_generalised);
    fact("schemas", format!("{}: {concrete} concrete, {generalised} generalised", s.schemas_total));
    fact(
        "speed",
        format!("{:.1} steps/s; {}", s.steps_per_s, latency(s.step_latency_us_p50, s.step_latency_us_p99)),
    );
    fact("memory", format!("{} resident", bytes(s.memory_bytes)));
    fact("digest", plain(&s.memory_digest));
    if let Some(goal) = &s.goal {
        let (number, wanted, body) = (goal.number, goals::goal(&goal.goal), plain(&goal.body));
        let actions = format!("{} of at most {}", count(goal.actions, "action"), goal.actions_max);
        fact("goal", format!("{number}, pursued by {body}: {wanted}; {actions}"));
    }
    fact("excitation", format!("{:.2} at the last decision", s.excitation_top));
    let world: Vec<_> = s.world.iter().map(|o| plain(o)).collect();
    fact("perceived", if world.is_empty() { "nothing".to_owned() } else { world.join(" ") });
    format!("{}\n{}", facts.text(&[0]), bodies(&s.bodies))
}

fn durability(s: &Status) -> String {
    match s.durable_step {
        Some(step) => format!("on disk up to {step}"),
        None => "in RAM only: it ends with the daemon".to_owned(),
    }
}

/// `a step takes 55 us (median), 180 us (99th percentile)`.
pub(crate) fn latency(p50: f64, p99: f64) -> String {
    format!("a step takes {p50:.0} us (median), {p99:.0} us (99th percentile)")
}

fn bodies(bodies: &[BodyStatus]) -> String {
    if bodies.is_empty() {
        return "No body has attached. Start one with `pschema sim`.\n".to_owned();
    }
    let mut table =
        Columns::new(&["body", "kind", "process", "state", "frames", "refused"]).figures(&[2, 4, 5]);
    for b in bodies {
        let (frames, refused) = (b.frames.to_string(), b.frames_refused.to_string());
        table.row([plain(&b.name), plain(&b.kind), b.pid.to_string(), plain(&b.state), frames, refused]);
    }
    let mut text = table.text(&[]);
    for b in bodies {
        if let Some(refusal) = &b.last_refusal {
            let last = format!("The last frame of {} refused: {}", plain(&b.name), plain(refusal));
            text.push_str(&format!("\n{}", wrapped(&last, "")));
        }
    }
    text
}

/// Where a curriculum stands.
pub(crate) fn report(r: &Report) -> String {
    let state = if r.finished { "finished" } else { &r.stage_state };
    let mut text = format!("{}: stage {}, {}\n\n", plain(&r.curriculum), plain(&r.stage), plain(state));
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
