//! Where grains and walls are.

use space::{Period, Vector};

use crate::grains::Grains;
use crate::walls::near::Walls;

/// Where grains and walls are.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a, const D: usize> {
    /// Grains.
    pub grains: &'a Grains,
    /// Their centres \[m\].
    pub position: &'a [Vector<D>],
    /// Walls.
    pub walls: &'a Walls<D>,
    /// Period along each axis \[m\].
    pub period: Period<D>,
}
