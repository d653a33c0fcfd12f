//! The solid's response: what the coupler tells the fluid about the grains (S1).
//!
//! Over a coupling step a grain that meets no contact obeys, with n sub-steps of δ = Δt/n,
//!
//! ```text
//!   m (v_k − v_{k−1})/δ = m g + q − γ v_k       q = γ v_f − V ∇p                          (R1)
//!   v̄ = S vⁿ + D (m g + q)                      mean over the sub-steps; n = 1: D = Δt/(m+γΔt)   (R2)
//! ```
//!
//! and the fluid is given the affine model v̄ ≈ z + λ D q of every grain. With A = λ γ D:
//!
//! ```text
//!   φ = 1 − T(V)   β = T(γ(1−A))   c = T(V A)   κ = T(V² λ D)   β^f = β of fixed grains
//!   s  = T(γ z) + [β w* − T(γ(1−A) N w*)] + [c G* − T(V A N G*)] + T(carried force)              (R3)
//!   j⁰ = T(V z) − [c w* − T(V A N w*)] + [κ G* − T(V² λ D N G*)]                                 (R4)
//! ```
//!
//! T deposits, N samples (`transfer/deposit.rs`); w* and G* are the last known nodal velocity and mean
//! pressure gradient. The brackets are the deferred correction: the nodal products of the fluid's
//! equations minus what the grains feel. They sum to zero over the nodes.

use space::{Dim, Dimension, Vector};

use crate::state::{Candidate, Flow, Grains, Response};
use crate::transfer::{Placement, Transfer};

/// Coefficients of (R2) for one grain: (S, D) with D in s/kg.
pub fn free_response(mass: f64, drag: f64, dt: f64, sub_steps: u32) -> (f64, f64) {
    let step = dt / f64::from(sub_steps);
    let keep = mass / (mass + drag * step);
    let gain = step / (mass + drag * step);
    let (mut from_velocity, mut from_force) = (1.0, 0.0);
    let (mut mean_velocity, mut mean_force) = (0.0, 0.0);
    for _ in 0..sub_steps {
        from_velocity *= keep;
        from_force = keep * from_force + gain;
        mean_velocity += from_velocity;
        mean_force += from_force;
    }
    let count = f64::from(sub_steps);
    (mean_velocity / count, mean_force / count)
}

/// The affine model of all grains, a value each.
#[derive(Debug, Clone, Default)]
pub struct Model<const D: usize> {
    /// γ \[kg/s\]
    pub drag: Vec<f64>,
    /// V \[m³\]
    pub volume: Vec<f64>,
    /// D \[s/kg\]; 0 for a fixed grain
    pub mobility: Vec<f64>,
    /// λ in [0, 1]
    pub lambda: Vec<f64>,
    /// z \[m/s\]
    pub free_velocity: Vec<Vector<D>>,
    /// Never moves
    pub fixed: Vec<bool>,
}

impl<const D: usize> Model<D> {
    /// Grains that meet no contact: λ = 1, z = S vⁿ + D m g (R2).
    pub fn free(
        grains: &Grains<D>,
        drag: Vec<f64>,
        gravity: &Vector<D>,
        dt: f64,
        sub_steps: u32,
    ) -> Model<D> {
        let count = grains.count();
        let mut model = Model {
            volume: grains.volume.clone(),
            mobility: vec![0.0; count],
            lambda: vec![1.0; count],
            free_velocity: vec![Vector::zeros(); count],
            fixed: grains.fixed.clone(),
            drag,
        };
        for i in (0..count).filter(|&i| !grains.fixed[i]) {
            let mass = grains.mass[i];
            let (keep, mobility) = free_response(mass, model.drag[i], dt, sub_steps.max(1));
            model.mobility[i] = mobility;
            model.free_velocity[i] = grains.velocity[i] * keep + gravity * (mobility * mass);
        }
        model
    }

    /// A = λ γ D: the share of the drag that entrains the grain within the step.
    pub fn entrainment(&self, grain: usize) -> f64 {
        self.lambda[grain] * self.drag[grain] * self.mobility[grain]
    }

    /// v_model = z + λ D q \[m/s\].
    pub fn velocity(&self, force: &[Vector<D>]) -> Vec<Vector<D>> {
        let of = |i: usize| self.free_velocity[i] + force[i] * (self.lambda[i] * self.mobility[i]);
        (0..force.len()).map(of).collect()
    }

    /// r = v̄ − v_model \[m/s\].
    pub fn residual(&self, force: &[Vector<D>], candidate: &Candidate<D>) -> Vec<Vector<D>> {
        let modelled = self.velocity(force);
        let pairs = candidate.mean_velocity.iter().zip(&modelled);
        pairs.map(|(v, m)| v - m).collect()
    }

    /// z = v̄ − λ D q: the model then gives this candidate back.
    pub fn calibrate(&mut self, candidate: &Candidate<D>, force: &[Vector<D>]) {
        for (i, force) in force.iter().enumerate() {
            let share = self.lambda[i] * self.mobility[i];
            self.free_velocity[i] = candidate.mean_velocity[i] - force * share;
        }
    }

    /// γ(1 − A): of the drag, what stays a drag on the mesh.
    fn nodal_drag(&self, grain: usize) -> f64 {
        self.drag[grain] * (1.0 - self.entrainment(grain))
    }

    /// The same of a fixed grain, else 0.
    fn fixed_drag(&self, grain: usize) -> f64 {
        match self.fixed[grain] {
            true => self.nodal_drag(grain),
            false => 0.0,
        }
    }

    /// V A: of the volume, what moves with the fluid.
    fn entrained_volume(&self, grain: usize) -> f64 {
        self.volume[grain] * self.entrainment(grain)
    }

    /// V² λ D: volume that flows under a pressure gradient.
    fn volume_mobility(&self, grain: usize) -> f64 {
        self.volume[grain].powi(2) * self.lambda[grain] * self.mobility[grain]
    }
}

/// The deferred correction of (R3) and (R4).
#[derive(Debug, Clone)]
pub struct Correction<const D: usize> {
    /// Of s \[N/m³\]
    pub force: Vec<Vector<D>>,
    /// Of j⁰ \[m/s\]
    pub flux: Vec<Vector<D>>,
}

impl<const D: usize> Correction<D> {
    /// None, on this many nodes.
    pub fn none(nodes: usize) -> Correction<D> {
        Correction {
            force: vec![Vector::zeros(); nodes],
            flux: vec![Vector::zeros(); nodes],
        }
    }
}

impl<const D: usize> Response<D> {
    /// What only the matrix sees: it stays the same over the passes with one λ. The sources are empty.
    pub fn of_matrix<const N: usize>(
        transfer: &Transfer<D, N>,
        placement: &Placement,
        porosity: Vec<f64>,
        model: &Model<D>,
    ) -> Response<D>
    where
        Dim<D>: Dimension<D>,
    {
        let fixed_drag = match model.fixed.contains(&true) {
            true => transfer.deposit(placement, |i| model.fixed_drag(i)),
            false => vec![0.0; porosity.len()],
        };
        Response {
            porosity,
            fixed_drag,
            drag: transfer.deposit(placement, |i| model.nodal_drag(i)),
            entrained_fraction: transfer.deposit(placement, |i| model.entrained_volume(i)),
            solid_mobility: transfer.deposit(placement, |i| model.volume_mobility(i)),
            drag_source: Vec::new(),
            solid_flux: Vec::new(),
        }
    }

    /// The deferred correction at the fluid fields (w*, G*).
    pub fn correction<const N: usize>(
        &self,
        transfer: &Transfer<D, N>,
        placement: &Placement,
        model: &Model<D>,
        reference: &Flow<D>,
    ) -> Correction<D>
    where
        Dim<D>: Dimension<D>,
    {
        let velocity = transfer.sample(placement, &reference.velocity);
        let gradient = transfer.sample(placement, &reference.pressure_gradient);
        let felt_force = transfer.deposit(placement, |i| {
            velocity[i] * model.nodal_drag(i) + gradient[i] * model.entrained_volume(i)
        });
        let felt_flux = transfer.deposit(placement, |i| {
            velocity[i] * model.entrained_volume(i) - gradient[i] * model.volume_mobility(i)
        });
        let nodes = || reference.velocity.iter().zip(&reference.pressure_gradient);
        let force = nodes().zip(&felt_force).enumerate();
        let force = force.map(|(a, ((w, gradient), felt))| {
            w * self.drag[a] + gradient * self.entrained_fraction[a] - felt // (R3)
        });
        let flux = nodes().zip(&felt_flux).enumerate();
        let flux = flux.map(|(a, ((w, gradient), felt))| {
            -(w * self.entrained_fraction[a] - gradient * self.solid_mobility[a] - felt) // (R4)
        });
        Correction {
            force: force.collect(),
            flux: flux.collect(),
        }
    }

    /// s and j⁰ (R3, R4) from z, a correction, and a force on the fluid in the grains' places \[N\].
    pub fn set_sources<const N: usize>(
        &mut self,
        transfer: &Transfer<D, N>,
        placement: &Placement,
        model: &Model<D>,
        correction: &Correction<D>,
        force: &[Vector<D>],
    ) where
        Dim<D>: Dimension<D>,
    {
        let z = &model.free_velocity;
        let add = |mut deposited: Vec<Vector<D>>, correction: &[Vector<D>]| {
            let nodes = deposited.iter_mut().zip(correction);
            nodes.for_each(|(value, extra)| *value += extra);
            deposited
        };
        let source = transfer.deposit(placement, |i| z[i] * model.drag[i] + force[i]);
        let flux = transfer.deposit(placement, |i| z[i] * model.volume[i]);
        self.drag_source = add(source, &correction.force);
        self.solid_flux = add(flux, &correction.flux);
    }
}
