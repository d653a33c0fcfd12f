//! What can only be drawn in the plane: pictures and the page. ParaView shows space.

use std::collections::BTreeMap;

use run::vtu::mesh::Mesh;
use run::vtu::read::State;
use scene::Error;

/// A point or vector of the plane.
pub type Point = [f64; 2];

/// A mesh of triangles that all lie where they are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Triangles {
    /// Points \[m\]: the nodes, then copies of nodes beyond periodic sides.
    pub points: Vec<Point>,
    /// The node of each point.
    pub node_of: Vec<u32>,
    /// Corners of the triangles, as points.
    pub triangles: Vec<[u32; 3]>,
    /// Number of nodes: the length of nodal fields.
    pub node_count: usize,
}

impl Triangles {
    /// A mesh of the plane; none for any other.
    pub fn of(mesh: Mesh) -> Option<Triangles> {
        (mesh.dimension == 2).then(|| Triangles {
            points: pairs(&mesh.points),
            triangles: triples(&mesh.corners),
            node_of: mesh.node_of,
            node_count: mesh.node_count,
        })
    }

    /// Those of a state that was written: every point is a node of its own; none in a state without them.
    pub fn of_state(state: &State) -> Result<Option<Triangles>, Error> {
        let points = state.vectors::<2>("position")?;
        let corners = state.indices("connectivity")?;
        let (Some(points), Some(corners)) = (points, corners) else {
            return Ok(None);
        };
        let outside = |&corner: &i64| corner < 0 || corner as usize >= points.len();
        if corners.iter().any(outside) {
            let why = "a triangle names a point that is not there";
            return Err(state.refuse("connectivity", why));
        }
        let corners: Vec<u32> = corners.iter().map(|&corner| corner as u32).collect();
        Ok(Some(Triangles {
            node_of: (0..points.len() as u32).collect(),
            node_count: points.len(),
            triangles: triples(&corners),
            points,
        }))
    }

    /// Lower left and upper right corner of all points \[m\].
    pub fn bounds(&self) -> (Point, Point) {
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

/// Flat numbers as points.
pub fn pairs(numbers: &[f64]) -> Vec<Point> {
    numbers.chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}

/// Flat corners as triangles.
pub fn triples(corners: &[u32]) -> Vec<[u32; 3]> {
    corners
        .chunks_exact(3)
        .map(|c| [c[0], c[1], c[2]])
        .collect()
}

/// Lower left and upper right corner of points.
pub fn bounds(points: impl Iterator<Item = Point>) -> (Point, Point) {
    points.fold(([f64::MAX; 2], [f64::MIN; 2]), |(low, high), point| {
        (
            [low[0].min(point[0]), low[1].min(point[1])],
            [high[0].max(point[0]), high[1].max(point[1])],
        )
    })
}

/// Lower left and upper right corner of disks.
pub fn grain_bounds(centres: impl Iterator<Item = Point>, radius: &[f64]) -> (Point, Point) {
    let radii = radius.iter().copied().chain(std::iter::repeat(0.0));
    bounds(
        centres
            .zip(radii)
            .flat_map(|(centre, radius)| [centre.map(|x| x - radius), centre.map(|x| x + radius)]),
    )
}
