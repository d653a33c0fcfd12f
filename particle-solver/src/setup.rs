//! What a scene tells the engine, and what it must not say.

use crate::error::Error;
use crate::grains::{Grains, State};
use crate::vector::Vector;
use crate::walls::{Segment, Walls};

/// What a scene tells the engine.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// g \[m/s²\].
    pub gravity: Vector,
    /// Wall segments.
    pub walls: Vec<Segment>,
    /// Period in x and y \[m\].
    pub period: [Option<f64>; 2],
    /// μ between grains.
    pub friction: f64,
    /// μ between grains and walls.
    pub wall_friction: f64,
    /// I/(m r²).
    pub inertia_factor: f64,
    /// Contact residual at which a solve stops, when the request names none.
    pub tolerance: f64,
    /// Sweeps allowed in a solve.
    pub sweeps_max: usize,
    /// Sub-steps allowed in a step.
    pub sub_steps_max: u32,
}

impl Setup {
    /// Ranges of all numbers.
    pub fn check(&self) -> Result<(), Error> {
        let finite = [
            ("gravity x", self.gravity[0], f64::NEG_INFINITY),
            ("gravity y", self.gravity[1], f64::NEG_INFINITY),
            ("friction", self.friction, 0.0),
            ("wall_friction", self.wall_friction, 0.0),
        ];
        for (what, value, least) in finite {
            if !(value.is_finite() && value >= least) {
                return Err(Error::Setup(format!(
                    "{what} is {value}, must be finite and ≥ {least}"
                )));
            }
        }
        let positive = [
            ("inertia_factor", Some(self.inertia_factor)),
            ("tolerance", Some(self.tolerance)),
            ("sweeps_max", Some(self.sweeps_max as f64)),
            ("sub_steps_max", Some(f64::from(self.sub_steps_max))),
            ("period x", self.period[0]),
            ("period y", self.period[1]),
        ];
        for (what, value) in positive {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(Error::Setup(format!("{what} is {value}, must be positive")));
            }
        }
        Ok(())
    }
}

/// No grain wider than the period or inside a wall.
pub fn check_places(
    setup: &Setup,
    grains: &Grains,
    state: &State,
    walls: &Walls,
) -> Result<(), Error> {
    for grain in 0..grains.count() {
        let (position, radius) = (state.position[grain], grains.radius[grain]);
        for length in setup.period.into_iter().flatten() {
            if 2.0 * radius > length {
                return Err(Error::Setup(format!(
                    "radius {radius} of grain {grain} is more than half the period {length}"
                )));
            }
        }
        if let Some((wall, depth)) = walls
            .behind(position, radius)
            .filter(|_| !grains.fixed[grain])
        {
            return Err(Error::Setup(format!(
                "centre of grain {grain} lies {depth:.3e} m behind wall {wall}"
            )));
        }
    }
    Ok(())
}
