//! What a scene tells the engine, and what it must not say.

use space::{Dim, Dimension, Period, Vector};

use crate::contact::delassus::Material;
use crate::contact::law::Friction;
use crate::error::Error;
use crate::grains::{Grains, State};
use crate::small::choice::Solver;
use crate::walls::facet::Facet;
use crate::walls::near::Walls;

/// What a scene tells the engine.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup<const D: usize> {
    /// g \[m/s²\].
    pub gravity: Vector<D>,
    /// Walls.
    pub walls: Vec<Facet<D>>,
    /// Period along each axis \[m\].
    pub period: Period<D>,
    /// μ between grains.
    pub friction: f64,
    /// μ between grains and walls.
    pub wall_friction: f64,
    /// I/(m r²).
    pub inertia_factor: f64,
    /// How contacts are solved; none: as the state of the grains suggests.
    pub solver: Option<Solver>,
    /// Contact residual at which a solve stops, when the request names none.
    pub tolerance: f64,
    /// Sweeps allowed in a solve.
    pub sweeps_max: usize,
    /// Sub-steps allowed in a step.
    pub sub_steps_max: u32,
}

const AXES: [char; 3] = ['x', 'y', 'z'];

impl<const D: usize> Setup<D> {
    /// What contacts are made of.
    pub fn material(&self) -> Material {
        Material {
            friction: Friction {
                grains: self.friction,
                walls: self.wall_friction,
            },
            inertia_factor: self.inertia_factor,
        }
    }

    /// Ranges of all numbers.
    pub fn check(&self) -> Result<(), Error> {
        for (axis, &value) in self.gravity.iter().enumerate() {
            at_least(&format!("gravity {}", AXES[axis]), value, f64::NEG_INFINITY)?;
        }
        at_least("friction", self.friction, 0.0)?;
        at_least("wall_friction", self.wall_friction, 0.0)?;
        positive("inertia_factor", self.inertia_factor)?;
        positive("tolerance", self.tolerance)?;
        positive("sweeps_max", self.sweeps_max as f64)?;
        positive("sub_steps_max", f64::from(self.sub_steps_max))?;
        for (axis, length) in self.period.iter().enumerate() {
            positive(&format!("period {}", AXES[axis]), length.unwrap_or(1.0))?;
        }
        Ok(())
    }
}

fn at_least(what: &str, value: f64, least: f64) -> Result<(), Error> {
    if value.is_finite() && value >= least {
        return Ok(());
    }
    let why = format!("{what} is {value}, must be finite and ≥ {least}");
    Err(Error::Setup(why))
}

fn positive(what: &str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::Setup(format!("{what} is {value}, must be positive")))
}

/// No grain wider than the period or inside a wall.
pub fn check_places<const D: usize>(
    setup: &Setup<D>,
    grains: &Grains,
    state: &State<D>,
    walls: &Walls<D>,
) -> Result<(), Error>
where
    Dim<D>: Dimension<D>,
{
    for grain in 0..grains.count() {
        let (position, radius) = (&state.position[grain], grains.radius[grain]);
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
