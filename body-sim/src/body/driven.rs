//! The same arm, table and camera driven from outside, posture by posture: by an emulated controller, say, that has
//! motions and limits of its own.

use pschema_arm::Side;
use pschema_protocol::body::Outcome;

use super::{SimBody, finger_pose};
use crate::arm::Posture;
use crate::objects::Refusal;
use crate::touch;

/// Farther than this from every block, and none moving, the finger can meet nothing in one step.
const MEETING_M: f64 = 0.08;

/// What the finger feels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Felt {
    /// The pads that feel something, in the order of [`Side::ALL`].
    pub sides: Vec<Side>,
    /// How deep the finger is in what it meets, in metres; 0 when it is not.
    pub overlap_m: f64,
}

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

    /// What the finger feels now, without the faults of the world file's `[noise]`.
    #[must_use]
    pub fn felt(&self) -> Felt {
        let gaps = self.world.gaps();
        Felt {
            sides: touch::sides(&gaps, &self.posture.finger_turn),
            overlap_m: gaps.iter().map(|gap| -gap.distance_m).fold(0.0, f64::max),
        }
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
            Err(Refusal::Occupied { by }) => {
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
