//! Plain values to structures. A [`Description`] is checked first; observations are not, because the receiver checks them and
//! says what is wrong.

use super::layout::{
    FrameHeader, HelloHead, MAGIC, Name, Page, Reason, Record, TOOLS_VERSION, Text, VERSION, Welcome,
    WireActionType, WireObservationType, WireProperty, WireReply, flags, kind, outcome, reply,
};
use super::message::{OrderReport, RawFrame, RawHello, Reply};
use crate::description::{Action, ActionType, Description, ObservationType, Property, Value, ValueKind};
use crate::limits::{PAGE_BYTES, PROPERTIES_MAX, SYMBOLS_MAX};
use crate::outcome::Outcome;
use crate::refusal::Refusal;

/// `text` as far as it fits. It is cut between two characters.
#[must_use]
pub fn text<const N: usize>(text: &str) -> Text<N> {
    let mut end = text.len().min(N);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let mut bytes = [0; N];
    for (to, from) in bytes.iter_mut().zip(text.as_bytes().iter().take(end)) {
        *to = *from;
    }
    Text { length: saturating_u32(end), bytes }
}

/// The record of the declaration `index` with these values. Values beyond the eighth are cut off but counted, so that the
/// receiver refuses the record.
#[must_use]
pub fn record(index: u16, values: &[Value]) -> Record {
    let count = u16::try_from(values.len()).unwrap_or(u16::MAX);
    let mut record = Record { index, count, ..Record::default() };
    for (place, (to, value)) in record.values.iter_mut().zip(values).enumerate() {
        let (tag, bits) = value_bits(value);
        *to = bits;
        record.kinds |= tag << (4 * place);
    }
    record
}

fn value_bits(value: &Value) -> (u32, u64) {
    match *value {
        Value::Integer(number) => (kind::INTEGER, number.cast_unsigned()),
        Value::Symbol(index) => (kind::SYMBOL, u64::from(index)),
        Value::Boolean(truth) => (kind::BOOLEAN, u64::from(truth)),
        Value::Real(number) => (kind::REAL, number.to_bits()),
    }
}

/// A body's hello.
///
/// # Errors
/// The first thing in `description` that the protocol does not allow.
pub fn hello(description: &Description, pid: u32, wake: u64) -> Result<RawHello, Refusal> {
    description.check()?;
    let mut symbols = SymbolTable::default();
    let mut head = Box::new(empty_head());
    head.pid = pid;
    head.wake = wake;
    head.name = text(&description.name);
    head.kind = text(&description.kind);
    head.observation_type_count = saturating_u32(description.observation_types.len());
    head.action_count = saturating_u32(description.actions.len());
    head.scene_command_count = saturating_u32(description.scene_commands.len());
    head.primitive_count = saturating_u32(description.repertoire.len());
    for (to, from) in head.observation_types.iter_mut().zip(&description.observation_types) {
        *to = observation_type(from, &mut symbols);
    }
    for (to, from) in head.actions.iter_mut().zip(&description.actions) {
        *to = action_type(from, &mut symbols);
    }
    for (to, from) in head.scene_commands.iter_mut().zip(&description.scene_commands) {
        *to = action_type(from, &mut symbols);
    }
    head.symbol_count = saturating_u32(symbols.names.len());
    for (to, from) in head.symbols.iter_mut().zip(&symbols.names) {
        *to = *from;
    }
    let primitives =
        description.repertoire.iter().map(|one| record(one.id.index(), &one.parameters)).collect();
    Ok(RawHello { head, primitives })
}

/// A head that declares nothing.
fn empty_head() -> HelloHead {
    HelloHead {
        magic: MAGIC,
        version: VERSION,
        pid: 0,
        observation_type_count: 0,
        action_count: 0,
        scene_command_count: 0,
        symbol_count: 0,
        primitive_count: 0,
        wake: 0,
        name: Name::default(),
        kind: Name::default(),
        observation_types: Default::default(),
        actions: Default::default(),
        scene_commands: Default::default(),
        symbols: [Name::default(); SYMBOLS_MAX],
    }
}

#[derive(Default)]
struct SymbolTable {
    names: Vec<Name>,
}

fn observation_type(from: &ObservationType, symbols: &mut SymbolTable) -> WireObservationType {
    let own = if from.own { flags::OWN } else { 0 };
    let transient = if from.transient { flags::TRANSIENT } else { 0 };
    let value = if from.value { flags::VALUE } else { 0 };
    WireObservationType {
        name: text(&from.name),
        flags: own | transient | value,
        property_count: saturating_u32(from.properties.len()),
        reserved: 0,
        properties: properties(&from.properties, symbols),
    }
}

fn action_type(from: &ActionType, symbols: &mut SymbolTable) -> WireActionType {
    WireActionType {
        name: text(&from.name),
        parameter_count: saturating_u32(from.parameters.len()),
        reserved: [0; 2],
        parameters: properties(&from.parameters, symbols),
    }
}

fn properties(from: &[Property], symbols: &mut SymbolTable) -> [WireProperty; PROPERTIES_MAX] {
    std::array::from_fn(|place| {
        let mut property = WireProperty::default();
        if let Some(declared) = from.get(place) {
            property.name = text(&declared.name);
            property.unit = text(&declared.unit);
            value_kind(&declared.kind, &mut property, symbols);
        }
        property
    })
}

fn value_kind(from: &ValueKind, property: &mut WireProperty, symbols: &mut SymbolTable) {
    match from {
        ValueKind::Integer { min, max } => {
            property.kind = kind::INTEGER;
            property.min = min.cast_unsigned();
            property.max = max.cast_unsigned();
        }
        ValueKind::Symbol { symbols: declared } => {
            property.kind = kind::SYMBOL;
            property.first_symbol = saturating_u32(symbols.names.len());
            property.symbol_count = saturating_u32(declared.len());
            symbols.names.extend(declared.iter().map(|symbol| text(symbol)));
        }
        ValueKind::Boolean => property.kind = kind::BOOLEAN,
        ValueKind::Real { min, max, resolution } => {
            property.kind = kind::REAL;
            property.min = min.to_bits();
            property.max = max.to_bits();
            property.resolution = resolution.to_bits();
        }
    }
}

/// The welcome that opens `session` (above zero) with `learner`. The wake number of the hello is still to be filled in.
#[must_use]
pub fn welcome(session: u64, learner: &str) -> Welcome {
    Welcome {
        magic: MAGIC,
        version: VERSION,
        session,
        wake: 0,
        code: 0,
        reserved: 0,
        learner: text(learner),
        reason: Text::default(),
    }
}

/// The answer to a hello that is refused, which says why.
#[must_use]
pub fn unwelcome(refusal: &Refusal, learner: &str) -> Welcome {
    Welcome { code: refusal.code(), reason: text(&refusal.to_string()), ..welcome(0, learner) }
}

/// The frame whose session, sequence and count of observations are in `header`, with these records and, if there was an order,
/// the report on it.
#[must_use]
pub fn frame(header: FrameHeader, report: Option<&OrderReport>, records: Vec<Record>) -> RawFrame {
    let Some(OrderReport { outcome, answers }) = report else {
        return RawFrame { header, records, reason: Reason::default() };
    };
    let header = FrameHeader { outcome: outcome_number(outcome), answers: *answers, ..header };
    RawFrame { header, records, reason: text(outcome.reason().unwrap_or_default()) }
}

fn outcome_number(from: &Outcome) -> u32 {
    match from {
        Outcome::Done => outcome::DONE,
        Outcome::Refused(_) => outcome::REFUSED,
        Outcome::Failed(_) => outcome::FAILED,
        Outcome::TimedOut => outcome::TIMED_OUT,
        Outcome::EpisodeEnded => outcome::EPISODE_ENDED,
        Outcome::EpisodeCut => outcome::EPISODE_CUT,
    }
}

/// The reply to frame `sequence` of `session`.
#[must_use]
pub fn reply(session: u64, sequence: u64, from: &Reply) -> WireReply {
    let none = Record::default();
    let order = |action: &Action| record(action.id.index(), &action.parameters);
    let (number, order, wait_ms, code, reason) = match from {
        Reply::Act(action) => (reply::ACT, order(action), 0, 0, ""),
        Reply::Arrange(command) => (reply::ARRANGE, order(command), 0, 0, ""),
        Reply::Wait { ms } => (reply::WAIT, none, *ms, 0, ""),
        Reply::Refused { code, reason } => (reply::REFUSED, none, 0, *code, reason.as_str()),
        Reply::Detach => (reply::DETACH, none, 0, 0, ""),
    };
    WireReply {
        magic: MAGIC,
        version: VERSION,
        session,
        sequence,
        kind: number,
        code,
        wait_ms,
        reserved: 0,
        order,
        reason: text(reason),
        reserved_end: 0,
    }
}

/// Page `number` of `pages` of request `request`, with as many of the bytes as one page carries.
pub(crate) fn page(request: u64, (number, pages): (usize, usize), bytes: &[u8]) -> Page {
    let length = bytes.len().min(PAGE_BYTES);
    let mut page = Page {
        magic: MAGIC,
        version: TOOLS_VERSION,
        request,
        wake: 0,
        page: saturating_u32(number),
        pages: saturating_u32(pages),
        length: saturating_u32(length),
        code: 0,
        bytes: [0; PAGE_BYTES],
    };
    page.bytes[..length].copy_from_slice(&bytes[..length]);
    page
}

fn saturating_u32(number: usize) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}
