//! Grains that the fluid does not feel: the fluid is solved alone, then the grains move in it.

use space::{Dim, Dimension};

use crate::error::CouplerError;
use crate::immersion::Immersion;
use crate::report::StepReport;
use crate::seats::fluid::FluidSeat;
use crate::seats::particles::{Forces, ParticleSeat};
use crate::seats::request::Request;
use crate::state::{State, require_finite};

/// Fluid, and grains in it.
pub struct OneWay<const D: usize, const N: usize> {
    /// The fluid's seat.
    pub fluid: FluidSeat<D, N>,
    /// The grains' seat.
    pub particles: ParticleSeat<D>,
    /// The grains in their fluid.
    pub immersion: Immersion<D, N>,
}

impl<const D: usize, const N: usize> OneWay<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Advance the accepted state by dt \[s\]; an error leaves it as it is.
    pub fn advance(&mut self, state: &mut State<D>, dt: f64) -> Result<StepReport, CouplerError> {
        let (immersion, grains) = (&self.immersion, &state.grains);
        let request = Request::after(state, 1, dt);
        let flow = self.fluid.advance(&request, None)?;
        let placement = immersion.place(grains, dt)?;
        let clear = vec![1.0; immersion.transfer.node_count()];
        let drag = immersion.drag(grains, &flow, &placement, &clear, Some(dt));
        let force = immersion.force(grains, &flow, &placement, &drag);
        let forces = Forces::new(&drag, &force);
        let candidate = self.particles.advance(&request, Some(forces), 0)?;
        require_finite(&candidate.position, request.step, "a grain's position")?;
        let sub_steps = candidate.sub_steps;
        state.grains.accept(candidate);
        state.flow = flow;
        Ok(StepReport {
            dt,
            passes: 1,
            sub_steps,
            ..StepReport::default()
        })
    }
}
