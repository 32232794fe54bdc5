//! A bar on stderr for work of a known size, where that is a terminal.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pschema_process::colour_is_wanted;

/// The bar; dropped, it goes away.
#[derive(Debug)]
pub struct Bar(ProgressBar);

impl Bar {
    /// For so many bytes; hidden when `quiet` or stderr is no terminal.
    pub(crate) fn bytes(quiet: bool) -> Self {
        let template = if colour_is_wanted() {
            "{bar:30.green} {bytes}/{total_bytes}  {msg}"
        } else {
            "{bar:30} {bytes}/{total_bytes}  {msg}"
        };
        Self::with(quiet, template)
    }

    /// For things that are counted.
    #[must_use]
    pub fn count(quiet: bool) -> Self {
        Self::with(quiet, "{spinner} {pos}  {msg}")
    }

    fn with(quiet: bool, template: &str) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(None, target);
        bar.set_style(style(template));
        bar.enable_steady_tick(Duration::from_millis(200));
        Self(bar)
    }

    /// Shows how far it is.
    pub fn show(&self, done: u64, of: u64, message: String) {
        if self.0.length() != Some(of) {
            self.0.set_length(of);
        }
        self.0.set_message(message);
        self.0.set_position(done);
    }
}

/// The style of this template; one of ours that does not parse would show as the default one.
pub(crate) fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
