//! Keys of contacts and of the coupling: `[contact]` and `[coupling]`.

use protocol::scene::{AdaptiveStep, ContactSolver, DragLaw, Geometry, Scheme};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ranges::{not_negative, one_or_more, tolerance};

/// Contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Coulomb coefficient between grains.
    #[serde(default)]
    #[schemars(transform = not_negative)]
    pub friction: f64,
    /// Coulomb coefficient between grains and walls; left out: as between grains.
    #[schemars(transform = not_negative)]
    pub wall_friction: Option<f64>,
    /// "small-steps": a step is cut into sub-steps with one sweep each, for grains that press on each other for long;
    /// "converged": sweeps until the laws of contact hold to the tolerance. Left out: as the state of the grains
    /// suggests, step by step.
    pub solver: Option<ContactSolver>,
    /// Residual at which a contact solve stops, of |g| Δt.
    #[schemars(transform = tolerance)]
    pub tolerance: f64,
    /// Sweeps allowed in a contact solve; more is an error.
    #[serde(default = "sweeps_max")]
    #[schemars(transform = one_or_more)]
    pub sweeps_max: usize,
    /// Sub-steps allowed in a coupling step; more is an error.
    #[serde(default = "sub_steps_max")]
    #[schemars(transform = one_or_more)]
    pub sub_steps_max: u32,
}

/// Coupling of grains and fluid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// { iterated = { tolerance, passes_max } }; or "staggered": one pass. For comparison only, as
    /// they lose stability where stiff: "semi-implicit" and "explicit".
    pub scheme: Option<Scheme>,
    /// Drag law of a grain among others.
    #[serde(default = "dallavalle")]
    pub drag: DragLaw,
    /// Does the fluid feel the grains? false: one-way.
    #[serde(default = "yes")]
    pub reaction: bool,
    /// In the plane, what a grain is: "disk" (without this key), or { sphere = { depth } } in a slab.
    pub geometry: Option<Geometry>,
    /// Adaptive coupling step: { step_min, step_max, courant }.
    pub adaptive: Option<AdaptiveStep>,
}

fn yes() -> bool {
    true
}
fn dallavalle() -> DragLaw {
    DragLaw::Dallavalle
}
// Resource limits, not accuracies: crossing one is an error, so a generous number is safe.
fn sweeps_max() -> usize {
    100_000
}
fn sub_steps_max() -> u32 {
    1000
}
