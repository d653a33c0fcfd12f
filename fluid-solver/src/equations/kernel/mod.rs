//! The blocks of all simplices, four at a time: `momentum` and `continuity` with all sums over quadrature
//! points taken first.
//!
//! With g_i = ∇N_i, s = ∇φ, X = N/φ, w = weight × volume, P, M_j, d_j, st_i and F as in `point`, and at a point
//! y_j = a·g_j − X_j a·s, st_i = τρ y_i + d_i/φ, T_j = ρ(α/Δt N_j + y_j) + b_j:
//!
//! ```text
//!   D_ij = Σ_q w(X_i + st_i) T_j    A_ij = Σ_q w X_i X_j/φ    W_ij = Σ_q w st_i X_j/φ
//!   U_i  = Σ_q w(X_i + st_i) P      Λ_j  = Σ_q wP T_j         Π_i  = Σ_q wP X_i/φ
//!   Ξ_i  = Σ_q w X_i                Σ    = Σ_q wP²                                             (K1)
//! ```
//!
//! and since Σ_j φ_j X_j = 1, once a simplex A_i = Σ_j φ_j A_ij, A_0 = Σ_i φ_i A_i, V_i = Σ_j φ_j W_ij,
//! Π = Σ_i φ_i Π_i, Θ_id = g_id Π − s_d Π_i + Ξ_i ∂_dP:
//!
//! ```text
//!   u_d,u_f  δ_df [D_ij + μ(V_i s·g_j − W_ij s²) + μ(A_0 g_i·g_j − A_i s·g_j − A_j s·g_i + A_ij s²)]
//!            + μ[A_0 g_if g_jd − A_i s_f g_jd − A_j g_if s_d + A_ij s_f s_d]
//!            + μ s_d (V_i g_jf − W_ij s_f) + τ_c Θ_id g_jf (1 + c_j/φ_j)                          (K2)
//!   u_d,p    U_i g_jd − τ_c Θ_id ∇κ·g_j
//!   p,u_f    g_if [τΛ_j + τμ(Π s·g_j − Π_j s²) − V/N (1 + c_j/φ_j) − V d_j]
//!            + τμ g_i·s (Π g_jf − Π_j s_f)
//!   p,p      (τΣ + V κ¯) g_i·g_j
//!   right    Σ_q w(X_i + st_i) F_d − τ_c Θ_id ∇·j⁰,   g_i·(V j⁰¯ + τ Σ_q wP F)                    (K3)
//! ```
//!
//! A group whose nodes are all in clear fluid takes the closed form of `clear`. Newton's term, the literal
//! viscous form and a body force are not here: `point` has them.

mod blocks;
mod clear;
mod energy;
mod group;
mod groups;
mod lanes;
mod porous;
mod records;
mod sums;

pub use self::group::{GroupMatrix, GroupRight};
pub use self::groups::Kernel;
pub use self::lanes::{LANES, Lanes};
