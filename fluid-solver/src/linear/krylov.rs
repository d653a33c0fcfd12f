//! Flexible GMRES in double precision.
//!
//! ```text
//!   A Z_j = V_(j+1) H_j,   Z_j = M(V_j),      y = argmin |‖r‖ e₁ − H y|,      x = Z y
//! ```
//!
//! Saad, SIAM J. Sci. Comput. 14 (1993). The basis is made orthogonal by modified Gram–Schmidt, H triangular by
//! rotations as it grows. All sums are in a fixed order.

/// What was reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// Iterations done.
    pub iterations: usize,
    /// ‖r − A x‖ as the recurrence has it.
    pub residual: f64,
}

/// Solve A x = r from 0 until the norm of what is left is at most `goal`. `precondition` writes M(v) of its first
/// argument to its second, `multiply` A z.
pub fn solve(
    residual: Vec<f64>,
    goal: f64,
    iterations_max: usize,
    mut precondition: impl FnMut(&[f64], &mut [f64]),
    mut multiply: impl FnMut(&[f64], &mut [f64]),
) -> (Vec<f64>, Reached) {
    let n = residual.len();
    let norm = dot(&residual, &residual).sqrt();
    let mut small = Triangle::new(norm);
    let mut basis = vec![scaled(residual, norm)];
    let mut steps: Vec<Vec<f64>> = Vec::new();
    while steps.len() < iterations_max && small.residual() > goal {
        let last = &basis[steps.len()];
        let mut step = vec![0.0; n];
        precondition(last, &mut step);
        let mut next = vec![0.0; n];
        multiply(&step, &mut next);
        let mut column = Vec::with_capacity(basis.len() + 1);
        for vector in &basis {
            let share = dot(vector, &next);
            for (slot, value) in next.iter_mut().zip(vector) {
                *slot -= share * value;
            }
            column.push(share);
        }
        let left = dot(&next, &next).sqrt();
        column.push(left);
        if !column.iter().all(|value| value.is_finite()) {
            break;
        }
        small.push(column);
        steps.push(step);
        basis.push(scaled(next, left));
        if left == 0.0 {
            break;
        }
    }
    let mut x = vec![0.0; n];
    for (share, step) in small.solution().iter().zip(&steps) {
        for (slot, value) in x.iter_mut().zip(step) {
            *slot += share * value;
        }
    }
    let reached = Reached {
        iterations: steps.len(),
        residual: small.residual(),
    };
    (x, reached)
}

/// H, made triangular.
struct Triangle {
    /// Columns, each down to the diagonal.
    columns: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    right: Vec<f64>,
}

impl Triangle {
    fn new(norm: f64) -> Triangle {
        Triangle {
            columns: Vec::new(),
            rotations: Vec::new(),
            right: vec![norm],
        }
    }

    /// Norm of what is left.
    fn residual(&self) -> f64 {
        self.right.last().map_or(0.0, |value| value.abs())
    }

    /// Add a column of H.
    fn push(&mut self, mut column: Vec<f64>) {
        for (k, &(cosine, sine)) in self.rotations.iter().enumerate() {
            let (upper, lower) = (column[k], column[k + 1]);
            column[k] = cosine * upper + sine * lower;
            column[k + 1] = cosine * lower - sine * upper;
        }
        let k = self.rotations.len();
        let length = column[k].hypot(column[k + 1]);
        let (cosine, sine) = match length > 0.0 {
            true => (column[k] / length, column[k + 1] / length),
            false => (1.0, 0.0),
        };
        column[k] = length;
        column.truncate(k + 1);
        let upper = self.right[k];
        self.right[k] = cosine * upper;
        self.right.push(-sine * upper);
        self.rotations.push((cosine, sine));
        self.columns.push(column);
    }

    /// y
    fn solution(&self) -> Vec<f64> {
        let mut y = self.right[..self.columns.len()].to_vec();
        for (k, column) in self.columns.iter().enumerate().rev() {
            if column[k] == 0.0 {
                y[k] = 0.0;
                continue;
            }
            y[k] /= column[k];
            let value = y[k];
            for (slot, entry) in y[..k].iter_mut().zip(column) {
                *slot -= entry * value;
            }
        }
        y
    }
}

fn scaled(mut vector: Vec<f64>, norm: f64) -> Vec<f64> {
    if norm > 0.0 {
        vector.iter_mut().for_each(|value| *value /= norm);
    }
    vector
}

/// Several sums at once, added up in a fixed order.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    const SUMS: usize = 8;
    let mut sums = [0.0; SUMS];
    let (a, a_rest) = a.as_chunks::<SUMS>();
    let (b, b_rest) = b.as_chunks::<SUMS>();
    for (a, b) in a.iter().zip(b) {
        (0..SUMS).for_each(|k| sums[k] += a[k] * b[k]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_system_is_solved_in_as_many_steps_as_it_has_unknowns() {
        let matrix = [
            [4.0, 1.0, 0.0, 2.0],
            [-1.0, 3.0, 0.5, 0.0],
            [0.0, 2.0, 5.0, 1.0],
            [1.0, 0.0, -2.0, 2.0],
        ];
        let right = vec![1.0, -2.0, 0.5, 3.0];
        let multiply = |z: &[f64], w: &mut [f64]| {
            for (slot, row) in w.iter_mut().zip(&matrix) {
                *slot = dot(row, z);
            }
        };
        // A preconditioner that is another one every time.
        let mut count = 0.0;
        let precondition = |v: &[f64], z: &mut [f64]| {
            count += 1.0;
            (0..4).for_each(|k| z[k] = v[k] / (matrix[k][k] + count));
        };
        let (x, reached) = solve(right.clone(), 1e-13, 10, precondition, multiply);
        let mut product = vec![0.0; 4];
        multiply(&x, &mut product);
        let apart = product.iter().zip(&right).map(|(a, b)| (a - b).abs());
        assert!(apart.fold(0.0, f64::max) < 1e-12);
        assert!(reached.iterations == 4 && reached.residual < 1e-13);
    }
}
