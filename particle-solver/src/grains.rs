//! The grains: what never changes, and their state.

use space::{Dim, Dimension, Linear, Spin, Vector, dot};

use crate::contact::impulses::Impulses;
use crate::error::Error;

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

    /// The same without some, by ascending numbers.
    pub fn without(&self, gone: &[usize]) -> Grains {
        Grains {
            radius: without(&self.radius, gone),
            mass: without(&self.mass, gone),
            fixed: without(&self.fixed, gone),
        }
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
pub struct State<const D: usize>
where
    Dim<D>: Dimension<D>,
{
    /// Centre \[m\], never wrapped across a period.
    pub position: Vec<Vector<D>>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vector<D>>,
    /// Angular velocity \[rad/s\]; in the plane counter-clockwise.
    pub spin: Vec<Spin<D>>,
    /// Impulses of the last accepted sub-step, where the next solve starts.
    pub impulses: Impulses<D>,
}

impl<const D: usize> State<D>
where
    Dim<D>: Dimension<D>,
{
    /// A state without contact history; fixed grains get no velocity.
    pub fn new(
        grains: &Grains,
        position: Vec<Vector<D>>,
        mut velocity: Vec<Vector<D>>,
    ) -> Result<State<D>, Error> {
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
                *velocity = Vector::zeros();
            }
        }
        let state = State {
            position,
            velocity,
            spin: vec![Spin::<D>::default(); count],
            impulses: Impulses::default(),
        };
        state.check_finite()?;
        Ok(state)
    }

    /// The same without some of the grains, by ascending numbers.
    pub fn without(&self, gone: &[usize]) -> State<D> {
        State {
            position: without(&self.position, gone),
            velocity: without(&self.velocity, gone),
            spin: without(&self.spin, gone),
            impulses: self.impulses.without(gone, self.position.len()),
        }
    }

    /// Every number is finite, or the first one that is not.
    pub fn check_finite(&self) -> Result<(), Error> {
        for (what, values) in [("position", &self.position), ("velocity", &self.velocity)] {
            for (grain, value) in values.iter().enumerate() {
                finite(what, grain, value.iter().copied())?;
            }
        }
        for (grain, spin) in self.spin.iter().enumerate() {
            let components = 0..Spin::<D>::COMPONENTS;
            finite("spin", grain, components.map(|k| spin.component(k)))?;
        }
        Ok(())
    }

    /// Σ ½ m |v|² + ½ I ω² over the grains that move \[J\], I = `inertia_factor` m r².
    pub fn kinetic_energy(&self, grains: &Grains, inertia_factor: f64) -> f64 {
        (0..grains.count())
            .filter(|&grain| !grains.fixed[grain])
            .map(|grain| {
                let velocity = &self.velocity[grain];
                let surface = self.spin[grain] * grains.radius[grain];
                let spinning = (surface * inertia_factor).dot(surface);
                0.5 * grains.mass[grain] * (dot(velocity, velocity) + spinning)
            })
            .sum()
    }
}

/// All components are finite, or an error.
pub fn finite(
    what: &'static str,
    grain: usize,
    mut components: impl Iterator<Item = f64>,
) -> Result<(), Error> {
    match components.find(|component| !component.is_finite()) {
        Some(value) => Err(Error::NotFinite { what, grain, value }),
        None => Ok(()),
    }
}

/// Values without those of some grains, by ascending numbers.
pub fn without<T: Copy>(values: &[T], gone: &[usize]) -> Vec<T> {
    let mut gone = gone.iter().copied().peekable();
    let stays = |(grain, value): (usize, &T)| match gone.next_if_eq(&grain) {
        Some(_) => None,
        None => Some(*value),
    };
    values.iter().enumerate().filter_map(stays).collect()
}
