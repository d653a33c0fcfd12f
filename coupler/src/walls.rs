//! The walls of the grains: those of the scene, and the facets of the fluid's mesh that are no openings.
//!
//! A wall of the scene that facets cover wholly is theirs, for they may move; facets that lie on a part of
//! a wall of the scene are left out: no wall is there twice.

use std::collections::BTreeMap;

use protocol::engine::FacetDescription;
use protocol::message::BoundaryKind;
use protocol::scene::{GrainBoundary, ParticleScene, Wall};
use space::dimension::factorial;
use space::{Dim, Dimension, Vector, dot, hypot, norm};

use crate::error::CouplerError;
use crate::seats::door;

/// Part of the size of a wall within which a facet lies on it.
const ON_WALL: f64 = 1e-9;
/// Part of its area that may be bare where facets cover a wall.
const BARE: f64 = 1e-6;
/// Part of its speed at which a boundary that moves along itself may move across.
const ASIDE: f64 = 1e-6;

/// The scene of the particle engine with the facets that are walls to grains, by what the scene says
/// about their boundaries. An error where `engine` tells no facets.
pub fn with_facets<const D: usize>(
    part: &ParticleScene,
    told: &FacetDescription,
    sides: &BTreeMap<String, GrainBoundary>,
    engine: &str,
) -> Result<ParticleScene, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    if told.count() == 0 {
        return Err(CouplerError::Walls {
            why: format!(
                "the fluid engine {engine} does not tell where its mesh ends, so grains would fall through: \
                 write [particles] walls = \"none\" and every wall as [[walls]]"
            ),
        });
    }
    let mut facets = solid::<D>(told, sides)?;
    let mut walls = Vec::new();
    for wall in &part.walls {
        let own = Plate::<D>::of(wall)?;
        let lies_on = |facet: &Plate<D>| facet.lies_on(&own, wall);
        let covered: f64 = facets.iter().filter(|f| lies_on(f)).map(|f| f.size).sum();
        if covered >= (1.0 - BARE) * own.size {
            continue;
        }
        let differs = |facet: &&Plate<D>| lies_on(facet) && facet.velocity != own.velocity;
        if let Some(facet) = facets.iter().find(differs) {
            let (at, corners) = (facet.corners[0].as_slice(), &wall.corners);
            return Err(CouplerError::Walls {
                why: format!(
                    "the wall of the scene with corners {corners:?} m lies on a part of the fluid's boundary \
                     that moves, at {at:?} m: end it there, or leave it out"
                ),
            });
        }
        facets.retain(|facet| !lies_on(facet));
        walls.push(wall.clone());
    }
    walls.extend(facets.iter().map(Plate::wall));
    Ok(ParticleScene {
        walls,
        ..part.clone()
    })
}

/// A flat wall, measured.
struct Plate<const D: usize> {
    corners: [Vector<D>; D],
    velocity: Vector<D>,
    /// Towards the grains.
    normal: Vector<D>,
    /// Length, area.
    size: f64,
}

impl<const D: usize> Plate<D>
where
    Dim<D>: Dimension<D>,
{
    fn new(corners: [Vector<D>; D], velocity: Vector<D>) -> Plate<D> {
        let normal = Dim::<D>::inward_normal(&corners);
        let length = norm(&normal);
        Plate {
            corners,
            velocity,
            normal: normal * (1.0 / length),
            size: length / factorial(D - 1) as f64,
        }
    }

    fn of(wall: &Wall) -> Result<Plate<D>, CouplerError> {
        let velocity = match &wall.velocity {
            Some(velocity) => door::vector(velocity, "wall")?,
            None => Vector::zeros(),
        };
        Ok(Plate::new(door::corners(wall)?, velocity))
    }

    /// Is it a part of a wall, seen from the same side?
    fn lies_on(&self, other: &Plate<D>, wall: &Wall) -> bool {
        let reach = ON_WALL * other.size.powf(1.0 / (D - 1) as f64);
        let near = |corner: &Vector<D>| wall.distance(corner.as_slice()) <= reach;
        dot(&self.normal, &other.normal) > 0.0 && self.corners.iter().all(near)
    }

    fn wall(&self) -> Wall {
        let moves = self.velocity != Vector::<D>::zeros();
        Wall {
            corners: self.corners.iter().map(|c| c.as_slice().to_vec()).collect(),
            velocity: moves.then(|| self.velocity.as_slice().to_vec()),
        }
    }
}

/// The facets that are walls to grains. One moves at the velocity that the boundary gives the fluid where
/// that is along it; where fluid crosses it, it rests.
fn solid<const D: usize>(
    told: &FacetDescription,
    sides: &BTreeMap<String, GrainBoundary>,
) -> Result<Vec<Plate<D>>, CouplerError>
where
    Dim<D>: Dimension<D>,
{
    let is_wall = |boundary: u32| {
        let boundary = &told.boundaries[boundary as usize];
        let unsaid = match boundary.kind {
            BoundaryKind::Open => GrainBoundary::Removed,
            BoundaryKind::NoSlip
            | BoundaryKind::Slip
            | BoundaryKind::MovingWall
            | BoundaryKind::Inflow => GrainBoundary::Wall,
        };
        sides.get(&boundary.name).copied().unwrap_or(unsaid) == GrainBoundary::Wall
    };
    let positions = door::vectors::<D>(&told.position, "facet_position")?;
    let velocities = door::vectors::<D>(&told.velocity, "facet_velocity")?;
    let facets = positions.chunks_exact(D).zip(velocities);
    let walls = facets.zip(&told.boundary).filter(|(_, b)| is_wall(**b));
    walls
        .map(|((corners, velocity), _)| {
            let corners = <[Vector<D>; D]>::try_from(corners)
                .map_err(|_| door::wrong_count("facet_position", corners.len(), D))?;
            let at_rest = Plate::new(corners, Vector::zeros());
            let across = dot(&velocity, &at_rest.normal).abs();
            Ok(match across <= ASIDE * hypot(&velocity) {
                true => Plate::new(corners, velocity),
                false => at_rest,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::message::MeshBoundary;

    fn scene(walls: Vec<Wall>) -> ParticleScene {
        ParticleScene {
            dimension: 2,
            gravity: vec![0.0, -1.0],
            walls,
            period: vec![None, None],
            friction: 0.5,
            wall_friction: 0.5,
            inertia_factor: 0.5,
            tolerance: 1e-3,
            solver: None,
            sweeps_max: 100,
            sub_steps_max: 10,
            threads: 1,
        }
    }

    /// A floor of two facets, the second a belt, an inflow on the right and an opening above.
    fn told() -> FacetDescription {
        let boundary = |(name, kind): (&str, BoundaryKind)| MeshBoundary {
            name: name.to_string(),
            kind,
        };
        let kinds = [
            ("floor", BoundaryKind::NoSlip),
            ("belt", BoundaryKind::MovingWall),
            ("in", BoundaryKind::Inflow),
            ("out", BoundaryKind::Open),
        ];
        FacetDescription {
            boundaries: kinds.map(boundary).into(),
            position: vec![
                0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 2.0, 0.0, 2.0, 0.0, 2.0, 1.0, 2.0, 1.0, 0.0, 1.0,
            ],
            boundary: vec![0, 1, 2, 3],
            velocity: vec![0.0, 0.0, 0.3, 0.0, -0.1, 0.0, 0.0, 0.0],
        }
    }

    fn all(walls: Vec<Wall>, sides: &[(&str, GrainBoundary)]) -> Result<Vec<Wall>, String> {
        let sides = sides.iter().map(|(name, side)| (name.to_string(), *side));
        let scene = with_facets::<2>(&scene(walls), &told(), &sides.collect(), "mine");
        scene
            .map(|scene| scene.walls)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn facets_are_walls_unless_they_are_open_and_belts_move() {
        let floor = Wall::segment([0.0, 0.0], [1.0, 0.0]);
        let belt = Wall::of(&[[1.0, 0.0], [2.0, 0.0]], Some([0.3, 0.0]));
        let inflow = Wall::segment([2.0, 0.0], [2.0, 1.0]);
        let lid = Wall::segment([2.0, 1.0], [0.0, 1.0]);
        let walls = [floor, belt, inflow];
        assert_eq!(all(Vec::new(), &[]).unwrap(), walls);
        let chosen = [("in", GrainBoundary::Open), ("out", GrainBoundary::Wall)];
        let [floor, belt, _] = walls;
        assert_eq!(all(Vec::new(), &chosen).unwrap(), [floor, belt, lid]);
    }

    #[test]
    fn an_engine_that_does_not_tell_where_its_mesh_ends_is_refused() {
        let nothing = FacetDescription::default();
        let error = with_facets::<2>(&scene(Vec::new()), &nothing, &BTreeMap::new(), "mine");
        let error = error.expect_err("no facets");
        println!("{error}");
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("engine mine does not tell"));
    }

    #[test]
    fn no_wall_is_there_twice() {
        // Covered wholly: the facet's. Longer than the facet: the scene's. The other way round: both.
        let right = Wall::segment([2.0, 0.0], [2.0, 1.0]);
        assert_eq!(all(vec![right], &[]).unwrap().len(), 3);
        let longer = Wall::segment([-1.0, 0.0], [1.0, 0.0]);
        let walls = all(vec![longer.clone()], &[]).unwrap();
        assert_eq!((walls.len(), &walls[0]), (3, &longer));
        let outside = Wall::segment([1.0, 0.0], [0.0, 0.0]);
        assert_eq!(all(vec![outside], &[]).unwrap().len(), 4);
        let both = Wall::segment([0.0, 0.0], [2.0, 0.0]);
        assert_eq!(all(vec![both], &[]).unwrap().len(), 3);
        let error = all(vec![Wall::segment([0.0, 0.0], [9.0, 0.0])], &[]).unwrap_err();
        println!("{error}");
        assert!(error.contains("moves"));
    }
}
