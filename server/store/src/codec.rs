//! Values of the format to bytes and back. The only file that names bincode.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// The longest value, in bytes: what a forged length can have the reader allocate.
pub(crate) const VALUE_BYTES_MAX: usize = 64 * 1024 * 1024;

/// Why bytes could not be made or read.
#[derive(Debug, thiserror::Error)]
pub enum CodecError {
    /// The value cannot be written, mostly because it is longer than the limit.
    #[error("the value cannot be written within {VALUE_BYTES_MAX} bytes: {0}")]
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

fn config() -> impl bincode::config::Config {
    bincode::config::standard().with_limit::<VALUE_BYTES_MAX>()
}

/// The bytes of `value`.
pub(crate) fn encode<T: Serialize>(value: &T) -> Result<Vec<u8>, CodecError> {
    let mut bytes = Vec::new();
    encode_onto(value, &mut bytes)?;
    Ok(bytes)
}

/// Appends the bytes of `value`.
pub(crate) fn encode_onto<T: Serialize>(value: &T, bytes: &mut Vec<u8>) -> Result<(), CodecError> {
    let written = bincode::serde::encode_into_std_write(value, bytes, config());
    match written.map_err(|error| CodecError::Encode(error.to_string()))? {
        length if length > VALUE_BYTES_MAX => Err(CodecError::Encode(format!("it has {length} bytes"))),
        _ => Ok(()),
    }
}

/// The value that `bytes` are, all of them.
pub(crate) fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    let (value, rest) = decode_first(bytes)?;
    if rest.is_empty() {
        return Ok(value);
    }
    Err(CodecError::Decode { length: bytes.len(), problem: format!("{} bytes are left over", rest.len()) })
}

/// The value at the beginning of `bytes`, and the bytes after it.
pub(crate) fn decode_first<T: DeserializeOwned>(bytes: &[u8]) -> Result<(T, &[u8]), CodecError> {
    let wrong = |problem: String| CodecError::Decode { length: bytes.len(), problem };
    let decoded = bincode::serde::decode_from_slice(bytes, config());
    let (value, used) = decoded.map_err(|error| wrong(error.to_string()))?;
    Ok((value, bytes.get(used..).unwrap_or_default()))
}
