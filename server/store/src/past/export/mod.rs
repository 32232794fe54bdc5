//! Memory as JSON Lines: what a person or another program can read, and what a later release can always read back. The lines
//! are the items of the memory, as a snapshot has them, in JSON. `docs/EXPORT.md` has them one by one.

#[cfg(feature = "schema")]
mod described;
mod line;
mod named;

use std::io::{self, BufRead, Read, Write};

use pschema_learner::curriculum::Curriculum;
use pschema_learner::digest::digest;
use pschema_learner::memory::Content;
use pschema_learner::parameters::Parameters;

use crate::content_error::ContentError;
use crate::format::VERSION;
use crate::format::v1::{Assembly, End, Item, Kind, Setting, items};
#[cfg(feature = "schema")]
pub use described::ExportLine;
use line::{FirstLine, Header, Line};
use named::Named;

/// The longest line, in bytes: what a hostile file can have held in memory beside what it says.
pub const LINE_BYTES_MAX: u64 = 16 * 1024 * 1024;

/// Whose memory it is, and what it lives under.
#[derive(Clone, Copy, Debug)]
pub struct Identity<'a> {
    /// The learner's name.
    pub learner: &'a str,
    /// The seed that the memory was begun with.
    pub seed: u64,
    /// The learner's numbers and switches.
    pub parameters: &'a Parameters,
    /// The curriculum that the learner is led through.
    pub curriculum: &'a Curriculum,
}

/// Why an export can't be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A line is wrong.
    #[error("line {line}: {problem}")]
    Line {
        /// The number of the line, from 1.
        line: u64,
        /// What is wrong with it.
        problem: String,
    },
    /// The file can't be read to its end.
    #[error("line {line} can't be read: {error}")]
    Read {
        /// The number of the line, from 1.
        line: u64,
        /// Why it can't be read.
        #[source]
        error: io::Error,
    },
    /// The file can't be written.
    #[error("it can't be written: {0}")]
    Write(#[source] io::Error),
}

/// The lines of an export that was written or read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportSummary {
    /// How many lines there are.
    pub lines: u64,
    /// The digest of the memory.
    pub memory_digest: String,
}

/// Numbers of items, counted from 0 in each kind.
#[derive(Debug)]
struct Numbering {
    kind: Kind,
    next: u32,
}

impl Numbering {
    fn new() -> Self {
        Self { kind: Kind::Memory, next: 0 }
    }

    /// The number of the next item, if items of this kind are referred to by number.
    fn number(&mut self, kind: Kind) -> Option<u32> {
        if std::mem::replace(&mut self.kind, kind) != kind {
            self.next = 0;
        }
        let number = self.next;
        self.next = self.next.saturating_add(1);
        let numbered =
            (Kind::Property..=Kind::Schema).contains(&kind) || matches!(kind, Kind::Facet | Kind::Tree);
        numbered.then_some(number)
    }
}

/// Writes all of a memory. `progress` is told after each line how many lines are written.
///
/// # Errors
/// When it can't be written.
pub fn write(
    content: &Content,
    identity: Identity<'_>,
    to: &mut dyn Write,
    mut progress: impl FnMut(u64),
) -> Result<ExportSummary, ExportError> {
    let memory_digest = digest(content);
    let header = Header {
        format: VERSION,
        learner: identity.learner.to_owned(),
        seed: identity.seed.to_string(),
        memory_digest: memory_digest.clone(),
    };
    put(to, &FirstLine { pschema: header })?;
    let (mut lines, mut numbering) = (1, Numbering::new());
    for item in items(content, &Setting::new(identity.parameters, identity.curriculum)) {
        let kind = item.kind();
        let id = numbering.number(kind);
        let named = id.and_then(|id| Named::of(content, kind, id));
        put(to, &Line { item: &item, id, named })?;
        lines += 1;
        progress(lines);
    }
    let end = Item::End(End { items: lines - 1, memory_digest: memory_digest.clone() });
    put(to, &Line { item: &end, id: None, named: None })?;
    to.flush().map_err(ExportError::Write)?;
    Ok(ExportSummary { lines: lines + 1, memory_digest })
}

fn put(to: &mut dyn Write, line: &impl serde::Serialize) -> Result<(), ExportError> {
    let written = serde_json::to_writer(&mut *to, line).map_err(io::Error::from);
    written.and_then(|()| to.write_all(b"\n")).map_err(ExportError::Write)
}

/// A memory that was read from an export.
#[derive(Clone, Debug)]
pub struct Import {
    /// What the memory knows.
    pub content: Content,
    /// The learner's name.
    pub learner: String,
    /// The seed that the memory was begun with.
    pub seed: u64,
    /// The learner's numbers and switches.
    pub parameters: Parameters,
    /// The curriculum that the learner is led through.
    pub curriculum: Curriculum,
    /// How many lines there were, and the digest, which is that of the memory that was written.
    pub lines: ExportSummary,
}

/// Reads what [`write()`] wrote. `progress` is told after each line how many lines are read. Everything is checked; the memory
/// that it takes is in proportion to the length of the file.
///
/// # Errors
/// The first line that is wrong, and what is wrong with it; or that the lines together are not the memory that was written.
pub fn read(from: &mut dyn BufRead, mut progress: impl FnMut(u64)) -> Result<Import, ExportError> {
    let mut lines = LineReader { from, number: 0 };
    let header = lines.header()?;
    let seed = header.seed.parse().map_err(|_| lines.wrong(format!("{:?} is no seed", header.seed)))?;
    let (mut numbering, mut assembly) = (Numbering::new(), None);
    let end = loop {
        let Line { item, id, .. } = lines.item()?;
        if let Item::End(end) = item {
            break end;
        }
        let kind = item.kind();
        if let (Some(id), Some(next)) = (id, numbering.number(kind))
            && id != next
        {
            let kind = kind.name();
            return Err(lines.wrong(format!(
                "{kind} {id} stands where {kind} {next} is next: lines are missing, or out of order"
            )));
        }
        let taken = match &mut assembly {
            None => Assembly::begin(item).map(|begun| assembly = Some(begun)),
            Some(assembly) => assembly.take(item),
        };
        taken.map_err(|error| lines.wrong(error))?;
        progress(lines.number);
    };
    let assembly = assembly.ok_or(ContentError::missing(Kind::Memory.name()));
    let whole = assembly.and_then(|assembly| assembly.end(end)).map_err(|error| lines.wrong(error))?;
    let found = digest(&whole.content);
    if found != header.memory_digest || found != whole.memory_digest {
        return Err(lines.wrong(format!(
            "what the file says has digest {found}, and the memory that was written had {}: a line was changed or lost",
            header.memory_digest
        )));
    }
    let (parameters, curriculum) = whole.setting.checked().map_err(|error| lines.wrong(error))?;
    lines.over()?;
    let lines = ExportSummary { lines: lines.number, memory_digest: found };
    Ok(Import { content: whole.content, learner: header.learner, seed, parameters, curriculum, lines })
}

/// An export, line by line.
struct LineReader<'a> {
    from: &'a mut dyn BufRead,
    /// The number of the line that was read last, from 1.
    number: u64,
}

impl LineReader<'_> {
    fn wrong(&self, problem: impl ToString) -> ExportError {
        ExportError::Line { line: self.number, problem: problem.to_string() }
    }

    fn header(&mut self) -> Result<Header, ExportError> {
        let bytes = self.bytes()?;
        let line: FirstLine = serde_json::from_slice(&bytes).map_err(|error| {
            self.wrong(format!(
                "the first line must be a `pschema` line: this is no export, or not the beginning of one ({error})"
            ))
        })?;
        match line.pschema {
            header if header.format == VERSION => Ok(header),
            Header { format, .. } => Err(self.wrong(format!(
                "the file has format {format}, and this release reads formats 1 to {VERSION}"
            ))),
        }
    }

    fn item(&mut self) -> Result<Line<Item>, ExportError> {
        let bytes = self.bytes()?;
        let line = serde_json::from_slice(&bytes);
        line.map_err(|error| self.wrong(format!("it is not a line of an export: {error}")))
    }

    fn bytes(&mut self) -> Result<Vec<u8>, ExportError> {
        self.number += 1;
        let mut bytes = Vec::new();
        let read = (&mut *self.from).take(LINE_BYTES_MAX + 1).read_until(b'\n', &mut bytes);
        let read = read.map_err(|error| ExportError::Read { line: self.number, error })?;
        if read == 0 {
            return Err(self.wrong("the file ends before its `end` line: it was cut short"));
        }
        if bytes.len() as u64 > LINE_BYTES_MAX {
            return Err(self.wrong(format!("it is longer than {LINE_BYTES_MAX} bytes, the limit")));
        }
        Ok(bytes)
    }

    /// Whether nothing follows.
    fn over(&mut self) -> Result<(), ExportError> {
        match self.from.fill_buf() {
            Ok([]) => Ok(()),
            Ok(_) => {
                let problem = "something follows the `end` line".to_owned();
                Err(ExportError::Line { line: self.number + 1, problem })
            }
            Err(error) => Err(ExportError::Read { line: self.number, error }),
        }
    }
}

#[cfg(test)]
mod tests;
