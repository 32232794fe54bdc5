//! The driver against the emulated controller, and against a plain port that writes down what it is told.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

#[path = "driver/calibrate.rs"]
mod calibrate;
#[path = "driver/camera.rs"]
mod camera;
#[path = "driver/enabling.rs"]
mod enabling;
#[path = "driver/fake.rs"]
mod fake;
#[path = "driver/heartbeat.rs"]
mod heartbeat;
#[path = "driver/killed.rs"]
mod killed;
#[path = "driver/limits.rs"]
mod limits;
#[path = "driver/meddled.rs"]
mod meddled;
#[path = "driver/motion.rs"]
mod motion;
#[path = "driver/numbers.rs"]
mod numbers;
#[path = "driver/rig.rs"]
mod rig;
#[path = "driver/safety.rs"]
mod safety;
#[path = "driver/slow_line.rs"]
mod slow_line;
