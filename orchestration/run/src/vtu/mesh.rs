//! The fluid's mesh as it is drawn: across a periodic side its nodes appear twice.

use std::collections::BTreeMap;

use protocol::field::Field;

/// A mesh whose triangles all lie where they are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Points \[m\]: the nodes, then copies of nodes beyond periodic sides.
    pub points: Vec<[f64; 2]>,
    /// The node of each point.
    pub node_of: Vec<u32>,
    /// Corners of the triangles, as points.
    pub triangles: Vec<[u32; 3]>,
    /// Number of nodes: the length of nodal fields.
    pub node_count: usize,
}

impl Mesh {
    /// From the fields of `Started`; none when they do not fit together.
    pub fn from_fields(fields: &[(Field, Vec<f64>)]) -> Option<Mesh> {
        let values = |wanted: Field| {
            fields
                .iter()
                .find(|(field, _)| *field == wanted)
                .map(|(_, values)| values.as_slice())
        };
        let positions = values(Field::NodePosition)?;
        let corners = values(Field::TriangleNodes)?;
        let corner_positions = values(Field::TrianglePosition)?;
        Mesh::new(positions, corners, corner_positions)
    }

    fn new(positions: &[f64], corners: &[f64], corner_positions: &[f64]) -> Option<Mesh> {
        let mut points: Vec<[f64; 2]> = positions.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
        let node_count = points.len();
        let mut node_of: Vec<u32> = (0..node_count as u32).collect();
        let mut copies: BTreeMap<(u32, u64, u64), u32> = BTreeMap::new();
        if corners.len() * 2 != corner_positions.len() {
            return None;
        }
        let mut flat = Vec::with_capacity(corners.len());
        for (corner, at) in corners.iter().zip(corner_positions.chunks_exact(2)) {
            let node = *corner as u32;
            let home = points.get(node as usize).copied()?;
            // Unwrapped corners are a whole period away from their node, or exactly on it.
            if home == [at[0], at[1]] {
                flat.push(node);
                continue;
            }
            let key = (node, at[0].to_bits(), at[1].to_bits());
            let point = *copies.entry(key).or_insert_with(|| {
                points.push([at[0], at[1]]);
                node_of.push(node);
                points.len() as u32 - 1
            });
            flat.push(point);
        }
        let triangles = flat.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        Some(Mesh {
            points,
            node_of,
            triangles,
            node_count,
        })
    }

    /// Lower left and upper right corner of all points \[m\].
    pub fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        bounds(self.points.iter().copied())
    }

    /// Edges of one triangle only: the boundary.
    pub fn boundary(&self) -> Vec<[u32; 2]> {
        let mut uses: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        for triangle in &self.triangles {
            for side in 0..3 {
                let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
                *uses.entry((a.min(b), a.max(b))).or_default() += 1;
            }
        }
        uses.into_iter()
            .filter(|(_, count)| *count == 1)
            .map(|((a, b), _)| [a, b])
            .collect()
    }
}

/// Lower left and upper right corner of points.
pub fn bounds(points: impl Iterator<Item = [f64; 2]>) -> ([f64; 2], [f64; 2]) {
    points.fold(([f64::MAX; 2], [f64::MIN; 2]), |(low, high), point| {
        (
            [low[0].min(point[0]), low[1].min(point[1])],
            [high[0].max(point[0]), high[1].max(point[1])],
        )
    })
}
