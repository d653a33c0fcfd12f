//! What the pressure stabilisation of a mesh lacks on coarser ones.
//!
//! ```text
//!   k = (τ_H − τ_h) P²         τ of (S1) with β the least of the corners
//! ```
//!
//! A coarse matrix that is made from that of the next finer mesh keeps its τ_h, which is too small by the square of
//! the sizes where viscosity rules. What τ depends on is averaged over the nodes of the finer mesh, by mass and weight
//! of interpolation, the size of its simplices among it.

use space::{Dim, Dimension, hypot};

use super::coefficients::Coefficients;
use super::stabilization::Scales;
use crate::linear::hierarchy::Hierarchy;
use crate::mesh::simplices::Mesh;

/// Mass, and times mass: φ, |a|, β, P, h.
type Sums = [f64; 6];

/// k of the simplices of each coarser mesh \[m³ s/kg\].
pub fn missing<const D: usize, const N: usize>(
    terms: &Coefficients<'_, D>,
    mesh: &Mesh<D, N>,
    hierarchy: &Hierarchy<N>,
) -> Vec<Vec<f64>>
where
    Dim<D>: Dimension<D>,
{
    let of_node = sums(terms, mesh);
    let order = hierarchy.order.iter();
    let mut fine: Vec<Sums> = order.map(|&node| of_node[node as usize]).collect();
    let mut missing = Vec::with_capacity(hierarchy.levels.len());
    for level in &hierarchy.levels {
        let mut coarse = level.transfer.sums(|node| fine[node]);
        let simplices = level.simplices.iter().zip(&level.sizes);
        let k = simplices.map(|(nodes, &size)| {
            let corners = nodes.map(|node| coarse[node as usize]);
            lacking(terms, &corners, f64::from(size))
        });
        missing.push(k.collect());
        let simplices = level.simplices.iter().zip(&level.sizes);
        own_sizes(&mut coarse, simplices);
        fine = coarse;
    }
    missing
}

fn sums<const D: usize, const N: usize>(terms: &Coefficients<'_, D>, mesh: &Mesh<D, N>) -> Vec<Sums>
where
    Dim<D>: Dimension<D>,
{
    let solid = &terms.solid.matrix;
    let mut size = vec![0.0; mesh.node_count()];
    for (nodes, shape) in mesh.simplices.iter().zip(&mesh.geometry) {
        let share = shape.volume / N as f64 * shape.size();
        nodes.iter().for_each(|&node| size[node] += share);
    }
    let of_node = |node: usize| {
        let mass = mesh.nodal_mass[node];
        let porosity = solid.porosity[node];
        let carriers = terms.carriers.iter();
        let speed = carriers.fold(space::Vector::<D>::zeros(), |sum, carrier| {
            let flow = carrier.flow;
            let factor = carrier.convects / flow.porosity[node];
            sum + flow.superficial_velocity[node] * factor
        });
        let mixture = porosity + solid.entrained_fraction[node];
        [
            mass,
            mass * porosity,
            mass * hypot(&speed),
            mass * solid.drag[node],
            mass * mixture,
            size[node],
        ]
    };
    (0..mesh.node_count()).map(of_node).collect()
}

/// k of a coarse simplex of this size.
fn lacking<const D: usize, const N: usize>(
    terms: &Coefficients<'_, D>,
    corners: &[Sums; N],
    size: f64,
) -> f64 {
    let mean = |k: usize| corners.iter().map(|sums| sums[k] / sums[0]).sum::<f64>() / N as f64;
    let drags = corners.iter().map(|sums| sums[3] / sums[0]);
    let porosity = mean(1);
    let coarse = Scales {
        rate: terms.rate,
        inertia: terms.density * porosity,
        viscosity: terms.dynamic_viscosity * porosity,
        drag: drags.fold(f64::INFINITY, f64::min),
        relieved: 0.0,
        speed: mean(2),
        mixture: mean(4),
        size,
    };
    let fine = Scales {
        size: mean(5),
        ..coarse
    };
    (coarse.momentum() - fine.momentum()).max(0.0) * coarse.mixture * coarse.mixture
}

/// Put the sizes of the simplices of a mesh in place of those of the finer one.
fn own_sizes<'a, const N: usize>(
    sums: &mut [Sums],
    simplices: impl Iterator<Item = (&'a [u32; N], &'a f32)>,
) {
    let mut total = vec![(0.0, 0.0_f64); sums.len()];
    for (nodes, &size) in simplices {
        // A volume up to a factor.
        let size = f64::from(size);
        let volume = size.powi(N as i32 - 1);
        for &node in nodes {
            let (sum, weight) = &mut total[node as usize];
            *sum += volume * size;
            *weight += volume;
        }
    }
    for (sums, (sum, weight)) in sums.iter_mut().zip(total) {
        sums[5] = sums[0] * sum / weight;
    }
}
