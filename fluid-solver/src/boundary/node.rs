//! What is known about the velocity of a node.

use space::Vector;

/// What is known about the velocity of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum NodeVelocity<const D: usize> {
    Free,
    /// Normal component zero; where that follows no axis the unknowns are turned.
    Normal(Vector<D>),
    /// Only this component is free, along an edge between two walls; where that follows no axis the unknowns are turned.
    Along(Vector<D>),
    /// Given by this boundary, times a shape factor.
    Given(usize, f64),
    Zero,
}
