//! The same in space: a box of fluid, spheres, their scene.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use protocol::engine::InitialGrains;
use protocol::scene::{
    Boundary, CouplerScene, FluidScene, Geometry, MeshSource, ParticleScene, Profile, Refinement,
    Region, Wall,
};

use crate::grains::Noise;

/// Names of the sides of a box.
pub const SIDES: [&str; 6] = ["left", "right", "bottom", "top", "back", "front"];

/// A box of fluid at rest, closed by no-slip walls, Stokes flow unless changed.
pub fn fluid(
    density: f64,
    viscosity: f64,
    gravity: [f64; 3],
    lower: [f64; 3],
    upper: [f64; 3],
    cells: [usize; 3],
) -> FluidScene {
    let closed = |side: &&str| ((*side).to_owned(), Boundary::NoSlip);
    FluidScene {
        dimension: 3,
        gravity: gravity.to_vec(),
        mesh: MeshSource::Box {
            lower: lower.to_vec(),
            upper: upper.to_vec(),
            cells: cells.to_vec(),
        },
        boundaries: SIDES.iter().map(closed).collect::<BTreeMap<_, _>>(),
        initial_velocity: vec![0.0; 3],
        ..crate::fluid(density, viscosity, [0.0; 2], [0.0; 2], [1.0; 2], [1; 2])
    }
}

/// Frictionless spheres without walls.
pub fn particles(gravity: [f64; 3]) -> ParticleScene {
    ParticleScene {
        dimension: 3,
        gravity: gravity.to_vec(),
        period: vec![None; 3],
        inertia_factor: 0.4,
        ..crate::particles([0.0; 2])
    }
}

/// A scene of both.
pub fn scene(
    fluid: Option<FluidScene>,
    particles: Option<ParticleScene>,
    coupling_step: f64,
    steps: usize,
) -> CouplerScene {
    CouplerScene {
        dimension: 3,
        geometry: Geometry::Sphere { depth: 1.0 },
        ..crate::scene(fluid, particles, coupling_step, steps)
    }
}

/// Cells of this size within a ball, which grow from there.
pub fn fine_ball(
    mut fluid: FluidScene,
    centre: [f64; 3],
    radius: f64,
    sizes: (f64, f64),
) -> FluidScene {
    let (size, growth) = sizes;
    let centre = centre.to_vec();
    fluid.refinement = Some(Refinement {
        growth,
        largest: None,
        regions: vec![Region::Ball {
            centre,
            radius,
            size,
        }],
    });
    fluid
}

/// Spheres of one density at these centres, at rest.
pub fn spheres(centres: &[[f64; 3]], radii: &[f64], density: f64) -> InitialGrains {
    let volume = |radius: &f64| 4.0 / 3.0 * PI * radius.powi(3);
    let volume: Vec<f64> = radii.iter().map(volume).collect();
    InitialGrains {
        dimension: 3,
        position: centres.as_flattened().to_vec(),
        velocity: vec![0.0; 3 * centres.len()],
        radius: radii.to_vec(),
        mass: volume.iter().map(|volume| density * volume).collect(),
        volume,
        fixed: vec![0.0; centres.len()],
    }
}

/// A cubic lattice with its first sphere half a spacing from the lower corner.
pub fn cubic(lower: [f64; 3], spacing: f64, counts: [usize; 3]) -> Vec<[f64; 3]> {
    let number = 0..counts.iter().product();
    let place = |k: usize| {
        let at = [
            k % counts[0],
            k / counts[0] % counts[1],
            k / (counts[0] * counts[1]),
        ];
        std::array::from_fn(|axis| lower[axis] + (at[axis] as f64 + 0.5) * spacing)
    };
    number.map(place).collect()
}

/// As many centres at random in a ball, no two nearer than `apart`.
pub fn ball(centre: [f64; 3], radius: f64, count: usize, apart: f64) -> Vec<[f64; 3]> {
    let mut noise = Noise::new(7);
    let mut placed: Vec<[f64; 3]> = Vec::with_capacity(count);
    let squared = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>();
    let mut tries = 0;
    while placed.len() < count {
        tries += 1;
        assert!(tries < 10_000_000, "{} of {count} placed", placed.len());
        let place: [f64; 3] = centre.map(|x| x + noise.around(radius));
        let inside = squared(&place, &centre) <= radius * radius;
        if inside
            && placed
                .iter()
                .all(|other| squared(&place, other) >= apart * apart)
        {
            placed.push(place);
        }
    }
    placed
}

/// Mean of one component of an interleaved field of space.
pub fn mean(interleaved: &[f64], axis: usize) -> f64 {
    let count = interleaved.len() / 3;
    interleaved.iter().skip(axis).step_by(3).sum::<f64>() / count as f64
}

/// The floor y = 0 under a box that is so wide, and as far beyond each of its sides.
pub fn floor(width: f64) -> Vec<Wall> {
    let corner = |x: f64, z: f64| [x, 0.0, z];
    let (low, high) = (-width, 2.0 * width);
    let far = corner(high, high);
    vec![
        Wall::of(&[corner(low, low), corner(high, low), far], None),
        Wall::of(&[corner(low, low), far, corner(low, high)], None),
    ]
}

/// The same, periodic across.
pub fn periodic_across(mut fluid: FluidScene) -> FluidScene {
    for side in ["left", "right", "back", "front"] {
        fluid.boundaries.insert(side.to_owned(), Boundary::Periodic);
    }
    fluid
}

/// Flow of this speed in through the bottom and out of the open top, from the start.
pub fn upward(mut fluid: FluidScene, speed: f64) -> FluidScene {
    let velocity = vec![0.0, speed, 0.0];
    let inflow = Boundary::Inflow {
        velocity: velocity.clone(),
        profile: Profile::Uniform,
    };
    let open = Boundary::Open { pressure: 0.0 };
    for (side, condition) in [("bottom", inflow), ("top", open)] {
        fluid.boundaries.insert(side.to_owned(), condition);
    }
    fluid.initial_velocity = velocity;
    fluid
}
