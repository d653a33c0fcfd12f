//! Meshes and numbers for the tests.

use coupler::transfer::Mesh;
use space::{Dim, Dimension, Simplex, Vector, vector};

/// Numbers in (0, 1) that repeat.
pub fn noise(seed: usize) -> f64 {
    ((seed as f64 * 12.9898 + 78.233).sin() * 43758.5453).rem_euclid(1.0)
}

/// The D! simplices of a unit cube, each along the edges of a path from 0 to (1, …, 1) (Kuhn).
fn kuhn<const D: usize>() -> Vec<Vec<[usize; D]>> {
    let mut orders = vec![Vec::new()];
    for _ in 0..D {
        let longer = |order: &Vec<usize>| -> Vec<Vec<usize>> {
            let free = (0..D).filter(|axis| !order.contains(axis));
            free.map(|axis| [&order[..], &[axis]].concat()).collect()
        };
        orders = orders.iter().flat_map(longer).collect();
    }
    let corners = |order: &Vec<usize>| {
        let mut at = [0; D];
        let mut path = vec![at];
        for &axis in order {
            at[axis] = 1;
            path.push(at);
        }
        path
    };
    orders.iter().map(corners).collect()
}

/// A unit cube of `cells` cells along each axis, each cut along its diagonal; nodes inside are moved
/// by `shift` of a cell in a random direction. Periodic along the first axis where that is asked for.
pub fn cube<const D: usize, const N: usize>(cells: usize, shift: f64, periodic: bool) -> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    let sides: [usize; D] = std::array::from_fn(|axis| match axis {
        0 if periodic => cells,
        _ => cells + 1,
    });
    let edge = 1.0 / cells as f64;
    let number = |at: &[usize; D]| {
        let along = (0..D).rev();
        along.fold(0, |node, axis| node * sides[axis] + at[axis] % sides[axis])
    };
    let offset = |node: usize, axis: usize| shift * edge * (noise(D * node + axis) - 0.5);
    let place = |at: &[usize; D]| -> Vector<D> {
        let inside = at.iter().all(|&i| i > 0 && i < cells);
        let moved = |axis| {
            if inside {
                offset(number(at), axis)
            } else {
                0.0
            }
        };
        vector::from_fn(|axis| at[axis] as f64 * edge + moved(axis))
    };
    let nodes: usize = sides.iter().product();
    let mut mesh = Mesh {
        node_position: vec![Vector::zeros(); nodes],
        simplices: Vec::new(),
        corners: Vec::new(),
        nodal_mass: vec![0.0; nodes],
        period: std::array::from_fn(|axis| (periodic && axis == 0).then_some(1.0)),
    };
    for cell in 0..cells.pow(D as u32) {
        let first: [usize; D] = std::array::from_fn(|axis| cell / cells.pow(axis as u32) % cells);
        for path in kuhn::<D>() {
            let at: [[usize; D]; N] =
                std::array::from_fn(|k| std::array::from_fn(|axis| first[axis] + path[k][axis]));
            let mut order: [usize; N] = std::array::from_fn(|k| k);
            if Simplex::new(&at.map(|at| place(&at))).volume < 0.0 {
                order.swap(N - 1, N - 2);
            }
            let at = order.map(|k| at[k]);
            let corners = at.map(|at| place(&at));
            let simplex = Simplex::new(&corners);
            for (at, position) in at.iter().zip(&corners) {
                let node = number(at);
                mesh.nodal_mass[node] += simplex.volume / N as f64;
                if !periodic || at[0] < cells {
                    mesh.node_position[node] = *position;
                }
            }
            mesh.simplices.push(at.map(|at| number(&at) as u32));
            mesh.corners.push(corners);
        }
    }
    mesh
}

/// Points in the unit cube.
pub fn points<const D: usize>(count: usize) -> Vec<Vector<D>> {
    let point = |i: usize| vector::from_fn(|axis| noise(D * i + axis));
    (0..count).map(point).collect()
}
