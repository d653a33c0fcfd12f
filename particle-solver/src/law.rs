//! The law of one contact: inelastic impact with a gap, and Coulomb friction.
//!
//! ```text
//!   0 ≤ R_n  ⊥  U_n ≥ 0,   U_n = u_n + b,   b = max(gap, 0)/δt                        (L1)
//!   R_t = −μ R_n sign(u_t)  if u_t ≠ 0,   |R_t| ≤ μ R_n otherwise                      (L2)
//! ```
//!
//! (L1) is Signorini's condition at the end of the sub-step, to first order in the rotation of
//! the normal; for disks and straight walls it can never create an overlap. An overlap that is
//! already there gives b = 0: it is kept by the velocities and removed by `correct`, which moves
//! grains without giving them velocity, so recovering an overlap never adds energy.
//!
//! Both laws are projections, for any positive k: R_n = [R_n − k U_n]₊ and R_t = clamp(R_t − k_t u_t).
//! With k = 1/W (W the diagonal of the Delassus operator) that is a Gauss–Seidel visit (Moreau,
//! Jean 1992); what is left of the equality is the natural map.

/// b of a contact \[m/s\]: speed at which it may still close.
pub fn closing_speed(gap: f64, dt: f64) -> f64 {
    gap.max(0.0) / dt
}

/// R_n after a visit (L1); `relaxation` multiplies the change, `k` = 1/W_nn \[kg\].
#[inline]
pub fn normal_impulse(old: f64, normal_speed: f64, k: f64, relaxation: f64) -> f64 {
    (old - relaxation * k * normal_speed).max(0.0)
}

/// R_t after a visit (L2); `limit` = μ R_n \[N s\], `k` = 1/W_tt \[kg\].
#[inline]
pub fn tangential_impulse(
    old: f64,
    tangential_speed: f64,
    k: f64,
    limit: f64,
    relaxation: f64,
) -> f64 {
    (old - relaxation * k * tangential_speed)
        .min(limit)
        .max(-limit)
}

/// Natural map of one contact \[N s\]: 0 where both laws hold.
///
/// `impulse` = (R_n, R_t), `speed` = (U_n, u_t), `k` = (1/W_nn, 1/W_tt).
#[inline]
pub fn natural_map(impulse: [f64; 2], speed: [f64; 2], k: [f64; 2], friction: f64) -> [f64; 2] {
    let normal = impulse[0] - normal_impulse(impulse[0], speed[0], k[0], 1.0);
    let limit = friction * impulse[0];
    let tangential = impulse[1] - tangential_impulse(impulse[1], speed[1], k[1], limit, 1.0);
    [normal, tangential]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn impulses_stay_in_the_coulomb_cone(
            old in 0.0..10.0f64, old_t in -10.0..10.0f64, un in -10.0..10.0f64,
            ut in -10.0..10.0f64, k in 1e-6..1e3f64, mu in 0.0..2.0f64, w in 0.1..1.9f64,
        ) {
            let normal = normal_impulse(old, un, k, w);
            let tangential = tangential_impulse(old_t, ut, k / 3.0, mu * normal, w);
            prop_assert!(normal >= 0.0);
            prop_assert!(tangential.abs() <= mu * normal);
        }

        #[test]
        fn a_visit_of_a_lone_contact_solves_its_laws(
            un in -10.0..10.0f64, ut in -10.0..10.0f64, k in 1e-6..1e3f64, mu in 0.0..2.0f64,
        ) {
            // Velocities answer to impulses through W = 1/k, here without coupling.
            let normal = normal_impulse(0.0, un, k, 1.0);
            let tangential = tangential_impulse(0.0, ut, k / 3.0, mu * normal, 1.0);
            let speed = [un + normal / k, ut + tangential * 3.0 / k];
            let left = natural_map([normal, tangential], speed, [k, k / 3.0], mu);
            prop_assert!(left[0].abs() <= 1e-12 * k * 10.0 && left[1].abs() <= 1e-12 * k * 10.0);
            prop_assert!(speed[0] >= -1e-12 && normal * speed[0] <= 1e-10 * k);
            // Friction never pushes forward.
            prop_assert!(tangential * ut <= 0.0 && tangential * speed[1] <= 1e-10 * k);
        }

        #[test]
        fn the_natural_map_vanishes_only_where_the_laws_hold(
            rn in 0.0..10.0f64, un in -10.0..10.0f64, k in 1e-3..1e3f64,
        ) {
            let normal = natural_map([rn, 0.0], [un, 0.0], [k, k], 0.0)[0];
            let holds = un >= 0.0 && rn * un == 0.0;
            prop_assert_eq!(normal == 0.0, holds || (rn > 0.0 && rn - k * un == rn));
            prop_assert!((normal - (k * un).min(rn)).abs() <= 1e-12 * (rn + k * un.abs()));
        }
    }

    #[test]
    fn an_overlap_gives_no_speed() {
        assert_eq!(closing_speed(-1.0, 1e-3), 0.0);
        assert_eq!(closing_speed(2e-3, 1e-3), 2.0);
    }
}
