//! Where grains may go: the walls of the domain, and its periods.

use std::collections::BTreeMap;

use protocol::scene::{Boundary, Wall};

use crate::check::Checker;
use crate::keys::{DefaultWalls, Particles, Rectangle, SceneFile, Side};

/// The rectangle in which grains move, with what its sides are.
#[derive(Debug, Clone, PartialEq)]
pub struct GrainRoom {
    /// Lower left corner \[m\].
    pub lower: [f64; 2],
    /// Upper right corner \[m\].
    pub upper: [f64; 2],
    /// Which sides hold grains back: left, right, bottom, top.
    pub closed: [bool; 4],
    /// Period in x and y \[m\].
    pub period: [Option<f64>; 2],
}

/// The room of a scene; none for a mesh without `[particles.domain]`.
pub fn room(
    scene: &SceneFile,
    rectangle: Option<&Rectangle>,
    boundaries: &BTreeMap<String, Boundary>,
) -> Option<GrainRoom> {
    match (&scene.particles.domain, rectangle) {
        (Some(domain), _) => {
            let sides = [Side::Left, Side::Right, Side::Bottom, Side::Top];
            let closed = std::array::from_fn(|side| {
                !domain.open.contains(&sides[side]) && !domain.periodic[side / 2]
            });
            Some(GrainRoom::new(
                domain.lower,
                domain.upper,
                closed,
                domain.periodic,
            ))
        }
        (None, Some(rectangle)) => {
            let condition = |name: &str| boundaries.get(name);
            let closed = std::array::from_fn(|side| {
                !matches!(
                    condition(super::boundaries::SIDES[side]),
                    Some(Boundary::Periodic | Boundary::Open { .. })
                )
            });
            let periodic =
                ["left", "bottom"].map(|name| condition(name) == Some(&Boundary::Periodic));
            Some(GrainRoom::new(
                rectangle.lower,
                rectangle.upper,
                closed,
                periodic,
            ))
        }
        (None, None) => None,
    }
}

impl GrainRoom {
    fn new(lower: [f64; 2], upper: [f64; 2], closed: [bool; 4], periodic: [bool; 2]) -> Self {
        let period = std::array::from_fn(|axis| periodic[axis].then(|| upper[axis] - lower[axis]));
        GrainRoom {
            lower,
            upper,
            closed,
            period,
        }
    }

    /// The closed sides, counter-clockwise: grains stay on the left of a → b.
    fn walls(&self) -> Vec<Wall> {
        let ([left, bottom], [right, top]) = (self.lower, self.upper);
        let sides = [
            ([left, top], [left, bottom]),
            ([right, bottom], [right, top]),
            ([left, bottom], [right, bottom]),
            ([right, top], [left, top]),
        ];
        sides
            .into_iter()
            .zip(self.closed)
            .filter(|(_, closed)| *closed)
            .map(|((a, b), _)| Wall::segment(a, b))
            .collect()
    }
}

/// All wall segments of a scene.
pub fn walls(scene: &SceneFile, room: Option<&GrainRoom>, checker: &mut Checker<'_>) -> Vec<Wall> {
    let Particles { walls: default, .. } = &scene.particles;
    let mut walls = match (default, room) {
        (DefaultWalls::None, _) => Vec::new(),
        (DefaultWalls::Domain, Some(room)) => room.walls(),
        (DefaultWalls::Domain, None) => {
            if scene.walls.is_empty() && !scene.grains.is_empty() {
                checker.refuse(
                    "particles.domain",
                    "missing: nothing says where the walls are; write [particles.domain] lower, \
                     upper, or [[walls]] from, to, or [particles] walls = \"none\"",
                );
            }
            Vec::new()
        }
    };
    let own = scene.walls.iter();
    walls.extend(own.map(|wall| Wall::segment(wall.from, wall.to)));
    walls
}
