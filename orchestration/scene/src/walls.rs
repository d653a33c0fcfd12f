//! Where grains may go: the walls of the domain, and its periods.

use std::collections::BTreeMap;

use protocol::scene::{Boundary, GrainBoundary, Profile, Wall};

use crate::boundaries::SIDES;
use crate::check::Checker;
use crate::keys::{DefaultWalls, GrainDomain, Rectangle, SceneFile, Side};

/// The rectangle in which grains move, with what its sides are.
#[derive(Debug, Clone, PartialEq)]
pub struct GrainRoom {
    /// Lower left corner \[m\].
    pub lower: [f64; 2],
    /// Upper right corner \[m\].
    pub upper: [f64; 2],
    /// Which sides hold grains back: left, right, bottom, top.
    pub closed: [bool; 4],
    /// At which the closed sides move along themselves \[m/s\].
    pub velocity: [Option<[f64; 2]>; 4],
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
        (Some(domain), _) => Some(of_domain(domain, rectangle, boundaries)),
        (None, Some(rectangle)) => {
            let keys = &scene.particles.boundaries;
            let closed = SIDES.map(|side| {
                let condition = boundaries.get(side);
                condition
                    .is_none_or(|condition| meets(side, condition, keys) == GrainBoundary::Wall)
            });
            let periodic =
                ["left", "bottom"].map(|name| boundaries.get(name) == Some(&Boundary::Periodic));
            let velocity = SIDES.map(|side| wall_velocity(boundaries.get(side)?, normal(side)));
            let room = GrainRoom::new(rectangle.lower, rectangle.upper, closed, periodic);
            Some(GrainRoom { velocity, ..room })
        }
        (None, None) => None,
    }
}

/// What `[particles.domain]` says; a side that is one of the fluid's moves with it.
fn of_domain(
    domain: &GrainDomain,
    rectangle: Option<&Rectangle>,
    boundaries: &BTreeMap<String, Boundary>,
) -> GrainRoom {
    let sides = [Side::Left, Side::Right, Side::Bottom, Side::Top];
    let closed = std::array::from_fn(|side| {
        !domain.open.contains(&sides[side]) && !domain.periodic[side / 2]
    });
    let velocity = std::array::from_fn(|side| {
        let of = |lower: &[f64; 2], upper: &[f64; 2]| [lower, upper][side % 2][side / 2];
        let rectangle = rectangle?;
        let same = of(&domain.lower, &domain.upper) == of(&rectangle.lower, &rectangle.upper);
        let condition = boundaries.get(SIDES[side]).filter(|_| same)?;
        wall_velocity(condition, normal(SIDES[side]))
    });
    let room = GrainRoom::new(domain.lower, domain.upper, closed, domain.periodic);
    GrainRoom { velocity, ..room }
}

/// What grains meet at a boundary of the fluid.
pub fn meets(
    name: &str,
    condition: &Boundary,
    keys: &BTreeMap<String, GrainBoundary>,
) -> GrainBoundary {
    let chosen = keys.get(name).copied();
    match condition {
        Boundary::NoSlip | Boundary::Slip | Boundary::MovingWall { .. } => GrainBoundary::Wall,
        Boundary::Inflow { .. } => chosen.unwrap_or(GrainBoundary::Wall),
        Boundary::Open { .. } => chosen.unwrap_or(GrainBoundary::Removed),
        Boundary::Periodic => GrainBoundary::Open,
    }
}

/// Velocity \[m/s\] of the wall that grains meet where the fluid has this condition; none: it rests, as
/// one that the fluid crosses does.
fn wall_velocity(condition: &Boundary, normal: [f64; 2]) -> Option<[f64; 2]> {
    match condition {
        Boundary::MovingWall { velocity }
        | Boundary::Inflow {
            velocity,
            profile: Profile::Uniform,
        } => {
            let velocity = [velocity[0], velocity[1]];
            let moves = velocity != [0.0; 2] && is_along(velocity, normal);
            moves.then_some(velocity)
        }
        _ => None,
    }
}

/// Does a velocity lead along a boundary with this normal, but for round-off?
pub fn is_along(velocity: [f64; 2], normal: [f64; 2]) -> bool {
    let across = velocity[0] * normal[0] + velocity[1] * normal[1];
    across.abs() <= 1e-6 * f64::hypot(velocity[0], velocity[1])
}

/// Of a side of a rectangle, into it.
fn normal(side: &str) -> [f64; 2] {
    match side {
        "left" => [1.0, 0.0],
        "right" => [-1.0, 0.0],
        "bottom" => [0.0, 1.0],
        _ => [0.0, -1.0],
    }
}

impl GrainRoom {
    fn new(lower: [f64; 2], upper: [f64; 2], closed: [bool; 4], periodic: [bool; 2]) -> Self {
        let period = std::array::from_fn(|axis| periodic[axis].then(|| upper[axis] - lower[axis]));
        GrainRoom {
            lower,
            upper,
            closed,
            velocity: [None; 4],
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
            .zip(self.velocity)
            .zip(self.closed)
            .filter(|(_, closed)| *closed)
            .map(|(((a, b), velocity), _)| Wall::segment(a, b).moving(velocity))
            .collect()
    }
}

/// All wall segments of a scene; those of a mesh come from the fluid engine.
pub fn walls(scene: &SceneFile, room: Option<&GrainRoom>, checker: &mut Checker<'_>) -> Vec<Wall> {
    let mut walls = match (scene.particles.walls, room) {
        (DefaultWalls::None, _) => Vec::new(),
        (DefaultWalls::Domain, Some(room)) => room.walls(),
        (DefaultWalls::Domain, None) => {
            if scene.walls.is_empty() && !scene.grains.is_empty() && scene.fluid.is_none() {
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
    walls.extend(own.map(|wall| Wall::segment(wall.from, wall.to).moving(wall.velocity)));
    walls
}

/// What grains meet at each boundary of the fluid's mesh, where its walls are theirs.
pub fn of_mesh(
    scene: &SceneFile,
    boundaries: &BTreeMap<String, Boundary>,
) -> Option<BTreeMap<String, GrainBoundary>> {
    let fluid = scene.fluid.as_ref()?;
    let theirs = scene.particles.walls == DefaultWalls::Domain && !scene.grains.is_empty();
    let keys = &scene.particles.boundaries;
    let met = boundaries
        .iter()
        .map(|(name, condition)| (name.clone(), meets(name, condition, keys)));
    (fluid.domain.mesh.is_some() && theirs).then(|| met.collect())
}
