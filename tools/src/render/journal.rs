//! `journal`, `verify`, `repair` and `replay` for people.

use pschema_store::past::{Batch, BatchCause, EffectCount, Files, Finding, RepairPlan, Tail, Verification};
use serde::Serialize;

use super::schema::wrapped;
use super::table::Columns;
use super::time::time;
use super::words::{bytes, count, plain};

/// The contents of a data directory.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) struct DirectoryListing {
    /// The path of the directory.
    pub(crate) path: String,
    /// The learner's name.
    pub(crate) learner: String,
    /// The seed of the learner.
    pub(crate) seed: u64,
    /// Its files.
    #[serde(flatten)]
    pub(crate) files: Files,
    /// The state of the end of its journal.
    pub(crate) tail: Tail,
}

/// `2026-11-22 07:05:09.120`, in UTC.
pub(crate) fn moment(unix_ms: u64) -> String {
    format!("{}.{:03}", time(unix_ms / 1_000), unix_ms % 1_000)
}

/// Batches as a table, or one by one where effects are told; then the files.
pub(crate) fn listing(batches: &[Batch], listed: &DirectoryListing) -> String {
    let mut text = match batches {
        [] => "No batch of such a step.\n".to_owned(),
        _ if batches.iter().any(|batch| !batch.told.is_empty()) => batches.iter().map(told).collect(),
        _ => table(batches),
    };
    text.push('\n');
    text.push_str(&files(listed));
    text
}

fn table(batches: &[Batch]) -> String {
    let mut table = Columns::new(&["step", "time (UTC)", "cause", "changed"]).figures(&[0]);
    let mut day = "";
    let moments: Vec<String> = batches.iter().map(|batch| moment(batch.at_unix_ms)).collect();
    for (batch, moment) in batches.iter().zip(&moments) {
        // The day is printed only where it changes.
        let (date, clock) = moment.split_once(' ').unwrap_or(("", moment));
        let shown = if date == day { clock.to_owned() } else { moment.clone() };
        day = date;
        table.row([batch.step.to_string(), shown, cause(&batch.cause), changed(&batch.effects)]);
    }
    table.text(&[0])
}

/// `sim: done`, `order: stage next`.
fn cause(cause: &BatchCause) -> String {
    match cause {
        BatchCause::Attached { body } => format!("{} attaches", plain(body)),
        BatchCause::Order { order } => format!("order: {}", plain(order)),
        BatchCause::Frame { body, outcome: Some(outcome), .. } => {
            format!("{}: {}", plain(body), outcome.replace('_', " "))
        }
        BatchCause::Frame { body, outcome: None, .. } => format!("{}: nothing was asked", plain(body)),
        BatchCause::Changed { curriculum } => format!("settings: {}", plain(curriculum)),
    }
}

/// `attempted, 2 executed, created`.
fn changed(effects: &[EffectCount]) -> String {
    let one = |counted: &EffectCount| {
        let kind = counted.kind.replace('_', " ");
        if counted.count == 1 { kind } else { format!("{} {kind}", counted.count) }
    };
    let kinds: Vec<_> = effects.iter().map(one).collect();
    if kinds.is_empty() { "nothing".to_owned() } else { kinds.join(", ") }
}

fn told(batch: &Batch) -> String {
    let (step, frame, when) = (batch.step, batch.frame, moment(batch.at_unix_ms));
    let mut text = format!("step {step}, frame {frame}, {when} UTC: {}\n", cause(&batch.cause));
    if let BatchCause::Frame { perceived, .. } = &batch.cause {
        let perceived: Vec<_> = perceived.iter().map(|one| plain(one)).collect();
        let perceived = if perceived.is_empty() { "nothing".to_owned() } else { perceived.join(" ") };
        text.push_str(&wrapped(&format!("perceived {perceived}"), "  "));
    }
    for effect in &batch.told {
        let item = wrapped(&plain(&effect.text), "    ");
        text.push_str(&item.replacen("    ", "  - ", 1));
    }
    text
}

fn files(listed: &DirectoryListing) -> String {
    let DirectoryListing { files, tail, .. } = listed;
    let journal: u64 = files.segments.iter().map(|one| one.bytes).sum();
    let kept: u64 = files.snapshots.iter().map(|one| one.bytes).sum();
    let segments = count(files.segments.len() as u64, "file");
    let steps = files.snapshots.iter().map(|one| one.step.map_or("?".to_owned(), |step| step.to_string()));
    let steps: Vec<_> = steps.collect();
    let snapshots = match steps.as_slice() {
        [] => "none".to_owned(),
        [step] => format!("of step {step}, {}", bytes(kept)),
        steps => format!("of steps {}, {}", steps.join(", "), bytes(kept)),
    };
    let mut facts = Columns::new(&[]);
    let (learner, path) = (plain(&listed.learner), plain(&listed.path));
    facts.fact("memory", format!("of {learner}, seed {}, in {path}", listed.seed));
    facts.fact("journal", format!("{segments}, {}; back to step {}", bytes(journal), files.oldest_step));
    facts.fact("snapshots", snapshots);
    facts.fact("end", self::tail(tail));
    facts.text(&[0])
}

/// The end of the journal in words.
fn tail(tail: &Tail) -> String {
    match tail {
        Tail::Whole => "whole".to_owned(),
        Tail::Torn { file, offset } => format!(
            "in the middle of a frame, which was never acted on (it is being written, or power failed): {}, byte {offset}",
            plain(file)
        ),
        Tail::Damaged { problem } => format!("DAMAGED: {}", plain(problem)),
    }
}

/// The result of a check.
pub(crate) fn checked(c: &Verification, relearn: bool) -> String {
    let mut facts = Columns::new(&[]);
    let mut fact = |name: &str, value: String| facts.fact(name, value);
    let segments = count(c.segments, "file");
    fact("journal", format!("{segments}, {} of sound frames", bytes(c.journal_bytes)));
    fact("frames", format!("{}, each with its checksum and the one before", c.frames));
    fact("replayed", format!("{}, to {}", batches(c.batches), count(c.last_step.unwrap_or(0), "step")));
    fact("digests", agreeing(c.digests, "as they were written on the way"));
    fact("snapshots", agreeing(c.snapshots, "as the journal leads to them"));
    if let Some(relearnt) = c.relearnt.filter(|_| relearn) {
        fact("learnt again", format!("{}, with the very same effects", count(relearnt, "step")));
    }
    fact("back to", c.first_step.map_or("nowhere".to_owned(), |step| format!("step {step}")));
    fact("end", tail(&c.tail));
    if let Some(digest) = &c.memory_digest {
        fact("digest", digest.clone());
    }
    let mut text = facts.text(&[0]);
    if c.sound {
        text.push_str("\nEverything is sound.\n");
        return text;
    }
    text.push('\n');
    for finding in &c.findings {
        text.push_str(&wrapped(&self::finding(finding), ""));
    }
    let path = plain(&c.directory);
    text.push_str(&format!("\nWhat can be saved: pschema repair --data {path} --dry-run\n"));
    text
}

/// `3, all as they were written`; there may be none.
fn agreeing(count: u64, how: &str) -> String {
    match count {
        0 => "none".to_owned(),
        1 => format!("1, {}", how.replace("as they were", "as it was").replace("to them", "to it")),
        count => format!("{count}, all {how}"),
    }
}

fn finding(f: &Finding) -> String {
    let lost = match (f.lost_from, f.lost_to) {
        (Some(from), Some(to)) if from < to => format!(" Steps {from} to {to} are lost by it."),
        (Some(from), _) => format!(" Step {from} is lost by it."),
        _ => String::new(),
    };
    let place = match (&f.file, f.offset) {
        // The problem names the place itself.
        (Some(file), _) if f.problem.contains(file.as_str()) => String::new(),
        (Some(file), Some(offset)) => format!("{}, byte {offset}: ", plain(file)),
        (Some(file), None) => format!("{}: ", plain(file)),
        (None, _) => String::new(),
    };
    format!("WRONG: {place}{}.{lost}", plain(f.problem.trim_end_matches('.')))
}

fn batches(n: u64) -> String {
    if n == 1 { "1 batch".to_owned() } else { format!("{n} batches") }
}

/// The plan of a repair.
pub(crate) fn repair(r: &RepairPlan) -> String {
    if r.damage.is_empty() {
        return format!("Nothing is damaged: memory is whole up to step {}.\n", r.saved_step);
    }
    let mut text = String::new();
    for damage in &r.damage {
        text.push_str(&wrapped(&format!("DAMAGED: {}", plain(damage)), ""));
    }
    let mut facts = Columns::new(&[]);
    let (step, digest) = (r.saved_step, &r.memory_digest);
    facts.fact("can be saved", format!("memory up to step {step}, digest {digest}"));
    let lost = match r.last_step.saturating_sub(r.saved_step) {
        0 => "no step".to_owned(),
        1 => format!("step {}", r.last_step),
        _ => format!("steps {} to {}, which were taken and acted on", r.saved_step + 1, r.last_step),
    };
    facts.fact("is lost", lost);
    if r.saved_first_step > r.first_step {
        let (first, kept) = (r.first_step, r.saved_first_step);
        facts.fact("its past", format!("goes back to step {kept} then, and not to {first}"));
    }
    format!("{text}\n{}", facts.text(&[0]))
}
