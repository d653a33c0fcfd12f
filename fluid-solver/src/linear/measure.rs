//! How equations are scaled, and how good a solution is.
//!
//! ```text
//!   s_u = (mean of |K_dd|)^(−1/2),      s_p = |K_pp|^(−1/2)      symmetric nodal scaling
//!   ω   = max_i |r − Kx|_i / (|K||x| + |r|)_i                    componentwise backward error
//! ```
//!
//! A 2-norm residual hides a wrong fluid velocity next to stiff grains; ω does not (Oettli and
//! Prager 1964). Where the denominator of a row is round-off, that of Arioli, Demmel and Duff
//! (1989) is taken.

use super::pattern::Block;
use super::system::System;

/// s of every unknown.
pub fn nodal_scale<const N: usize>(system: &System<N>) -> Vec<f64> {
    let root = |value: f64| {
        if value > 0.0 {
            value.sqrt().recip()
        } else {
            1.0
        }
    };
    let mut scale = Vec::with_capacity(system.right.len());
    for node in 0..system.pattern.nodes() {
        let (neighbours, blocks) = system.row(node);
        let own = neighbours.binary_search(&node);
        let diagonal: [f64; N] = match own {
            Ok(own) => std::array::from_fn(|k| blocks[own][k][k].abs()),
            Err(_) => [0.0; N],
        };
        let (velocity, pressure) = diagonal.split_at(N - 1);
        let sum = velocity.iter().fold(0.0, |sum, value| sum + value);
        scale.extend(velocity.iter().map(|_| root(sum / velocity.len() as f64)));
        scale.push(root(pressure[0]));
    }
    scale
}

/// S K S, with rows and columns of the identity where unknowns are fixed.
pub fn scale_matrix<const N: usize>(
    system: &System<N>,
    scale: &[f64],
    fixed: &[bool],
    scaled: &mut [Block<N>],
) {
    let unknowns = scale.iter().zip(fixed);
    let free: Vec<f64> = unknowns
        .map(|(&s, &fixed)| if fixed { 0.0 } else { s })
        .collect();
    let free = free.as_chunks::<N>().0;
    for (row, scale) in free.iter().enumerate() {
        let (neighbours, blocks) = system.row(row);
        let scaled = &mut scaled[system.pattern.range(row)];
        for (k, &column) in neighbours.iter().enumerate() {
            for f in 0..N {
                for d in 0..N {
                    scaled[k][f][d] = blocks[k][f][d] * scale[d] * free[column][f];
                }
                if row == column && free[column][f] == 0.0 {
                    scaled[k][f][f] = 1.0;
                }
            }
        }
    }
}

/// ‖S(r − Kx)‖ / ‖S|K||x|‖ over the free unknowns.
pub fn residual<const N: usize>(system: &System<N>, x: &[f64], fixed: &[bool]) -> f64 {
    let scale = nodal_scale(system);
    let mut residual = system.right.clone();
    let mut size = vec![0.0; x.len()];
    system
        .pattern
        .for_each(&system.matrix, |row, column, value| {
            residual[row] -= value * x[column];
            size[row] += (value * x[column]).abs();
        });
    let norm = |values: &[f64]| {
        let free = (0..values.len()).filter(|&k| !fixed[k]);
        free.map(|k| (scale[k] * values[k]).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let (residual, size) = (norm(&residual), norm(&size));
    if residual == 0.0 {
        0.0
    } else {
        residual / size
    }
}

/// ω of the free rows.
pub fn backward_error<const N: usize>(
    system: &System<N>,
    x: &[f64],
    scale: &[f64],
    fixed: &[bool],
) -> f64 {
    measured(system, x, scale, fixed, &mut Vec::new())
}

/// ω of the free rows; r − K x of all comes into `left`.
pub fn measured<const N: usize>(
    system: &System<N>,
    x: &[f64],
    scale: &[f64],
    fixed: &[bool],
    left: &mut Vec<f64>,
) -> f64 {
    left.clear();
    let n = x.len();
    let largest = x
        .iter()
        .zip(scale)
        .map(|(x, s)| (x / s).abs())
        .fold(0.0, f64::max);
    let (x, scale) = (x.as_chunks::<N>().0, scale.as_chunks::<N>().0);
    let mut worst: f64 = 0.0;
    for node in 0..system.pattern.nodes() {
        let (neighbours, blocks) = system.row(node);
        let right: [f64; N] = std::array::from_fn(|d| system.right[N * node + d]);
        let (mut residual, mut size, mut row_sum) = (right, right.map(f64::abs), [0.0; N]);
        for (&other, block) in neighbours.iter().zip(blocks) {
            for (f, column) in block.iter().enumerate() {
                let (x, scale) = (x[other][f], scale[other][f]);
                for d in 0..N {
                    let product = column[d] * x;
                    residual[d] -= product;
                    size[d] += product.abs();
                    row_sum[d] += (column[d] * scale).abs();
                }
            }
        }
        left.extend_from_slice(&residual);
        for d in (0..N).filter(|&d| !fixed[N * node + d]) {
            let background = row_sum[d] * largest;
            let tiny = 1000.0 * n as f64 * f64::EPSILON * (background + right[d].abs());
            let bound = if size[d] > tiny {
                size[d]
            } else {
                size[d] + background
            };
            if residual[d] != 0.0 {
                worst = larger(worst, residual[d].abs() / bound);
            }
        }
    }
    worst
}

/// The larger one, NaN if one is.
fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}
