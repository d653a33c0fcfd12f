//! Where grains may go: the walls of the domain, and its periods.

use std::collections::BTreeMap;

use protocol::scene::{Boundary, GrainBoundary, Profile, Wall};
use space::{Dim, Vector};

use crate::check::Checker;
use crate::dimensions::{Cells, Scenic, is_along, sides};
use crate::keys::{DefaultWalls, GrainDomain, SIDES, SceneFile};

/// The rectangle or box in which grains move, with what its sides are.
#[derive(Debug, Clone, PartialEq)]
pub struct GrainRoom<const D: usize> {
    /// Lower corner \[m\].
    pub lower: [f64; D],
    /// Upper corner \[m\].
    pub upper: [f64; D],
    /// Its sides, two an axis.
    pub sides: Vec<RoomSide<D>>,
    /// Period along each axis \[m\].
    pub period: [Option<f64>; D],
}

/// What a side of it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoomSide<const D: usize> {
    /// Does it hold grains back?
    pub closed: bool,
    /// At which it moves along itself \[m/s\].
    pub velocity: Option<[f64; D]>,
}

/// Axes along which opposite sides are joined.
pub fn joined<const D: usize>(boundaries: &BTreeMap<String, Boundary>) -> [bool; D] {
    std::array::from_fn(|axis| boundaries.get(sides::<D>()[2 * axis]) == Some(&Boundary::Periodic))
}

/// The room of a scene; none for a mesh without `[particles.domain]`.
pub fn room<const D: usize>(
    scene: &SceneFile<D>,
    cells: Option<&Cells<D>>,
    boundaries: &BTreeMap<String, Boundary>,
) -> Option<GrainRoom<D>> {
    if let Some(domain) = &scene.particles.domain {
        return Some(of_domain(domain, cells, boundaries));
    }
    let cells = cells?;
    let keys = &scene.particles.boundaries;
    let side = |(number, name): (usize, &&str)| {
        let condition = boundaries.get(*name);
        let is_wall = |condition| meets(name, condition, keys) == GrainBoundary::Wall;
        RoomSide {
            closed: condition.is_none_or(is_wall),
            velocity: condition.and_then(|condition| wall_velocity(condition, normal(number))),
        }
    };
    let sides = sides::<D>().iter().enumerate().map(side).collect();
    let (lower, upper) = (cells.lower, cells.upper);
    Some(GrainRoom {
        period: period(&lower, &upper, joined(boundaries)),
        lower,
        upper,
        sides,
    })
}

/// What `[particles.domain]` says; a side that is one of the fluid's moves with it.
fn of_domain<const D: usize>(
    domain: &GrainDomain<D>,
    cells: Option<&Cells<D>>,
    boundaries: &BTreeMap<String, Boundary>,
) -> GrainRoom<D> {
    let velocity = |side: usize| {
        let of = |lower: &[f64; D], upper: &[f64; D]| [lower, upper][side % 2][side / 2];
        let cells = cells?;
        let same = of(&domain.lower, &domain.upper) == of(&cells.lower, &cells.upper);
        let condition = boundaries.get(sides::<D>()[side]).filter(|_| same)?;
        wall_velocity(condition, normal(side))
    };
    let side = |side: usize| RoomSide {
        closed: !domain.open.contains(&SIDES[side]) && !domain.periodic.0[side / 2],
        velocity: velocity(side),
    };
    GrainRoom {
        lower: domain.lower,
        upper: domain.upper,
        sides: (0..2 * D).map(side).collect(),
        period: period(&domain.lower, &domain.upper, domain.periodic.0),
    }
}

fn period<const D: usize>(
    lower: &[f64; D],
    upper: &[f64; D],
    periodic: [bool; D],
) -> [Option<f64>; D] {
    std::array::from_fn(|axis| periodic[axis].then(|| upper[axis] - lower[axis]))
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
fn wall_velocity<const D: usize>(condition: &Boundary, normal: Vector<D>) -> Option<[f64; D]> {
    match condition {
        Boundary::MovingWall { velocity }
        | Boundary::Inflow {
            velocity,
            profile: Profile::Uniform,
        } => {
            let velocity: [f64; D] = velocity[..].try_into().ok()?;
            let moves = velocity != [0.0; D] && is_along(&velocity, &normal);
            moves.then_some(velocity)
        }
        _ => None,
    }
}

/// Of a side of a rectangle or box, into it.
fn normal<const D: usize>(side: usize) -> Vector<D> {
    let inward = [1.0, -1.0][side % 2];
    space::vector::from_fn(|axis| if axis == side / 2 { inward } else { 0.0 })
}

impl<const D: usize> GrainRoom<D>
where
    Dim<D>: Scenic<D>,
{
    /// The closed sides.
    fn walls(&self) -> Vec<Wall> {
        let closed = self
            .sides
            .iter()
            .enumerate()
            .filter(|(_, side)| side.closed);
        let walls = closed.flat_map(|(number, side)| {
            let facets = Dim::<D>::side(&self.lower, &self.upper, number).into_iter();
            facets.map(|corners| Wall::of(&corners, side.velocity))
        });
        walls.collect()
    }
}

/// All walls of a scene; those of a mesh come from the fluid engine.
pub fn walls<const D: usize>(
    scene: &SceneFile<D>,
    room: Option<&GrainRoom<D>>,
    checker: &mut Checker<'_>,
) -> Vec<Wall>
where
    Dim<D>: Scenic<D>,
{
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
    for keys in &scene.walls {
        // What is wrong with one was told before.
        let facets = Dim::<D>::wall(keys).unwrap_or_default().into_iter();
        walls.extend(
            facets.map(|corners| Wall::of(&corners, keys.velocity.map(|velocity| velocity.0))),
        );
    }
    walls
}

/// What grains meet at each boundary of the fluid's mesh, where its walls are theirs.
pub fn of_mesh<const D: usize>(
    scene: &SceneFile<D>,
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
