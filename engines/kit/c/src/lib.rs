//! The protocol behind a C interface. The header `include/sillage_engine.h` is written from these
//! files, whose comments are its comments, and from the table of fields of the protocol.
//!
//! | file | what |
//! | --- | --- |
//! | `handle` | the engine's handle, its capabilities, failures and numbers, the last error |
//! | `constants` | version of the interface, capabilities, kinds of failure |
//! | `calls` | what both seats do the same way |
//! | `exchange` | the fields of a candidate, and how an engine gets at them |
//! | `scene`, `sizes`, `mesh` | what a fluid engine is configured with and asked for, and what it answers |
//! | `particles`, `fluid` | the two seats: what crosses the border, and the engine behind it |
//!
//! Nothing unwinds into C: every entry point catches panics and turns them into an error.

mod calls;
mod constants;
mod exchange;
mod fluid;
mod handle;
mod mesh;
mod particles;
mod scene;
mod sizes;

pub use constants::*;
pub use exchange::{Inputs, Outputs, sillage_input, sillage_output};
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
pub use sizes::{Region, Sizes};
