//! How a run is going: a bar on a terminal, nothing but finished stages elsewhere.

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget};
use pschema_inspect::Report;
use pschema_process::{colour_is_wanted, say};

use crate::bar;
use crate::render::story::{StageProgress, doing};

use super::experiment::Workload;

const UNBOUNDED: &str = "{spinner} {pos}  {msg}";
const BOUNDED: &str = "{bar:30} {pos}/{len}  {msg}";
const BOUNDED_IN_COLOUR: &str = "{bar:30.green} {pos}/{len}  {msg}";

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
        bar.set_style(bar::style(UNBOUNDED));
        Self { bar, size, label }
    }

    /// Shows how far the run is.
    pub(crate) fn show(&self, report: &Report) {
        let Some(StageProgress { what, done, of }) = doing(report, self.size.postures, &self.size.trials)
        else {
            return;
        };
        if self.bar.length() != of {
            match of {
                Some(of) => self.bar.set_length(of),
                None => self.bar.unset_length(),
            }
            let bounded = if colour_is_wanted() { BOUNDED_IN_COLOUR } else { BOUNDED };
            self.bar.set_style(bar::style(if of.is_some() { bounded } else { UNBOUNDED }));
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
