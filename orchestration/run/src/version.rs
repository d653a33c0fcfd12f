//! What this program is.

use serde_json::{Value, json};

/// Version of the programs.
pub const SILLAGE: &str = env!("CARGO_PKG_VERSION");

/// Version of the transport.
pub const ICEORYX2: &str = env!("SILLAGE_ICEORYX2");

/// The commit that the programs were built from, when it is known.
pub fn commit() -> Option<&'static str> {
    Some(env!("SILLAGE_COMMIT")).filter(|commit| !commit.is_empty())
}

/// Versions that matter for a result.
pub fn all() -> Value {
    json!({
        "sillage": SILLAGE,
        "protocol": protocol::PROTOCOL_VERSION,
        "commit": commit(),
    })
}
