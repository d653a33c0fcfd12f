//! Keys of where grains may go: `[particles]` and `[[walls]]`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where grains may go.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Particles {
    /// "domain": the sides of the domain that are neither periodic nor open; "none".
    #[serde(default)]
    pub walls: DefaultWalls,
    /// The rectangle of a scene without fluid, or one that differs from the fluid's.
    pub domain: Option<GrainDomain>,
}

/// Walls made from the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "kebab-case")]
pub enum DefaultWalls {
    /// A wall on every side that is neither periodic nor open.
    #[default]
    Domain,
    /// Only the segments written as `walls`.
    None,
}

/// Rectangle of the grains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainDomain {
    /// Lower left corner (m).
    pub lower: [f64; 2],
    /// Upper right corner (m).
    pub upper: [f64; 2],
    /// Sides without a wall: any of "left", "right", "bottom", "top".
    #[serde(default)]
    pub open: Vec<Side>,
    /// Periodic in x and y.
    #[serde(default)]
    pub periodic: [bool; 2],
}

/// A side of a rectangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Smallest x.
    Left,
    /// Largest x.
    Right,
    /// Smallest y.
    Bottom,
    /// Largest y.
    Top,
}

/// A wall segment; grains stay on the left of from → to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallSegment {
    /// Start (m).
    pub from: [f64; 2],
    /// End (m).
    pub to: [f64; 2],
}
