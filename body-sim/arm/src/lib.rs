//! What every arm with a finger under a camera shares, simulated or real (section III-A of the paper): how it describes
//! itself to a learner, how it reports what it senses, and the way its finger goes from posture to posture.
//!
//! There is no physics here and no arm of any one kind, so that the driver of a real arm is built without a simulator.
//!
//! ```
//! use pschema_arm::route::{OUTWARDS, RouteSetup, Waypoint, route};
//! use pschema_arm::{FingerArm, JointPositions, Square};
//!
//! let goal = JointPositions { j1: 0.4, j2: 0.6 };
//! let (description, ids) = FingerArm {
//!     name: "arm".to_owned(),
//!     kind: "my-arm".to_owned(),
//!     fields: 224,
//!     finger_colour: "green".to_owned(),
//!     object_colours: vec!["blue".to_owned(), "red".to_owned()],
//!     objects: vec!["blue-block".to_owned()],
//!     places: 100,
//!     moves: vec![goal],
//!     pushes: Vec::new(),
//! }
//! .declare();
//! assert_eq!((description.repertoire.len(), ids.push), (1, None));
//!
//! // The way from the rest posture to the goal: up, over, down before the goal, and up to it along the table.
//! let square = Square { across_m: 1.6, nearest_m: 0.12, outwards_m: 0.7, rest_m: 0.06 };
//! let rest = Waypoint { joints: square.joints((0.0, square.rest_m)), lift_m: 0.0 };
//! let points = route(RouteSetup { lift_m: 0.05, approach_m: 0.03 }, &square, rest, OUTWARDS, goal);
//! assert_eq!(points.len(), 4);
//! assert_eq!(points[3], Waypoint { joints: goal, lift_m: 0.0 });
//! ```

#![deny(missing_docs)]

mod declare;
mod eye;
mod file;
mod random;
pub mod route;
mod side;
mod square;
mod units;

pub use declare::{ArmIds, FingerArm, Percept, object_symbol};
pub use eye::{VisionSection, field_marks};
pub use file::{FileError, FileKind, check_names};
pub use random::SplitMix;
pub use side::Side;
pub use square::{JOINT_RESOLUTION, JointPositions, Square};
pub use units::{PointMm, Within};
