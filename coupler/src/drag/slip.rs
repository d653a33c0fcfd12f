//! The slip that the drag itself decides within a step.

use protocol::scene::DragLaw;

use crate::drag::laws::{Fluid, Shape, coefficient};

/// The slip speed at the end of a step that the drag itself decides: the root s of
///
/// ```text
///   (m/Δt + γ(s)) s = |m/Δt w + F|      (D7)
/// ```
///
/// with the slip w at its start and the force F on the grain. With it γ is as implicit as the
/// velocity: a lagged γ oscillates between two values for ever once Δt γ/m is large and γ ∝ |w|.
pub fn implicit_slip_speed(
    law: DragLaw,
    fluid: &Fluid,
    porosity: f64,
    grain: &Shape,
    inertia: f64,
    drive: f64,
) -> f64 {
    if drive == 0.0 {
        return 0.0;
    }
    let excess =
        |speed: f64| (inertia + coefficient(law, fluid, porosity, speed, grain)) * speed - drive;
    // γ(0) > 0 and γ does not fall with s, so the root lies in [0, drive/(inertia + γ(0))]
    let mut low = 0.0;
    let mut high = drive / (inertia + coefficient(law, fluid, porosity, 0.0, grain));
    let mut speed = high;
    for _ in 0..200 {
        let value = excess(speed);
        if value > 0.0 {
            high = speed;
        } else {
            low = speed;
        }
        let shift = 1e-6 * speed;
        let slope = (excess(speed + shift) - value) / shift;
        let newton = speed - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - speed).abs() <= 4.0 * f64::EPSILON * speed {
            return next;
        }
        speed = next;
    }
    speed
}
