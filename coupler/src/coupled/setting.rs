//! What the passes of a step share.

use space::{Dim, Dimension, Vector};

use crate::coupled::carry;
use crate::coupled::defect::{self, Scales};
use crate::coupled::outcome::Pass;
use crate::coupled::response::{Correction, Model};
use crate::immersion::Immersion;
use crate::state::{Candidate, Flow, Grains, Response};
use crate::transfer::Placement;

/// How good the deferred correction of an accepted pass must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Deferred {
    /// In a first pass that of the last step will do, as for a free cloud.
    Lagged,
    /// Passes go on until it stands still: for a fluid that does not take c and κ.
    Converged,
    /// There is none; for tests, to see what it is for.
    LeftOut,
}

/// What all passes of a step share.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a, const D: usize, const N: usize> {
    /// The grains in their fluid.
    pub immersion: &'a Immersion<D, N>,
    /// Where they are on its mesh.
    pub placement: &'a Placement,
    /// The accepted grains.
    pub grains: &'a Grains<D>,
    /// Length of the step \[s\].
    pub dt: f64,
    /// Does the fluid take c and κ?
    pub affine: bool,
    /// The deferred correction.
    pub deferred: Deferred,
}

impl<const D: usize, const N: usize> Setting<'_, D, N>
where
    Dim<D>: Dimension<D>,
{
    /// The model of grains that meet no contact.
    pub fn free_model(&self, drag: Vec<f64>, sub_steps: u32) -> Model<D> {
        let gravity = &self.immersion.gravity;
        Model::free(self.grains, drag, gravity, self.dt, sub_steps)
    }

    /// What only the matrix sees. A fluid that does not take c and κ is given 0: the deferred
    /// correction then holds all of both.
    pub fn matrix_response(&self, porosity: Vec<f64>, model: &Model<D>) -> Response<D> {
        let transfer = &self.immersion.transfer;
        let mut response = Response::of_matrix(transfer, self.placement, porosity, model);
        if !self.affine {
            response.entrained_fraction.fill(0.0);
            response.solid_mobility.fill(0.0);
        }
        response
    }

    /// The deferred correction at the fluid fields (w*, G*).
    pub fn correction(
        &self,
        model: &Model<D>,
        response: &Response<D>,
        reference: &Flow<D>,
    ) -> Correction<D> {
        let transfer = &self.immersion.transfer;
        match self.deferred {
            Deferred::LeftOut => Correction::none(transfer.node_count()),
            _ => response.correction(transfer, self.placement, model, reference),
        }
    }

    /// γ of every grain \[kg/s\] (D7).
    pub fn drag(&self, flow: &Flow<D>, porosity: &[f64]) -> Vec<f64> {
        let immersion = self.immersion;
        immersion.drag(self.grains, flow, self.placement, porosity, Some(self.dt))
    }

    /// q of every grain \[N\] (S3).
    pub fn force(&self, flow: &Flow<D>, drag: &[f64]) -> Vec<Vector<D>> {
        let immersion = self.immersion;
        immersion.force(self.grains, flow, self.placement, drag)
    }

    /// A pass with its defect.
    pub fn measure(
        &self,
        model: &Model<D>,
        flow: Flow<D>,
        force: Vec<Vector<D>>,
        grains: Candidate<D>,
        residual: Vec<Vector<D>>,
    ) -> Pass<D> {
        let scales = Scales {
            density: self.immersion.fluid.density,
            gravity: self.immersion.gravity,
            dt: self.dt,
        };
        let (transfer, placement) = (&self.immersion.transfer, self.placement);
        let vectors = [&force[..], &residual, &grains.mean_velocity];
        let defect = defect::measure(&scales, transfer, placement, self.grains, model, vectors);
        Pass {
            flow,
            force,
            grains,
            residual,
            defect,
        }
    }

    /// V A N (G* − G) \[N\]; 0 where the fluid takes c.
    pub fn lagged_force(
        &self,
        model: &Model<D>,
        reference: &Flow<D>,
        flow: &Flow<D>,
    ) -> Vec<Vector<D>> {
        if self.affine {
            return vec![Vector::zeros(); self.grains.count()];
        }
        let (transfer, placement) = (&self.immersion.transfer, self.placement);
        carry::lagged_pressure_force(transfer, placement, model, reference, flow)
    }
}
