//! The mesh: nodes, triangles, named boundary edges; periodic sides share their nodes.
//!
//! Corner coordinates are kept for each triangle as well: across a periodic boundary they are
//! unwrapped, so geometry always comes from them and never from the node coordinates. With one
//! cell across a period two corners of a triangle are the same node; nothing here minds.

use crate::element::Triangle;
use crate::error::FluidError;

/// An edge of the boundary, with the domain on its left.
#[derive(Debug, Clone, Copy)]
pub struct BoundaryEdge {
    /// Corner numbers of the edge within its triangle, in counter-clockwise order.
    pub corner: [usize; 2],
    /// Nodes of the edge.
    pub node: [usize; 2],
    /// The triangle it belongs to.
    pub triangle: usize,
    /// Which boundary, index into `Mesh::boundary_names`.
    pub boundary: usize,
    /// Outward unit normal.
    pub normal: [f64; 2],
    /// Length \[m\].
    pub length: f64,
}

/// A mesh of linear triangles.
#[derive(Debug, Clone)]
pub struct Mesh {
    /// Node coordinates \[m\].
    pub position: Vec<[f64; 2]>,
    /// Corners of each triangle, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// Corner coordinates of each triangle \[m\], unwrapped across periodic boundaries.
    pub corners: Vec<[[f64; 2]; 3]>,
    /// Gradients and area of each triangle.
    pub geometry: Vec<Triangle>,
    /// Lumped mass ∫N_α of each node \[m²\].
    pub nodal_mass: Vec<f64>,
    /// Edges of the boundary that are not joined periodically.
    pub edges: Vec<BoundaryEdge>,
    /// Names of the boundaries.
    pub boundary_names: Vec<String>,
    /// Period in x and y \[m\].
    pub period: [Option<f64>; 2],
}

impl Mesh {
    /// Mesh from its parts; `named` lists boundary edges as (node, node, boundary), `tag` numbers
    /// triangles in error messages. Every edge of a single triangle must be named once.
    pub fn new(
        position: Vec<[f64; 2]>,
        triangles: Vec<[usize; 3]>,
        boundary_names: Vec<String>,
        named: &[(usize, usize, usize)],
        tag: impl Fn(usize) -> usize,
    ) -> Result<Mesh, FluidError> {
        let corners: Vec<_> = triangles.iter().map(|t| t.map(|n| position[n])).collect();
        let mut mesh = Mesh::without_edges(position, triangles, corners, tag)?;
        mesh.boundary_names = boundary_names;
        mesh.edges = mesh.match_edges(named)?;
        Ok(mesh)
    }

    /// Geometry and lumped mass; every triangle must be counter-clockwise.
    pub(crate) fn without_edges(
        position: Vec<[f64; 2]>,
        triangles: Vec<[usize; 3]>,
        corners: Vec<[[f64; 2]; 3]>,
        tag: impl Fn(usize) -> usize,
    ) -> Result<Mesh, FluidError> {
        if triangles.is_empty() {
            return Err(FluidError::Mesh("no triangles".into()));
        }
        let geometry: Vec<_> = corners.iter().map(Triangle::new).collect();
        let mut nodal_mass = vec![0.0; position.len()];
        for (index, (nodes, shape)) in triangles.iter().zip(&geometry).enumerate() {
            if shape.area.is_nan() || shape.area <= 0.0 {
                let [a, b, c] = corners[index];
                let (triangle, area) = (tag(index), shape.area);
                return Err(FluidError::InvertedTriangle {
                    triangle,
                    a,
                    b,
                    c,
                    area,
                });
            }
            for &node in nodes {
                nodal_mass[node] += shape.area / 3.0;
            }
        }
        Ok(Mesh {
            position,
            triangles,
            corners,
            geometry,
            nodal_mass,
            edges: Vec::new(),
            boundary_names: Vec::new(),
            period: [None; 2],
        })
    }

    /// The edge `k` of triangle `t` (opposite to its corner k) as an edge of `boundary`.
    pub(crate) fn edge(&self, t: usize, k: usize, boundary: usize) -> BoundaryEdge {
        let corner = [(k + 1) % 3, (k + 2) % 3];
        let [a, b] = corner.map(|c| self.corners[t][c]);
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        BoundaryEdge {
            corner,
            node: corner.map(|c| self.triangles[t][c]),
            triangle: t,
            boundary,
            normal: [(b[1] - a[1]) / length, (a[0] - b[0]) / length],
            length,
        }
    }

    /// Names for the edges of single triangles, in the order of the triangles.
    fn match_edges(
        &self,
        named: &[(usize, usize, usize)],
    ) -> Result<Vec<BoundaryEdge>, FluidError> {
        let ordered = |a: usize, b: usize| (a.min(b), a.max(b));
        let mut names: Vec<_> = named.iter().map(|&(a, b, k)| (ordered(a, b), k)).collect();
        names.sort_unstable();
        names.dedup();
        let ends = |(a, b): (usize, usize)| (self.position[a], self.position[b]);
        if let Some(pair) = names.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let (a, b) = ends(pair[0].0);
            let [first, second] = [pair[0].1, pair[1].1].map(|k| self.boundary_names[k].clone());
            return Err(FluidError::EdgeInTwoBoundaries {
                a,
                b,
                first,
                second,
            });
        }
        let mut sides = Vec::with_capacity(3 * self.triangles.len());
        for (t, nodes) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                sides.push((ordered(nodes[(k + 1) % 3], nodes[(k + 2) % 3]), t, k));
            }
        }
        sides.sort_unstable();
        let mut edges = Vec::new();
        let mut used = 0;
        for group in sides.chunk_by(|p, q| p.0 == q.0) {
            let (key, t, k) = group[0];
            let name = names.binary_search_by(|entry| entry.0.cmp(&key));
            match (group.len(), name) {
                (1, Ok(at)) => {
                    used += 1;
                    edges.push(self.edge(t, k, names[at].1));
                }
                (1, Err(_)) => {
                    let (a, b) = ends(key);
                    let names = self.boundary_names.clone();
                    return Err(FluidError::UnnamedEdge { a, b, names });
                }
                (2, Err(_)) => {}
                (2, Ok(at)) => return Err(self.inside(key, names[at].1)),
                (count, _) => return Err(self.crowded(key, count)),
            }
        }
        if used != names.len() {
            let stray = names
                .iter()
                .find(|n| sides.binary_search_by(|s| s.0.cmp(&n.0)).is_err());
            let (key, boundary) = *stray.unwrap_or(&names[0]);
            let (a, b) = ends(key);
            let name = &self.boundary_names[boundary];
            let why = format!("edge {a:?} to {b:?} of boundary {name:?} is no side of a triangle");
            return Err(FluidError::Mesh(why));
        }
        edges.sort_unstable_by_key(|edge| (edge.triangle, edge.corner[0]));
        Ok(edges)
    }

    fn inside(&self, (a, b): (usize, usize), boundary: usize) -> FluidError {
        let (p, q) = (self.position[a], self.position[b]);
        let name = &self.boundary_names[boundary];
        FluidError::Mesh(format!(
            "edge {p:?} to {q:?} of boundary {name:?} lies inside the domain; \
             only edges of a single triangle can carry a condition"
        ))
    }

    fn crowded(&self, (a, b): (usize, usize), count: usize) -> FluidError {
        let (p, q) = (self.position[a], self.position[b]);
        FluidError::Mesh(format!(
            "edge {p:?} to {q:?} belongs to {count} triangles; at most 2"
        ))
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.position.len()
    }

    /// Index of a boundary by its name.
    pub fn boundary(&self, name: &str) -> Result<usize, FluidError> {
        let found = self.boundary_names.iter().position(|known| known == name);
        found.ok_or_else(|| FluidError::UnknownBoundary {
            name: name.into(),
            allowed: self.boundary_names.clone(),
        })
    }

    /// Mass-averaged gradient ℓ_α⁻¹ ∫N_α ∇p of a nodal field.
    pub fn averaged_gradient(&self, value: &[f64]) -> Vec<[f64; 2]> {
        let mut sum = vec![[0.0; 2]; self.node_count()];
        for (nodes, shape) in self.triangles.iter().zip(&self.geometry) {
            let gradient = shape.gradient_of(&nodes.map(|n| value[n]));
            for &node in nodes {
                for d in 0..2 {
                    sum[node][d] += shape.area / 3.0 * gradient[d];
                }
            }
        }
        for (sum, mass) in sum.iter_mut().zip(&self.nodal_mass) {
            *sum = [sum[0] / mass, sum[1] / mass];
        }
        sum
    }
}
