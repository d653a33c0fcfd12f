//! What a run's grains and walls are, apart from how rapier moves them.

use clap::Args;
use space::{Dim, Dimension, Vector, hypot, simplex};

/// Settings of the contact solver; each is an argument of the program.
#[derive(Debug, Clone, Copy, Args)]
pub struct Settings {
    /// Natural frequency of contacts (Hz); a grain at rest overlaps by about g/(2πf)²
    #[arg(long, value_name = "HZ", default_value_t = 400.0, value_parser = positive)]
    pub frequency: f64,
    /// Damping ratio of contacts; 1: critical
    #[arg(long, value_name = "ZETA", default_value_t = 1.0, value_parser = positive)]
    pub damping_ratio: f64,
    /// Solver iterations in a sub-step
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub iterations: u16,
    /// Longest sub-step (s)
    #[arg(long, value_name = "SECONDS", default_value_t = 2e-3, value_parser = positive)]
    pub sub_step_max: f64,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if f64::is_finite(value) && value > 0.0 => Ok(value),
        _ => Err("must be a positive number".to_owned()),
    }
}

/// What does not change.
#[derive(Debug, Clone)]
pub struct Model<const D: usize> {
    /// Settings of the solver.
    pub settings: Settings,
    /// g \[m/s²\].
    pub gravity: Vector<D>,
    /// Corners of the walls \[m\]: segments with the grains on their left, in space triangles with the
    /// grains where their corners are seen clockwise.
    pub walls: Vec<[Vector<D>; D]>,
    /// Coulomb coefficients, between grains and with walls.
    pub friction: [f64; 2],
    /// Radii \[m\].
    pub radius: Vec<f64>,
    /// Masses \[kg\].
    pub mass: Vec<f64>,
    /// Moments of inertia \[kg m²\].
    pub inertia: Vec<f64>,
    /// Grains that never move.
    pub fixed: Vec<bool>,
}

impl<const D: usize> Model<D> {
    /// Mean diameter \[m\]: rapier's unit of length, to which its margins are relative.
    pub fn length(&self) -> f64 {
        2.0 * self.radius.iter().sum::<f64>() / self.radius.len().max(1) as f64
    }

    /// |g| \[m/s²\].
    pub fn weight(&self) -> f64 {
        hypot(&self.gravity)
    }

    /// Rapier's speed of recovery from overlaps \[m/s\]: its 3 m/s for bodies of 1 m under 9.81 m/s² is √(g d).
    pub fn recovery(&self) -> f64 {
        (self.weight().max(1.0) * self.length()).sqrt()
    }
}

/// The first grain that crossed a wall from one place to another, and the wall.
///
/// ```text
///   p = w₀ q + Σ w_i c_i      weights of the place before, in the simplex of the place after and the wall
///   crossed where w_i ≥ 0:    w_i/(1 − w₀) are the weights of the point where p → q meets the wall
/// ```
pub fn crossing<const D: usize, const N: usize>(
    model: &Model<D>,
    before: &[Vector<D>],
    after: &[Vector<D>],
) -> Option<(usize, usize)>
where
    Dim<D>: Dimension<D>,
{
    // A way through the edge of two triangles crosses one of them, whatever round-off says.
    const INSIDE: f64 = -1e-12;
    (0..model.radius.len()).find_map(|grain| {
        let (p, q) = (before[grain], after[grain]);
        let crosses = |wall: &[Vector<D>; D]| {
            let inward = Dim::<D>::inward_normal(wall);
            let side = |place: Vector<D>| inward.dot(&(place - wall[0]));
            if side(p) < 0.0 || side(q) >= 0.0 {
                return false;
            }
            let corners = std::array::from_fn(|k| if k == 0 { q } else { wall[k - 1] });
            let weights = simplex::weights::<D, N>(&corners, &p);
            weights[1..].iter().all(|&weight| weight >= INSIDE)
        };
        let wall = model.walls.iter().position(crosses);
        wall.map(|wall| (grain, wall))
    })
}
