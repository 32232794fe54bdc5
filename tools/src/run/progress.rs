//! How a run is going: a bar on a terminal, nothing but finished stages elsewhere.

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use pschema_inspect::Report;
use pschema_process::{colour_is_wanted, say};

use crate::render::story::{StageProgress, doing};

use super::experiment::Workload;

/// Bars on stderr, when that is a terminal: one for each run under way.
pub(crate) struct Bars(MultiProgress);

impl Bars {
    /// Bars, or none when `quiet` or stderr is no terminal.
    pub(crate) fn new(quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self(MultiProgress::with_draw_target(target))
    }
}

/// The bar of one run.
pub(crate) struct Progress {
    bar: ProgressBar,
    size: Workload,
    /// What stands before everything, such as the seed.
    label: String,
}

impl Progress {
    /// One more bar.
    pub(crate) fn new(bars: &Bars, label: String, size: Workload) -> Self {
        let bar = bars.0.add(ProgressBar::no_length());
        bar.set_style(style(false));
        Self { bar, size, label }
    }

    /// Shows how far the run is.
    pub(crate) fn show(&self, report: &Report) {
        let Some(StageProgress { what, done, of }) = doing(report, self.size.postures, &self.size.trials)
        else {
            return;
        };
        if self.bar.length() != of {
            self.bar.set_style(style(of.is_some()));
            match of {
                Some(of) => self.bar.set_length(of),
                None => self.bar.unset_length(),
            }
        }
        self.bar.set_message(format!("{}{what}", self.label));
        self.bar.set_position(done);
    }

    /// Says a line that stays.
    pub(crate) fn say(&self, line: &str) {
        self.bar.suspend(|| say(line));
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

fn style(bounded: bool) -> ProgressStyle {
    let template = match (bounded, colour_is_wanted()) {
        (true, true) => "{bar:30.green} {pos}/{len}  {msg}",
        (true, false) => "{bar:30} {pos}/{len}  {msg}",
        (false, _) => "{spinner} {pos}  {msg}",
    };
    // A template of ours that does not parse would show as the default one.
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
