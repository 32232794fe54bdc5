//! Requests and answers to bytes and back.
//!
//! The bytes are one JSON value. What is left over after it is refused. What a peer sends can't make a reader take memory
//! without bound: the transport bounds the bytes, a value takes at most some tens of times as much memory as its bytes, and
//! serde_json refuses what is nested deeper than 128 times.

use std::io::{self, Write};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Longest request or answer that is made, in bytes.
pub const MESSAGE_BYTES_MAX: usize = 16 * 1024 * 1024;

/// Why bytes could not be made or read.
#[derive(Debug, thiserror::Error)]
pub enum CodecError {
    /// The value cannot be written, mostly because it is longer than the limit.
    #[error("the value cannot be encoded within {MESSAGE_BYTES_MAX} bytes: {0}")]
    Encode(#[source] serde_json::Error),
    /// The bytes are not such a value.
    #[error("{length} bytes are not what was expected: {problem}")]
    Decode {
        /// How many bytes there were.
        length: usize,
        /// What is wrong with them.
        problem: serde_json::Error,
    },
}

/// A request that is not answered, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(transparent)]
#[error("{0}")]
pub struct Problem(pub String);

impl Problem {
    /// A problem that is told as `error` is.
    pub fn of(error: impl std::fmt::Display) -> Self {
        Self(error.to_string())
    }
}

/// What comes back for a request: its answer, or why there is none.
///
/// In JSON `{"answer": …}` or `{"problem": "there is no schema 9: they are numbered 0 to 8"}`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reply<A> {
    /// The answer.
    Answer(A),
    /// Why there is none, and what to do.
    Problem(Problem),
}

impl<A> From<Reply<A>> for Result<A, Problem> {
    fn from(reply: Reply<A>) -> Self {
        match reply {
            Reply::Answer(answer) => Ok(answer),
            Reply::Problem(problem) => Err(problem),
        }
    }
}

impl<A> From<Result<A, Problem>> for Reply<A> {
    fn from(result: Result<A, Problem>) -> Self {
        result.map_or_else(Reply::Problem, Reply::Answer)
    }
}

/// Takes bytes as long as there are not too many.
struct Bounded(Vec<u8>);

impl Write for Bounded {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.0.len().saturating_add(bytes.len()) > MESSAGE_BYTES_MAX {
            return Err(io::Error::other("it is longer"));
        }
        self.0.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The JSON of `value`.
///
/// # Errors
/// When it is longer than [`MESSAGE_BYTES_MAX`].
pub fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, CodecError> {
    let mut to = Bounded(Vec::new());
    serde_json::to_writer(&mut to, value).map_err(CodecError::Encode)?;
    Ok(to.0)
}

/// The value that `bytes` are, all of them.
///
/// # Errors
/// When they are not such a value, or more follows it.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    serde_json::from_slice(bytes).map_err(|problem| CodecError::Decode { length: bytes.len(), problem })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Request, StatusQuery, ValueText};

    #[test]
    fn what_is_left_over_is_refused() {
        let request = Request::from(StatusQuery {});
        let mut bytes = encode(&request).unwrap();
        assert_eq!(decode::<Request>(&bytes).unwrap(), request);
        bytes.push(b' ');
        assert_eq!(decode::<Request>(&bytes).unwrap(), request, "white space is nothing");
        bytes.push(b'1');
        let error = decode::<Request>(&bytes).unwrap_err().to_string();
        assert!(error.contains("28 bytes") && error.contains("trailing"), "{error}");
    }

    #[test]
    fn what_is_too_long_is_refused_before_it_is_made() {
        let text = "x".repeat(MESSAGE_BYTES_MAX - 2);
        assert_eq!(encode(&text).unwrap().len(), MESSAGE_BYTES_MAX);
        let error = encode(&(text + "x")).unwrap_err().to_string();
        assert!(error.contains("16777216 bytes: it is longer"), "{error}");
    }

    #[test]
    fn what_is_nested_too_deep_is_refused() {
        for bytes in [b"[".repeat(1_000_000), br#"{"question":"#.repeat(100_000)] {
            assert!(decode::<Request>(&bytes).is_err());
            assert!(decode::<serde_json::Value>(&bytes).is_err());
        }
    }

    #[test]
    fn a_reply_is_an_answer_or_a_problem() {
        let done = encode(&Reply::Answer(())).unwrap();
        assert_eq!(done, br#"{"answer":null}"#);
        assert_eq!(decode::<Reply<()>>(&done).unwrap(), Reply::Answer(()));
        let not = encode(&Reply::<()>::Problem(Problem("no".to_owned()))).unwrap();
        assert_eq!(not, br#"{"problem":"no"}"#);
        assert_eq!(Result::from(decode::<Reply<()>>(&not).unwrap()), Err(Problem::of("no")));
    }

    #[test]
    fn figures_that_overflow_break_no_answer() {
        let endless = [ValueText::Real(f64::INFINITY), ValueText::Real(1.0), ValueText::Integer(1)];
        let bytes = encode(&endless).unwrap();
        assert_eq!(bytes, b"[null,1.0,1]");
        let back: Vec<ValueText> = decode(&bytes).unwrap();
        assert!(
            matches!(back[..], [ValueText::Real(nan), ValueText::Real(1.0), ValueText::Integer(1)] if nan.is_nan())
        );
    }
}
