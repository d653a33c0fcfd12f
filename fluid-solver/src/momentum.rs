//! Momentum: rows of u. Non-conservative, pressure not integrated by parts.
//!
//! ```text
//!   ρφ(∂v/∂t + a·∇v) + (φ + c)∇p − ∇·(2μφ D(v)) + βv = ρφ g + s                  (M)
//!
//!   u_d,u_f   X_i (ρφ D_t v_j + b_j) δ_df + μφ(∇X_i·∇X_j δ_df + ∂_fX_i ∂_dX_j)
//!             + st_i S_j,df + τ_c (∂_dP X_i + P ∂_dX_i) ∂_f(N_j + e_j)            (M1)
//!   u_d,p     (X_i + st_i) P ∂_dN_j − τ_c (…)_id ∇κ·∇N_j                          (M2)
//!   right     (X_i + st_i) F_d − τ_c (…)_id ∇·j⁰                                  (M3)
//! ```
//!
//! st_i = τρφ a·∇X_i (SUPG); τ_c tests div(P w) with the residual of continuity (grad-div). The
//! literal form of the paper has μφ∇X_i·∇X_j + μ∇φ·∇(X_i X_j) instead of the symmetric term: its
//! −μ v∇²φ is integrated by parts.

use crate::point::Point;

/// Element matrix: 3 unknowns (u_x, u_y, p) a node, node by node; rows are equations.
pub type Matrix = [[f64; 9]; 9];
/// Element right-hand side.
pub type Vector = [f64; 9];

/// Add (M1) and (M2).
#[inline]
pub fn add_matrix(at: &Point, matrix: &mut Matrix) {
    for i in 0..3 {
        let weighted = at.test[i] + at.streamline[i];
        for j in 0..3 {
            let diffusion = viscous_diagonal(at, i, j);
            let leak = at.tau_c * dot(at.mobility_gradient, at.gradient[j]);
            for d in 0..2 {
                let row = &mut matrix[3 * i + d];
                let squeeze = at.tau_c * at.test_divergence[i][d];
                for f in 0..2 {
                    let mut entry = at.streamline[i] * at.strong[j][d][f]
                        + squeeze * at.flux_gradient[j][f]
                        + at.test[i] * at.newton[d][f] * at.test[j];
                    if at.symmetric {
                        entry += at.viscosity * at.test_gradient[i][f] * at.test_gradient[j][d];
                    }
                    if d == f {
                        entry += at.test[i] * at.transport[j] + diffusion;
                    }
                    row[3 * j + f] += at.weight * entry; // (M1)
                }
                let push = weighted * at.mixture * at.gradient[j][d];
                row[3 * j + 2] += at.weight * (push - leak * at.test_divergence[i][d]); // (M2)
            }
        }
    }
}

/// Add (M3).
#[inline]
pub fn add_right_side(at: &Point, right: &mut Vector) {
    for i in 0..3 {
        let weighted = at.test[i] + at.streamline[i];
        for d in 0..2 {
            let squeeze = at.tau_c * at.test_divergence[i][d] * at.solid_divergence;
            right[3 * i + d] += at.weight * (weighted * at.force[d] - squeeze); // (M3)
        }
    }
}

#[inline]
fn viscous_diagonal(at: &Point, i: usize, j: usize) -> f64 {
    let (p, q) = (at.test_gradient[i], at.test_gradient[j]);
    let literal = at.test[i] * dot(at.literal, q) + at.test[j] * dot(at.literal, p);
    at.viscosity * dot(p, q) + literal
}

/// Scalar product.
#[inline]
pub fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
