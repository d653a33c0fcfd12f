//! Is the convection of the fluid there: never, always, or where it matters?
//!
//! In scenes, recordings and JSON it is `false`, `true` or `"auto"`; in a message one byte, 0, 1 or 2.
//! The first two are those of a `bool`, which is what engines that know nothing else read.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Reynolds number of the creeping flow below which an engine leaves convection out where it may: what
/// that changes is about this part of the velocity.
pub const CREEPING_REYNOLDS: f64 = 1e-3;

/// ρφ v·∇v in the fluid's equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convection {
    /// Left out: creeping flow.
    Never,
    /// Always there.
    Always,
    /// The engine leaves it out while its own estimate of the term is small; sent only to engines
    /// with `Capability::ConvectionAsNeeded`.
    AsNeeded,
}

const AUTO: &str = "auto";

impl From<bool> for Convection {
    fn from(always: bool) -> Convection {
        match always {
            true => Convection::Always,
            false => Convection::Never,
        }
    }
}

impl JsonSchema for Convection {
    fn schema_name() -> Cow<'static, str> {
        "Convection".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "enum": [true, false, AUTO] })
    }
}

impl Serialize for Convection {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        match (self, out.is_human_readable()) {
            (Convection::AsNeeded, true) => out.serialize_str(AUTO),
            (Convection::AsNeeded, false) => out.serialize_u8(2),
            (Convection::Always, _) => out.serialize_bool(true),
            (Convection::Never, _) => out.serialize_bool(false),
        }
    }
}

impl<'de> Deserialize<'de> for Convection {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Convection, D::Error> {
        if source.is_human_readable() {
            return source.deserialize_any(Words);
        }
        match u8::deserialize(source)? {
            0 => Ok(Convection::Never),
            1 => Ok(Convection::Always),
            2 => Ok(Convection::AsNeeded),
            other => Err(de::Error::custom(format!(
                "{other} for convection, must be 0 (never), 1 (always) or 2 (as needed)"
            ))),
        }
    }
}

/// Reads `true`, `false` and `"auto"`.
struct Words;

impl Visitor<'_> for Words {
    type Value = Convection;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "true, false or \"{AUTO}\"")
    }

    fn visit_bool<E: de::Error>(self, always: bool) -> Result<Convection, E> {
        Ok(always.into())
    }

    fn visit_str<E: de::Error>(self, word: &str) -> Result<Convection, E> {
        match word {
            AUTO => Ok(Convection::AsNeeded),
            _ => Err(de::Error::invalid_value(de::Unexpected::Str(word), &self)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::language::codec;

    #[test]
    fn words_and_bytes_read_back_and_two_of_them_are_those_of_a_bool() {
        for (convection, word) in [
            (Convection::Never, "false"),
            (Convection::Always, "true"),
            (Convection::AsNeeded, "\"auto\""),
        ] {
            let json = serde_json::to_string(&convection).expect("JSON");
            let bytes = codec::encode(&convection).expect("bytes");
            println!("{convection:?}: {json}, {bytes:?}");
            assert_eq!(json, word);
            let back: Convection = serde_json::from_str(&json).expect("JSON");
            assert_eq!(back, convection);
            let back: Convection = codec::decode(&bytes).expect("bytes");
            assert_eq!(back, convection);
            let as_bool = codec::decode::<bool>(&bytes).ok();
            assert_eq!(
                as_bool.map(Convection::from),
                (convection != Convection::AsNeeded).then_some(convection)
            );
        }
        let wrong = serde_json::from_str::<Convection>("\"on\"").expect_err("not a word of it");
        assert!(wrong.to_string().contains("auto"), "{wrong}");
        assert!(codec::decode::<Convection>(&[3]).is_err());
    }
}
