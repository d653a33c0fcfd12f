//! How far the impulses are from the laws of all contacts.
//!
//! The natural map (law) is an impulse; it is compared with the impulse that the force on a
//! grain gives in a sub-step:
//!
//! ```text
//!   e_c = |natural map|_c / (δt F_c)                                                      (D5)
//!   F_i = m_i |g| + |q_i − γ_i v_i^n|                                                     (D6)
//!   F_c = min( r_c/(10 W_nn δt²), max( min(F_i, F_j), m_c max(ā/10, â/100) ) )            (D7)
//!   ā = Σ F_i / Σ m_i,    â = rms over contacts of [−U_n(v_free)]₊ /(W_nn δt m_c)
//! ```
//!
//! A free grain at rest gains the velocity δt F/(m + γδt), and W_nn e_c δt F_c is the violation
//! of the laws in velocity, so e is relative to the free velocity increment of the lighter grain:
//! without drag to |g|δt, with stiff drag to |g|m/γ, which may be 1e-5 of it. F uses the sum of
//! the magnitudes, because at terminal speed weight and drag cancel. Immobile partners do not
//! count. The floor (D7) serves grains on which nothing acts, as in an impact without gravity:
//! a tenth of the mean force per mass, or a hundredth of the rms impact. The cap keeps what a
//! violation can move grains into each other to a tenth of the smaller radius r_c, times the
//! tolerance; it acts where forces would move a grain farther than that in a sub-step.
//! m_c is the smaller mass. The root mean square is
//! over engaged contacts (R_n > 0 or U_n < 0), so it does not depend on the detection margin.

use space::{Dim, Dimension, Vector, hypot};

use crate::contact::delassus::{Contact, System};
use crate::contact::law::natural_map;
use crate::contact::loads::Loads;
use crate::grains::Grains;

/// How far the impulses are from the laws, in the unit of (D5).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Residual {
    /// Root mean square over engaged contacts.
    pub rms: f64,
    /// Largest.
    pub max: f64,
}

/// The worst contact may have this many times the tolerance.
pub const MAX_OVER_RMS: f64 = 20.0;

impl Residual {
    /// Good enough: rms below the tolerance, no contact far above it. Not finite is not good.
    pub fn within(&self, tolerance: f64) -> bool {
        self.rms <= tolerance && self.max <= MAX_OVER_RMS * tolerance
    }

    /// One number to compare iterates by.
    pub fn size(&self) -> f64 {
        self.rms.max(self.max / MAX_OVER_RMS)
    }
}

/// F (D6) \[N\].
pub fn force_scale<const D: usize>(
    grains: &Grains,
    loads: &Loads<'_, D>,
    velocity: &[Vector<D>],
    grain: usize,
) -> f64
where
    Dim<D>: Dimension<D>,
{
    let (drag, force) = loads.on(grain);
    let applied = hypot(&(force - velocity[grain] * drag));
    grains.mass[grain] * hypot(&loads.gravity) + applied
}

impl<const D: usize> System<D>
where
    Dim<D>: Dimension<D>,
{
    /// Set the weights of the residual (D5)–(D7); call at the free velocity.
    pub fn set_weights(&mut self, grains: &Grains, loads: &Loads<'_, D>, velocity: &[Vector<D>]) {
        let force: Vec<f64> = (0..grains.count())
            .map(|grain| force_scale(grains, loads, velocity, grain))
            .collect();
        let floor = self.floor(grains, &force, loads.dt);
        let weight = |contact: &Contact<D>| {
            let floor = floor * self.smaller(contact, &grains.mass);
            let radius = self.smaller(contact, &grains.radius);
            let cap = 0.1 * radius * contact.mass.normal / (loads.dt * loads.dt);
            let scale = loads.dt * self.smaller(contact, &force).max(floor).min(cap);
            if scale > 0.0 { 1.0 / scale } else { 0.0 }
        };
        self.weights = self.contacts.iter().map(weight).collect();
    }

    /// max(ā/10, â/100) of (D7) \[m/s²\].
    fn floor(&self, grains: &Grains, force: &[f64], dt: f64) -> f64 {
        let (mut force_sum, mut mass_sum) = (0.0, 0.0);
        for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
            force_sum += force[grain];
            mass_sum += grains.mass[grain];
        }
        let (mut squares, mut engaged) = (0.0, 0usize);
        for contact in &self.contacts {
            let violation = -self.speed(contact).normal;
            if violation > 0.0 {
                let mass = self.smaller(contact, &grains.mass);
                squares += (violation * contact.mass.normal / (dt * mass)).powi(2);
                engaged += 1;
            }
        }
        let impact = (squares / engaged.max(1) as f64).sqrt();
        f64::max(0.1 * force_sum / mass_sum, 0.01 * impact)
    }

    /// The smaller value of the bodies of a contact that can move.
    fn smaller(&self, contact: &Contact<D>, of: &[f64]) -> f64 {
        let one = |body: u32| match self.bodies[body as usize].inverse_mass > 0.0 {
            true => of[body as usize],
            false => f64::INFINITY,
        };
        one(contact.first).min(one(contact.second))
    }

    /// The residual at the present impulses and velocities.
    pub fn residual(&self) -> Residual {
        let rough = self.has_friction();
        let (mut squares, mut max, mut engaged) = (0.0, 0.0, 0usize);
        for (contact, weight) in self.contacts.iter().zip(&self.weights) {
            let speed = self.speed(contact);
            if contact.impulse.normal == 0.0 && speed.normal >= 0.0 {
                continue;
            }
            let friction = self.friction_of(contact);
            let mut map = natural_map(&contact.impulse, &speed, &contact.mass, friction);
            if !rough {
                map.tangential = Default::default();
            }
            let square = map.dot(&map) * weight * weight;
            squares += square;
            max = if square > max { square } else { max };
            engaged += 1;
        }
        Residual {
            rms: (squares / engaged.max(1) as f64).sqrt(),
            max: max.sqrt(),
        }
    }
}
