//! Values of the disk format to bytes and back. The only file that names bincode.

/// The longest value: what a forged length can make the reader allocate.
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

pub(crate) fn encode<T: serde::Serialize>(value: &T) -> Result<Vec<u8>, CodecError> {
    let bytes = bincode::serde::encode_to_vec(value, config());
    let bytes = bytes.map_err(|error| CodecError::Encode(error.to_string()))?;
    if bytes.len() > VALUE_BYTES_MAX {
        return Err(CodecError::Encode(format!("it has {} bytes", bytes.len())));
    }
    Ok(bytes)
}

/// The value that `bytes` are, all of them.
pub(crate) fn decode<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    let problem = |problem: String| CodecError::Decode { length: bytes.len(), problem };
    let (value, used) =
        bincode::serde::decode_from_slice(bytes, config()).map_err(|error| problem(error.to_string()))?;
    if used != bytes.len() {
        return Err(problem(format!("{} bytes are left over", bytes.len() - used)));
    }
    Ok(value)
}
