//! A fluid without grains, and grains without a fluid.

use protocol::scene::Refinement;
use space::{Dim, Dimension};

use crate::error::CouplerError;
use crate::follow::carry;
use crate::report::StepReport;
use crate::seats::fluid::FluidSeat;
use crate::seats::particles::ParticleSeat;
use crate::seats::request::Request;
use crate::state::{State, require_finite};
use crate::transfer::deposit::Transfer;

/// A fluid without grains.
pub struct FluidAlone<const D: usize, const N: usize> {
    /// The fluid's seat.
    pub fluid: FluidSeat<D, N>,
}

/// Grains without a fluid.
pub struct Dry<const D: usize> {
    /// The grains' seat.
    pub particles: ParticleSeat<D>,
}

impl<const D: usize, const N: usize> FluidAlone<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Advance the accepted state by dt \[s\]; an error leaves it as it is.
    pub fn advance(&mut self, state: &mut State<D>, dt: f64) -> Result<StepReport, CouplerError> {
        let request = Request::after(state, 1, dt);
        let flow = self.fluid.advance(&request, None)?;
        require_finite(&flow.velocity, request.step, "the fluid's velocity")?;
        state.flow = flow;
        Ok(StepReport {
            dt,
            passes: 1,
            ..StepReport::default()
        })
    }

    /// Ask for cells of these sizes before this step, on a mesh of this epoch; the state follows.
    pub fn adapt(
        &mut self,
        asked: (u64, u64),
        sizes: &Refinement,
        state: &mut State<D>,
    ) -> Result<(), CouplerError> {
        // per metre of depth, which no grain asks for
        let before = Transfer::new(&self.fluid.mesh, 1.0);
        match self.fluid.adapt(asked, sizes)? {
            true => carry(&before, &self.fluid.mesh, state),
            false => Ok(()),
        }
    }
}

impl<const D: usize> Dry<D> {
    /// Advance the accepted state by dt \[s\]; an error leaves it as it is.
    pub fn advance(&mut self, state: &mut State<D>, dt: f64) -> Result<StepReport, CouplerError> {
        let request = Request::after(state, 1, dt);
        let candidate = self.particles.advance(&request, None, 0)?;
        require_finite(&candidate.position, request.step, "a grain's position")?;
        let sub_steps = candidate.sub_steps;
        state.grains.accept(candidate);
        Ok(StepReport {
            dt,
            passes: 1,
            sub_steps,
            ..StepReport::default()
        })
    }
}
