//! Pacing simulated time to the clock on the wall.

use std::time::{Duration, Instant};

use crate::world::STEP_S;

/// When the simulation is further behind than this, the lost time is given up and not caught up with.
const LAG_MAX: Duration = Duration::from_millis(100);

/// Lets a simulated step take as long as it would in the real world.
#[derive(Clone, Debug)]
pub struct Pace {
    due: Instant,
}

impl Pace {
    /// Waits until one more step is due.
    pub fn step(&mut self) {
        let now = Instant::now();
        if now.saturating_duration_since(self.due) > LAG_MAX {
            self.due = now;
        }
        self.due += Duration::from_secs_f64(STEP_S);
        std::thread::sleep(self.due.saturating_duration_since(now));
    }
}

impl Default for Pace {
    /// A pace that starts now.
    fn default() -> Self {
        Self { due: Instant::now() }
    }
}
