//! L2 projection of nodal fields from one bisected mesh to another.
//!
//! ```text
//!   ∫N_i f₂ = ∫N_i f₁        for every node i of the new mesh                                        (L2)
//! ```
//!
//! The mesh of min(h₁, h₂) divides both, so that all functions are linear on each of its triangles and the integrals
//! are exact.

use std::iter::zip;

use fluid_solver::mesh::{Bisection, Mesh, Root};
use fluid_solver::state::Flow;

/// Values at nodes and shape functions.
pub fn at<T>(values: &[T], (nodes, weights): &([u32; 3], [f64; 3])) -> T
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let term = |k: usize| values[nodes[k] as usize] * weights[k];
    term(0) + term(1) + term(2)
}

/// M x with the mass matrix ∫N_i N_j.
fn mass_times(mesh: &Mesh<2, 3>, x: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; x.len()];
    for (nodes, triangle) in mesh.simplices.iter().zip(&mesh.geometry) {
        let sum: f64 = nodes.iter().map(|&n| x[n]).sum();
        for &n in nodes {
            product[n] += triangle.volume / 12.0 * (x[n] + sum);
        }
    }
    product
}

/// Conjugate gradients on M x = b, with the lumped mass before it; the solution and how many iterations.
fn solve(mesh: &Mesh<2, 3>, b: &[f64]) -> (Vec<f64>, usize) {
    let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let lumped = |r: &[f64]| -> Vec<f64> {
        let pairs = r.iter().zip(&mesh.nodal_mass);
        pairs.map(|(r, mass)| r / mass).collect()
    };
    let (mut x, mut r) = (vec![0.0; b.len()], b.to_vec());
    let mut p = lumped(&r);
    let first = product(&r, &p);
    let mut size = first;
    for iteration in 0..200 {
        if size <= 1e-30 * first {
            return (x, iteration);
        }
        let mp = mass_times(mesh, &p);
        let step = size / product(&p, &mp);
        for k in 0..x.len() {
            x[k] += step * p[k];
            r[k] -= step * mp[k];
        }
        let z = lumped(&r);
        let next = product(&r, &z);
        for k in 0..x.len() {
            p[k] = z[k] + next / size * p[k];
        }
        size = next;
    }
    panic!("not solved: {size:e} of {first:e}");
}

/// A mesh, and how points are found in it.
pub struct Found<'a>(pub &'a Bisection<Root<2>, 2, 3>, pub &'a Mesh<2, 3>);

fn projected(
    common: &Found,
    from: &Found,
    to: &Found,
    fields: &[Vec<f64>],
) -> (Vec<Vec<f64>>, usize) {
    let spots: Vec<_> = zip(from.0.spots_of(common.0), to.0.spots_of(common.0)).collect();
    let mut iterations = 0;
    let mut project = |field: &Vec<f64>| {
        let mut b = vec![0.0; to.1.node_count()];
        for (nodes, triangle) in zip(&common.1.simplices, &common.1.geometry) {
            let old = nodes.map(|n| at(field, &spots[n].0));
            let sum: f64 = old.iter().sum();
            for k in 0..3 {
                let (to, shape) = spots[nodes[k]].1;
                for (&node, weight) in to.iter().zip(shape) {
                    b[node as usize] += weight * triangle.volume / 12.0 * (old[k] + sum);
                }
            }
        }
        let (x, taken) = solve(to.1, &b);
        iterations = iterations.max(taken);
        x
    };
    (fields.iter().map(&mut project).collect(), iterations)
}

/// (L2) of u and φ, by the mesh that divides both; how many iterations.
pub fn projected_flow(
    common: &Found,
    from: &Found,
    to: &Found,
    flow: &Flow<2>,
) -> (Flow<2>, usize) {
    let along = |d: usize| flow.superficial_velocity.iter().map(|u| u[d]).collect();
    let fields = [along(0), along(1), flow.porosity.clone()];
    let (fields, iterations) = projected(common, from, to, &fields);
    let pairs = fields[0].iter().zip(&fields[1]);
    let flow = Flow {
        superficial_velocity: pairs.map(|(&x, &y)| [x, y].into()).collect(),
        porosity: fields[2].clone(),
    };
    (flow, iterations)
}
