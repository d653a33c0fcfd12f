//! The fluid engine: volume-averaged Navier–Stokes on P1–P1 simplices, in `D` dimensions with
//! `N = D + 1` unknowns a node.
//!
//! ```text
//!   ρφ(∂v/∂t + v·∇v) + (φ + c)∇p − ∇·(2μφ D(v)) + βv = ρφ g + s          u = φ v     (M)
//!   ∇·(u + j⁰ + c v − κ∇p) = 0                                                       (C)
//! ```
//!
//! Unknowns are the superficial velocity u and the pressure p; φ, β, s, c, j⁰ and κ are nodal
//! fields that describe the grains. Read in this order:
//!
//! * [`mesh`]: simplices and the facets of the boundary
//! * [`equations`]: each term in its file, and the system made of them
//! * [`boundary`]: conditions, resolved to nodes
//! * [`linear`]: factor and refinement
//! * [`step`], [`problem`], [`solve`]: advance and commit; one step; Picard and Newton
//! * [`refined`], [`source`]: the same on a mesh that follows a size function, and where a mesh comes from
//! * [`diagnostics`]: the energy identity, forces on boundaries
//! * [`serve`]: the seat in the coupled system, the only file that knows the protocol
//!
//! ```
//! use fluid_solver::boundary::Condition;
//! use fluid_solver::candidate::Request;
//! use fluid_solver::config::FluidConfig;
//! use fluid_solver::mesh::Rectangle;
//! use fluid_solver::solid::SolidFields;
//! use fluid_solver::step::FluidSolver;
//!
//! # fn main() -> Result<(), fluid_solver::error::FluidError> {
//! let mesh = Rectangle::new([0.0, 0.0], [1.0, 1.0], [8, 8]).mesh()?;
//! let config = FluidConfig::new(1000.0, 1e-3)
//!     .with("all", Condition::NoSlip)
//!     .with("top", Condition::uniform([0.1, 0.0]));
//! let mut solver = FluidSolver::new(config, mesh)?;
//! let candidate = solver.advance(&Request::first(1, 0.1), &SolidFields::default())?;
//! assert!(candidate.powers.kinetic_energy > 0.0);
//! solver.commit()?;
//! # Ok(())
//! # }
//! ```

pub mod boundary;
pub mod candidate;
pub mod config;
pub mod cost;
pub mod diagnostics;
pub mod equations;
pub mod error;
pub mod linear;
pub mod mesh;
pub mod numbers;
pub mod problem;
pub mod refined;
pub mod serve;
pub mod solid;
pub mod solve;
pub mod source;
pub mod state;
pub mod step;
pub mod time_scheme;
pub mod wide;
