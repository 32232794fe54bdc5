//! What every arm with a finger under a camera shares, simulated or real (section III-A of the paper): how it describes
//! itself to a learner, how it reports what it senses, and the way its finger goes from posture to posture.
//!
//! There is no physics here and no arm of any one kind, so that the driver of a real arm is built without a simulator.

mod declare;
mod random;
pub mod route;
mod side;
mod square;
mod units;

pub use declare::{ArmIds, FingerArm, Percept, object_symbol};
pub use random::SplitMix;
pub use side::Side;
pub use square::{JOINT_RESOLUTION, JointPositions, Square};
pub use units::{PointMm, Within};
