//! Enabling: power comes up and the arm may be calibrated, both at a person's word. They take seconds, in which it may move by
//! itself, so that they are watched over and stopped like a motion.

use std::mem;
use std::sync::atomic::Ordering;

use super::{Arm, Phase};
use crate::controller::{Fault, State};
use crate::switch::Pressed;
use crate::taught::Joints;

impl Arm {
    pub(super) fn enable_now(&mut self) -> Result<(), Fault> {
        if !self.may.moves {
            self.phase = Phase::Active;
            return Ok(());
        }
        // A person has just agreed: what was stopped before is over.
        self.switch.release();
        let watched = self.watch.command();
        let ready = match (self.make_ready(), self.switch.pressed_by()) {
            // That it was stopped is why, whatever the controller makes of it.
            (Err(Fault::Refused(_)), Some(by)) => Err(Fault::Stopped(by)),
            (ready, _) => ready,
        };
        let ready = ready.and_then(|(state, joints)| match self.unfit(&state, &joints) {
            Some(why) => Err(Fault::Other(why)),
            None => Ok(joints),
        });
        if let Err(fault) = &ready {
            tracing::warn!(%fault, "not enabled: the arm is stopped, and loses the power that it was given");
            self.make_safe();
        }
        drop(watched);
        let joints = ready?;
        self.phase = Phase::Active;
        self.enabled = true;
        tracing::info!(?joints, "enabled");
        Ok(())
    }

    /// Clears what was latched, turns power on and, where that is allowed, calibrates. What takes seconds ends at once when
    /// the process shall.
    fn make_ready(&mut self) -> Result<(State, Joints), Fault> {
        let Some(controller) = &mut self.controller else {
            return Err(Fault::Other("nobody answers on the line".to_owned()));
        };
        let (switch, stop) = (&self.switch, &self.watch.signs().stop);
        let go_on = || match switch.pressed_by() {
            Some(by) => Err(Fault::Stopped(by)),
            None if stop.load(Ordering::SeqCst) => Err(Fault::Stopped(Pressed::Asked)),
            None => Ok(()),
        };
        go_on()?;
        if controller.state()?.latched {
            controller.reset()?;
        }
        if !controller.state()?.power {
            go_on()?;
            // Ours from here on: power that was asked for may come after nobody waits for it any more.
            self.powered_by_us = true;
            controller.power(true)?;
        }
        if self.may.home && !controller.state()?.calibrated {
            go_on()?;
            tracing::warn!("calibrating: the arm moves by itself");
            // Ours as well: braking ends one of a calibration's own motions, only without power it is over for sure.
            (self.powered_by_us, self.homing) = (true, true);
            controller.calibrate()?;
            self.homing = false;
        }
        go_on()?;
        Ok((controller.state()?, controller.joints()?))
    }

    /// Stops the arm, whatever it was about to do, and takes the power away that this process answers for.
    fn make_safe(&mut self) {
        self.switch.press(Pressed::Trouble);
        if mem::take(&mut self.homing) {
            // Before it is known to stand, which takes seconds in which it may go on by itself.
            self.take_power();
        }
        let Some(controller) = &mut self.controller else { return };
        if let Err(fault) = controller.halt() {
            tracing::error!(%fault, "not known to stand still: press the emergency stop");
        }
        self.take_power();
    }

    pub(super) fn take_power(&mut self) {
        let (Some(controller), true) = (&mut self.controller, self.powered_by_us) else { return };
        match controller.power(false) {
            Ok(()) => self.powered_by_us = false,
            Err(fault) => tracing::error!(%fault, "high power stays on"),
        }
    }
}
