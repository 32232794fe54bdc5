//! How the body carries out its moves, step by step of the physics, and where they end.

use nalgebra::Isometry3;
use pschema_arm::JointPositions;
use pschema_arm::route::{self, RouteSetup, Waypoint};
use pschema_protocol::body::Outcome;

use super::{SimBody, finger_pose};
use crate::kinematics::Motion;
use crate::touch::GIVE_M;
use crate::world::{Gap, STEP_S};

/// A block that was apart from the finger for this many steps makes a new contact when they meet again.
const APART_STEPS_MIN: u32 = 10;
/// Overlap of finger and block at which the arm stalls instead of pushing on, in metres.
const BLOCKED_M: f64 = 0.002;
/// After the first contact the finger creeps on, to come to rest against the block and not short of it: at this speed,
/// in metres a second,
const PRESS_M_PER_S: f64 = 0.03;
/// for at most this distance, in metres,
const PRESS_M_MAX: f64 = 0.006;
/// until it has stayed in contact for this many steps.
const PRESS_STEPS: u32 = 6;
/// Longest wait for blocks to come to rest, in steps.
const SETTLE_STEPS_MAX: u32 = 240;

/// How a motion ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum MotionEnd {
    Arrived,
    Touched,
    Blocked,
    OutOfTime,
    OffManifold,
}

/// The effect of a contact on a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ContactRule {
    /// The touch reflex: a contact ends the motion.
    Stop,
    /// The motion goes on, and pushes the block.
    Push,
}

impl SimBody {
    /// Goes to joint positions, until the finger is there, has a new contact (the touch reflex), stalls, or runs out of
    /// time.
    pub(super) fn go(&mut self, to: JointPositions) -> Outcome {
        let manifold = &self.workspace.manifold;
        if manifold.at(to).is_none() {
            return self.refuse(to);
        }
        let goal = self.faults.goal(manifold, to);
        let points = route::route(self.route_setup(), &manifold.square, self.at, self.heading, goal);
        let Some(motions) = self.motions(&points) else { return self.refuse(to) };
        self.carry_out(motions.iter().map(|motion| (motion, ContactRule::Stop)))
    }

    /// Sets the finger down at `from` and goes straight to `to`, pushing the blocks that it meets. A contact before the
    /// finger is set down ends the push, as it ends a move.
    pub(super) fn push(&mut self, from: JointPositions, to: JointPositions) -> Outcome {
        let manifold = &self.workspace.manifold;
        if manifold.at(from).is_none() || manifold.at(to).is_none() {
            return self.refuse(to);
        }
        let (from, to) = (self.faults.goal(manifold, from), self.faults.goal(manifold, to));
        let mut points = route::carried(self.route_setup(), &manifold.square, self.at, self.heading, from);
        points.extend([from, to].map(|joints| Waypoint { joints, lift_m: 0.0 }));
        let Some(motions) = self.motions(&points) else { return self.refuse(to) };
        let last = motions.len() - 1;
        let on_contact = |index| if index == last { ContactRule::Push } else { ContactRule::Stop };
        self.carry_out(motions.iter().enumerate().map(|(index, motion)| (motion, on_contact(index))))
    }

    fn refuse(&self, to: JointPositions) -> Outcome {
        tracing::debug!(j1 = to.j1, j2 = to.j2, "refused: beyond the end of the arm's manifold");
        Outcome::refused(format_args!("the arm does not reach {}, {}", to.j1, to.j2))
    }

    fn route_setup(&self) -> RouteSetup {
        let arm = &self.workspace.file.arm;
        RouteSetup { lift_m: arm.lift_mm.metres(), approach_m: arm.approach_mm.metres() }
    }

    /// The motions from where the arm is through these points. None when some of the way cannot be taken.
    fn motions(&self, points: &[Waypoint]) -> Option<Vec<Motion>> {
        let starts = std::iter::once(&self.at).chain(points);
        let motion = |(from, to): (&Waypoint, &Waypoint)| {
            self.workspace.arm.motion(&self.workspace.manifold, *from, *to)
        };
        starts.zip(points).map(motion).collect()
    }

    /// Carries out motions one after the other, until one does not arrive, and waits for all to rest.
    fn carry_out<'a>(&mut self, motions: impl Iterator<Item = (&'a Motion, ContactRule)>) -> Outcome {
        let mut left_s = self.workspace.file.arm.move_time_max_s.get();
        let mut ended = MotionEnd::Arrived;
        for (motion, on_contact) in motions {
            ended = self.follow(motion, on_contact, left_s);
            left_s -= motion.duration_s;
            if ended != MotionEnd::Arrived {
                break;
            }
        }
        self.settle();
        tracing::debug!(?ended, steps = self.steps, "moved");
        match ended {
            MotionEnd::Arrived | MotionEnd::Touched | MotionEnd::Blocked => Outcome::Done,
            MotionEnd::OutOfTime => Outcome::TimedOut,
            MotionEnd::OffManifold => Outcome::failed("the arm cannot be where its motion leads"),
        }
    }

    fn follow(&mut self, motion: &Motion, on_contact: ContactRule, limit_s: f64) -> MotionEnd {
        let square = &self.workspace.manifold.square;
        if let Some(heading) = route::heading(square, motion.from.joints, motion.to.joints) {
            self.heading = heading;
        }
        let steps = (motion.duration_s / STEP_S).ceil();
        let mut step = 0.0;
        while step < steps {
            step += 1.0;
            let time_s = step * STEP_S;
            if time_s > limit_s {
                return MotionEnd::OutOfTime;
            }
            if !self.advance(motion.at(time_s)) {
                return MotionEnd::OffManifold;
            }
            let (new_contact, overlap_m) = self.feel();
            if overlap_m > BLOCKED_M {
                return MotionEnd::Blocked;
            }
            if new_contact && on_contact == ContactRule::Stop {
                return self.press(motion, Motion::share(time_s / motion.duration_s));
            }
        }
        MotionEnd::Arrived
    }

    /// Slows to a creep along the rest of the way, until the finger rests against the block that it has met.
    fn press(&mut self, motion: &Motion, from_share: f64) -> MotionEnd {
        let way_m = motion.way_m(&self.workspace.manifold).max(1e-6);
        let creep = PRESS_M_PER_S * STEP_S / way_m;
        let (mut share, mut held) = (from_share, 0);
        while share < (from_share + PRESS_M_MAX / way_m).min(1.0) && held < PRESS_STEPS {
            share = (share + creep).min(1.0);
            if !self.advance(motion.along(share)) {
                return MotionEnd::OffManifold;
            }
            let (_, overlap_m) = self.feel();
            if overlap_m > BLOCKED_M {
                return MotionEnd::Blocked;
            }
            held = if self.resting_contact() { held + 1 } else { 0 };
        }
        MotionEnd::Touched
    }

    /// Whether the finger touches a block that does not slide away from it.
    fn resting_contact(&self) -> bool {
        let close = |gap: &Gap| {
            gap.distance_m < GIVE_M / 2.0 && self.world.block_speed(gap.block) < 1.5 * PRESS_M_PER_S
        };
        self.world.gaps().iter().any(close)
    }

    /// One step of time with the arm going to `to`. False when the arm cannot be there.
    fn advance(&mut self, to: Waypoint) -> bool {
        let Some(posture) = self.workspace.arm.posture_by(&self.workspace.manifold, to) else {
            return false;
        };
        self.at = to;
        self.drive(&posture);
        true
    }

    /// The contacts after a step: whether one of them is new, and the deepest overlap in metres.
    fn feel(&mut self) -> (bool, f64) {
        let (mut new_contact, mut overlap_m) = (false, 0.0_f64);
        let gaps = self.world.gaps();
        for (block, apart) in self.apart_steps.iter_mut().enumerate() {
            *apart = apart.saturating_add(1);
            let Some(gap) = gaps.iter().find(|gap| gap.block == block) else { continue };
            overlap_m = overlap_m.max(-gap.distance_m);
            if gap.distance_m <= GIVE_M {
                new_contact |= *apart > APART_STEPS_MIN;
                *apart = 0;
            }
        }
        (new_contact, overlap_m)
    }

    /// Holds the arm until all blocks rest.
    pub(super) fn settle(&mut self) {
        let finger = self.finger_pose();
        let mut waited = 0;
        while waited < SETTLE_STEPS_MAX && !self.world.is_still() {
            self.step_world(&finger);
            self.passed_a_step();
            waited += 1;
        }
        self.feel();
    }

    pub(super) fn step_world(&mut self, finger: &Isometry3<f64>) {
        for lost in self.world.step(finger) {
            let name = self.workspace.file.objects.get(lost).map_or("?", |object| object.name.as_str());
            tracing::warn!(object = name, "fell off the table and is lost; place it again to go on with it");
        }
    }

    pub(super) fn passed_a_step(&mut self) {
        self.steps += 1;
        if let Some(path) = &mut self.path {
            path.push(finger_pose(&self.posture));
        }
        if let Some(pace) = &mut self.pace {
            pace.step();
        }
    }
}
