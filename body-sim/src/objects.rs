//! Placing blocks as a person would: near the place meant, turned a little. The errors follow from the seed
//! and the number of placements before, so a run is repeatable.

use crate::workspace::{Place, Workspace};
use crate::world::World;

/// Puts blocks down.
#[derive(Clone, Debug)]
pub struct Hand {
    seed: u64,
    placements: u64,
}

/// Why a block cannot be put down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Another block is in the way.
    Occupied {
        /// Index of that block.
        by: usize,
    },
}

impl Hand {
    /// A hand whose errors follow from a seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self { seed, placements: 0 }
    }

    /// Puts a block down at a place, not quite exactly.
    ///
    /// # Errors
    /// When another block is in the way.
    pub fn place(
        &mut self,
        world: &mut World,
        workspace: &Workspace,
        block: usize,
        place: &Place,
    ) -> Result<(), Refusal> {
        let mut random = SplitMix(self.seed ^ (self.placements + 1).wrapping_mul(0xD1B5_4A32_D192_ED03));
        let positions = &workspace.file.positions;
        let jitter_m = positions.jitter_mm.metres();
        let x_m = place.centre_m.0 + jitter_m * random.within_one();
        let y_m = place.centre_m.1 + jitter_m * random.within_one();
        let yaw_rad = positions.jitter_deg.radians() * random.within_one();
        if let Some(by) =
            (0..world.block_count()).find(|&other| other != block && overlap(world, block, other, (x_m, y_m)))
        {
            return Err(Refusal::Occupied { by });
        }
        self.placements += 1;
        world.place_block(block, (x_m, y_m), yaw_rad);
        Ok(())
    }
}

/// Whether a block put at `at` could touch another, however both are turned.
fn overlap(world: &World, block: usize, other: usize, at: (f64, f64)) -> bool {
    let Some(there) = world.block(other) else { return false };
    let there = there.translation.vector;
    let apart = ((there.x - at.0) * (there.x - at.0) + (there.y - at.1) * (there.y - at.1)).sqrt();
    apart < (world.block_side_m(block) + world.block_side_m(other)) * std::f64::consts::FRAC_1_SQRT_2
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Evenly between -1 and 1.
    fn within_one(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_even_and_bounded() {
        let mut random = SplitMix(42);
        let drawn: Vec<f64> = (0..10_000).map(|_| random.within_one()).collect();
        assert!(drawn.iter().all(|x| (-1.0..1.0).contains(x)));
        let mean = drawn.iter().sum::<f64>() / 1e4;
        let square = drawn.iter().map(|x| x * x).sum::<f64>() / 1e4;
        assert!(mean.abs() < 0.02 && (square - 1.0 / 3.0).abs() < 0.02, "{mean} {square}");
    }
}
