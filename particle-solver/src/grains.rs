//! The grains: what never changes, and their state.

use crate::contact::Impulses;
use crate::error::Error;
use crate::vector::Vector;

/// What a grain is; one value a grain.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Grains {
    /// Radius r \[m\].
    pub radius: Vec<f64>,
    /// Mass m \[kg\].
    pub mass: Vec<f64>,
    /// Never moves.
    pub fixed: Vec<bool>,
}

impl Grains {
    /// How many.
    pub fn count(&self) -> usize {
        self.radius.len()
    }

    /// Check lengths and ranges.
    pub fn check(&self) -> Result<(), Error> {
        let count = self.count();
        if self.mass.len() != count || self.fixed.len() != count {
            return Err(Error::Setup(format!(
                "{count} radii, {} masses and {} fixed flags: one of each is needed for a grain",
                self.mass.len(),
                self.fixed.len()
            )));
        }
        for grain in 0..count {
            for (what, value) in [("radius", self.radius[grain]), ("mass", self.mass[grain])] {
                if !(value.is_finite() && value > 0.0) {
                    return Err(Error::Setup(format!(
                        "{what} of grain {grain} is {value}, must be positive and finite"
                    )));
                }
            }
        }
        Ok(())
    }
}

/// Where the grains are and how they move; one value a grain.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct State {
    /// Centre \[m\], never wrapped across a period.
    pub position: Vec<Vector>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector>,
    /// Angular velocity \[rad/s\], counter-clockwise.
    pub spin: Vec<f64>,
    /// Impulses of the last accepted sub-step, where the next solve starts.
    pub impulses: Impulses,
}

impl State {
    /// A state without contact history; fixed grains get no velocity.
    pub fn new(
        grains: &Grains,
        position: Vec<Vector>,
        mut velocity: Vec<Vector>,
    ) -> Result<State, Error> {
        let count = grains.count();
        if position.len() != count || velocity.len() != count {
            return Err(Error::Setup(format!(
                "{} positions and {} velocities for {count} grains",
                position.len(),
                velocity.len()
            )));
        }
        for (velocity, &fixed) in velocity.iter_mut().zip(&grains.fixed) {
            if fixed {
                *velocity = [0.0; 2];
            }
        }
        let spin = vec![0.0; count];
        let state = State {
            position,
            velocity,
            spin,
            impulses: Impulses::default(),
        };
        state.check_finite()?;
        Ok(state)
    }

    /// Every number is finite, or the first one that is not.
    pub fn check_finite(&self) -> Result<(), Error> {
        for (what, values) in [("position", &self.position), ("velocity", &self.velocity)] {
            for (grain, value) in values.iter().enumerate() {
                for component in value {
                    if !component.is_finite() {
                        return Err(Error::NotFinite {
                            what,
                            grain,
                            value: *component,
                        });
                    }
                }
            }
        }
        for (grain, value) in self.spin.iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::NotFinite {
                    what: "spin",
                    grain,
                    value: *value,
                });
            }
        }
        Ok(())
    }

    /// Σ ½ m |v|² + ½ I ω² over the grains that move \[J\], I = `inertia_factor` m r².
    pub fn kinetic_energy(&self, grains: &Grains, inertia_factor: f64) -> f64 {
        (0..grains.count())
            .filter(|&grain| !grains.fixed[grain])
            .map(|grain| {
                let [x, y] = self.velocity[grain];
                let surface = grains.radius[grain] * self.spin[grain];
                0.5 * grains.mass[grain] * (x * x + y * y + inertia_factor * surface * surface)
            })
            .sum()
    }
}
