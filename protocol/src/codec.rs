//! Values of tools' requests and answers to bytes and back. The only file that names bincode.

use crate::limits::ANSWER_BYTES_MAX;

/// Why bytes could not be made or read.
#[derive(Debug, thiserror::Error)]
pub enum CodecError {
    /// The value cannot be written, mostly because it is longer than the limit.
    #[error("the value cannot be encoded within {ANSWER_BYTES_MAX} bytes: {0}")]
    Encode(String),
    /// The bytes are not such a value.
    #[error("{length} bytes are not what was expected: {problem}")]
    Decode {
        /// How many bytes there were.
        length: usize,
        /// What is wrong with them.
        problem: String,
    },
}

/// A limit on what a forged length can make the reader allocate.
fn config() -> impl bincode::config::Config {
    bincode::config::standard().with_limit::<ANSWER_BYTES_MAX>()
}

/// `value` as bytes.
///
/// # Errors
/// When the value is longer than [`ANSWER_BYTES_MAX`] or cannot be represented.
pub fn encode<T: serde::Serialize>(value: &T) -> Result<Vec<u8>, CodecError> {
    let bytes = bincode::serde::encode_to_vec(value, config());
    let bytes = bytes.map_err(|error| CodecError::Encode(error.to_string()))?;
    if bytes.len() > ANSWER_BYTES_MAX {
        return Err(CodecError::Encode(format!("it has {} bytes", bytes.len())));
    }
    Ok(bytes)
}

/// The value that `bytes` are, all of them.
///
/// # Errors
/// When they are not such a value, or more follows it.
pub fn decode<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    let problem = |problem: String| CodecError::Decode { length: bytes.len(), problem };
    let (value, used) =
        bincode::serde::decode_from_slice(bytes, config()).map_err(|error| problem(error.to_string()))?;
    if used != bytes.len() {
        return Err(problem(format!("{} bytes are left over", bytes.len() - used)));
    }
    Ok(value)
}
