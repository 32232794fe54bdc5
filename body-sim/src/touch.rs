//! Touch: four pads around the finger's ball, facing left, right, near and far as the finger is turned.
//! They are a little soft: a block within their give is felt.

use nalgebra::{UnitQuaternion, Vector3};
use pschema_arm::Side;

use crate::world::Gap;

/// The pads' give: a block this near is felt, in metres.
pub const GIVE_M: f64 = 0.001;
/// Half the angle that a pad covers, as a cosine: 52 degrees, so that a contact on a corner is felt by two.
const HALF_PAD_COSINE: f64 = 0.616;

/// The direction in which a pad faces, in the finger's frame.
fn facing(side: Side) -> Vector3<f64> {
    match side {
        Side::Left => -Vector3::x(),
        Side::Right => Vector3::x(),
        Side::Near => -Vector3::y(),
        Side::Far => Vector3::y(),
    }
}

/// The contact of the finger with the blocks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// The sides whose pads feel a block, in the order of [`Side::ALL`].
    pub sides: Vec<Side>,
    /// How deep the finger is in a block, in metres; 0 when it is in none.
    pub overlap_m: f64,
}

/// Whether any pad feels a block.
#[must_use]
pub fn touching(gaps: &[Gap]) -> bool {
    gaps.iter().any(|gap| gap.distance_m <= GIVE_M)
}

/// The sides whose pads feel a block, in the order of [`Side::ALL`]. A contact from straight below is felt by none.
#[must_use]
pub fn sides(gaps: &[Gap], finger_turn: &UnitQuaternion<f64>) -> Vec<Side> {
    let felt: Vec<Vector3<f64>> = gaps
        .iter()
        .filter(|gap| gap.distance_m <= GIVE_M)
        .filter_map(|gap| {
            let local = finger_turn.inverse_transform_vector(&gap.direction);
            Vector3::new(local.x, local.y, 0.0).try_normalize(0.2)
        })
        .collect();
    let feels = |side: &Side| felt.iter().any(|direction| direction.dot(&facing(*side)) >= HALF_PAD_COSINE);
    Side::ALL.into_iter().filter(feels).collect()
}

/// The contact that these gaps make.
#[must_use]
pub fn contact(gaps: &[Gap], finger_turn: &UnitQuaternion<f64>) -> Contact {
    Contact {
        sides: sides(gaps, finger_turn),
        overlap_m: gaps.iter().map(|gap| -gap.distance_m).fold(0.0, f64::max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(x: f64, y: f64, z: f64, distance_m: f64) -> Gap {
        Gap { block: 0, distance_m, direction: Vector3::new(x, y, z).normalize() }
    }

    #[test]
    fn a_contact_is_felt_on_the_side_it_is_on() {
        let turn = UnitQuaternion::identity();
        for (x, y, side) in
            [(-1.0, 0.0, Side::Left), (1.0, 0.1, Side::Right), (0.1, -1.0, Side::Near), (0.0, 1.0, Side::Far)]
        {
            assert_eq!(sides(&[gap(x, y, 0.1, 0.0)], &turn), [side]);
        }
    }

    #[test]
    fn sides_turn_with_the_finger() {
        let quarter_right = UnitQuaternion::from_euler_angles(0.0, 0.0, -std::f64::consts::FRAC_PI_2);
        assert_eq!(sides(&[gap(1.0, 0.0, 0.0, 0.0)], &quarter_right), [Side::Far]);
    }

    #[test]
    fn a_corner_is_felt_by_two_and_a_distant_block_by_none() {
        let turn = UnitQuaternion::identity();
        assert_eq!(sides(&[gap(1.0, 1.0, 0.0, 0.0005)], &turn), [Side::Right, Side::Far]);
        assert!(sides(&[gap(1.0, 0.0, 0.0, 0.002)], &turn).is_empty());
        assert!(!touching(&[gap(1.0, 0.0, 0.0, 0.002)]) && touching(&[gap(1.0, 0.0, 0.0, -0.001)]));
    }
}
