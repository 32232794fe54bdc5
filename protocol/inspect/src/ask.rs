//! Asking: from a question to its answer, whatever carries the bytes.

use std::error::Error;

use crate::codec::{self, CodecError, Problem};
use crate::request::{Ask, Request};

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub enum AskError<E: Error> {
    /// The daemon says why it does not answer.
    #[error(transparent)]
    Problem(#[from] Problem),
    /// The request can't be written, or its reply not be read.
    #[error(transparent)]
    Codec(CodecError),
    /// The bytes were not carried.
    #[error(transparent)]
    Send(E),
}

/// Asks, or orders. `send` takes the bytes of a request to the daemon and brings the bytes of its reply: with
/// `pschema-protocol` that is `|request| client.request(request)`.
///
/// ```
/// use pschema_inspect::{AskError, DetailQuery, ask};
///
/// // A daemon that has learnt nothing.
/// let send = |_request: &[u8]| Ok::<_, std::io::Error>(br#"{"problem": "there is no schema 3"}"#.to_vec());
/// let answer = ask(DetailQuery { id: 3 }, send);
/// assert!(matches!(answer, Err(AskError::Problem(problem)) if problem.0.contains("no schema 3")));
/// ```
///
/// # Errors
/// [`AskError`].
pub fn ask<Q: Ask, E: Error>(
    asked: Q,
    send: impl FnOnce(&[u8]) -> Result<Vec<u8>, E>,
) -> Result<Q::Answer, AskError<E>> {
    let request: Request = asked.into();
    let request = codec::encode(&request).map_err(AskError::Codec)?;
    let reply = send(&request).map_err(AskError::Send)?;
    let reply: codec::Reply<Q::Answer> = codec::decode(&reply).map_err(AskError::Codec)?;
    Ok(Result::from(reply)?)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::{ReportQuery, ShutdownOrder};

    #[test]
    fn a_question_decides_what_its_answer_is_read_as() {
        let send = |_: &[u8]| Ok::<_, Infallible>(br#"{"answer":null}"#.to_vec());
        assert!(matches!(ask(ShutdownOrder {}, send), Ok(())));
        let error = ask(ReportQuery {}, send).unwrap_err();
        assert!(matches!(error, AskError::Codec(_)), "{error}");
    }
}
