//! Wide registers against others.

use super::*;
use crate::equations::coefficients::Carrier;
use crate::equations::kernel::lanes::Lanes;
use crate::solid::{Solid, SolidFields};
use crate::state::Flow;
use space::vector::from_fn;
use space::{Dim, Dimension, Vector};

/// Numbers between 0 and 1 without a pattern.
fn scattered(count: usize, seed: f64) -> Vec<f64> {
    (0..count)
        .map(|k| {
            (43758.5453 * (12.9898 * k as f64 + seed).sin())
                .fract()
                .abs()
        })
        .collect()
}

/// Simplices that share nothing.
fn apart<const D: usize, const N: usize>(count: usize) -> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    let numbers = scattered(D * N * count, 0.3);
    let position: Vec<Vector<D>> = numbers.chunks_exact(D).map(|x| from_fn(|d| x[d])).collect();
    let simplices: Vec<[usize; N]> = (0..count)
        .map(|t| {
            let mut nodes: [usize; N] = std::array::from_fn(|k| N * t + k);
            if space::simplex::determinant(&nodes.map(|n| position[n])) < 0.0 {
                nodes.swap(0, 1);
            }
            nodes
        })
        .collect();
    let corners = simplices.iter().map(|t| t.map(|n| position[n])).collect();
    Mesh::without_facets(position, simplices, corners, |t| t).unwrap()
}

/// Blocks and right-hand sides of all groups, with and without wide registers.
fn check<const D: usize, const N: usize>(drag_max: f64, clear: bool)
where
    Dim<D>: Dimension<D>,
{
    let mesh = apart::<D, N>(22);
    let nodes = mesh.node_count();
    let field = |low: f64, high: f64, seed: f64| -> Vec<f64> {
        let numbers = scattered(nodes, seed);
        numbers.iter().map(|x| low + (high - low) * x).collect()
    };
    let porosity = field(if clear { 1.0 } else { 0.4 }, 1.0, 1.0);
    let drag = field(0.0, drag_max, 2.0);
    let fields = SolidFields {
        porosity: Some(&porosity),
        drag: Some(&drag),
        ..SolidFields::default()
    };
    let solid = Solid::new(&fields, &mesh).unwrap();
    let velocity = field(-0.1, 0.1, 3.0);
    let flow = Flow {
        superficial_velocity: velocity
            .iter()
            .map(|u| from_fn(|d| u * (1.0 + d as f64)))
            .collect(),
        porosity,
    };
    let carriers = [Carrier {
        flow: &flow,
        convects: 1.0,
        history: 2.0,
    }];
    let terms = Coefficients {
        density: 1200.0,
        dynamic_viscosity: 12.0,
        gravity: from_fn(|d| 3.0 - d as f64),
        viscous_form: ViscousForm::Symmetric,
        grad_div: 1.0,
        rate: 2.0,
        newton: false,
        body_force: None,
        time: 0.0,
        carriers: &carriers,
        solid: &solid,
    };
    let mut kernel = Kernel::new(&terms, &mesh).unwrap();
    let all = |kernel: &Kernel<'_, D, N>| {
        let groups = 0..mesh.simplices.len().div_ceil(LANES);
        let blocks = groups.map(|g| {
            let mut matrix = [[[[Lanes::ZERO; N]; N]; N]; N];
            let mut right = [[Lanes::ZERO; N]; N];
            kernel.compute(g, true, &mut matrix, &mut right);
            (matrix, right)
        });
        blocks.collect::<Vec<_>>()
    };
    let wide = all(&kernel);
    println!("{:?}", kernel.wide);
    kernel.wide = Wide::none();
    assert!(wide == all(&kernel));
}

#[test]
fn wide_registers_give_the_same_bits() {
    for (drag, clear) in [(0.0, true), (1e4, false), (1e8, false)] {
        check::<2, 3>(drag, clear);
        check::<3, 4>(drag, clear);
    }
}
