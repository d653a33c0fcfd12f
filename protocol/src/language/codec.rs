//! Control messages as bytes: bincode 2, standard configuration (little endian, variable-length
//! integers), at most [`LIMIT`] bytes in both directions, nothing after the message. What is kept in files is
//! written alike, without a limit.

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
    whole(bytes, configuration())
}

/// The bytes of what is kept in a file, as long as it is.
pub fn encode_file<T: Serialize>(content: &T) -> Result<Vec<u8>, CodecError> {
    bincode::serde::encode_to_vec(content, bincode::config::standard())
        .map_err(|error| CodecError::Malformed(error.to_string()))
}

/// The content of such a file. Lengths that damaged bytes claim ask for no more memory than a multiple of the
/// bytes that are there.
pub fn decode_file<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, CodecError> {
    // A number takes 8 bytes at most, and one of the file at least. The library's limits are types.
    let standard = bincode::config::standard;
    match bytes.len().saturating_mul(8) {
        most if most <= 0x1_0000 => whole(bytes, standard().with_limit::<0x1_0000>()),
        most if most <= 0x10_0000 => whole(bytes, standard().with_limit::<0x10_0000>()),
        most if most <= 0x100_0000 => whole(bytes, standard().with_limit::<0x100_0000>()),
        most if most <= 0x1000_0000 => whole(bytes, standard().with_limit::<0x1000_0000>()),
        most if most <= 0x1_0000_0000 => whole(bytes, standard().with_limit::<0x1_0000_0000>()),
        _ => whole(bytes, standard().with_limit::<0x100_0000_0000>()),
    }
}

/// What is in these bytes, which must end where it ends.
fn whole<T: DeserializeOwned>(
    bytes: &[u8],
    by: impl bincode::config::Config,
) -> Result<T, CodecError> {
    let (content, length) = bincode::serde::decode_from_slice(bytes, by)
        .map_err(|error| CodecError::Malformed(error.to_string()))?;
    match bytes.len() - length {
        0 => Ok(content),
        extra => Err(CodecError::Trailing { length, extra }),
    }
}
