//! The law of one contact: inelastic impact with a gap, and Coulomb friction.
//!
//! ```text
//!   0 ≤ R_n  ⊥  U_n ≥ 0,   U_n = u_n + b,   b = max(gap, 0)/δt                        (L1)
//!   R_t = −μ R_n u_t/|u_t|  if u_t ≠ 0,   |R_t| ≤ μ R_n otherwise                      (L2)
//! ```
//!
//! (L1) is Signorini's condition at the end of the sub-step, to first order in the rotation of
//! the normal; for balls and flat walls it can never create an overlap. An overlap that is
//! already there gives b = 0: it is kept by the velocities and removed by `correct`, which moves
//! grains without giving them velocity, so recovering an overlap never adds energy.
//!
//! Both laws are projections, for any positive k: R_n = [R_n − k U_n]₊ and R_t = the nearest to
//! R_t − k_t u_t that is no longer than μ R_n. With k = 1/W (W the diagonal of the Delassus operator)
//! that is a Gauss–Seidel visit (Moreau, Jean 1992); what is left of the equality is the natural map.

use space::{Dim, Dimension, Linear, Tangent};

/// An impulse \[N s\], a force \[N\] or a velocity \[m/s\] in the frame of a contact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Local<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// Along the normal.
    pub normal: f64,
    /// In the tangent plane.
    pub tangential: Tangent<D>,
}

impl<const D: usize> Local<D>
where
    Dim<D>: Dimension<D>,
{
    /// self − other
    #[inline(always)]
    pub fn minus(&self, other: &Local<D>) -> Local<D> {
        Local {
            normal: self.normal - other.normal,
            tangential: self.tangential - other.tangential,
        }
    }

    /// self + other
    #[inline(always)]
    pub fn plus(&self, other: &Local<D>) -> Local<D> {
        Local {
            normal: self.normal + other.normal,
            tangential: self.tangential + other.tangential,
        }
    }

    /// factor · self
    #[inline(always)]
    pub fn times(&self, factor: f64) -> Local<D> {
        Local {
            normal: factor * self.normal,
            tangential: self.tangential * factor,
        }
    }

    /// self / divisor
    #[inline(always)]
    pub fn over(&self, divisor: f64) -> Local<D> {
        Local {
            normal: self.normal / divisor,
            tangential: self.tangential / divisor,
        }
    }

    /// Product with another one: an energy \[J\] of an impulse and a velocity.
    #[inline(always)]
    pub fn dot(&self, other: &Local<D>) -> f64 {
        self.normal * other.normal + self.tangential.dot(other.tangential)
    }
}

/// What a contact resists a change of velocity with \[kg\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EffectiveMass {
    /// 1/W_nn.
    pub normal: f64,
    /// 1/W_tt.
    pub tangential: f64,
}

/// Coulomb coefficients μ.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Friction {
    /// Between grains.
    pub grains: f64,
    /// Between a grain and a wall.
    pub walls: f64,
}

impl Friction {
    /// Does any contact resist sliding?
    pub fn acts(&self) -> bool {
        self.grains > 0.0 || self.walls > 0.0
    }
}

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
pub fn tangential_impulse<const D: usize>(
    old: Tangent<D>,
    tangential_speed: Tangent<D>,
    k: f64,
    limit: f64,
    relaxation: f64,
) -> Tangent<D>
where
    Dim<D>: Dimension<D>,
{
    Dim::<D>::limited(old - tangential_speed * (relaxation * k), limit)
}

/// Natural map of one contact \[N s\]: 0 where both laws hold.
///
/// `impulse` = (R_n, R_t), `speed` = (U_n, u_t).
#[inline]
pub fn natural_map<const D: usize>(
    impulse: &Local<D>,
    speed: &Local<D>,
    mass: &EffectiveMass,
    friction: f64,
) -> Local<D>
where
    Dim<D>: Dimension<D>,
{
    let normal = normal_impulse(impulse.normal, speed.normal, mass.normal, 1.0);
    let (old, speed) = (impulse.tangential, speed.tangential);
    let limit = friction * impulse.normal;
    let tangential = tangential_impulse::<D>(old, speed, mass.tangential, limit, 1.0);
    impulse.minus(&Local { normal, tangential })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A number in the plane, a vector in space.
    fn tangent<const D: usize>(numbers: [f64; 3]) -> Tangent<D>
    where
        Dim<D>: Dimension<D>,
    {
        Linear::from_components(|k| numbers[k])
    }

    fn stays_in_the_cone<const D: usize>(
        old: [f64; 4],
        speed: [f64; 4],
        k: f64,
        mu: f64,
        w: f64,
    ) -> Result<(), TestCaseError>
    where
        Dim<D>: Dimension<D>,
    {
        let normal = normal_impulse(old[3].abs(), speed[3], k, w);
        let [old, speed] = [old, speed].map(|v| tangent::<D>([v[0], v[1], v[2]]));
        let tangential = tangential_impulse::<D>(old, speed, k / 3.0, mu * normal, w);
        prop_assert!(normal >= 0.0);
        prop_assert!(tangential.length() <= mu * normal * (1.0 + 1e-15));
        Ok(())
    }

    fn solves_a_lone_contact<const D: usize>(
        speed: [f64; 4],
        k: f64,
        mu: f64,
    ) -> Result<(), TestCaseError>
    where
        Dim<D>: Dimension<D>,
    {
        // Velocities answer to impulses through W = 1/k, here without coupling.
        let (un, ut) = (speed[3], tangent::<D>([speed[0], speed[1], speed[2]]));
        let normal = normal_impulse(0.0, un, k, 1.0);
        let rest = Tangent::<D>::default();
        let tangential = tangential_impulse::<D>(rest, ut, k / 3.0, mu * normal, 1.0);
        let after = Local {
            normal: un + normal / k,
            tangential: ut + tangential * (3.0 / k),
        };
        let impulse = Local { normal, tangential };
        let mass = EffectiveMass {
            normal: k,
            tangential: k / 3.0,
        };
        let left = natural_map(&impulse, &after, &mass, mu);
        prop_assert!(left.normal.abs() <= 1e-11 * k && left.tangential.length() <= 1e-11 * k);
        prop_assert!(after.normal >= -1e-12 && normal * after.normal <= 1e-10 * k);
        // Friction never pushes forward.
        prop_assert!(tangential.dot(ut) <= 0.0);
        prop_assert!(tangential.dot(after.tangential) <= 1e-10 * k);
        // It opposes what slides: |R_t| |u_t| = −R_t·u_t.
        let opposed = tangential.length() * after.tangential.length();
        prop_assert!((opposed + tangential.dot(after.tangential)).abs() <= 1e-10 * k);
        Ok(())
    }

    fn numbers() -> impl Strategy<Value = [f64; 4]> {
        prop::array::uniform4(-10.0..10.0f64)
    }

    proptest! {
        #[test]
        fn impulses_stay_in_the_coulomb_cone(
            old in numbers(), speed in numbers(), k in 1e-6..1e3f64, mu in 0.0..2.0f64,
            w in 0.1..1.9f64,
        ) {
            stays_in_the_cone::<2>(old, speed, k, mu, w)?;
            stays_in_the_cone::<3>(old, speed, k, mu, w)?;
        }

        #[test]
        fn a_visit_of_a_lone_contact_solves_its_laws(
            speed in numbers(), k in 1e-6..1e3f64, mu in 0.0..2.0f64,
        ) {
            solves_a_lone_contact::<2>(speed, k, mu)?;
            solves_a_lone_contact::<3>(speed, k, mu)?;
        }

        #[test]
        fn the_natural_map_vanishes_only_where_the_laws_hold(
            rn in 0.0..10.0f64, un in -10.0..10.0f64, k in 1e-3..1e3f64,
        ) {
            let along = |normal| Local::<2> { normal, tangential: 0.0 };
            let mass = EffectiveMass { normal: k, tangential: k };
            let normal = natural_map(&along(rn), &along(un), &mass, 0.0).normal;
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
