//! Vectors of a scene: as many numbers as it has dimensions.

use std::fmt;
use std::marker::PhantomData;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A vector where it stands within another key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers<T, const D: usize>(pub [T; D]);

/// What a vector is to an editor, in whichever dimension the scene is.
pub type Numeric = Numbers<f64, 3>;

fn list(items: Schema) -> Schema {
    json_schema!({ "type": "array", "items": items, "minItems": 2, "maxItems": 3 })
}

impl<T: Copy + Default, const D: usize> Default for Numbers<T, D> {
    fn default() -> Self {
        Numbers([T::default(); D])
    }
}

impl<T, const D: usize> AsRef<[T]> for Numbers<T, D> {
    fn as_ref(&self) -> &[T] {
        &self.0
    }
}

impl<'de, T: Deserialize<'de> + Copy + Default, const D: usize> Deserialize<'de> for Numbers<T, D> {
    fn deserialize<S: Deserializer<'de>>(source: S) -> Result<Self, S::Error> {
        deserialize(source).map(Numbers)
    }
}

impl<T: Serialize, const D: usize> Serialize for Numbers<T, D> {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.collect_seq(&self.0)
    }
}

impl<T: JsonSchema, const D: usize> JsonSchema for Numbers<T, D> {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        format!("Numbers{}", T::schema_name()).into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        list(generator.subschema_for::<T>())
    }
}

/// From a scene, for `#[serde(with)]`.
pub fn deserialize<'de, S, T, const D: usize>(source: S) -> Result<[T; D], S::Error>
where
    S: Deserializer<'de>,
    T: Deserialize<'de> + Copy + Default,
{
    source.deserialize_seq(List(PhantomData))
}

/// Into a scene.
pub fn serialize<S: Serializer, T: Serialize, const D: usize>(
    numbers: &[T; D],
    out: S,
) -> Result<S::Ok, S::Error> {
    out.collect_seq(numbers)
}

/// What a vector looks like.
pub fn form(dimension: usize) -> &'static str {
    match dimension {
        2 => "two numbers [x, y]",
        _ => "three numbers [x, y, z]",
    }
}

struct List<T, const D: usize>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Copy + Default, const D: usize> Visitor<'de> for List<T, D> {
    type Value = [T; D];

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(form(D))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<[T; D], A::Error> {
        let mut numbers = [T::default(); D];
        let mut count = 0;
        while count < D {
            let Some(number) = list.next_element()? else {
                break;
            };
            numbers[count] = number;
            count += 1;
        }
        while count >= D && list.next_element::<IgnoredAny>()?.is_some() {
            count += 1;
        }
        match count == D {
            true => Ok(numbers),
            false => Err(Error::invalid_length(count, &self)),
        }
    }
}
