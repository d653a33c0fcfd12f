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
//!   φ = 1 − T(V)   β = T(γ(1−A))   c = T(V A)   κ = T(V² λ D)
//!   s  = T(γ z) + [β w* − T(γ(1−A) N w*)] + [c G* − T(V A N G*)] + T(carried force)              (R3)
//!   j⁰ = T(V z) − [c w* − T(V A N w*)] + [κ G* − T(V² λ D N G*)]                                 (R4)
//! ```
//!
//! T deposits, N samples (`transfer.rs`); w* and G* are the last known nodal velocity and mean
//! pressure gradient. The brackets are the deferred correction: the nodal products of the fluid's
//! equations minus what the grains feel. They sum to zero over the nodes.

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

/// The model of all grains, a value each; vectors are interleaved.
#[derive(Debug, Clone, Default)]
pub struct Model {
    /// γ \[kg/s\]
    pub drag: Vec<f64>,
    /// V \[m³\]
    pub volume: Vec<f64>,
    /// D \[s/kg\]; 0 for a fixed grain
    pub mobility: Vec<f64>,
    /// λ in [0, 1]
    pub lambda: Vec<f64>,
    /// z \[m/s\]
    pub free_velocity: Vec<f64>,
}

impl Model {
    /// A = λ γ D: the share of the drag that follows the fluid within the step.
    pub fn follow(&self, grain: usize) -> f64 {
        self.lambda[grain] * self.drag[grain] * self.mobility[grain]
    }

    /// v_model = z + λ D q \[m/s\], interleaved.
    pub fn velocity(&self, force: &[f64]) -> Vec<f64> {
        let of =
            |k: usize| self.free_velocity[k] + self.lambda[k / 2] * self.mobility[k / 2] * force[k];
        (0..force.len()).map(of).collect()
    }
}

/// The nodal fields that the fluid receives.
#[derive(Debug, Clone, Default)]
pub struct NodalResponse {
    /// φ
    pub porosity: Vec<f64>,
    /// β \[kg/(m³ s)\]
    pub drag: Vec<f64>,
    /// s \[N/m³\]
    pub drag_source: Vec<f64>,
    /// c
    pub entrained_fraction: Vec<f64>,
    /// j⁰ \[m/s\]
    pub solid_flux: Vec<f64>,
    /// κ \[m³ s/kg\]
    pub solid_mobility: Vec<f64>,
}

/// Last known nodal fields of the fluid.
#[derive(Debug, Clone, Default)]
pub struct FluidState {
    /// w = u/φ \[m/s\]
    pub velocity: Vec<f64>,
    /// G = ℓ⁻¹∫N ∇p \[Pa/m\]
    pub pressure_gradient: Vec<f64>,
}

/// The fields that only the matrix sees: they stay the same over the passes with one λ.
pub fn matrix_fields(
    transfer: &Transfer,
    placement: &Placement,
    porosity: &[f64],
    model: &Model,
) -> NodalResponse {
    let scalar = |value: &dyn Fn(usize) -> f64| transfer.deposit(placement, value);
    NodalResponse {
        porosity: porosity.to_vec(),
        drag: scalar(&|i| model.drag[i] * (1.0 - model.follow(i))),
        entrained_fraction: scalar(&|i| model.volume[i] * model.follow(i)),
        solid_mobility: scalar(&|i| model.volume[i].powi(2) * model.lambda[i] * model.mobility[i]),
        drag_source: Vec::new(),
        solid_flux: Vec::new(),
    }
}

/// The deferred correction of (R3) and (R4) at the fluid fields `known`: (force, flux), interleaved.
pub fn deferred_correction(
    transfer: &Transfer,
    placement: &Placement,
    fields: &NodalResponse,
    model: &Model,
    known: &FluidState,
) -> (Vec<f64>, Vec<f64>) {
    let velocity = transfer.sample_vector(placement, &known.velocity);
    let gradient = transfer.sample_vector(placement, &known.pressure_gradient);
    let felt_force = transfer.deposit_vector(placement, |i| {
        let (drag, volume) = (
            model.drag[i] * (1.0 - model.follow(i)),
            model.volume[i] * model.follow(i),
        );
        [0, 1].map(|axis| drag * velocity[2 * i + axis] + volume * gradient[2 * i + axis])
    });
    let felt_flux = transfer.deposit_vector(placement, |i| {
        let volume = model.volume[i] * model.follow(i);
        let mobility = model.volume[i].powi(2) * model.lambda[i] * model.mobility[i];
        [0, 1].map(|axis| volume * velocity[2 * i + axis] - mobility * gradient[2 * i + axis])
    });
    let nodal = |a: &[f64], b: &[f64], sign: f64, felt: &[f64]| -> Vec<f64> {
        let product =
            |k: usize| a[k / 2] * known.velocity[k] + sign * b[k / 2] * known.pressure_gradient[k];
        (0..felt.len()).map(|k| product(k) - felt[k]).collect()
    };
    let force = nodal(&fields.drag, &fields.entrained_fraction, 1.0, &felt_force);
    let mut flux = nodal(
        &fields.entrained_fraction,
        &fields.solid_mobility,
        -1.0,
        &felt_flux,
    );
    flux.iter_mut().for_each(|value| *value = -*value);
    (force, flux)
}

/// Fill s and j⁰ (R3, R4) from z, a correction, and the force carried from the last step.
pub fn set_sources(
    transfer: &Transfer,
    placement: &Placement,
    fields: &mut NodalResponse,
    model: &Model,
    correction: &(Vec<f64>, Vec<f64>),
    carried: &[f64],
) {
    let z = &model.free_velocity;
    let add = |mut deposited: Vec<f64>, correction: &[f64]| {
        deposited
            .iter_mut()
            .zip(correction)
            .for_each(|(value, extra)| *value += extra);
        deposited
    };
    let force = transfer.deposit_vector(placement, |i| {
        [0, 1].map(|axis| model.drag[i] * z[2 * i + axis] + carried[2 * i + axis])
    });
    let flux = transfer.deposit_vector(placement, |i| {
        [0, 1].map(|axis| model.volume[i] * z[2 * i + axis])
    });
    fields.drag_source = add(force, &correction.0);
    fields.solid_flux = add(flux, &correction.1);
}
