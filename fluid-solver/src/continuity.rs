//! Continuity of the mixture: rows of p, by parts, so that a closed box is compatible exactly.
//!
//! ```text
//!   ∇·(u + j⁰ + c v − κ∇p) = 0                                                   (C)
//!
//!   p,u_f     −∂_fN_i (N_j + e_j) + τP Σ_d ∂_dN_i S_j,df                          (C1)
//!   p,p       (τP² + κ) ∇N_i·∇N_j                                                 (C2)
//!   right     ∇N_i·j⁰ + τP ∇N_i·F − ∮ N_i Q_n                                     (C3)
//! ```
//!
//! Q_n is the mixture's flux out of the domain: 0 at walls whatever the solid flux carries there,
//! u·n where the velocity is given, unknown where the pressure is (rows replaced).

use crate::momentum::{Matrix, Vector, dot};
use crate::point::Point;

/// Add (C1) and (C2).
#[inline]
pub fn add_matrix(at: &Point, matrix: &mut Matrix) {
    let relaxed = at.tau * at.mixture;
    let spread = relaxed * at.mixture + at.mobility;
    for i in 0..3 {
        let row = &mut matrix[3 * i + 2];
        let g = at.gradient[i];
        for j in 0..3 {
            for f in 0..2 {
                let strong = g[0] * at.strong[j][0][f] + g[1] * at.strong[j][1][f];
                row[3 * j + f] += at.weight * (relaxed * strong - g[f] * at.flux[j]); // (C1)
            }
            row[3 * j + 2] += at.weight * spread * dot(g, at.gradient[j]); // (C2)
        }
    }
}

/// Add (C3) without its boundary part.
#[inline]
pub fn add_right_side(at: &Point, right: &mut Vector) {
    let relaxed = at.tau * at.mixture;
    let carried = [0, 1].map(|d| at.solid_flux[d] + relaxed * at.force[d]);
    for i in 0..3 {
        right[3 * i + 2] += at.weight * dot(at.gradient[i], carried); // (C3)
    }
}
