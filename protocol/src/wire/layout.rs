//! The structures that cross shared memory, byte for byte: integers and fixed arrays only, no padding, a version in every
//! message. Reals travel as their IEEE 754 bit pattern in a `u64`, so that no bit pattern is invalid. A structure that was
//! received is only an allegation until [`super::decode`] has checked it.
//!
//! A change of any layout here is a new [`VERSION`] and a new `vN` in the payload's type name.

use crate::limits::{
    ACTIONS_MAX, NAME_BYTES_MAX, OBSERVATION_TYPES_MAX, OBSERVATIONS_MAX, PAGE_BYTES, PRIMITIVES_MAX,
    PROPERTIES_MAX, REASON_BYTES_MAX, SCENE_COMMANDS_MAX, SYMBOLS_MAX,
};

/// First word of every message: `PSCH` in ASCII, read as a little-endian integer.
pub const MAGIC: u32 = u32::from_le_bytes(*b"PSCH");
/// Version of the protocol spoken by this build.
pub const VERSION: u32 = 2;
/// Version of what tools and daemon say to each other in pages. What is in a page describes itself (JSON, whose fields keep
/// their meaning), so this is raised only when a page itself, or the meaning of a request, changes. Bodies are not concerned.
pub const TOOLS_VERSION: u32 = 3;

/// Version of the messages that carry pictures.
pub const PICTURES_VERSION: u32 = 1;

/// Bits of [`WireObservationType::flags`].
pub mod flags {
    /// The observation is caused by the body itself.
    pub const OWN: u32 = 1;
    /// The observation is an event, holding for its frame only.
    pub const TRANSIENT: u32 = 2;
    /// The observation is a number that comes with the frame and may be wanted.
    pub const VALUE: u32 = 4;
}

/// Values of [`WireProperty::kind`] and of the four-bit tags in [`Record::kinds`].
pub mod kind {
    /// A signed whole number, two's complement in the `u64`.
    pub const INTEGER: u32 = 1;
    /// An index into the property's symbols.
    pub const SYMBOL: u32 = 2;
    /// 0 or 1.
    pub const BOOLEAN: u32 = 3;
    /// The bits of an IEEE 754 double.
    pub const REAL: u32 = 4;
}

/// Values of [`FrameHeader::purpose`].
pub mod purpose {
    /// The frame reports observations and asks what to do.
    pub const OBSERVE: u32 = 1;
    /// The body leaves; the frame has no observations.
    pub const DETACH: u32 = 2;
}

/// Values of [`FrameHeader::outcome`].
pub mod outcome {
    /// Nothing was asked of the body since its last frame.
    pub const NONE: u32 = 0;
    /// Carried out.
    pub const DONE: u32 = 1;
    /// Not begun.
    pub const REFUSED: u32 = 2;
    /// Begun and not completed.
    pub const FAILED: u32 = 3;
    /// Not completed in time.
    pub const TIMED_OUT: u32 = 4;
    /// Not carried out: the episode had ended, and this frame begins a new one.
    pub const EPISODE_ENDED: u32 = 5;
    /// Not carried out: the episode was cut off, and this frame begins a new one.
    pub const EPISODE_CUT: u32 = 6;
}

/// Values of [`WireReply::kind`].
pub mod reply {
    /// Carry out the action in `order`.
    pub const ACT: u32 = 1;
    /// Arrange the surroundings by the scene command in `order`.
    pub const ARRANGE: u32 = 2;
    /// Rest `wait_ms` milliseconds, then send a fresh frame.
    pub const WAIT: u32 = 3;
    /// The frame was refused: `code` and `reason` say why.
    pub const REFUSED: u32 = 4;
    /// Leave: the daemon is ending or has closed the session.
    pub const DETACH: u32 = 5;
}

/// UTF-8 text of at most `N` bytes; bytes past `length` are zero.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text<const N: usize> {
    /// Bytes used.
    pub length: u32,
    /// The text.
    pub bytes: [u8; N],
}

impl<const N: usize> Default for Text<N> {
    fn default() -> Self {
        Self { length: 0, bytes: [0; N] }
    }
}

/// A name: see [`NAME_BYTES_MAX`].
pub type Name = Text<NAME_BYTES_MAX>;
/// A reason: see [`REASON_BYTES_MAX`].
pub type Reason = Text<REASON_BYTES_MAX>;

/// The index of a declaration, with up to eight values: an observation, a primitive, an action or a scene command.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Record {
    /// Index of the declared observation type, action or scene command.
    pub index: u16,
    /// Values used.
    pub count: u16,
    /// [`kind`] of value `i` in bits `4 * i ..= 4 * i + 3`; 0 past `count`.
    pub kinds: u32,
    /// The values, in declared order; zero past `count`.
    pub values: [u64; PROPERTIES_MAX],
}

/// A property of an observation type or a parameter of an action.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireProperty {
    /// Its name.
    pub name: Name,
    /// Its unit, empty for none.
    pub unit: Name,
    /// One of [`kind`].
    pub kind: u32,
    /// Symbols only: index of its first symbol in [`HelloHead::symbols`].
    pub first_symbol: u32,
    /// Symbols only: how many follow from there.
    pub symbol_count: u32,
    /// Zero.
    pub reserved: u32,
    /// Smallest value, for integers and reals, as the values themselves are written.
    pub min: u64,
    /// Largest value, likewise.
    pub max: u64,
    /// Width of a bin, for reals.
    pub resolution: u64,
}

/// A declared observation type.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireObservationType {
    /// Its name.
    pub name: Name,
    /// Bits of [`flags`].
    pub flags: u32,
    /// Properties used.
    pub property_count: u32,
    /// Zero.
    pub reserved: u32,
    /// Its properties.
    pub properties: [WireProperty; PROPERTIES_MAX],
}

/// A declared action or scene command.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WireActionType {
    /// Its name.
    pub name: Name,
    /// Parameters used.
    pub parameter_count: u32,
    /// Zero.
    pub reserved: [u32; 2],
    /// Its parameters.
    pub parameters: [WireProperty; PROPERTIES_MAX],
}

/// A body's introduction without its repertoire, which follows in the same message: `primitive_count` records.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HelloHead {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`VERSION`] of the body.
    pub version: u32,
    /// Process of the body, for people and logs.
    pub pid: u32,
    /// Observation types used.
    pub observation_type_count: u32,
    /// Actions used.
    pub action_count: u32,
    /// Scene commands used.
    pub scene_command_count: u32,
    /// Symbols used.
    pub symbol_count: u32,
    /// Primitives that follow.
    pub primitive_count: u32,
    /// The port name of the body's wake listener is this number as 16 hexadecimal digits.
    pub wake: u64,
    /// The body's name.
    pub name: Name,
    /// What kind of body it is.
    pub kind: Name,
    /// Its observation types.
    pub observation_types: [WireObservationType; OBSERVATION_TYPES_MAX],
    /// Its actions.
    pub actions: [WireActionType; ACTIONS_MAX],
    /// Its scene commands.
    pub scene_commands: [WireActionType; SCENE_COMMANDS_MAX],
    /// The symbols of all its properties.
    pub symbols: [Name; SYMBOLS_MAX],
}

/// A whole hello: only `head.primitive_count` of its primitives are written and read.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireHello {
    /// Everything but the repertoire.
    pub head: HelloHead,
    /// The repertoire.
    pub primitives: [Record; PRIMITIVES_MAX],
}

/// The daemon's answer to a hello.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Welcome {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`VERSION`] of the daemon.
    pub version: u32,
    /// The session's number, above zero; 0 when refused.
    pub session: u64,
    /// The wake number of the hello: by it the body knows that it is its own that is answered.
    pub wake: u64,
    /// 0 when accepted, else the number of the refusal.
    pub code: u32,
    /// Zero.
    pub reserved: u32,
    /// The learner's name.
    pub learner: Name,
    /// Why it was refused; empty when accepted.
    pub reason: Reason,
}

/// The header of a frame. Its `observation_count` records follow in the same message.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameHeader {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`VERSION`] of the body.
    pub version: u32,
    /// The session it belongs to, as the welcome gave it.
    pub session: u64,
    /// 1 for the first frame of a session, one more for each next.
    pub sequence: u64,
    /// Sequence of the frame whose reply `outcome` answers; 0 when there is none.
    pub answers: u64,
    /// The port name of the body's wake listener is this number as 16 hexadecimal digits.
    pub wake: u64,
    /// One of [`outcome`].
    pub outcome: u32,
    /// One of [`purpose`].
    pub purpose: u32,
    /// Records that follow.
    pub observation_count: u32,
    /// Zero.
    pub reserved: u32,
}

impl FrameHeader {
    /// Whether the frame says why an order was not carried out.
    #[must_use]
    pub fn has_reason(&self) -> bool {
        matches!(self.outcome, outcome::REFUSED | outcome::FAILED)
    }
}

impl Default for FrameHeader {
    /// The header of a frame that observes nothing, of no session.
    fn default() -> Self {
        Self {
            magic: MAGIC,
            version: VERSION,
            session: 0,
            sequence: 0,
            answers: 0,
            wake: 0,
            outcome: outcome::NONE,
            purpose: purpose::OBSERVE,
            observation_count: 0,
            reserved: 0,
        }
    }
}

/// The observations of a frame, of which only the `observation_count` of the header are written and read, and the reason why an
/// order was not carried out, which is written and read only with [`outcome::REFUSED`] and [`outcome::FAILED`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireFrame {
    /// The observations.
    pub records: [Record; OBSERVATIONS_MAX],
    /// Why the order was refused or failed; empty when the body does not say.
    pub reason: Reason,
    /// Zero.
    pub reserved: u32,
}

/// The daemon's reply to a frame.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WireReply {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`VERSION`] of the daemon.
    pub version: u32,
    /// The session of the frame it answers.
    pub session: u64,
    /// The sequence of the frame it answers.
    pub sequence: u64,
    /// One of [`reply`].
    pub kind: u32,
    /// The number of the refusal; 0 otherwise.
    pub code: u32,
    /// Milliseconds to rest; 0 for other kinds.
    pub wait_ms: u32,
    /// Zero.
    pub reserved: u32,
    /// The action or scene command; zero for other kinds.
    pub order: Record,
    /// Why the frame was refused; empty otherwise.
    pub reason: Reason,
    /// Zero.
    pub reserved_end: u32,
}

/// One page of a tool's request or of the daemon's answer to it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`TOOLS_VERSION`] of the sender.
    pub version: u32,
    /// Number the tool gave its request; every page of the answer repeats it.
    pub request: u64,
    /// The port name of the tool's wake listener is this number as 16 hexadecimal digits; 0 in answers.
    pub wake: u64,
    /// This page, from 0.
    pub page: u32,
    /// Pages in all, at least 1.
    pub pages: u32,
    /// Bytes used in this page.
    pub length: u32,
    /// 0, or the number of the refusal whose reason is the page's text.
    pub code: u32,
    /// What is carried; bytes past `length` mean nothing.
    pub bytes: [u8; PAGE_BYTES],
}

/// The header of a picture. The bytes of the picture are first its fields, then its pixels.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PictureHeader {
    /// [`MAGIC`].
    pub magic: u32,
    /// [`PICTURES_VERSION`].
    pub version: u32,
    /// The session of the body that took it.
    pub session: u64,
    /// How many frames the body had exchanged in that session before it took it.
    pub frame: u64,
    /// Pixels in a row, at least 1.
    pub width_px: u32,
    /// Rows, at least 1.
    pub height_px: u32,
    /// Fields; each is three little-endian `f32`: x and y of its middle and its radius, in pixels.
    pub field_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// Bytes of one field before the pixels, which are three bytes each, red, green and blue, row by row from the top.
pub const PICTURE_FIELD_BYTES: usize = 12;

/// Bytes of a page before what it carries.
pub const PAGE_HEAD_BYTES: usize = 40;

/// The layout is the contract with bodies in other languages. These sizes show that no padding has crept in.
const _: () = {
    assert!(size_of::<Name>() == 36 && size_of::<Reason>() == 260);
    assert!(size_of::<Record>() == 72);
    assert!(size_of::<WireProperty>() == 2 * 36 + 4 * 4 + 3 * 8);
    assert!(size_of::<WireObservationType>() == 36 + 3 * 4 + PROPERTIES_MAX * size_of::<WireProperty>());
    assert!(size_of::<WireActionType>() == size_of::<WireObservationType>());
    assert!(
        size_of::<HelloHead>()
            == 8 * 4
                + 8
                + 2 * 36
                + (OBSERVATION_TYPES_MAX + ACTIONS_MAX + SCENE_COMMANDS_MAX) * size_of::<WireActionType>()
                + SYMBOLS_MAX * 36
    );
    assert!(size_of::<WireHello>() == size_of::<HelloHead>() + PRIMITIVES_MAX * size_of::<Record>());
    assert!(size_of::<WireFrame>() == OBSERVATIONS_MAX * size_of::<Record>() + 260 + 4);
    assert!(size_of::<Welcome>() == 2 * 4 + 2 * 8 + 2 * 4 + 36 + 260);
    assert!(size_of::<FrameHeader>() == 2 * 4 + 4 * 8 + 4 * 4);
    assert!(size_of::<WireReply>() == 2 * 4 + 2 * 8 + 4 * 4 + 72 + 260 + 4);
    assert!(size_of::<Page>() == PAGE_HEAD_BYTES + PAGE_BYTES);
    assert!(size_of::<PictureHeader>() == 2 * 4 + 2 * 8 + 4 * 4);
};
