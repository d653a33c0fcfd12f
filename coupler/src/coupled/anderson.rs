//! Anderson acceleration of a fixed-point iteration x ← g(x) (type II, depth m).
//!
//! ```text
//!   x_{k+1} = g_k − Σ_j θ_j (g_{k−j+1} − g_{k−j}),   θ minimises |W (f_k − Σ θ_j Δf_j)|,  f = g − x   (N1)
//! ```
//!
//! Anderson 1965; Walker and Ni 2011. W is a positive diagonal weight that makes the parts of x
//! comparable. Nearly dependent columns are dropped.

use nalgebra::{DMatrix, DVector};

/// History of an iteration with a fixed map.
#[derive(Debug)]
pub struct Anderson {
    depth: usize,
    weights: Vec<f64>,
    last: Option<(Vec<f64>, Vec<f64>)>,
    /// Differences of weighted residuals and of images, oldest first.
    history: Vec<(Vec<f64>, Vec<f64>)>,
}

impl Anderson {
    /// An empty history of this depth; `weights` is the diagonal of W.
    pub fn new(depth: usize, weights: Vec<f64>) -> Anderson {
        Anderson {
            depth,
            weights,
            last: None,
            history: Vec::new(),
        }
    }

    /// The next iterate from x and g(x).
    pub fn next(&mut self, x: &[f64], image: &[f64]) -> Vec<f64> {
        let residual: Vec<f64> = (0..x.len())
            .map(|i| self.weights[i] * (image[i] - x[i]))
            .collect();
        if let Some((last_residual, last_image)) = &self.last {
            let residual_change = difference(&residual, last_residual);
            let image_change = difference(image, last_image);
            self.history.push((residual_change, image_change));
            if self.history.len() > self.depth {
                self.history.remove(0);
            }
        }
        let factors = self.factors(&residual);
        let mut next = image.to_vec();
        for (factor, (_, image_change)) in factors.iter().zip(&self.history) {
            next.iter_mut()
                .zip(image_change)
                .for_each(|(value, change)| *value -= factor * change);
        }
        self.last = Some((residual, image.to_vec()));
        next
    }

    /// θ of (N1), by a truncated singular value decomposition of the scaled normal equations.
    fn factors(&self, residual: &[f64]) -> Vec<f64> {
        let count = self.history.len();
        if count == 0 {
            return Vec::new();
        }
        let norms: Vec<f64> = self
            .history
            .iter()
            .map(|(f, _)| dot(f, f).sqrt().max(f64::MIN_POSITIVE))
            .collect();
        let gram = DMatrix::from_fn(count, count, |i, j| {
            dot(&self.history[i].0, &self.history[j].0) / (norms[i] * norms[j])
        });
        let right = DVector::from_fn(count, |i, _| dot(&self.history[i].0, residual) / norms[i]);
        let eigen = gram.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let mut scaled = DVector::zeros(count);
        for k in 0..count {
            if eigen.eigenvalues[k] > 1e-12 * largest {
                let vector = eigen.eigenvectors.column(k);
                scaled += vector * (vector.dot(&right) / eigen.eigenvalues[k]);
            }
        }
        (0..count).map(|i| scaled[i] / norms[i]).collect()
    }
}

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
