//! A uniform pressure gradient that gives the flow through periodic sides the mean that is asked for.
//!
//! ```text
//!   p = p_h + Σ_k G_k x_k                                            k: axes that are periodic
//!   K x + Σ_k b_k G_k = r        b_k = (M2), (C2) with ∇N_j = e_k                            (D1)
//!   c_k·x + Σ_l e_kl G_l = r_k   (C1)–(C3) with ∇N_i = e_k;  ∮ x_k Q_n = U_k |Ω|             (D2)
//! ```
//!
//! | symbol | meaning | unit |
//! | ------ | ------- | ---- |
//! | G      | uniform part of ∇p | Pa/m |
//! | U      | flux of the mixture, u + j⁰ + c v − κ∇p, through unit area | m/s |
//!
//! The functions x_k join those of the pressure: their gradient is periodic although they are not. So
//! (D2) is the equation of continuity tested with x_k, the flux of the mixture through every section is U
//! to round-off, and the energy identity has −G·U|Ω| as the power of what drives the flow.

use std::ops::Range;

use rayon::prelude::*;
use space::vector::from_fn;
use space::{Dim, Dimension, Vector};

use super::coefficients::Coefficients;
use super::element::Element;
use super::point::Point;
use crate::mesh::simplices::Mesh;

/// Simplices whose parts are computed, on all threads, before they are added in order.
const BATCH: usize = 2048;

/// What the flow is to do on the whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive<const D: usize> {
    /// U \[m/s\].
    pub velocity: Vector<D>,
    /// Along which axes it is steered: the periodic ones.
    pub axes: [bool; D],
}

impl<const D: usize> Drive<D> {
    /// The axes that are steered.
    pub fn steered(&self) -> impl Iterator<Item = usize> + '_ {
        (0..D).filter(|&k| self.axes[k])
    }
}

/// The rows and columns of the functions x_k.
pub struct Border<const D: usize> {
    /// b_k, of all unknowns.
    pub columns: [Vec<f64>; D],
    /// c_k, of all unknowns.
    pub rows: [Vec<f64>; D],
    /// e_kl.
    pub corner: [[f64; D]; D],
    /// r_k; 0 along axes that are not steered.
    pub right: [f64; D],
}

/// The parts of a simplex: axis, node, then unknown.
#[derive(Clone, Copy)]
struct Part<const D: usize, const N: usize> {
    columns: [[[f64; N]; N]; D],
    rows: [[[f64; N]; N]; D],
    corner: f64,
    right: [f64; D],
}

impl<const D: usize> Border<D> {
    /// Of the equations on a mesh, whose unknowns follow the axes: a periodic domain is a rectangle.
    pub fn new<const N: usize>(
        terms: &Coefficients<'_, D>,
        mesh: &Mesh<D, N>,
        drive: &Drive<D>,
    ) -> Border<D>
    where
        Dim<D>: Dimension<D>,
    {
        let unknowns = N * mesh.node_count();
        let mut border = Border {
            columns: std::array::from_fn(|_| vec![0.0; unknowns]),
            rows: std::array::from_fn(|_| vec![0.0; unknowns]),
            corner: [[0.0; D]; D],
            right: [0.0; D],
        };
        let count = mesh.simplices.len();
        for first in (0..count).step_by(BATCH) {
            border.add(terms, mesh, drive, first..(first + BATCH).min(count));
        }
        let size: f64 = mesh.geometry.iter().map(|simplex| simplex.volume).sum();
        for k in drive.steered() {
            border.right[k] -= drive.velocity[k] * size;
        }
        border
    }

    /// Add these simplices, in their order.
    fn add<const N: usize>(
        &mut self,
        terms: &Coefficients<'_, D>,
        mesh: &Mesh<D, N>,
        drive: &Drive<D>,
        simplices: Range<usize>,
    ) where
        Dim<D>: Dimension<D>,
    {
        let parts: Vec<Part<D, N>> = simplices
            .clone()
            .into_par_iter()
            .map(|t| Part::of(&Element::gather(terms, mesh, t)))
            .collect();
        for (t, part) in simplices.zip(&parts) {
            for k in drive.steered() {
                for (i, &node) in mesh.simplices[t].iter().enumerate() {
                    for q in 0..N {
                        self.columns[k][N * node + q] += part.columns[k][i][q];
                        self.rows[k][N * node + q] += part.rows[k][i][q];
                    }
                }
                self.corner[k][k] += part.corner;
                self.right[k] += part.right[k];
            }
        }
    }

    /// G, where `start` is K⁻¹r and `responses` are K⁻¹b_k along the axes that are steered.
    pub fn gradient(
        &self,
        drive: &Drive<D>,
        start: &[f64],
        responses: &[Vec<f64>; D],
    ) -> Vector<D> {
        let mut matrix = [[0.0; D]; D];
        let mut right = [0.0; D];
        (0..D).for_each(|k| matrix[k][k] = 1.0);
        for k in drive.steered() {
            right[k] = self.right[k] - product(&self.rows[k], start);
            for l in drive.steered() {
                matrix[k][l] = self.corner[k][l] - product(&self.rows[k], &responses[l]);
            }
        }
        let gradient = quotient(matrix, right);
        from_fn(|k| gradient[k])
    }

    /// r − Σ b_k G_k
    pub fn pushed(&self, right: &[f64], gradient: &Vector<D>) -> Vec<f64> {
        let mut pushed = right.to_vec();
        for (column, g) in self.columns.iter().zip(gradient.iter()) {
            if *g != 0.0 {
                let pairs = pushed.iter_mut().zip(column);
                pairs.for_each(|(value, b)| *value -= b * g);
            }
        }
        pushed
    }
}

impl<const D: usize, const N: usize> Part<D, N>
where
    Dim<D>: Dimension<D>,
{
    fn of(element: &Element<'_, D, N>) -> Part<D, N> {
        let mut part = Part {
            columns: [[[0.0; N]; N]; D],
            rows: [[[0.0; N]; N]; D],
            corner: 0.0,
            right: [0.0; D],
        };
        for at in element.points() {
            part.add_column(&at);
            part.add_row(&at);
        }
        part
    }

    /// (D1)
    fn add_column(&mut self, at: &Point<D, N>) {
        let spread = at.tau * at.mixture * at.mixture + at.mobility;
        for k in 0..D {
            for i in 0..N {
                let weighted = at.test[i] + at.streamline[i];
                let leak = at.tau_c * at.mobility_gradient[k];
                let column = &mut self.columns[k][i];
                for d in 0..D {
                    column[d] -= at.weight * leak * at.test_divergence[i][d];
                }
                column[k] += at.weight * weighted * at.mixture;
                column[D] += at.weight * spread * at.gradient[i][k];
            }
        }
    }

    /// (D2)
    fn add_row(&mut self, at: &Point<D, N>) {
        let relaxed = at.tau * at.mixture;
        let spread = relaxed * at.mixture + at.mobility;
        for k in 0..D {
            for j in 0..N {
                let row = &mut self.rows[k][j];
                for f in 0..D {
                    row[f] += at.weight * relaxed * at.strong[j][k][f];
                }
                row[k] -= at.weight * at.flux[j];
                row[D] += at.weight * spread * at.gradient[j][k];
            }
            self.right[k] += at.weight * (at.solid_flux[k] + relaxed * at.force[k]);
        }
        self.corner += at.weight * spread;
    }
}

/// Σ c_j x_j
fn product(row: &[f64], x: &[f64]) -> f64 {
    row.iter().zip(x).map(|(c, x)| c * x).sum()
}

/// A⁻¹ b, by elimination with row exchanges.
fn quotient<const D: usize>(mut a: [[f64; D]; D], mut b: [f64; D]) -> [f64; D] {
    for k in 0..D {
        let largest = |best: usize, i: usize| {
            if a[i][k].abs() > a[best][k].abs() {
                i
            } else {
                best
            }
        };
        let pivot = (k + 1..D).fold(k, largest);
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in (0..D).filter(|&i| i != k) {
            let factor = a[i][k] / a[k][k];
            for j in k..D {
                a[i][j] -= factor * a[k][j];
            }
            b[i] -= factor * b[k];
        }
    }
    std::array::from_fn(|k| b[k] / a[k][k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_systems_are_solved_with_exchanges() {
        let a = [[0.0, 2.0, 1.0], [1.0, 1.0, 0.0], [3.0, 0.0, 1.0]];
        let x = [0.5, -2.0, 4.0];
        let b = a.map(|row: [f64; 3]| product(&row, &x));
        let found = quotient(a, b);
        assert!(found.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-14));
    }
}
