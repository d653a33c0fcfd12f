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
//! st_i = τρφ a·∇X_i (SUPG) + d_i/φ (held grains, `held`); τ_c tests div(P w) with the residual of continuity (grad-div). The
//! literal form of the paper has μφ∇X_i·∇X_j + μ∇φ·∇(X_i X_j) instead of the symmetric term: its
//! −μ v∇²φ is integrated by parts.

use space::dot;

use super::point::Point;

/// What couples two nodes: rows are equations, columns unknowns, (u, p).
pub type Block<const N: usize> = [[f64; N]; N];
/// Element matrix: a block for each pair of nodes, rows first.
pub type Matrix<const N: usize> = [[Block<N>; N]; N];
/// Element right-hand side, node by node.
pub type RightSide<const N: usize> = [[f64; N]; N];

/// Add (M1) and (M2).
#[inline]
pub fn add_matrix<const D: usize, const N: usize>(at: &Point<D, N>, matrix: &mut Matrix<N>) {
    for i in 0..N {
        let weighted = at.test[i] + at.streamline[i];
        for j in 0..N {
            let block = &mut matrix[i][j];
            let diffusion = viscous_diagonal(at, i, j);
            let leak = at.tau_c * dot(&at.mobility_gradient, &at.gradient[j]);
            for d in 0..D {
                let squeeze = at.tau_c * at.test_divergence[i][d];
                for f in 0..D {
                    let mut entry = at.streamline[i] * at.strong[j][d][f]
                        + squeeze * at.flux_gradient[j][f]
                        + at.test[i] * at.newton[d][f] * at.test[j];
                    if at.symmetric {
                        entry += at.viscosity * at.test_gradient[i][f] * at.test_gradient[j][d];
                    }
                    if d == f {
                        entry += at.test[i] * at.transport[j] + diffusion;
                    }
                    block[d][f] += at.weight * entry; // (M1)
                }
                let push = weighted * at.mixture * at.gradient[j][d];
                block[d][D] += at.weight * (push - leak * at.test_divergence[i][d]); // (M2)
            }
        }
    }
}

/// Add (M3).
#[inline]
pub fn add_right_side<const D: usize, const N: usize>(at: &Point<D, N>, right: &mut RightSide<N>) {
    for i in 0..N {
        let weighted = at.test[i] + at.streamline[i];
        for d in 0..D {
            let squeeze = at.tau_c * at.test_divergence[i][d] * at.solid_divergence;
            right[i][d] += at.weight * (weighted * at.force[d] - squeeze); // (M3)
        }
    }
}

#[inline]
fn viscous_diagonal<const D: usize, const N: usize>(at: &Point<D, N>, i: usize, j: usize) -> f64 {
    let (p, q) = (&at.test_gradient[i], &at.test_gradient[j]);
    let literal = at.test[i] * dot(&at.literal, q) + at.test[j] * dot(&at.literal, p);
    at.viscosity * dot(p, q) + literal
}
