//! Continuity of the mixture: rows of p, by parts, so that a closed box is compatible exactly.
//!
//! ```text
//!   ∇·(u + j⁰ + c v − κ∇p) = 0                                                   (C)
//!
//!   p,u_f     −∂_fN_i (N_j + e_j + d_j) + τP Σ_d ∂_dN_i S_j,df                          (C1)
//!   p,p       (τP² + κ) ∇N_i·∇N_j                                                 (C2)
//!   right     ∇N_i·j⁰ + τP ∇N_i·F − ∮ N_i Q_n                                     (C3)
//! ```
//!
//! Q_n is the mixture's flux out of the domain: 0 at walls whatever the solid flux carries there,
//! u·n of the given profile where the velocity is given, whatever a shared corner does (`boundary::flux`),
//! unknown where the pressure is (rows replaced).

use space::dot;
use space::vector::from_fn;

use super::momentum::{Matrix, RightSide};
use super::point::Point;

/// Add (C1) and (C2).
#[inline]
pub fn add_matrix<const D: usize, const N: usize>(at: &Point<D, N>, matrix: &mut Matrix<N>) {
    let relaxed = at.tau * at.mixture;
    let spread = relaxed * at.mixture + at.mobility;
    for i in 0..N {
        let g = &at.gradient[i];
        for j in 0..N {
            let row = &mut matrix[i][j][D];
            for f in 0..D {
                let mut strong = g[0] * at.strong[j][0][f];
                for d in 1..D {
                    strong += g[d] * at.strong[j][d][f];
                }
                row[f] += at.weight * (relaxed * strong - g[f] * at.flux[j]); // (C1)
            }
            row[D] += at.weight * spread * dot(g, &at.gradient[j]); // (C2)
        }
    }
}

/// Add (C3) without its boundary part.
#[inline]
pub fn add_right_side<const D: usize, const N: usize>(at: &Point<D, N>, right: &mut RightSide<N>) {
    let relaxed = at.tau * at.mixture;
    let carried = from_fn(|d| at.solid_flux[d] + relaxed * at.force[d]);
    for i in 0..N {
        right[i][D] += at.weight * dot(&at.gradient[i], &carried); // (C3)
    }
}
