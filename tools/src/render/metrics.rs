//! `status` in Prometheus' text format, version 0.0.4: for a scraper, or a file that one collects.

use std::collections::BTreeMap;

use pschema_inspect::{BodyState, BodyStatus, Durability, Status};

/// Families of samples, all of them about one learner.
struct MetricsPage<'a> {
    learner: &'a str,
    text: String,
}

type Labels<'a> = &'a [(&'a str, &'a str)];

impl MetricsPage<'_> {
    /// Begins a family of this type: its name without `pschema_`, in base units, and `_total` at the end of a counter's.
    fn family(&mut self, name: &str, kind: &str, help: &str) {
        self.text += &format!("# HELP pschema_{name} {help}\n# TYPE pschema_{name} {kind}\n");
    }

    fn sample(&mut self, name: &str, labels: Labels<'_>, value: f64) {
        let all = [("learner", self.learner)].into_iter().chain(labels.iter().copied());
        let all: Vec<_> = all.map(|(name, value)| format!("{name}=\"{}\"", escaped(value))).collect();
        self.text += &format!("pschema_{name}{{{}}} {value}\n", all.join(","));
    }

    /// A gauge of one sample.
    fn gauge(&mut self, name: &str, value: f64, help: &str) {
        self.family(name, "gauge", help);
        self.sample(name, &[], value);
    }

    /// A counter of one sample.
    fn counter(&mut self, name: &str, count: u64, help: &str) {
        self.family(name, "counter", help);
        self.sample(name, &[], float(count));
    }

    fn summary(&mut self, name: &str, p50_us: f64, p99_us: f64, help: &str) {
        self.family(name, "summary", help);
        for (quantile, microseconds) in [("0.5", p50_us), ("0.99", p99_us)] {
            self.sample(name, &[("quantile", quantile)], microseconds / 1e6);
        }
    }
}

fn escaped(value: &str) -> String {
    value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

#[expect(clippy::cast_precision_loss, reason = "the format has floats")]
fn float(count: u64) -> f64 {
    count as f64
}

/// A page that begins with whether a daemon serves the learner.
fn begun(learner: &str, up: f64) -> MetricsPage<'_> {
    let mut page = MetricsPage { learner, text: String::new() };
    page.gauge("up", up, "Whether a daemon serves the learner.");
    page
}

/// The metrics of a learner that no daemon serves.
pub(crate) fn down(learner: &str) -> String {
    begun(learner, 0.0).text
}

/// The metrics of a daemon and its learner.
pub(crate) fn metrics(s: &Status) -> String {
    let mut page = begun(&s.name, 1.0);
    page.gauge("uptime_seconds", s.uptime_s, "Time since the daemon began.");
    page.gauge("resident_memory_bytes", float(s.memory_bytes), "Resident memory of the daemon.");
    if let Some(max) = s.memory_max_bytes {
        page.gauge(
            "memory_max_bytes",
            float(max),
            "Resident memory at which nothing new is learnt any more.",
        );
    }
    page.gauge(
        "memory_full",
        f64::from(u8::from(s.memory_full)),
        "1 while nothing new is learnt, because memory is full.",
    );
    page.counter(
        "log_lines_lost_total",
        s.log_lines_lost,
        "Lines of the daemon's log that nobody read in time.",
    );
    learnt(&mut page, s);
    kept(&mut page, s);
    times(&mut page, s);
    bodies(&mut page, &s.bodies);
    page.family("refusals_total", "counter", "Messages of bodies and tools that were refused, by reason.");
    for refused in &s.refused {
        let code = refused.code.to_string();
        let labels = [("code", code.as_str()), ("reason", &refused.reason)];
        page.sample("refusals_total", &labels, float(refused.count));
    }
    page.text
}

fn learnt(page: &mut MetricsPage<'_>, s: &Status) {
    page.counter("steps_total", s.step, "Steps taken in the life of this memory.");
    page.family("schemas", "gauge", "Schemas in memory.");
    for (kind, count) in [("concrete", s.schemas_concrete), ("generalised", s.schemas_generalised)] {
        page.sample("schemas", &[("kind", kind)], count.into());
    }
    page.family("stage_info", "gauge", "The present stage of the curriculum, and what it is doing.");
    // What it is stuck on may be anything, and would make a series of its own each time.
    let labels =
        [("curriculum", s.curriculum.as_str()), ("stage", &s.stage), ("state", s.stage_state.as_str())];
    page.sample("stage_info", &labels, 1.0);
    page.gauge("excitation_top", s.excitation_top, "Top excitation of the last decision.");
    if let Some(saturation) = &s.saturation {
        let help = "Actions in a row that brought nothing new or exciting.";
        page.gauge("quiet_actions", saturation.quiet_actions.into(), help);
    }
}

fn kept(page: &mut MetricsPage<'_>, s: &Status) {
    let strict = s.storage.as_ref().is_some_and(|storage| storage.durability == Durability::Strict);
    let help = "Whether memory is on disk before anything rests on it.";
    page.gauge("durability_strict", f64::from(u8::from(strict)), help);
    let Some(storage) = &s.storage else { return };
    page.counter("durable_steps_total", storage.durable_step, "Steps known to be on disk.");
    page.gauge("journal_bytes", float(storage.journal_bytes), "Bytes of journal that are kept.");
    let help = "The oldest step that memory can be returned to.";
    page.gauge("oldest_step", float(storage.oldest_step), help);
    if let Some(step) = storage.snapshot_step {
        page.gauge("snapshot_step", float(step), "The step of the last snapshot.");
    }
}

fn times(page: &mut MetricsPage<'_>, s: &Status) {
    page.gauge("steps_per_second", s.steps_per_s, "Steps a second, over the last 10 seconds.");
    let help = "Time from a frame to the decision, of the last 4096.";
    page.summary("decision_duration_seconds", s.step_latency_us_p50, s.step_latency_us_p99, help);
    let help = "Time from a frame to its reply, which waits for the disk if memory is kept strictly, of the last 4096.";
    page.summary("reply_duration_seconds", s.commit_latency_us_p50, s.commit_latency_us_p99, help);
}

/// The bodies by name: all sessions of one body are one series.
fn bodies(page: &mut MetricsPage<'_>, bodies: &[BodyStatus]) {
    let mut named: BTreeMap<(&str, &str), [f64; 3]> = BTreeMap::new();
    for body in bodies {
        let [attached, frames, refused] = named.entry((&body.name, &body.kind)).or_default();
        *attached = attached.max(f64::from(u8::from(body.state == BodyState::Attached)));
        *frames += float(body.frames);
        *refused += float(body.frames_refused);
    }
    let families = [
        ("body_attached", "gauge", "Whether the body is attached."),
        ("body_frames_total", "counter", "Frames taken of the body in its last session."),
        (
            "body_frames_refused_total",
            "counter",
            "Frames of the body that were refused, in its last session.",
        ),
    ];
    for (at, (name, kind, help)) in families.into_iter().enumerate() {
        page.family(name, kind, help);
        for ((body, kind), values) in &named {
            page.sample(name, &[("body", body), ("kind", kind)], values[at]);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use pschema_inspect::StorageStatus;

    use super::*;
    use crate::render::tests::a_status;

    /// What the exposition format asks of a page: families together, each announced once before its samples; names
    /// and labels of its alphabet; values that are numbers.
    fn assert_exposition(page: &str) -> BTreeSet<String> {
        assert!(page.ends_with('\n'));
        let (mut announced, mut current) = (BTreeSet::new(), (String::new(), String::new()));
        for line in page.lines() {
            if let Some(help) = line.strip_prefix("# HELP ") {
                let (name, text) = help.split_once(' ').unwrap();
                assert!(announced.insert(name.to_owned()), "{name} is announced twice");
                assert!(text.ends_with('.') && !text.contains('\\'), "{line}");
                current.0 = name.to_owned();
                continue;
            }
            if let Some(kind) = line.strip_prefix("# TYPE ") {
                let (name, kind) = kind.split_once(' ').unwrap();
                assert_eq!(name, current.0, "TYPE follows its HELP");
                assert_eq!(name.ends_with("_total"), kind == "counter", "{line}");
                current.1 = kind.to_owned();
                continue;
            }
            let (series, value) = line.rsplit_once(' ').unwrap();
            let (name, labels) = series.split_once('{').unwrap();
            assert_eq!(name, current.0, "a sample stands in its family");
            assert!(value.parse::<f64>().is_ok_and(f64::is_finite), "{line}");
            let mut labels = labels.strip_suffix('}').unwrap();
            let mut names = BTreeSet::new();
            while !labels.is_empty() {
                let (name, rest) = labels.split_once("=\"").unwrap();
                let name = name.trim_start_matches(',');
                assert!(name.chars().all(|c| c.is_ascii_lowercase() || c == '_'), "{line}");
                assert!(names.insert(name.to_owned()), "{line}");
                let mut escaped = false;
                let end = rest.find(|c| {
                    let end = c == '"' && !escaped;
                    escaped = c == '\\' && !escaped;
                    end
                });
                labels = &rest[end.unwrap() + 1..];
            }
            assert!(names.contains("learner"), "{line}");
        }
        announced
    }

    #[test]
    fn the_page_is_of_the_exposition_format() {
        let mut status = a_status();
        status.storage = Some(StorageStatus {
            directory: "/var/lib/robot".to_owned(),
            durability: Durability::Strict,
            durable_step: 344,
            changes_waiting: 1,
            journal_bytes: 1_000,
            oldest_step: 0,
            snapshot_step: Some(300),
        });
        status.stage = "with \"quotes\" and \\ and\na line break".to_owned();
        let announced = assert_exposition(&metrics(&status));
        for wanted in ["pschema_steps_total", "pschema_durable_steps_total", "pschema_reply_duration_seconds"]
        {
            assert!(announced.contains(wanted), "{wanted}: {announced:?}");
        }
        assert_exposition(&down("robot-1"));
    }

    #[test]
    fn a_learner_without_a_daemon_is_down() {
        assert!(down("robot-1").ends_with("pschema_up{learner=\"robot-1\"} 0\n"));
    }
}
