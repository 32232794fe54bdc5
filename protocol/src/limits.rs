//! Every limit of the wire, by name. Sizes of the fixed arrays in [`crate::wire`] follow from these.

/// Longest name of a body, type, property, symbol, action or parameter, in bytes of UTF-8.
pub const NAME_BYTES_MAX: usize = 32;
/// Observation types one body may declare.
pub const OBSERVATION_TYPES_MAX: usize = 32;
/// Properties of one observation type, and parameters of one action or scene command.
pub const PROPERTIES_MAX: usize = 8;
/// Symbols that one body may declare, in all its properties together.
pub const SYMBOLS_MAX: usize = 512;
/// Action types one body may declare.
pub const ACTIONS_MAX: usize = 16;
/// Scene commands one body may declare.
pub const SCENE_COMMANDS_MAX: usize = 16;
/// Primitives (actions with their parameters filled in) in one body's repertoire.
pub const PRIMITIVES_MAX: usize = 4096;
/// Observations in one frame.
pub const OBSERVATIONS_MAX: usize = 4096;
/// Bodies attached to one daemon at a time.
pub const BODIES_MAX: usize = 8;
/// Tools connected to one daemon at a time.
pub const TOOLS_MAX: usize = 16;
/// Places on the tool service beside those, for tools that connect to give orders or to ask how the learner is: however many tools
/// watch, somebody can still look and hold it.
pub const OPERATORS_MAX: usize = 4;
/// Files that the process of a body or of a tool has open, generously rounded up.
pub const PEER_DESCRIPTORS_NEEDED: u64 = 128;
/// Longest reason of a refusal, or of an order that was not carried out, in bytes of UTF-8.
pub const REASON_BYTES_MAX: usize = 256;
/// Longest name of a learner, in bytes: small letters, digits, `_` and `-`.
pub const LEARNER_NAME_BYTES_MAX: usize = 32;
/// Longest a `wait` reply may ask a body to rest before its next frame, in milliseconds.
pub const WAIT_MS_MAX: u32 = 10_000;
/// Bytes carried by one page of a tool's request or the daemon's answer.
pub const PAGE_BYTES: usize = 32 * 1024;
/// Longest request of a tool, in bytes: one page.
pub const REQUEST_BYTES_MAX: usize = PAGE_BYTES;
/// Longest answer to a tool, in bytes. A tool asks for longer results piece by piece.
pub const ANSWER_BYTES_MAX: usize = 16 * 1024 * 1024;
/// Pages of the longest answer.
pub const PAGES_MAX: usize = ANSWER_BYTES_MAX.div_ceil(PAGE_BYTES);

/// Tools that may look at pictures at a time.
pub const WATCHERS_MAX: usize = 4;
/// Pixels of the largest picture; 1920 by 1200.
pub const PICTURE_PIXELS_MAX: u32 = 1920 * 1200;
/// Fields drawn into one picture.
pub const PICTURE_FIELDS_MAX: usize = 16_384;

// Indexes into these travel as u16.
const _: () = assert!(OBSERVATION_TYPES_MAX <= 1 << 16);
const _: () = assert!(ACTIONS_MAX <= 1 << 16);
const _: () = assert!(SCENE_COMMANDS_MAX <= 1 << 16);
// A record keeps the kind of each value in four bits of one u32.
const _: () = assert!(PROPERTIES_MAX <= 8);
