//! Enabling: power comes up and the arm may be calibrated, both at a person's word. Both take seconds, in which the arm
//! may move by itself, so that they are watched over and stopped like a motion.

use std::mem;
use std::sync::atomic::Ordering;

use super::{Arm, Phase, answering};
use crate::controller::{ControllerError, ControllerState, Result};
use crate::switch::StopCause;
use crate::taught::Joints;

impl Arm {
    pub(super) fn enable_now(&mut self) -> Result<()> {
        if !self.may.moves {
            self.phase = Phase::Active;
            return Ok(());
        }
        // A person has just agreed: an earlier stop is over.
        self.switch.release();
        let watched = self.watch.command();
        let ready = match (self.make_ready(), self.switch.pressed_by()) {
            // The stop is the cause, whatever the controller makes of it.
            (Err(ControllerError::Refused(_)), Some(by)) => Err(ControllerError::Stopped(by)),
            (ready, _) => ready,
        };
        let ready = ready.and_then(|(state, joints)| match self.unfit(&state, &joints) {
            Some(why) => Err(ControllerError::Other(why)),
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

    /// Clears what the controller latched, turns power on and, where that is allowed, calibrates. The steps that take
    /// seconds end at once when the process is to end.
    fn make_ready(&mut self) -> Result<(ControllerState, Joints)> {
        let controller = answering(&mut self.controller)?;
        let (switch, stop) = (&self.switch, &self.watch.signs().stop);
        let go_on = || match switch.pressed_by() {
            Some(by) => Err(ControllerError::Stopped(by)),
            None if stop.load(Ordering::SeqCst) => Err(ControllerError::Stopped(StopCause::Asked)),
            None => Ok(()),
        };
        go_on()?;
        if controller.state()?.latched {
            controller.reset()?;
        }
        if !controller.state()?.power {
            go_on()?;
            // This process answers for power from here on: it may come up after nobody waits for it any more.
            self.powered_by_us = true;
            controller.power(true)?;
        }
        if self.may.home && !controller.state()?.calibrated {
            go_on()?;
            tracing::warn!("calibrating: the arm moves by itself");
            // It answers for power now, too: braking ends one of a calibration's own motions, and only without power is
            // the calibration over for sure.
            (self.powered_by_us, self.homing) = (true, true);
            controller.calibrate()?;
            self.homing = false;
        }
        go_on()?;
        Ok((controller.state()?, controller.joints()?))
    }

    /// Stops the arm, and takes the power away that this process answers for.
    fn make_safe(&mut self) {
        self.switch.press(StopCause::Trouble);
        if mem::take(&mut self.homing) {
            // Before the arm is known to stand: that takes seconds, in which it may go on by itself.
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
