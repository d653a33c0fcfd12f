//! Errors, random numbers, grains and tables that several tests share.

use std::path::Path;

use fluid_solver::linear::System;
use fluid_solver::mesh::Mesh;
use space::{Simplex, Vector, dot};

pub use fluid_solver::equations::manufactured::{at_nodes, errors};

/// Kinetic energy per density, ½∫φ|v|², by nodal mass.
pub fn nodal_energy(mesh: &Mesh<2, 3>, velocity: &[Vector<2>]) -> f64 {
    let pairs = mesh.nodal_mass.iter().zip(velocity);
    pairs.map(|(mass, v)| 0.5 * mass * dot(v, v)).sum()
}

/// Observed order between two meshes or steps whose ratio is two.
pub fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

/// Largest |a − b| over nodes and components.
pub fn largest_difference(a: &[Vector<2>], b: impl Fn(usize) -> Vector<2>) -> f64 {
    let pairs = a
        .iter()
        .enumerate()
        .flat_map(|(n, v)| [0, 1].map(|d| (v[d] - b(n)[d]).abs()));
    pairs.fold(0.0, f64::max)
}

/// A place turned about two axes, so that what followed an axis follows none.
pub fn turn(x: &Vector<3>) -> Vector<3> {
    let (c, s) = (0.8, 0.6);
    let x = Vector::from([c * x[0] - s * x[1], s * x[0] + c * x[1], x[2]]);
    Vector::from([x[0], c * x[1] - s * x[2], s * x[1] + c * x[2]])
}

/// A mesh turned like that.
pub fn turned(straight: &Mesh<3, 4>) -> Mesh<3, 4> {
    let position = straight.position.iter().map(turn).collect();
    let facets = straight.facets.iter();
    let named: Vec<_> = facets.map(|facet| (facet.node, facet.boundary)).collect();
    let (simplices, names) = (straight.simplices.clone(), straight.boundary_names.clone());
    Mesh::new(position, simplices, names, &named, |t| t).unwrap()
}

/// A small deterministic generator of uniform numbers (SplitMix64, Steele et al. 2014).
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// Deposit (point, value) pairs with linear weights, divided by the nodal mass.
pub fn deposit(mesh: &Mesh<2, 3>, points: &[Vector<2>], value: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut sum = vec![0.0; mesh.node_count()];
    for (k, x) in points.iter().enumerate() {
        let (t, shape) = locate(mesh, *x).expect("point inside the mesh");
        for (node, weight) in mesh.simplices[t].iter().zip(shape) {
            sum[*node] += weight * value(k);
        }
    }
    sum.iter()
        .zip(&mesh.nodal_mass)
        .map(|(sum, mass)| sum / mass)
        .collect()
}

/// The triangle that holds a point, and its shape functions there.
pub fn locate(mesh: &Mesh<2, 3>, x: Vector<2>) -> Option<(usize, [f64; 3])> {
    mesh.corners.iter().enumerate().find_map(|(t, corners)| {
        let low = [0, 1].map(|d| corners.iter().map(|c| c[d]).fold(f64::INFINITY, f64::min));
        let high = [0, 1].map(|d| {
            corners
                .iter()
                .map(|c| c[d])
                .fold(f64::NEG_INFINITY, f64::max)
        });
        if (0..2).any(|d| x[d] < low[d] - 1e-12 || x[d] > high[d] + 1e-12) {
            return None;
        }
        let triangle = Simplex::new(corners);
        let shape = [0, 1, 2].map(|k| {
            let g = triangle.gradient[k];
            let other = corners[(k + 1) % 3];
            g[0] * (x[0] - other[0]) + g[1] * (x[1] - other[1])
        });
        shape.iter().all(|&n| n >= -1e-9).then_some((t, shape))
    })
}

/// Write a system, fixed unknowns as equations of their own, and its solution: numbers of unknowns and of entries,
/// rows, columns (from 1), entries, right-hand side, solution, in little-endian.
pub fn write_system<const N: usize>(
    system: &System<N>,
    fixed: &[bool],
    given: &[f64],
    solution: &[f64],
    file: &Path,
) {
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    system
        .pattern
        .for_each(&system.matrix, |row, column, value| {
            rows.push(row as i32 + 1);
            columns.push(column as i32 + 1);
            values.push(match fixed[row] {
                true => f64::from(u8::from(row == column)),
                false => value,
            });
        });
    let right = system.right.iter().enumerate();
    let right = right.map(|(k, &value)| if fixed[k] { given[k] } else { value });
    let mut bytes = Vec::new();
    for count in [solution.len(), values.len()] {
        bytes.extend((count as i64).to_le_bytes());
    }
    let numbers = rows.iter().chain(&columns);
    bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
    let values = values.into_iter().chain(right);
    let values = values.chain(solution.iter().copied());
    bytes.extend(values.flat_map(f64::to_le_bytes));
    std::fs::write(file, bytes).unwrap();
}
