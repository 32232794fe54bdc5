//! Placing blocks as a person would: near the intended place, turned a little. The errors follow from the seed
//! and the number of placements before, so a run is repeatable.

use pschema_arm::SplitMix;

use crate::workspace::{TablePlace, Workspace};
use crate::world::World;

/// Puts blocks down.
#[derive(Clone, Debug)]
pub struct Hand {
    seed: u64,
    placements: u64,
}

/// A block cannot be put down because another block is in the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaceOccupied {
    /// Index of the block in the way.
    pub by: usize,
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
        place: &TablePlace,
    ) -> Result<(), PlaceOccupied> {
        let mut random = SplitMix::new(self.seed ^ (self.placements + 1).wrapping_mul(0xD1B5_4A32_D192_ED03));
        let positions = &workspace.file.positions;
        let jitter_m = positions.jitter_mm.metres();
        let x_m = place.centre_m.0 + jitter_m * random.within_one();
        let y_m = place.centre_m.1 + jitter_m * random.within_one();
        let yaw_rad = positions.jitter_deg.radians() * random.within_one();
        if let Some(by) =
            (0..world.block_count()).find(|&other| other != block && overlap(world, block, other, (x_m, y_m)))
        {
            return Err(PlaceOccupied { by });
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
    apart < world.form(block).reach_m() + world.form(other).reach_m()
}
