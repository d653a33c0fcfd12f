//! Keys of where grains may go: `[particles]` and `[[walls]]`.

use std::collections::BTreeMap;

use protocol::scene::GrainBoundary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where grains may go.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields)]
pub struct Particles {
    /// "domain": the walls of the fluid's rectangle or mesh, and of `domain` where it is given; "none".
    #[serde(default)]
    pub walls: DefaultWalls,
    /// The rectangle of a scene without fluid, or one that differs from the fluid's; walls that lie on
    /// those of a mesh are the same ones.
    pub domain: Option<GrainDomain>,
    /// What grains meet where fluid flows in or out, by the name of the boundary: "wall" (without this key
    /// where it is inflow), "removed" (taken out where they leave; without it where it is open) or "open"
    /// (a grain that leaves ends the run). Sides that hold the fluid are walls.
    #[serde(default)]
    pub boundaries: BTreeMap<String, GrainBoundary>,
}

/// Walls made from the domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "kebab-case")]
pub enum DefaultWalls {
    /// A wall on every side that is neither periodic nor open, and where a mesh ends.
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

impl Side {
    /// Is its name one of these?
    pub fn name_is(self, names: &[&str]) -> bool {
        let name = match self {
            Side::Left => "left",
            Side::Right => "right",
            Side::Bottom => "bottom",
            Side::Top => "top",
        };
        names.contains(&name)
    }
}

/// A wall segment; grains stay on the left of from → to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WallSegment {
    /// Start (m).
    pub from: [f64; 2],
    /// End (m).
    pub to: [f64; 2],
    /// Velocity along itself (m/s), which rubs on the grains; where the wall is does not change.
    pub velocity: Option<[f64; 2]>,
}
