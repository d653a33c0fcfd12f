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

use super::system::System;

/// s of every unknown.
pub fn nodal_scale<const N: usize>(system: &System<N>) -> Vec<f64> {
    let mut diagonal = vec![0.0; system.right.len()];
    system
        .pattern
        .for_each(&system.matrix, |row, column, value| {
            if row == column {
                diagonal[row] = value.abs();
            }
        });
    let root = |value: f64| {
        if value > 0.0 {
            value.sqrt().recip()
        } else {
            1.0
        }
    };
    let mut scale = vec![1.0; diagonal.len()];
    let nodes = scale.chunks_exact_mut(N);
    for (scale, diagonal) in nodes.zip(diagonal.chunks_exact(N)) {
        let (velocity, pressure) = diagonal.split_at(N - 1);
        let sum = velocity.iter().fold(0.0, |sum, value| sum + value);
        scale.fill(root(sum / velocity.len() as f64));
        scale[N - 1] = root(pressure[0]);
    }
    scale
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
    let n = x.len();
    let mut residual = system.right.clone();
    let mut size: Vec<f64> = system.right.iter().map(|value| value.abs()).collect();
    let mut row_sum = vec![0.0; n];
    system
        .pattern
        .for_each(&system.matrix, |row, column, value| {
            let product = value * x[column];
            residual[row] -= product;
            size[row] += product.abs();
            row_sum[row] += (value * scale[column]).abs();
        });
    let largest = x
        .iter()
        .zip(scale)
        .map(|(x, s)| (x / s).abs())
        .fold(0.0, f64::max);
    let mut worst: f64 = 0.0;
    for k in (0..n).filter(|&k| !fixed[k]) {
        let background = row_sum[k] * largest;
        let tiny = 1000.0 * n as f64 * f64::EPSILON * (background + system.right[k].abs());
        let bound = if size[k] > tiny {
            size[k]
        } else {
            size[k] + background
        };
        if residual[k] != 0.0 {
            worst = worst.max(residual[k].abs() / bound);
        }
        if residual[k].is_nan() {
            return f64::NAN;
        }
    }
    worst
}
