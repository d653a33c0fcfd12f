//! Keys of where grains may go: `[particles]` and `[[walls]]`.

use std::collections::BTreeMap;

use protocol::scene::GrainBoundary;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::numbers::Numbers;
use super::ranges::{exactly_one_of, positive};

/// Where grains may go.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Particles<const D: usize> {
    /// "domain": the walls of the fluid's rectangle, box or mesh, and of `domain` where it is given; "none".
    #[serde(default)]
    pub walls: DefaultWalls,
    /// The rectangle or box of a scene without fluid, or one that differs from the fluid's; walls that lie on
    /// those of a mesh are the same ones.
    pub domain: Option<GrainDomain<D>>,
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
    /// Only those written as `walls`.
    None,
}

/// Rectangle or box of the grains.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GrainDomain<const D: usize> {
    /// Lower corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub lower: [f64; D],
    /// Upper corner (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "super::numbers::Numeric")]
    pub upper: [f64; D],
    /// Sides without a wall: any of "left", "right", "bottom", "top", in space "back", "front".
    #[serde(default)]
    pub open: Vec<Side>,
    /// Periodic in x and y, in space z.
    #[serde(default)]
    pub periodic: Numbers<bool, D>,
}

/// A side of a rectangle or box.
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
    /// Smallest z.
    Back,
    /// Largest z.
    Front,
}

/// All sides, two an axis.
pub const SIDES: [Side; 6] = [
    Side::Left,
    Side::Right,
    Side::Bottom,
    Side::Top,
    Side::Back,
    Side::Front,
];

/// A wall: in the plane a segment, grains stay on the left of from → to; in space a flat one with these corners,
/// grains stay on the side from which they are seen clockwise, or a round one, with grains inside.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = exactly_one_of(&["from", "corners", "cylinder"]))]
pub struct WallKeys<const D: usize> {
    /// In the plane: start (m).
    pub from: Option<Numbers<f64, D>>,
    /// In the plane: end (m).
    pub to: Option<Numbers<f64, D>>,
    /// In space: corners (m), three or more, of a convex polygon.
    #[serde(default)]
    #[schemars(with = "Vec<super::numbers::Numeric>")]
    pub corners: Vec<Numbers<f64, D>>,
    /// In space: the inside of a tube, made of flat sides that touch it from outside.
    pub cylinder: Option<Cylinder>,
    /// Velocity along itself (m/s), which rubs on the grains; where the wall is does not change.
    pub velocity: Option<Numbers<f64, D>>,
}

/// A tube of flat sides.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Start of its axis (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "[f64; 3]")]
    pub from: [f64; 3],
    /// End of its axis (m).
    #[serde(with = "super::numbers")]
    #[schemars(with = "[f64; 3]")]
    pub to: [f64; 3],
    /// Distance of the sides from the axis (m).
    #[schemars(transform = positive)]
    pub radius: f64,
    /// How many sides.
    #[serde(default = "sides")]
    #[schemars(range(min = 3))]
    pub sides: usize,
}

fn sides() -> usize {
    32
}

// By hand: arrays of any length have no default.
impl<const D: usize> Default for Particles<D> {
    fn default() -> Self {
        Particles {
            walls: DefaultWalls::default(),
            domain: None,
            boundaries: BTreeMap::new(),
        }
    }
}
