//! The fluid engine: volume-averaged Navier–Stokes on P1–P1 triangles.
//!
//! ```text
//!   ρφ(∂v/∂t + v·∇v) + (φ + c)∇p − ∇·(2μφ D(v)) + βv = ρφ g + s          u = φ v     (M)
//!   ∇·(u + j⁰ + c v − κ∇p) = 0                                                       (C)
//! ```
//!
//! Unknowns are the superficial velocity u and the pressure p; φ, β, s, c, j⁰ and κ are nodal
//! fields that describe the grains. Each term has its file: [`momentum`], [`continuity`],
//! [`stabilization`]; [`point`] holds what they share at a quadrature point.
//!
//! ```
//! use fluid_solver::boundary::Condition;
//! use fluid_solver::config::FluidConfig;
//! use fluid_solver::rectangle::Rectangle;
//! use fluid_solver::state::SolidFields;
//! use fluid_solver::step::{FluidSolver, Request};
//!
//! # fn main() -> Result<(), fluid_solver::error::FluidError> {
//! let mesh = Rectangle::new([0.0, 0.0], [1.0, 1.0], [8, 8]).mesh()?;
//! let config = FluidConfig::new(1000.0, 1e-3)
//!     .with("all", Condition::NoSlip)
//!     .with("top", Condition::Uniform([0.1, 0.0]));
//! let mut solver = FluidSolver::new(config, mesh)?;
//! let candidate = solver.advance(&Request::first(1, 0.1), &SolidFields::default())?;
//! assert!(candidate.powers.kinetic_energy > 0.0);
//! solver.commit()?;
//! # Ok(())
//! # }
//! ```

pub mod assembly;
pub mod boundary;
pub mod config;
pub mod continuity;
pub mod cost;
pub mod creeping;
pub mod diagnostics;
pub mod dissection;
pub mod element;
pub mod error;
pub mod gmsh;
pub mod linear;
pub mod manufactured;
pub mod mesh;
pub mod momentum;
pub mod multifrontal;
pub mod pivoting;
pub mod point;
pub mod rectangle;
pub mod serve;
pub mod solve;
pub mod stabilization;
pub mod state;
pub mod step;
