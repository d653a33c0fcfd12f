//! The fluid's mesh as ParaView takes it: across a periodic side its nodes appear twice.

use std::collections::BTreeMap;

use protocol::field::Field;

/// A mesh whose simplices all lie where they are drawn, in any number of dimensions: triangles in the
/// plane, tetrahedra in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Numbers a point.
    pub dimension: usize,
    /// Points \[m\], flat: the nodes, then copies of nodes beyond periodic sides.
    pub points: Vec<f64>,
    /// The node of each point.
    pub node_of: Vec<u32>,
    /// Corners of the simplices as points, flat: `dimension + 1` a simplex.
    pub corners: Vec<u32>,
    /// Number of nodes: the length of nodal fields.
    pub node_count: usize,
}

impl Mesh {
    /// From the fields of `Started`; none when they do not fit together.
    pub fn from_fields(dimension: usize, fields: &[(Field, Vec<f64>)]) -> Option<Mesh> {
        let values = |wanted: Field| {
            fields
                .iter()
                .find(|(field, _)| *field == wanted)
                .map(|(_, values)| values.as_slice())
        };
        let nodes = values(Field::NodePosition)?.to_vec();
        let corners = values(Field::SimplexNodes)?;
        let places = values(Field::SimplexPosition)?;
        let node_count = nodes.len() / dimension;
        let mut mesh = Mesh {
            dimension,
            points: nodes,
            node_of: (0..node_count as u32).collect(),
            corners: Vec::with_capacity(corners.len()),
            node_count,
        };
        let fits = corners.len() * dimension == places.len()
            && corners.len().is_multiple_of(dimension + 1)
            && corners.iter().all(|&node| (node as usize) < node_count);
        fits.then(|| {
            mesh.unwrap(corners, places);
            mesh
        })
    }

    /// Unwrapped corners are a whole period away from their node, or exactly on it.
    fn unwrap(&mut self, corners: &[f64], places: &[f64]) {
        let mut copies: BTreeMap<(u32, Vec<u64>), u32> = BTreeMap::new();
        for (corner, place) in corners.iter().zip(places.chunks_exact(self.dimension)) {
            let node = *corner as u32;
            let point = if self.point(node) == place {
                node
            } else {
                let key = (node, place.iter().map(|x| x.to_bits()).collect());
                *copies.entry(key).or_insert_with(|| {
                    self.points.extend_from_slice(place);
                    self.node_of.push(node);
                    self.node_of.len() as u32 - 1
                })
            };
            self.corners.push(point);
        }
    }

    /// Where a point is \[m\].
    pub fn point(&self, point: u32) -> &[f64] {
        let start = point as usize * self.dimension;
        &self.points[start..start + self.dimension]
    }

    /// Values of a nodal field at the points, `width` numbers each.
    pub fn at_points(&self, nodal: &[f64], width: usize) -> Vec<f64> {
        let at = |&node: &u32| &nodal[node as usize * width..(node as usize + 1) * width];
        self.node_of.iter().flat_map(at).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_beyond_a_periodic_side_becomes_a_point_of_its_own() {
        // Two cells, periodic in x: nodes 0, 1 below and 2, 3 above; the second cell wraps.
        let mesh = Mesh::from_fields(
            2,
            &[
                (
                    Field::NodePosition,
                    vec![0.0, 0.0, 0.5, 0.0, 0.0, 1.0, 0.5, 1.0],
                ),
                (Field::SimplexNodes, vec![1.0, 0.0, 2.0, 1.0, 2.0, 3.0]),
                (
                    Field::SimplexPosition,
                    vec![0.5, 0.0, 1.0, 0.0, 1.0, 1.0, 0.5, 0.0, 1.0, 1.0, 0.5, 1.0],
                ),
            ],
        )
        .expect("a mesh");
        println!("{mesh:?}");
        assert_eq!(mesh.node_of, [0, 1, 2, 3, 0, 2]);
        assert_eq!(mesh.corners, [1, 4, 5, 1, 5, 3]);
        assert_eq!(mesh.point(4), [1.0, 0.0]);
    }
}
