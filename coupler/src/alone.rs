//! A fluid without grains, and grains without a fluid.

use space::{Dim, Dimension};

use crate::error::CouplerError;
use crate::report::StepReport;
use crate::seats::fluid::FluidSeat;
use crate::seats::particles::ParticleSeat;
use crate::seats::request::Request;
use crate::state::{State, require_finite};

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
