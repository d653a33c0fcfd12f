//! The two engines of a coupled step.

use space::{Dim, Dimension};

use crate::coupled::proximity::Proximity;
use crate::error::CouplerError;
use crate::seats::fluid::FluidSeat;
use crate::seats::particles::{Forces, ParticleSeat};
use crate::seats::request::Request;
use crate::state::{Candidate, Flow, Grains, Response};

/// Who solves the fluid, who moves the grains.
pub struct Engines<const D: usize, const N: usize> {
    /// The fluid's seat.
    pub fluid: FluidSeat<D, N>,
    /// The grains' seat.
    pub particles: ParticleSeat<D>,
    /// Who may touch, for grains whose engine does not tell.
    proximity: Option<Proximity<D>>,
}

impl<const D: usize, const N: usize> Engines<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Both seats, and what the grains may touch.
    pub fn new(
        fluid: FluidSeat<D, N>,
        particles: ParticleSeat<D>,
        proximity: Proximity<D>,
    ) -> Engines<D, N> {
        Engines {
            proximity: (!particles.tells_contacts()).then_some(proximity),
            fluid,
            particles,
        }
    }

    /// S2.
    pub fn solve_fluid(
        &mut self,
        request: &Request,
        response: &Response<D>,
    ) -> Result<Flow<D>, CouplerError> {
        self.fluid.advance(request, Some(response))
    }

    /// S4 and S5 from the accepted grains; every candidate has contact states. `sub_steps` 0 lets the
    /// engine choose.
    pub fn move_grains(
        &mut self,
        request: &Request,
        grains: &Grains<D>,
        forces: Forces<'_, D>,
        sub_steps: u32,
    ) -> Result<Candidate<D>, CouplerError> {
        let mut candidate = self.particles.advance(request, Some(forces), sub_steps)?;
        if let Some(proximity) = &self.proximity {
            candidate.contact = proximity.contacts(grains, request.dt);
        }
        Ok(candidate)
    }
}
