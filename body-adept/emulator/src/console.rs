//! A program of the controller that serves the line: the monitor, or `pschema.v2`.

use std::time::Instant;

use crate::machine::{Machine, MachineEvent};

/// The program at the controller's end of the line.
pub(crate) trait Console: Send {
    /// Takes bytes that came in on the line, and lets time pass until `now`, a time of the clock on the wall.
    fn take(&mut self, bytes: &[u8], machine: &mut Machine, now: Instant);

    /// Takes an event of the machine, which may be the one that a command waits for.
    fn tell(&mut self, event: MachineEvent, machine: &mut Machine);

    /// The texts to send. The faults of the line meet each of them as an answer of its own.
    fn said(&mut self) -> Vec<String>;

    /// Meets an error of V+, if it is a program that can.
    ///
    /// # Errors
    /// When no program serves the line.
    fn trip(&mut self, _: &mut Machine) -> Result<(), String> {
        Err("no program runs there".to_owned())
    }
}
