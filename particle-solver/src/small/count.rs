//! How many sub-steps.
//!
//! A contact that a force F presses sinks by δ = W F h² before the impulse is there that carries it. So that
//!
//! ```text
//!   rms over contacts of W F h²/r ≤ ε,   ε = 1e-3                                        (M6)
//! ```
//!
//! with the forces of the last sub-step of the accepted state, n = Δt √(rms(W F/r)/ε). Waves of load pass √2 grains a
//! sub-step or so, and n grows with the square root of the number of layers.

use space::{Dim, Dimension};

use crate::contact::impulses::Impulses;
use crate::grains::Grains;

/// ε.
pub const SINKING: f64 = 1e-3;
/// Fewest sub-steps of a step.
pub const LEAST: u32 = 8;

/// rms(W F/r) of the last sub-step \[1/s²\]; `drag` γ \[kg/s\].
pub fn load<const D: usize>(impulses: &Impulses<D>, grains: &Grains, drag: Option<&[f64]>) -> f64
where
    Dim<D>: Dimension<D>,
{
    let inverse_mass = |grain: u32| {
        let grain = grain as usize;
        match grains.fixed.get(grain) {
            Some(false) => {
                let drag = drag.map_or(0.0, |drag| drag[grain]);
                1.0 / (grains.mass[grain] + impulses.dt * drag)
            }
            _ => 0.0,
        }
    };
    let radius = |grain: u32| grains.radius.get(grain as usize).copied();
    let (mut squares, mut count) = (0.0, 0.0);
    for (key, impulse) in &impulses.entries {
        let one = radius(key.first).unwrap_or(f64::INFINITY);
        let smaller = one.min(radius(key.second).unwrap_or(f64::INFINITY));
        let w = inverse_mass(key.first) + inverse_mass(key.second);
        squares += (w * impulse.normal / (impulses.dt * smaller)).powi(2);
        count += 1.0;
    }
    (squares / f64::max(count, 1.0)).sqrt()
}
