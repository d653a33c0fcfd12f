//! What is coupled with what, chosen once from the scene.

use protocol::partner::Partner;
use protocol::scene::Refinement;
use space::{Dim, Dimension};

use crate::alone::{Dry, FluidAlone};
use crate::coupled::step::Coupled;
use crate::error::CouplerError;
use crate::immersion::Immersion;
use crate::one_way::OneWay;
use crate::report::StepReport;
use crate::seats::fluid::FluidSeat;
use crate::seats::particles::ParticleSeat;
use crate::state::{Grains, State};

/// The parts of a run, and how they are coupled.
pub enum System<const D: usize, const N: usize> {
    /// Fluid and grains feel each other.
    Coupled(Box<Coupled<D, N>>),
    /// The fluid does not feel the grains.
    OneWay(Box<OneWay<D, N>>),
    /// No grains.
    FluidAlone(Box<FluidAlone<D, N>>),
    /// No fluid.
    Dry(Dry<D>),
}

impl<const D: usize, const N: usize> System<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Advance the accepted state by dt \[s\]; an error leaves it as it is.
    pub fn advance(&mut self, state: &mut State<D>, dt: f64) -> Result<StepReport, CouplerError> {
        match self {
            System::Coupled(system) => system.advance(state, dt),
            System::OneWay(system) => system.advance(state, dt),
            System::FluidAlone(system) => system.advance(state, dt),
            System::Dry(system) => system.advance(state, dt),
        }
    }

    /// The fluid's seat, where there is a fluid.
    pub fn fluid(&self) -> Option<&FluidSeat<D, N>> {
        match self {
            System::Coupled(system) => Some(&system.engines.fluid),
            System::OneWay(system) => Some(&system.fluid),
            System::FluidAlone(system) => Some(&system.fluid),
            System::Dry(_) => None,
        }
    }

    /// The grains' seat, where there are grains.
    pub fn particles(&self) -> Option<&ParticleSeat<D>> {
        match self {
            System::Coupled(system) => Some(&system.engines.particles),
            System::OneWay(system) => Some(&system.particles),
            System::FluidAlone(_) => None,
            System::Dry(system) => Some(&system.particles),
        }
    }

    /// Both seats, to speak with.
    pub fn seats_mut(&mut self) -> (Option<&mut FluidSeat<D, N>>, Option<&mut ParticleSeat<D>>) {
        match self {
            System::Coupled(system) => {
                let engines = &mut system.engines;
                (Some(&mut engines.fluid), Some(&mut engines.particles))
            }
            System::OneWay(system) => (Some(&mut system.fluid), Some(&mut system.particles)),
            System::FluidAlone(system) => (Some(&mut system.fluid), None),
            System::Dry(system) => (None, Some(&mut system.particles)),
        }
    }

    /// The grains in their fluid, where there are both.
    pub fn immersion(&self) -> Option<&Immersion<D, N>> {
        match self {
            System::Coupled(system) => Some(&system.immersion),
            System::OneWay(system) => Some(&system.immersion),
            System::FluidAlone(_) | System::Dry(_) => None,
        }
    }

    /// Grains have left, by their ascending numbers before; `left` are the others.
    pub fn remove(
        &mut self,
        gone: &[usize],
        left: &Grains<D>,
        step: u64,
    ) -> Result<(), CouplerError> {
        match self {
            System::Coupled(system) => system.immersion.remove(gone),
            System::OneWay(system) => system.immersion.remove(gone),
            System::FluidAlone(_) | System::Dry(_) => {}
        }
        match self.seats_mut() {
            (_, Some(seat)) => seat.remove(gone, left, step),
            _ => Ok(()),
        }
    }

    /// Ask the fluid for cells of these sizes, on a mesh of this epoch; the state follows.
    pub fn adapt(
        &mut self,
        epoch: u64,
        sizes: &Refinement,
        state: &mut State<D>,
    ) -> Result<(), CouplerError> {
        let asked = (state.step + 1, epoch);
        let (fluid, immersion) = match self {
            System::Coupled(system) => (&mut system.engines.fluid, &mut system.immersion),
            System::OneWay(system) => (&mut system.fluid, &mut system.immersion),
            System::FluidAlone(system) => return system.adapt(asked, sizes, state),
            System::Dry(_) => return Ok(()),
        };
        match fluid.adapt(asked, sizes)? {
            true => immersion.change_mesh(&fluid.mesh, state),
            false => Ok(()),
        }
    }

    /// The engines, to speak with.
    pub fn partners(&mut self) -> impl Iterator<Item = &mut Partner> {
        let (fluid, particles) = self.seats_mut();
        let fluid = fluid.map(FluidSeat::partner);
        let particles = particles.and_then(ParticleSeat::partner);
        fluid.into_iter().chain(particles)
    }
}
