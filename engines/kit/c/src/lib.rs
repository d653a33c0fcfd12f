//! The protocol behind a C interface. The header `include/sillage_engine.h` is written from these
//! files; the comments of public items are its comments.
//!
//! | file | what |
//! | --- | --- |
//! | `handle` | the engine's handle, its capabilities, failures and numbers, the last error |
//! | `calls` | what both seats do the same way |
//! | `fields`, `exchange` | the fields of a candidate: their numbers, and how an engine gets at them |
//! | `scene`, `mesh` | what a fluid engine is configured with, and what it answers |
//! | `particles`, `fluid` | the two seats: what crosses the border, and the engine behind it |
//!
//! Nothing unwinds into C: every entry point catches panics and turns them into an error.

mod calls;
mod exchange;
mod fields;
mod fluid;
mod handle;
mod mesh;
mod particles;
mod scene;

pub use exchange::{Inputs, Outputs, sillage_input, sillage_output};
pub use fields::*;
pub use fluid::{FluidCalls, FluidReport, sillage_run_fluid};
pub use handle::{
    Engine, Request, sillage_abi_version, sillage_diagnostic, sillage_engine_declare,
    sillage_engine_free, sillage_engine_new, sillage_fail, sillage_last_error,
};
pub use mesh::Mesh;
pub use particles::{Grains, ParticleCalls, ParticleReport, ParticleScene, sillage_run_particles};
pub use scene::{
    Boundary, FluidScene, SILLAGE_BACKWARD_EULER, SILLAGE_BDF2, SILLAGE_INFLOW_PARABOLIC,
    SILLAGE_INFLOW_UNIFORM, SILLAGE_NO_SLIP, SILLAGE_OPEN, SILLAGE_PERIODIC, SILLAGE_SLIP,
    SILLAGE_STEADY,
};

/// Version of this interface; compare with sillage_abi_version().
pub const SILLAGE_ABI_VERSION: u32 = 2;

/// Fluid: the entrained fraction and the solid mobility are used, not only drag and source.
pub const SILLAGE_AFFINE_RESPONSE: u32 = 0;
/// Particles: the drag is taken implicitly, in the free motion and in the contacts.
pub const SILLAGE_IMPLICIT_DRAG: u32 = 1;
/// Particles: contact 2 tells grains that a wall or a fixed grain holds.
pub const SILLAGE_CONTACT_STATE: u32 = 2;
/// Both: save and restore bring back the same bits.
pub const SILLAGE_CHECKPOINT: u32 = 3;

/// The scene's part is not usable (exit code 2).
pub const SILLAGE_FAILURE_SCENE: u32 = 2;
/// The engine cannot do this, or broke (exit code 4).
pub const SILLAGE_FAILURE_ENGINE: u32 = 4;
/// A value is not finite, or an invariant is broken (exit code 7).
pub const SILLAGE_FAILURE_NOT_FINITE: u32 = 7;
/// An iteration did not converge (exit code 8).
pub const SILLAGE_FAILURE_NOT_CONVERGED: u32 = 8;
