//! What an engine tells about itself when it is configured: its mesh, or its grains.

use crate::language::field::Field;
use crate::language::message::MeshBoundary;

/// The mesh of a fluid engine. Flat numbers; shapes: see [`Field`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MeshDescription {
    /// Dimension d of the space.
    pub dimension: usize,
    /// Node coordinates \[m\], d numbers each.
    pub node_position: Vec<f64>,
    /// Nodes of each simplex's corners, positively oriented, d + 1 numbers each.
    pub simplex_nodes: Vec<u32>,
    /// Coordinates of each simplex's corners \[m\], unwrapped across periodic boundaries, d (d + 1) numbers
    /// each.
    pub simplex_position: Vec<f64>,
    /// Lumped mass of each node \[m²; m³ in space\].
    pub nodal_mass: Vec<f64>,
    /// Period along each axis \[m\].
    pub period: Vec<Option<f64>>,
    /// The boundary; without facets where the engine does not tell it.
    pub facets: FacetDescription,
}

/// The boundary of a mesh, in facets: edges in the plane, triangles in space. Flat numbers; shapes: see
/// [`Field`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FacetDescription {
    /// The boundaries that facets belong to.
    pub boundaries: Vec<MeshBoundary>,
    /// Coordinates of each facet's corners \[m\], d d numbers each: in the plane with the fluid on the left
    /// of the way, in space seen counter-clockwise from outside.
    pub position: Vec<f64>,
    /// Number of each facet's boundary in `boundaries`.
    pub boundary: Vec<u32>,
    /// Velocity that the boundary gives the fluid there \[m/s\], d numbers each.
    pub velocity: Vec<f64>,
}

impl FacetDescription {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.boundary.len()
    }

    /// Boundaries of the facets as numbers of a field.
    pub fn boundary_numbers(&self) -> Vec<f64> {
        self.boundary.iter().map(|&number| number.into()).collect()
    }
}

impl MeshDescription {
    /// How many nodes it has.
    pub fn node_count(&self) -> usize {
        self.nodal_mass.len()
    }

    /// How many simplices it has.
    pub fn simplex_count(&self) -> usize {
        self.simplex_nodes.len() / (self.dimension + 1)
    }

    /// Area (in space the volume) of a simplex; negative where its corners are the wrong way round.
    pub fn measure(&self, simplex: usize) -> f64 {
        let d = self.dimension;
        let corners = &self.simplex_position[simplex * d * (d + 1)..];
        let edge = |corner: usize, axis: usize| corners[corner * d + axis] - corners[axis];
        if d == 2 {
            return 0.5 * (edge(1, 0) * edge(2, 1) - edge(2, 0) * edge(1, 1));
        }
        let minor = |a: usize, b: usize| edge(2, a) * edge(3, b) - edge(2, b) * edge(3, a);
        let determinant =
            edge(1, 0) * minor(1, 2) - edge(1, 1) * minor(0, 2) + edge(1, 2) * minor(0, 1);
        determinant / 6.0
    }

    /// Corners of the simplices as numbers of a field.
    pub fn corner_numbers(&self) -> Vec<f64> {
        self.simplex_nodes.iter().map(|&node| node.into()).collect()
    }
}

/// Grains as they are when a run begins, or when others have left. Flat numbers; shapes: see [`Field`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InitialGrains {
    /// Dimension d of the space.
    pub dimension: usize,
    /// Centres \[m\], d numbers each.
    pub position: Vec<f64>,
    /// Velocities \[m/s\], d numbers each.
    pub velocity: Vec<f64>,
    /// Radii \[m\].
    pub radius: Vec<f64>,
    /// Masses \[kg\].
    pub mass: Vec<f64>,
    /// Volumes \[m³\] (disk: m²).
    pub volume: Vec<f64>,
    /// 1 for a grain that never moves.
    pub fixed: Vec<f64>,
}

impl InitialGrains {
    /// How many there are.
    pub fn count(&self) -> usize {
        self.radius.len()
    }

    /// From the arrays in the order of [`GRAINS`](crate::field::GRAINS).
    pub fn from_arrays(dimension: usize, arrays: [Vec<f64>; 6]) -> InitialGrains {
        let [position, velocity, radius, mass, volume, fixed] = arrays;
        InitialGrains {
            dimension,
            position,
            velocity,
            radius,
            mass,
            volume,
            fixed,
        }
    }

    /// The same without some of them, by ascending numbers.
    pub fn without(&self, gone: &[usize]) -> InitialGrains {
        let d = self.dimension;
        InitialGrains {
            dimension: d,
            position: without(&self.position, d, gone),
            velocity: without(&self.velocity, d, gone),
            radius: without(&self.radius, 1, gone),
            mass: without(&self.mass, 1, gone),
            volume: without(&self.volume, 1, gone),
            fixed: without(&self.fixed, 1, gone),
        }
    }

    /// The fields in the order of [`GRAINS`](crate::field::GRAINS).
    pub fn slices(&self) -> [(Field, &[f64]); 6] {
        [
            (Field::GrainPosition, &self.position),
            (Field::GrainVelocity, &self.velocity),
            (Field::GrainRadius, &self.radius),
            (Field::GrainMass, &self.mass),
            (Field::GrainVolume, &self.volume),
            (Field::GrainFixed, &self.fixed),
        ]
    }
}

/// Values of `components` numbers a grain without those of some grains, by ascending numbers.
pub fn without<T: Clone>(values: &[T], components: usize, gone: &[usize]) -> Vec<T> {
    let mut left = Vec::with_capacity(values.len().saturating_sub(gone.len() * components));
    let mut from = 0;
    for &grain in gone {
        left.extend_from_slice(&values[from..grain * components]);
        from = (grain + 1) * components;
    }
    left.extend_from_slice(&values[from..]);
    left
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_keeps_its_order() {
        let numbers: Vec<u32> = (0..10).collect();
        assert_eq!(without(&numbers, 2, &[0, 3]), [2, 3, 4, 5, 8, 9]);
        assert_eq!(without(&numbers, 2, &[4]), (0..8).collect::<Vec<_>>());
        assert_eq!(without(&numbers, 1, &[]), numbers);
        assert!(without(&numbers, 5, &[0, 1]).is_empty());
    }
}
