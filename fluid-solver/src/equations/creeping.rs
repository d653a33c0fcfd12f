//! How much convection matters to a flow that is solved without it.
//!
//! ```text
//!   Re = (1/k) [∫ |ρφ v·∇v|²/(μφ)]^½ / [∫ μφ (2|D(v)|² + k²|v|²)]^½,   k = π/L            (R1)
//! ```
//!
//! | symbol | meaning | unit |
//! | ------ | ------- | ---- |
//! | L      | shortest extent of the domain along an axis that is not periodic (all are: shortest period) | m |
//! | D(v)   | ½(∇v + ∇vᵀ) | 1/s |
//!
//! Let δv be what the term would change. Testing its equation with δv gives
//! ∫2μφ|D(δv)|² = −∫ρφ(v·∇v)·δv, and a flow without a net flux across a domain of width L has
//! ∫|∇δv|² ≥ k²∫|δv|² (Poincaré): δv is at most Re of v, in the norm of the denominator. The bound is on the safe side: drag and inertia, which hold δv back too,
//! are not in it, and the part of v·∇v that only changes the pressure is. Uniform flow has Re = 0.

use std::ops::Range;

use rayon::prelude::*;
use space::simplex::interpolate;
use space::vector::from_fn;
use space::{Dim, Dimension, Vector, dot};

use super::element::components;
use crate::mesh::simplices::Mesh;
use crate::state::Flow;

/// Simplices of a partial sum.
const PIECE: usize = 1024;

/// What (R1) needs besides the flow.
#[derive(Debug, Clone, Copy)]
pub struct Creeping {
    /// ρ \[kg/m³\].
    density: f64,
    /// μ \[Pa s\].
    viscosity: f64,
    /// k = π/L \[1/m\].
    wave_number: f64,
}

impl Creeping {
    /// For a fluid on a mesh.
    pub fn new<const D: usize, const N: usize>(
        density: f64,
        viscosity: f64,
        mesh: &Mesh<D, N>,
    ) -> Creeping {
        Creeping {
            density,
            viscosity,
            wave_number: std::f64::consts::PI / shortest_extent(mesh),
        }
    }

    /// Re of (R1); 0 for fluid at rest.
    pub fn reynolds<const D: usize, const N: usize>(&self, flow: &Flow<D>, mesh: &Mesh<D, N>) -> f64
    where
        Dim<D>: Dimension<D>,
    {
        // Partial sums of fixed pieces: the same bits on any number of threads.
        let count = mesh.simplices.len();
        let parts: Vec<[f64; 2]> = (0..count.div_ceil(PIECE))
            .into_par_iter()
            .map(|piece| self.sums(PIECE * piece..count.min(PIECE * (piece + 1)), flow, mesh))
            .collect();
        let [convection, viscous] = parts
            .iter()
            .fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
        if convection == 0.0 {
            return 0.0;
        }
        (convection / viscous).sqrt() / self.wave_number // (R1)
    }

    /// Both integrals of (R1) over some simplices, by the value at their centres.
    fn sums<const D: usize, const N: usize>(
        &self,
        simplices: Range<usize>,
        flow: &Flow<D>,
        mesh: &Mesh<D, N>,
    ) -> [f64; 2]
    where
        Dim<D>: Dimension<D>,
    {
        let centre = [1.0 / N as f64; N];
        let mut sums = [0.0; 2];
        for t in simplices {
            let (nodes, simplex) = (mesh.simplices[t], &mesh.geometry[t]);
            let porosity = nodes.map(|n| flow.porosity[n]);
            let here = interpolate(&centre, &porosity);
            let slope = simplex.gradient_of(&porosity);
            let u = components(&nodes, &flow.superficial_velocity);
            let v: Vector<D> = from_fn(|d| interpolate(&centre, &u[d]) / here);
            let gradient: [Vector<D>; D] = std::array::from_fn(|d| {
                let of_u = simplex.gradient_of(&u[d]);
                from_fn(|f| (of_u[f] - v[d] * slope[f]) / here)
            });
            let carried: Vector<D> = from_fn(|d| dot(&v, &gradient[d])); // v·∇v
            let strain = strain(&gradient);
            let (inertia, viscosity) = (self.density * here, self.viscosity * here);
            sums[0] += simplex.volume * inertia * inertia / viscosity * dot(&carried, &carried);
            sums[1] +=
                simplex.volume * viscosity * (strain + self.wave_number.powi(2) * dot(&v, &v));
        }
        sums
    }
}

/// 2|D(v)|²
fn strain<const D: usize>(gradient: &[Vector<D>; D]) -> f64 {
    let (mut normal, mut shear) = (0.0, 0.0);
    for d in 0..D {
        normal += gradient[d][d].powi(2);
        for f in d + 1..D {
            shear += (gradient[d][f] + gradient[f][d]).powi(2);
        }
    }
    2.0 * normal + shear
}

/// L of (R1) \[m\].
fn shortest_extent<const D: usize, const N: usize>(mesh: &Mesh<D, N>) -> f64 {
    let extent = |axis: usize| {
        let along = || mesh.corners.iter().flatten().map(|corner| corner[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    let all_periodic = mesh.period.iter().all(Option::is_some);
    let axes = (0..D).filter(|&axis| all_periodic || mesh.period[axis].is_none());
    axes.map(extent).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::rectangle::Rectangle;

    /// Flow of velocity v(x) in clear fluid.
    fn flow(mesh: &Mesh<2, 3>, velocity: impl Fn(Vector<2>) -> [f64; 2]) -> Flow<2> {
        Flow {
            superficial_velocity: mesh.position.iter().map(|x| velocity(*x).into()).collect(),
            porosity: vec![1.0; mesh.node_count()],
        }
    }

    #[test]
    fn the_number_of_known_flows_is_the_one_of_their_integrals() {
        let pi = std::f64::consts::PI;
        let mesh = Rectangle::new([0.0; 2], [1.0, 1.0], [64, 64])
            .mesh()
            .unwrap();
        let (density, viscosity, speed) = (2.0, 3.0, 1e-3);
        let number =
            |flow: &Flow<2>| Creeping::new(density, viscosity, &mesh).reynolds(flow, &mesh);
        // Vortices U (sin kx cos ky, −cos kx sin ky): v·∇v = ½kU² (sin 2kx, sin 2ky), with
        // ∫|v·∇v|² = k²U⁴/4, ∫2|D|² = k²U², ∫k²|v|² = k²U²/2: Re = ρU/(μk) √(1/6).
        let vortices = flow(&mesh, |at| {
            let (x, y) = (pi * at.x, pi * at.y);
            [speed * x.sin() * y.cos(), -speed * x.cos() * y.sin()]
        });
        let expected = density * speed / (viscosity * pi) * (1.0_f64 / 6.0).sqrt();
        let parallel = flow(&mesh, |at| [speed * at.y * (1.0 - at.y), 0.0]);
        let uniform = flow(&mesh, |_| [speed, 0.5 * speed]);
        println!(
            "vortices {:.4e} ({expected:.4e}), parallel {:.1e}, uniform {:.1e}",
            number(&vortices),
            number(&parallel),
            number(&uniform)
        );
        assert!((number(&vortices) / expected - 1.0).abs() < 2e-3);
        assert!(number(&parallel) < 1e-12 && number(&uniform) < 1e-12);
        assert_eq!(number(&flow(&mesh, |_| [0.0; 2])), 0.0);
    }

    #[test]
    fn the_extent_is_taken_between_walls() {
        for (periodic, extent) in [
            ([false, false], 0.2),
            ([true, false], 1.0),
            ([false, true], 0.2),
            ([true, true], 0.2),
        ] {
            let mut rectangle = Rectangle::new([0.0; 2], [0.2, 1.0], [3, 9]);
            rectangle.periodic = periodic;
            let found = shortest_extent(&rectangle.mesh().unwrap());
            println!("{periodic:?}: {found}");
            assert!((found - extent).abs() < 1e-12);
        }
    }
}
