//! The paper's table (section VI-A), to stand beside ours.

use serde::Serialize;

/// What the paper reports of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Published {
    /// Schemas produced.
    pub(crate) schemas_total: u32,
    /// Object placements that learning took.
    pub(crate) placements: u32,
}

/// Scenario 1, simulated robot.
pub(crate) const SCENARIO_1_SIMULATED: Published = Published { schemas_total: 227, placements: 2 };
/// Scenario 2, without generalisation.
pub(crate) const SCENARIO_2: Published = Published { schemas_total: 347, placements: 100 };
/// Scenario 1, physical robot: half as many visual fields.
pub(crate) const SCENARIO_1_PHYSICAL: Published = Published { schemas_total: 115, placements: 2 };
