//! A run between two steps: the system, its accepted state, and how one step follows another.

use protocol::engine::InitialGrains;
use protocol::message::Hello;
use protocol::partner::Partner;
use protocol::scene::{CouplerScene, Refinement};
use space::{Dim, Dimension, Vector};

use crate::error::CouplerError;
use crate::follow::{Asked, Follow};
use crate::report::StepReport;
use crate::seats::door;
use crate::seats::fluid::FluidSeat;
use crate::setup;
use crate::state::State;
use crate::system::System;

/// A scene that is run.
pub struct Simulation<const D: usize, const N: usize> {
    /// The scene.
    pub scene: CouplerScene,
    /// g \[m/s²\]
    pub gravity: Vector<D>,
    /// Who computes.
    pub system: System<D, N>,
    /// The accepted state.
    pub state: State<D>,
    /// How the mesh follows grains and flow, where it does.
    follow: Option<Follow<D, N>>,
    /// Are all in that state? Not while a step is being accepted.
    settled: bool,
}

impl<const D: usize, const N: usize> Simulation<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// Configure the engines and take over their initial state.
    pub fn new(
        scene: CouplerScene,
        fluid: Option<Partner>,
        particles: Option<Partner>,
        grains: &InitialGrains,
    ) -> Result<Simulation<D, N>, CouplerError> {
        let setup::Begun {
            system,
            state,
            follow,
        } = setup::begin(&scene, fluid, particles, grains)?;
        Ok(Simulation {
            gravity: door::vector(&scene.gravity, "gravity")?,
            scene,
            system,
            state,
            follow,
            settled: true,
        })
    }

    /// Let the mesh follow, before a step; true where it did.
    pub fn follow(&mut self) -> Result<bool, CouplerError> {
        let epoch = self.epoch();
        let (Some(follow), Some(seat)) = (&mut self.follow, self.system.fluid()) else {
            return Ok(false);
        };
        let Some(sizes) = follow.wish(&self.state, &seat.mesh, epoch) else {
            return Ok(false);
        };
        self.adapt(epoch + 1, &sizes)?;
        Ok(true)
    }

    /// Go back to the mesh that was asked for when a state was kept.
    pub fn follow_again(&mut self, asked: &Asked) -> Result<(), CouplerError> {
        let sizes = self.follow.as_mut().and_then(|f| f.again(asked));
        match sizes.filter(|_| asked.epoch > self.epoch()) {
            // all fields are replaced by those that were kept
            Some(sizes) => self.adapt(asked.epoch, &sizes),
            None => Ok(()),
        }
    }

    /// Does the mesh follow?
    pub fn follows(&self) -> bool {
        self.follow.is_some()
    }

    /// What the mesh was asked for last.
    pub fn asked(&self) -> Option<Asked> {
        let follow = self.follow.as_ref()?;
        Some(follow.asked(self.epoch()))
    }

    fn adapt(&mut self, epoch: u64, sizes: &Refinement) -> Result<(), CouplerError> {
        self.system.adapt(epoch, sizes, &mut self.state)?;
        tracing::info!(
            step = self.state.step,
            epoch = self.epoch(),
            "the mesh follows"
        );
        Ok(())
    }

    /// Epoch of the mesh; 0 without a fluid.
    pub fn epoch(&self) -> u64 {
        self.system.fluid().map_or(0, FluidSeat::epoch)
    }

    /// Advance the accepted state by dt \[s\].
    pub fn advance(&mut self, dt: f64) -> Result<StepReport, CouplerError> {
        let report = self.system.advance(&mut self.state, dt)?;
        self.settled = false;
        let step = self.state.step + 1;
        for partner in self.system.partners() {
            partner.commit(step)?;
        }
        self.state.step = step;
        self.state.time += dt;
        self.let_leave(dt)?;
        self.settled = true;
        Ok(report)
    }

    /// Are engines and coupler in the same accepted state, so that it can be kept?
    pub fn is_settled(&self) -> bool {
        self.settled
    }

    /// Take out the grains that the step of length `dt` has brought outside.
    fn let_leave(&mut self, dt: f64) -> Result<(), CouplerError> {
        let (grains, removed) = (&mut self.state.grains, &mut self.state.removed);
        let immersion = self.system.immersion();
        let Some(immersion) = immersion.filter(|immersion| immersion.exits.are_there()) else {
            return Ok(());
        };
        let gone = immersion.exits.left(&immersion.transfer, grains, dt);
        removed.add(grains, &gone, &self.gravity);
        self.take_out(&gone)
    }

    /// Take grains out, by their ascending numbers.
    pub fn take_out(&mut self, gone: &[usize]) -> Result<(), CouplerError> {
        if gone.is_empty() {
            return Ok(());
        }
        let State { grains, step, .. } = &mut self.state;
        grains.remove(gone);
        self.system.remove(gone, grains, *step)
    }

    /// May grains leave, so that their number changes?
    pub fn has_exits(&self) -> bool {
        let immersion = self.system.immersion();
        immersion.is_some_and(|immersion| immersion.exits.are_there())
    }

    /// Who takes part.
    pub fn hellos(&mut self) -> Vec<Hello> {
        let partners = self.system.partners();
        partners.map(|partner| partner.hello().clone()).collect()
    }

    /// Bring contact states and spins up to the accepted state, where the engine keeps them back.
    pub fn fetch_unread(&mut self) -> Result<(), CouplerError> {
        let step = self.state.step;
        match self.system.seats_mut() {
            (_, Some(seat)) if step > 0 => seat.fetch(&mut self.state.grains, step),
            _ => Ok(()),
        }
    }

    /// The engines leave.
    pub fn finish(&mut self) -> Result<(), CouplerError> {
        for partner in self.system.partners() {
            partner.finish()?;
        }
        Ok(())
    }
}
