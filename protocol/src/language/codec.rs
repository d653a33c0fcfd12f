//! Control messages as bytes: bincode 2, standard configuration (little endian, variable-length
//! integers), at most [`LIMIT`] bytes in both directions, nothing after the message.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// Largest encoded message \[bytes\].
pub const LIMIT: usize = 64 * 1024;

/// Why bytes are not a message, or a message not bytes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CodecError {
    /// The message is larger than [`LIMIT`].
    #[error("message of {length} bytes, at most {LIMIT} are allowed")]
    TooLong {
        /// Its length \[bytes\].
        length: usize,
    },
    /// Bytes are left after the message.
    #[error("{extra} bytes after a message of {length}")]
    Trailing {
        /// Bytes the message took.
        length: usize,
        /// Bytes after it.
        extra: usize,
    },
    /// The bytes are no message of this type.
    #[error("not a message: {0}")]
    Malformed(String),
}

fn configuration() -> impl bincode::config::Config {
    bincode::config::standard().with_limit::<LIMIT>()
}

/// The bytes of a message.
pub fn encode<T: Serialize>(message: &T) -> Result<Vec<u8>, CodecError> {
    let bytes = bincode::serde::encode_to_vec(message, configuration())
        .map_err(|error| CodecError::Malformed(error.to_string()))?;
    // The library's limit holds for decoding only.
    if bytes.len() > LIMIT {
        return Err(CodecError::TooLong {
            length: bytes.len(),
        });
    }
    Ok(bytes)
}

/// The message in these bytes, which must end where it ends.
pub fn decode<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    if bytes.len() > LIMIT {
        return Err(CodecError::TooLong {
            length: bytes.len(),
        });
    }
    let (message, length) = bincode::serde::decode_from_slice(bytes, configuration())
        .map_err(|error| CodecError::Malformed(error.to_string()))?;
    if length != bytes.len() {
        return Err(CodecError::Trailing {
            length,
            extra: bytes.len() - length,
        });
    }
    Ok(message)
}
