//! A boundary condition as a scene writes it: a name alone, or a table with one name.

use std::collections::BTreeMap;
use std::fmt;

use protocol::scene::{Boundary, Profile};
use schemars::JsonSchema;
use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{Error, IntoDeserializer, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Conditions by the names of their boundaries.
type Boundaries<const D: usize> = BTreeMap<String, Boundary<[f64; D]>>;

/// A condition on a boundary; velocities are superficial.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum BoundaryKey<const D: usize> {
    /// Without numbers.
    Alone(Alone),
    /// With numbers.
    With(With<D>),
}

/// Conditions without numbers.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Alone {
    /// u = 0.
    NoSlip,
    /// u·n = 0, no tangential traction.
    Slip,
    /// Joined with the opposite side of the rectangle or box.
    Periodic,
}

/// Conditions with numbers.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum With<const D: usize> {
    /// A wall that moves along itself: u = velocity.
    NoSlip {
        /// Velocity of the wall (m/s).
        #[serde(with = "super::numbers")]
        #[schemars(with = "super::numbers::Numeric")]
        velocity: [f64; D],
    },
    /// Velocity given; along the boundary it is that of a moving wall.
    Inflow {
        /// Superficial velocity (m/s); the largest one when parabolic.
        #[serde(with = "super::numbers")]
        #[schemars(with = "super::numbers::Numeric")]
        velocity: [f64; D],
        /// Shape across the boundary: "uniform" or "parabolic".
        #[serde(default)]
        profile: Profile,
    },
    /// Pressure given at the highest point, hydrostatic (ρ g) along the boundary.
    Open {
        /// Pressure (Pa).
        pressure: f64,
    },
}

impl<const D: usize> From<BoundaryKey<D>> for Boundary<[f64; D]> {
    fn from(key: BoundaryKey<D>) -> Self {
        match key {
            BoundaryKey::Alone(Alone::NoSlip) => Boundary::NoSlip,
            BoundaryKey::Alone(Alone::Slip) => Boundary::Slip,
            BoundaryKey::Alone(Alone::Periodic) => Boundary::Periodic,
            BoundaryKey::With(With::NoSlip { velocity }) => Boundary::MovingWall { velocity },
            BoundaryKey::With(With::Inflow { velocity, profile }) => {
                Boundary::Inflow { velocity, profile }
            }
            BoundaryKey::With(With::Open { pressure }) => Boundary::Open { pressure },
        }
    }
}

impl<const D: usize> From<&Boundary<[f64; D]>> for BoundaryKey<D> {
    fn from(boundary: &Boundary<[f64; D]>) -> Self {
        match *boundary {
            Boundary::NoSlip => BoundaryKey::Alone(Alone::NoSlip),
            Boundary::Slip => BoundaryKey::Alone(Alone::Slip),
            Boundary::Periodic => BoundaryKey::Alone(Alone::Periodic),
            Boundary::MovingWall { velocity } => BoundaryKey::With(With::NoSlip { velocity }),
            Boundary::Inflow { velocity, profile } => {
                BoundaryKey::With(With::Inflow { velocity, profile })
            }
            Boundary::Open { pressure } => BoundaryKey::With(With::Open { pressure }),
        }
    }
}

/// For `#[serde(with)]` of a map of conditions.
pub mod map {
    use super::*;

    /// From a scene.
    pub fn deserialize<'de, S: Deserializer<'de>, const D: usize>(
        source: S,
    ) -> Result<Boundaries<D>, S::Error> {
        let keys = BTreeMap::<String, BoundaryKey<D>>::deserialize(source)?;
        Ok(keys
            .into_iter()
            .map(|(name, key)| (name, key.into()))
            .collect())
    }

    /// Into a scene.
    pub fn serialize<S: Serializer, const D: usize>(
        boundaries: &Boundaries<D>,
        out: S,
    ) -> Result<S::Ok, S::Error> {
        let keys = boundaries.iter();
        out.collect_map(keys.map(|(name, boundary)| (name, BoundaryKey::from(boundary))))
    }
}

// By hand and not `untagged`, so that messages stay exact.
impl<'de, const D: usize> Deserialize<'de> for BoundaryKey<D> {
    fn deserialize<S: Deserializer<'de>>(deserializer: S) -> Result<Self, S::Error> {
        deserializer.deserialize_any(KeyVisitor)
    }
}

struct KeyVisitor<const D: usize>;

impl<'de, const D: usize> Visitor<'de> for KeyVisitor<D> {
    type Value = BoundaryKey<D>;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "a condition such as \"no-slip\", or {{ open = {{ pressure = 0.0 }} }}"
        )
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<BoundaryKey<D>, E> {
        const NAMES: &[&str] = &["no-slip", "slip", "periodic", "inflow", "open"];
        match word {
            "inflow" => Err(E::custom(
                "write { inflow = { velocity = [ux, uy] } } (m/s)",
            )),
            "open" => Err(E::custom("write { open = { pressure = 0.0 } } (Pa)")),
            _ if !NAMES.contains(&word) => Err(E::unknown_variant(word, NAMES)),
            _ => {
                let name: StrDeserializer<'_, E> = word.into_deserializer();
                Alone::deserialize(name).map(BoundaryKey::Alone)
            }
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<BoundaryKey<D>, A::Error> {
        With::deserialize(MapAccessDeserializer::new(map)).map(BoundaryKey::With)
    }
}
