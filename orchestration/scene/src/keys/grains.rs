//! Keys of a grain population: `[[grains]]`.

use std::fmt;

use schemars::JsonSchema;
use serde::de::{Error, MapAccess, Visitor, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};

use super::numbers::Numbers;
use super::ranges::{exactly_one_of, grain_properties, one_or_more, positive, solid_fraction};

/// One population of grains: exactly one of cloud, lattice, box and file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = exactly_one_of(&["cloud", "lattice", "box", "file"]), transform = grain_properties)]
pub struct Grains<const D: usize> {
    /// Density (kg/m³); required unless the file has a column for it.
    #[schemars(transform = positive)]
    pub density: Option<f64>,
    /// Radius (m), or { min, max }; required unless they come from a file.
    pub radius: Option<Radius>,
    /// Initial velocity (m/s).
    #[serde(default)]
    pub velocity: Numbers<f64, D>,
    /// Grains that never move.
    #[serde(default)]
    pub fixed: bool,
    /// A round cloud.
    pub cloud: Option<Cloud<D>>,
    /// A regular lattice in a rectangle or box.
    pub lattice: Option<Lattice<D>>,
    /// A rectangle or box filled at random.
    #[serde(rename = "box")]
    pub filled_box: Option<FilledBox<D>>,
    /// CSV file beside the scene: x, y, radius[, density][, vx, vy][, fixed]; in space z and vz too.
    pub file: Option<String>,
}

/// One radius, or uniformly distributed between two.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Radius {
    /// All grains alike (m).
    #[schemars(transform = positive)]
    One(f64),
    /// Uniformly distributed.
    Range(RadiusRange),
}

/// Bounds of the radius.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RadiusRange {
    /// Smallest (m).
    #[schemars(transform = positive)]
    pub min: f64,
    /// Largest (m).
    #[schemars(transform = positive)]
    pub max: f64,
}

impl Radius {
    /// Smallest radius (m).
    pub fn min(self) -> f64 {
        match self {
            Radius::One(radius) => radius,
            Radius::Range(range) => range.min,
        }
    }

    /// Largest radius (m).
    pub fn max(self) -> f64 {
        match self {
            Radius::One(radius) => radius,
            Radius::Range(range) => range.max,
        }
    }
}

/// A round cloud; the centres of the grains lie within its radius.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = exactly_one_of(&["solid_fraction", "count"]))]
pub struct Cloud<const D: usize> {
    /// Centre (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub centre: [f64; D],
    /// Radius of the cloud (m).
    #[schemars(transform = positive)]
    pub radius: f64,
    /// Share of the cloud's area, in space its volume, that grains take; or give the count.
    #[schemars(transform = solid_fraction)]
    pub solid_fraction: Option<f64>,
    /// Number of grains; or give the solid fraction.
    #[schemars(transform = one_or_more)]
    pub count: Option<usize>,
    /// Seed of the random numbers.
    #[serde(default = "first_seed")]
    pub seed: u64,
    /// "random" without overlap, or in the plane "sunflower" (even, without randomness).
    #[serde(default)]
    pub arrangement: Arrangement,
}

/// How the grains of a cloud are placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "kebab-case")]
pub enum Arrangement {
    /// At random, without overlap.
    #[default]
    Random,
    /// On a spiral with the golden angle: even, without randomness.
    Sunflower,
}

/// A regular lattice in a rectangle or box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = exactly_one_of(&["spacing", "solid_fraction"]))]
pub struct Lattice<const D: usize> {
    /// Lower corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub lower: [f64; D],
    /// Upper corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub upper: [f64; D],
    /// Distance between neighbours (m); or give the solid fraction.
    #[schemars(transform = positive)]
    pub spacing: Option<f64>,
    /// Share of the area, in space the volume, that grains take; whole cells fill the rectangle.
    #[schemars(transform = solid_fraction)]
    pub solid_fraction: Option<f64>,
    /// "square", in space "cubic", or "hexagonal" (close-packed layers).
    #[serde(default)]
    pub pattern: Pattern,
    /// Seed of the radii when they are distributed.
    #[serde(default = "first_seed")]
    pub seed: u64,
}

/// Pattern of a lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// Rows above each other.
    #[default]
    Square,
    /// The same in space.
    Cubic,
    /// Every second row shifted by half a spacing; in space layers of such rows, every second one in the
    /// hollows of the others.
    Hexagonal,
}

/// A rectangle or box filled at random without overlap.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = exactly_one_of(&["solid_fraction", "count"]))]
pub struct FilledBox<const D: usize> {
    /// Lower corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub lower: [f64; D],
    /// Upper corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub upper: [f64; D],
    /// Share of the area, in space the volume, that grains take; or give the count.
    #[schemars(transform = solid_fraction)]
    pub solid_fraction: Option<f64>,
    /// Number of grains; or give the solid fraction.
    #[schemars(transform = one_or_more)]
    pub count: Option<usize>,
    /// Seed of the random numbers.
    #[serde(default = "first_seed")]
    pub seed: u64,
}

fn first_seed() -> u64 {
    1
}

// By hand and not `untagged`, so that messages stay exact.
impl<'de> Deserialize<'de> for Radius {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(RadiusVisitor)
    }
}

struct RadiusVisitor;

impl<'de> Visitor<'de> for RadiusVisitor {
    type Value = Radius;

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "a radius in m, or {{ min = …, max = … }}")
    }
    fn visit_f64<E: Error>(self, value: f64) -> Result<Radius, E> {
        Ok(Radius::One(value))
    }
    fn visit_i64<E: Error>(self, value: i64) -> Result<Radius, E> {
        Ok(Radius::One(value as f64))
    }
    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Radius, A::Error> {
        RadiusRange::deserialize(MapAccessDeserializer::new(map)).map(Radius::Range)
    }
}
