//! Memory as JSON Lines: what a person or another program can read, and what a later release can always read back.
//! `docs/EXPORT.md` has it field by field.

mod lines;
mod reading;
mod values;
mod writing;

use std::io::{self, BufRead, Read, Write};

use pschema_learner::curriculum::Curriculum;
use pschema_learner::digest::digest;
use pschema_learner::memory::Content;
use pschema_learner::parameters::Parameters;

use crate::format::v1;
use lines::{EndLine, FORMAT, Line};
use reading::Reading;

/// The longest line: what a hostile file can have held in memory beside what it says.
pub const LINE_BYTES_MAX: u64 = 16 * 1024 * 1024;

/// What a memory lives under, beside what it knows.
#[derive(Clone, Copy, Debug)]
pub struct About<'a> {
    /// The learner's name.
    pub learner: &'a str,
    /// Where its randomness began.
    pub seed: u64,
    /// Its numbers and switches.
    pub parameters: &'a Parameters,
    /// What it is led through.
    pub curriculum: &'a Curriculum,
}

impl About<'_> {
    fn setting(&self) -> v1::Setting {
        v1::Setting::new(self.parameters, self.curriculum)
    }
}

/// Why an export can't be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A line is wrong.
    #[error("line {line}: {problem}")]
    Line {
        /// Its number, from 1.
        line: u64,
        /// What is wrong with it.
        problem: String,
    },
    /// It can't be read to its end.
    #[error("line {line} can't be read: {error}")]
    Read {
        /// The line's number, from 1.
        line: u64,
        /// Why.
        #[source]
        error: io::Error,
    },
    /// It can't be written.
    #[error("it can't be written: {0}")]
    Write(#[source] io::Error),
}

/// What was written or read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lines {
    /// How many lines.
    pub lines: u64,
    /// The digest of the memory.
    pub memory_digest: String,
}

/// Writes all of a memory; `told` hears of each line that is done.
///
/// # Errors
/// When it can't be written.
pub fn write(
    content: &Content,
    about: About<'_>,
    to: &mut dyn Write,
    mut told: impl FnMut(u64),
) -> Result<Lines, ExportError> {
    let (mut lines, mut memory_digest) = (0, String::new());
    let mut put = |line: &Line| {
        serde_json::to_writer(&mut *to, line).map_err(io::Error::from)?;
        to.write_all(b"\n")
    };
    for line in writing::lines(content, &about) {
        put(&line).map_err(ExportError::Write)?;
        lines += 1;
        if let Line::Pschema(header) = line {
            memory_digest = header.memory_digest;
        }
        told(lines);
    }
    lines += 1;
    let end = EndLine { lines, memory_digest: memory_digest.clone() };
    put(&Line::End(end)).and_then(|()| to.flush()).map_err(ExportError::Write)?;
    Ok(Lines { lines, memory_digest })
}

/// A memory that was read.
#[derive(Clone, Debug)]
pub struct Imported {
    /// What it knows.
    pub content: Content,
    /// The learner's name.
    pub learner: String,
    /// Where its randomness began.
    pub seed: u64,
    /// Its numbers and switches.
    pub parameters: Parameters,
    /// What it is led through.
    pub curriculum: Curriculum,
    /// How many lines there were, and the digest, which is that of the memory that was written.
    pub lines: Lines,
}

/// Reads what [`write()`] wrote. All of it is checked; what it takes in memory is in proportion to what was read.
///
/// # Errors
/// The first line that is wrong, and why; or that the lines together are not the memory that was written.
pub fn read(from: &mut dyn BufRead, mut told: impl FnMut(u64)) -> Result<Imported, ExportError> {
    let mut reading: Option<Reading> = None;
    let mut number = 0;
    let end = loop {
        number += 1;
        let wrong = |problem| ExportError::Line { line: number, problem };
        let Some(line) = line(from, number)? else {
            let problem = "it ends before its `end` line: the file was cut short".to_owned();
            return Err(wrong(problem));
        };
        match (line, &mut reading) {
            (Line::End(end), Some(_)) => break end,
            (line, None) => reading = Some(Reading::begin(line).map_err(wrong)?),
            (line, Some(reading)) => reading.take(line).map_err(wrong)?,
        }
        told(number);
    };
    let wrong = |problem| ExportError::Line { line: number, problem };
    if end.lines != number {
        return Err(wrong(format!("there are {number} lines, and {} were written", end.lines)));
    }
    if !from.fill_buf().map_err(|error| ExportError::Read { line: number, error })?.is_empty() {
        return Err(ExportError::Line {
            line: number + 1,
            problem: "something follows the `end` line".to_owned(),
        });
    }
    let Some(reading) = reading else { return Err(wrong("there is nothing before the end".to_owned())) };
    let (header, content) = reading.end().map_err(wrong)?;
    let content = checked(&content, &header.setting).map_err(|error| wrong(error.to_string()))?;
    let found = digest(&content);
    if found != header.memory_digest || found != end.memory_digest {
        return Err(wrong(format!(
            "what it says has digest {found}, and the memory that was written had {}: a line was changed or lost",
            header.memory_digest
        )));
    }
    let (parameters, curriculum) = header.setting.live().map_err(|error| wrong(error.to_string()))?;
    let lines = Lines { lines: number, memory_digest: found };
    let (learner, seed) = (header.learner, header.seed);
    Ok(Imported { content, learner, seed, parameters, curriculum, lines })
}

/// The next line; none at the end.
fn line(from: &mut dyn BufRead, number: u64) -> Result<Option<Line>, ExportError> {
    let wrong = |problem| ExportError::Line { line: number, problem };
    let mut bytes = Vec::new();
    let read = from.take(LINE_BYTES_MAX + 1).read_until(b'\n', &mut bytes);
    let read = read.map_err(|error| ExportError::Read { line: number, error })?;
    if read == 0 {
        return Ok(None);
    }
    if bytes.len() as u64 > LINE_BYTES_MAX {
        return Err(wrong(format!("it is longer than {LINE_BYTES_MAX} bytes, the limit")));
    }
    let line = serde_json::from_slice(&bytes);
    line.map(Some).map_err(|error| wrong(format!("it is not a line of an export: {error}")))
}

/// The same content, after every number in it was found to refer to something that is there.
fn checked(content: &Content, setting: &v1::Setting) -> Result<Content, v1::Impossible> {
    let mut reading: Option<v1::Reading> = None;
    for block in v1::blocks(content, setting) {
        match (block, &mut reading) {
            (v1::Block::Facts(facts), None) => reading = Some(v1::Reading::begin(*facts)),
            (block, Some(reading)) => reading.take(block)?,
            (_, None) => return Err(v1::Impossible("a block")),
        }
    }
    Ok(reading.ok_or(v1::Impossible("a block"))?.end()?.content)
}

#[cfg(test)]
mod tests;
