//! The same arm, table and camera, driven posture by posture from outside: by an emulated controller, for example,
//! which has motions and limits of its own.

use pschema_protocol::body::Outcome;

use super::{SimBody, finger_pose};
use crate::kinematics::Posture;
use crate::objects::PlaceOccupied;
use crate::touch::{self, Contact};

/// When the finger is farther than this from every block, and no block moves, it can meet nothing in one step, in
/// metres.
const MEETING_M: f64 = 0.08;

impl SimBody {
    /// One step of time ([`crate::world::STEP_S`]) with the arm in a posture.
    pub fn drive(&mut self, posture: &Posture) {
        let finger = finger_pose(posture);
        if self.world.nearest_block_m(&posture.tip_m) > MEETING_M && self.world.is_still() {
            self.world.carry_finger(&finger);
        } else {
            self.step_world(&finger);
        }
        self.posture = *posture;
        self.passed_a_step();
    }

    /// The contact of the finger now, without the faults of the world file's `[noise]`.
    #[must_use]
    pub fn contact(&self) -> Contact {
        touch::contact(&self.world.gaps(), &self.posture.finger_turn)
    }

    /// Puts an object down at a place, by their numbers, with the arm where it is. Refused when there is no such
    /// object or place, or another object is in the way.
    pub fn put(&mut self, object: usize, position: usize) -> Outcome {
        let place = self.workspace.places.get(position).copied();
        let Some(place) = place.filter(|_| object < self.world.block_count()) else {
            return Outcome::refused("there is no such object or position");
        };
        match self.hand.place(&mut self.world, &self.workspace, object, &place) {
            Ok(()) => {
                self.settle();
                Outcome::Done
            }
            Err(PlaceOccupied { by }) => {
                let by = self.workspace.file.objects.get(by).map_or("?", |other| other.name.as_str());
                tracing::warn!(position, by, "refused: another object is in the way; remove it first");
                Outcome::refused(format_args!("{by} is in the way at position {position}: remove it first"))
            }
        }
    }

    /// Takes an object away. Refused when there is none of that number.
    pub fn take_away(&mut self, object: usize) -> Outcome {
        if object >= self.world.block_count() {
            return Outcome::refused("there is no such object");
        }
        self.world.remove_block(object);
        Outcome::Done
    }
}
