//! Velocity unknowns along a wall: normal first, then tangential.

use space::{Dim, Dimension, Vector};

/// Orthonormal directions of the velocity unknowns of a node, the first the normal of its wall or the direction of its
/// edge; in the plane (n, t), t = (−n_y, n_x).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame<const D: usize>([Vector<D>; D]);

impl<const D: usize> Frame<D> {
    /// The frame of a wall with this unit normal, or of an edge along it.
    pub fn of_normal(normal: &Vector<D>) -> Frame<D>
    where
        Dim<D>: Dimension<D>,
    {
        Frame(Dim::<D>::frame(normal))
    }

    /// The directions.
    pub fn directions(&self) -> &[Vector<D>; D] {
        &self.0
    }

    /// The first D of these values, components along the axes, become those along the frame.
    #[inline]
    pub fn turn(&self, values: &mut [f64]) {
        let along_axes: Vector<D> = std::array::from_fn(|d| values[d]).into();
        for (value, direction) in values.iter_mut().zip(&self.0) {
            *value = space::dot(direction, &along_axes);
        }
    }

    /// Components along the axes from those along the frame.
    #[inline]
    pub fn turn_back(&self, values: &Vector<D>) -> Vector<D> {
        space::vector::from_fn(|d| {
            let mut sum = self.0[0][d] * values[0];
            for k in 1..D {
                sum += self.0[k][d] * values[k];
            }
            sum
        })
    }
}

/// Velocity of a node from its unknowns \[m/s\].
#[inline]
pub fn turn_back<const D: usize>(frame: &Option<Frame<D>>, values: &[f64]) -> Vector<D> {
    let values = std::array::from_fn(|d| values[d]).into();
    match frame {
        None => values,
        Some(frame) => frame.turn_back(&values),
    }
}

/// Velocity of every node from the unknowns \[m/s\].
pub fn velocity_of<const D: usize>(
    unknowns: &[f64],
    frames: &[Option<Frame<D>>],
) -> Vec<Vector<D>> {
    let nodes = unknowns.chunks_exact(D + 1).zip(frames);
    nodes.map(|(x, frame)| turn_back(frame, x)).collect()
}
