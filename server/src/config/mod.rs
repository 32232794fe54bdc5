//! What people write in files: the learner's parameters and curricula, in TOML. Every mistake is reported
//! with the file, the line and the column; unknown keys are mistakes.

mod curriculum;
mod learner;
mod source;
mod stage;
mod until;

pub use curriculum::{BUILT_IN, curriculum, lesson, named};
pub use learner::learner;
pub use source::{ConfigError, FILE_BYTES_MAX, Mistake, Source};
