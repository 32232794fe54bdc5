//! Structures to checked values. A message that came over shared memory is an allegation: it was copied once, and the copy
//! is checked here. No input makes these functions panic, and nothing invalid passes them.

use super::bounds::Bounds;
use super::check;
use super::layout::{
    FrameHeader, MAGIC, Name, Record, TOOLS_VERSION, Text, VERSION, Welcome, WireActionType,
    WireObservationType, WireProperty, WireReply, flags, kind, outcome, purpose, reply,
};
use super::message::{Admission, Introduction, OrderReport, RawFrame, RawHello, Reply, SensorFrame};
use super::observations::Observations;
use crate::description::{
    Action, ActionId, ActionType, Description, ObservationType, Property, Value, ValueKind,
};
use crate::limits::{LEARNER_NAME_BYTES_MAX, OBSERVATIONS_MAX, PRIMITIVES_MAX, WAIT_MS_MAX};
use crate::outcome::Outcome;
use crate::refusal::Refusal;

/// Checks that a message is of this protocol and this version.
pub(crate) fn preamble(magic: u32, version: u32) -> Result<(), Refusal> {
    of_version(magic, version, VERSION)
}

/// Checks that a page is of this protocol and of this version of the tools' messages.
pub(crate) fn tool_preamble(magic: u32, version: u32) -> Result<(), Refusal> {
    of_version(magic, version, TOOLS_VERSION)
}

fn of_version(magic: u32, theirs: u32, ours: u32) -> Result<(), Refusal> {
    if magic != MAGIC {
        return Err(Refusal::Magic { found: magic, expected: MAGIC });
    }
    if theirs != ours {
        return Err(Refusal::Version { theirs, ours });
    }
    Ok(())
}

fn text<const N: usize>(place: &str, from: &Text<N>) -> Result<String, Refusal> {
    let problem = |problem: String| Refusal::Name { place: place.to_owned(), problem };
    let used = usize::try_from(from.length).ok().and_then(|length| from.bytes.get(..length));
    let used = used.ok_or_else(|| problem(format!("it claims {} bytes of {N}", from.length)))?;
    let text = str::from_utf8(used).map_err(|error| problem(format!("it is not UTF-8: {error}")))?;
    Ok(text.to_owned())
}

/// The first `count` of `from`, or a refusal if there are not as many.
fn counted<'a, T>(what: &str, count: u32, from: &'a [T]) -> Result<&'a [T], Refusal> {
    let found = usize::try_from(count).unwrap_or(usize::MAX);
    from.get(..found).ok_or_else(|| Refusal::TooMany { what: what.to_owned(), found, limit: from.len() })
}

/// Checks a body's hello.
///
/// # Errors
/// The first thing wrong with it.
pub fn hello(from: &RawHello) -> Result<Introduction, Refusal> {
    let head = &*from.head;
    preamble(head.magic, head.version)?;
    let types = counted("observation types", head.observation_type_count, &head.observation_types)?;
    let actions = counted("actions", head.action_count, &head.actions)?;
    let commands = counted("scene commands", head.scene_command_count, &head.scene_commands)?;
    let symbols = counted("symbols", head.symbol_count, &head.symbols)?;
    let claimed = usize::try_from(head.primitive_count).unwrap_or(usize::MAX);
    let primitives = from.primitives.get(..claimed).filter(|_| claimed <= PRIMITIVES_MAX);
    let primitives = primitives
        .ok_or(Refusal::PrimitiveCount { found: head.primitive_count, held: from.primitives.len() })?;
    let (name, kind) = (text("the body's name", &head.name)?, text("the body's kind", &head.kind)?);
    let types = types.iter().map(|one| observation_type(one, symbols));
    let action_types = |declared: &[WireActionType]| -> Result<Vec<_>, Refusal> {
        declared.iter().map(|one| action_type(one, symbols)).collect()
    };
    let mut description = Description {
        observation_types: types.collect::<Result<_, _>>()?,
        actions: action_types(actions)?,
        scene_commands: action_types(commands)?,
        ..Description::new(name, kind)
    };
    // The declarations are checked first, because primitives are read by them.
    description.check()?;
    description.repertoire = primitives
        .iter()
        .enumerate()
        .map(|(number, one)| action(&|| format!("primitive {number}"), one, &description.actions))
        .collect::<Result<_, _>>()?;
    Ok(Introduction { pid: head.pid, description })
}

fn observation_type(from: &WireObservationType, symbols: &[Name]) -> Result<ObservationType, Refusal> {
    let name = text("name of an observation type", &from.name)?;
    let unknown = from.flags & !(flags::OWN | flags::TRANSIENT | flags::VALUE);
    if unknown != 0 {
        let problem = format!("flags {unknown:#x} are unknown");
        return Err(Refusal::Declaration { place: format!("observation type {name}"), problem });
    }
    let used = counted(&format!("{name}: properties"), from.property_count, &from.properties)?;
    Ok(ObservationType {
        own: from.flags & flags::OWN != 0,
        transient: from.flags & flags::TRANSIENT != 0,
        value: from.flags & flags::VALUE != 0,
        properties: used.iter().map(|one| property(&name, one, symbols)).collect::<Result<_, _>>()?,
        name,
    })
}

fn action_type(from: &WireActionType, symbols: &[Name]) -> Result<ActionType, Refusal> {
    let name = text("name of an action", &from.name)?;
    let used = counted(&format!("{name}: parameters"), from.parameter_count, &from.parameters)?;
    Ok(ActionType {
        parameters: used.iter().map(|one| property(&name, one, symbols)).collect::<Result<_, _>>()?,
        name,
    })
}

fn property(of: &str, from: &WireProperty, symbols: &[Name]) -> Result<Property, Refusal> {
    let name = text(&format!("{of}: name of a property"), &from.name)?;
    let place = format!("{of}: property {name}");
    let unit = text(&format!("{place}: unit"), &from.unit)?;
    let kind = match from.kind {
        kind::INTEGER => ValueKind::Integer { min: from.min.cast_signed(), max: from.max.cast_signed() },
        kind::SYMBOL => ValueKind::Symbol { symbols: property_symbols(&place, from, symbols)? },
        kind::BOOLEAN => ValueKind::Boolean,
        kind::REAL => ValueKind::Real {
            min: f64::from_bits(from.min),
            max: f64::from_bits(from.max),
            resolution: f64::from_bits(from.resolution),
        },
        unknown => {
            return Err(Refusal::Declaration { place, problem: format!("kind {unknown} is unknown") });
        }
    };
    Ok(Property { name, kind, unit })
}

fn property_symbols(place: &str, from: &WireProperty, symbols: &[Name]) -> Result<Vec<String>, Refusal> {
    let first = usize::try_from(from.first_symbol).unwrap_or(usize::MAX);
    let count = usize::try_from(from.symbol_count).unwrap_or(usize::MAX);
    let used = symbols.get(first..).and_then(|rest| rest.get(..count));
    let used = used.ok_or_else(|| Refusal::Declaration {
        place: place.to_owned(),
        problem: format!("symbols {first} + {count} are beyond the {} declared", symbols.len()),
    })?;
    used.iter().map(|one| text(&format!("{place}: a symbol"), one)).collect()
}

/// One value of a record, checked against its property.
fn value(
    place: &dyn Fn() -> String,
    from: &Record,
    position: usize,
    property: &Property,
) -> Result<Value, Refusal> {
    let bits = from.values.get(position).copied().unwrap_or(0);
    let tag = from.kinds.checked_shr(4 * u32::try_from(position).unwrap_or(8)).unwrap_or(0) & 0xf;
    let unreadable = |found: String| Refusal::ValueKind {
        place: format!("{} {}", place(), property.name),
        found,
        declared: check::kind_name(&property.kind),
    };
    let value = match tag {
        kind::INTEGER => Value::Integer(bits.cast_signed()),
        kind::SYMBOL => Value::Symbol(u32::try_from(bits).map_err(|_| unreadable(format!("symbol {bits}")))?),
        kind::BOOLEAN if bits <= 1 => Value::Boolean(bits == 1),
        kind::BOOLEAN => return Err(unreadable(format!("boolean {bits}"))),
        kind::REAL => Value::Real(f64::from_bits(bits)),
        unknown => return Err(unreadable(format!("kind {unknown}"))),
    };
    check::value(place, property, &value)?;
    Ok(value)
}

/// The values of a record, checked against the properties declared for it.
fn values(
    place: &dyn Fn() -> String,
    sort: &str,
    from: &Record,
    declared: &[Property],
) -> Result<Vec<Value>, Refusal> {
    if usize::from(from.count) != declared.len() {
        let declared = declared.len();
        return Err(Refusal::ValueCount { place: place(), found: from.count, declared });
    }
    let place = || format!("{}: {sort}", place());
    declared.iter().enumerate().map(|(position, one)| value(&place, from, position, one)).collect()
}

fn action(place: &dyn Fn() -> String, from: &Record, declared: &[ActionType]) -> Result<Action, Refusal> {
    let Some(kind) = declared.get(usize::from(from.index)) else {
        return Err(Refusal::UnknownIndex { place: place(), found: from.index, declared: declared.len() });
    };
    let place = || format!("{} ({})", place(), kind.name);
    let parameters = values(&place, "parameter", from, &kind.parameters)?;
    Ok(Action { id: ActionId::from_index(from.index), parameters })
}

/// Checks carefully that a record is an observation of a declared type, and says why not.
pub(crate) fn observation(number: usize, from: &Record, declared: &[ObservationType]) -> Result<(), Refusal> {
    let Some(kind) = declared.get(usize::from(from.index)) else {
        let place = format!("observation {number}");
        return Err(Refusal::UnknownIndex { place, found: from.index, declared: declared.len() });
    };
    let place = || format!("observation {number} ({})", kind.name);
    values(&place, "property", from, &kind.properties).map(drop)
}

/// The daemon's checks in one session: each frame is checked against the description, and against the frames and replies before
/// it.
#[derive(Clone, Debug)]
pub struct SessionChecks {
    number: u64,
    description: Description,
    bounds: Bounds,
    last_sequence: u64,
    /// Sequence of the frame whose reply was an order, until it is answered.
    ordered_at: Option<u64>,
}

impl SessionChecks {
    /// A session that has begun with a checked description. `number` is above zero.
    #[must_use]
    pub fn new(number: u64, description: Description) -> Self {
        let bounds = Bounds::of(&description.observation_types);
        Self { number, description, bounds, last_sequence: 0, ordered_at: None }
    }

    /// The session's number.
    #[must_use]
    pub fn number(&self) -> u64 {
        self.number
    }

    /// The body, as it described itself.
    #[must_use]
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Notes the reply given to the last frame, so that the next outcome can be matched to it.
    pub fn replied(&mut self, reply: &Reply) {
        if matches!(reply, Reply::Act(_) | Reply::Arrange(_)) {
            self.ordered_at = Some(self.last_sequence);
        }
    }

    /// Checks a frame. A frame that is out of order, or of another session or version, changes nothing. A frame in order uses
    /// its sequence number up, even if its content is refused, and the body goes on with the next number. An outcome in a refused
    /// frame counts as not reported; the body reports it again.
    ///
    /// # Errors
    /// The first thing wrong with it.
    pub fn check<'a>(&mut self, from: &'a RawFrame) -> Result<SensorFrame<'a>, Refusal> {
        let header = &from.header;
        preamble(header.magic, header.version)?;
        if header.session != self.number {
            return Err(Refusal::Session { found: header.session, expected: self.number });
        }
        let expected = self.last_sequence.saturating_add(1);
        if header.sequence != expected {
            return Err(Refusal::Sequence { found: header.sequence, expected });
        }
        self.last_sequence = expected;
        if header.purpose != purpose::OBSERVE {
            return Err(Refusal::Purpose { found: header.purpose });
        }
        let report = self.report(from)?;
        let claimed = usize::try_from(header.observation_count).unwrap_or(usize::MAX);
        let records = from.records.get(..claimed).filter(|_| claimed <= OBSERVATIONS_MAX);
        let records = records
            .ok_or(Refusal::ObservationCount { found: header.observation_count, held: from.records.len() })?;
        for (number, record) in records.iter().enumerate() {
            if !self.bounds.hold(record) {
                observation(number, record, &self.description.observation_types)?;
            }
        }
        if report.is_some() {
            self.ordered_at = None;
        }
        let observations = Observations::of(records);
        Ok(SensorFrame { session: self.number, sequence: expected, report, observations })
    }

    fn report(&self, from: &RawFrame) -> Result<Option<OrderReport>, Refusal> {
        let FrameHeader { outcome, answers, .. } = from.header;
        let reason = || text("reason of the outcome", &from.reason);
        let outcome = match outcome {
            outcome::NONE => None,
            outcome::DONE => Some(Outcome::Done),
            outcome::REFUSED => Some(Outcome::Refused(reason()?)),
            outcome::FAILED => Some(Outcome::Failed(reason()?)),
            outcome::TIMED_OUT => Some(Outcome::TimedOut),
            outcome::EPISODE_ENDED => Some(Outcome::EpisodeEnded),
            outcome::EPISODE_CUT => Some(Outcome::EpisodeCut),
            found => return Err(Refusal::UnknownOutcome { found }),
        };
        match (outcome, self.ordered_at) {
            (None, None) if answers == 0 => Ok(None),
            (Some(outcome), Some(order)) if answers == order => Ok(Some(OrderReport { outcome, answers })),
            // An order must be answered: an action whose end is never told would be learnt from wrongly.
            (_, order) => Err(Refusal::Answers { found: answers, expected: order.unwrap_or(0) }),
        }
    }
}

/// Checks the daemon's answer to a hello.
///
/// # Errors
/// The first thing wrong with it. A refusal by the daemon is no error here.
pub fn welcome(from: &Welcome) -> Result<Admission, Refusal> {
    // The reason of a refusal can be read whatever the version: that is how the version is refused.
    if from.magic == MAGIC && from.code != 0 {
        return Ok(Admission::Refused { code: from.code, reason: text("reason", &from.reason)? });
    }
    preamble(from.magic, from.version)?;
    let learner = text("the learner's name", &from.learner)?;
    if from.session == 0 || learner.len() > LEARNER_NAME_BYTES_MAX {
        return Err(Refusal::Session { found: from.session, expected: 1 });
    }
    Ok(Admission::Accepted { session: from.session, learner })
}

/// Checks the reply to frame `sequence` of `session`: an order is within what `description` declares.
///
/// # Errors
/// The first thing wrong with it. A refusal by the daemon is no error here.
pub fn reply(
    from: &WireReply,
    description: &Description,
    session: u64,
    sequence: u64,
) -> Result<Reply, Refusal> {
    preamble(from.magic, from.version)?;
    if from.session != session {
        return Err(Refusal::Session { found: from.session, expected: session });
    }
    if from.sequence != sequence {
        return Err(Refusal::Sequence { found: from.sequence, expected: sequence });
    }
    match from.kind {
        reply::ACT => Ok(Reply::Act(action(&|| "the action".to_owned(), &from.order, &description.actions)?)),
        reply::ARRANGE => {
            let place = || "the scene command".to_owned();
            Ok(Reply::Arrange(action(&place, &from.order, &description.scene_commands)?))
        }
        reply::WAIT if from.wait_ms <= WAIT_MS_MAX => Ok(Reply::Wait { ms: from.wait_ms }),
        reply::WAIT => Err(Refusal::WaitTooLong { found: from.wait_ms }),
        reply::REFUSED => Ok(Reply::Refused { code: from.code, reason: text("reason", &from.reason)? }),
        reply::DETACH => Ok(Reply::Detach),
        found => Err(Refusal::UnknownReply { found }),
    }
}
