//! The coupler: the clock, the coupling schemes, the transfer between grains and mesh, drag, budgets.
//!
//! It talks to a fluid engine and a particle engine through `protocol` and knows how neither solves.
//! Everything is written once for `D` dimensions, with `N = D + 1` corners of a simplex. Read in
//! this order:
//!
//! * [`state`]: grains, flow, and what a candidate is
//! * [`system`]: what is coupled with what; [`coupled`] (S1–S6), [`one_way`], [`alone`]
//! * [`immersion`]: grains in a fluid, with [`transfer`] and [`drag`]
//! * [`seats`]: the engines, as the scheme sees them
//! * [`simulation`], [`setup`] with [`walls`], [`run`], [`clock`]: from a scene to its end
//! * [`follow`]: when the mesh follows the grains
//! * [`checkpoint`], [`checkpoints`]: what is kept of a run, so that it can be resumed
//! * [`budget`], [`report`], [`cost`], [`observe`], [`listener`], [`record`]: what is told of it

pub mod alone;
pub mod budget;
pub mod checkpoint;
pub mod checkpoints;
pub mod clock;
pub mod cost;
pub mod coupled;
pub mod drag;
pub mod error;
pub mod exits;
pub mod follow;
pub mod immersion;
pub mod input;
pub mod listener;
pub mod observe;
pub mod one_way;
pub mod record;
pub mod report;
pub mod run;
pub mod scale;
pub mod seats;
pub mod setup;
pub mod simulation;
pub mod state;
pub mod system;
pub mod transfer;
pub mod walls;
