//! The plane: disks and segments of `rapier2d`.

use rapier2d_f64::prelude as rapier;

#[expect(
    clippy::duplicate_mod,
    reason = "rapier is two crates with the same names: what is alike is written once"
)]
#[path = "world.rs"]
mod world;

pub use world::World;

/// Dimensions.
const D: usize = 2;

/// The moment of inertia as rapier takes it.
fn moments(moment: f64) -> rapier::AngVector {
    moment
}

/// An angular velocity as we have it.
fn turning(spin: rapier::AngVector) -> f64 {
    spin
}

/// A segment that grains are on the left of.
fn wall([a, b]: [rapier::Vector; D]) -> rapier::ColliderBuilder {
    rapier::ColliderBuilder::segment(a, b)
}
