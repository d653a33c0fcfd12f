//! Space: spheres and triangles of `rapier3d`.

use rapier3d_f64::prelude as rapier;

#[expect(
    clippy::duplicate_mod,
    reason = "rapier is two crates with the same names: what is alike is written once"
)]
#[path = "world.rs"]
mod world;

pub use world::World;

/// Dimensions.
const D: usize = 3;

/// The moment of inertia of a sphere about each of its axes.
fn moments(moment: f64) -> rapier::AngVector {
    rapier::AngVector::splat(moment)
}

/// An angular velocity as we have it.
fn turning(spin: rapier::AngVector) -> space::Vector<3> {
    space::Vector::from(spin.to_array())
}

/// A triangle that grains are on the side of from which its corners are seen clockwise.
fn wall([a, b, c]: [rapier::Vector; D]) -> rapier::ColliderBuilder {
    rapier::ColliderBuilder::triangle(a, b, c)
}
