//! The global system: pattern, scatter, matrix and right-hand side.
//!
//! Unknowns are interleaved (u_x, u_y, p) node by node; the matrix is stored by columns. Column
//! 3j+f holds, for each neighbour i of j in ascending order, the three rows of i. Where an element
//! adds its block is computed once. Elements are added in their order: same input, same bits.

use rayon::prelude::*;

use crate::boundary::Constraints;
use crate::continuity;
use crate::element::EDGE_QUADRATURE;
use crate::mesh::{BoundaryEdge, Mesh};
use crate::momentum::{self, Matrix, Vector};
use crate::point::{Coefficients, Element, ViscousForm};

/// Triangles whose blocks are computed, on all threads, before they are added in order.
const BATCH: usize = 2048;

/// Which entries of the matrix exist.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Start of the neighbours of each node, and their total at the end.
    pub start: Vec<usize>,
    /// Neighbours (with the node itself), ascending.
    pub neighbour: Vec<usize>,
    /// For each triangle, row corner i and column corner j: where the block begins and how far
    /// its columns are apart.
    place: Vec<[[(u32, u32); 3]; 3]>,
}

impl Pattern {
    /// Pattern of a mesh.
    pub fn new(mesh: &Mesh) -> Pattern {
        let mut of_node = vec![Vec::new(); mesh.node_count()];
        for nodes in &mesh.triangles {
            for &node in nodes {
                of_node[node].extend_from_slice(nodes);
            }
        }
        let mut start = vec![0];
        let mut neighbour = Vec::new();
        for list in &mut of_node {
            list.sort_unstable();
            list.dedup();
            neighbour.extend_from_slice(list);
            start.push(neighbour.len());
        }
        let place = |column: usize, row: usize| {
            let list = &of_node[column];
            let rank = list.partition_point(|&node| node < row);
            ((9 * start[column] + 3 * rank) as u32, 3 * list.len() as u32)
        };
        let blocks = mesh
            .triangles
            .iter()
            .map(|t| t.map(|row| t.map(|column| place(column, row))));
        let place = blocks.collect();
        Pattern {
            start,
            neighbour,
            place,
        }
    }

    /// Neighbours of a node, with itself, ascending.
    pub fn neighbours(&self, node: usize) -> &[usize] {
        &self.neighbour[self.start[node]..self.start[node + 1]]
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        3 * (self.start.len() - 1)
    }

    /// Number of entries.
    pub fn entries(&self) -> usize {
        9 * self.neighbour.len()
    }

    /// Start of each column, and row of each entry.
    pub fn columns(&self) -> (Vec<usize>, Vec<usize>) {
        let mut pointers = vec![0];
        let mut rows = Vec::with_capacity(self.entries());
        for list in self.start.windows(2) {
            for _ in 0..3 {
                for &node in &self.neighbour[list[0]..list[1]] {
                    rows.extend([3 * node, 3 * node + 1, 3 * node + 2]);
                }
                pointers.push(rows.len());
            }
        }
        (pointers, rows)
    }

    /// Call `visit(row, column, value)` for every entry, column by column.
    #[inline]
    pub fn for_each(&self, values: &[f64], mut visit: impl FnMut(usize, usize, f64)) {
        let mut entry = values.iter();
        for (node, list) in self.start.windows(2).enumerate() {
            for column in 3 * node..3 * node + 3 {
                for &other in &self.neighbour[list[0]..list[1]] {
                    for row in 3 * other..3 * other + 3 {
                        if let Some(&value) = entry.next() {
                            visit(row, column, value);
                        }
                    }
                }
            }
        }
    }

    /// y ← y − K x.
    pub fn subtract_product(&self, values: &[f64], x: &[f64], y: &mut [f64]) {
        self.for_each(values, |row, column, value| y[row] -= value * x[column]);
    }
}

/// The assembled equations, before any unknown is fixed.
#[derive(Debug, Clone)]
pub struct System {
    /// Which entries exist.
    pub pattern: Pattern,
    /// Entries of the matrix K.
    pub matrix: Vec<f64>,
    /// Right-hand side.
    pub right: Vec<f64>,
}

impl System {
    /// An empty system on a mesh.
    pub fn new(mesh: &Mesh) -> System {
        let pattern = Pattern::new(mesh);
        let (matrix, right) = (vec![0.0; pattern.entries()], vec![0.0; pattern.unknowns()]);
        System {
            pattern,
            matrix,
            right,
        }
    }

    /// Assemble; the matrix is left as it is when `matrix_too` is false. `flux` is ∮ N_i Q_n.
    pub fn assemble(
        &mut self,
        terms: &Coefficients<'_>,
        mesh: &Mesh,
        constraints: &Constraints,
        flux: &[f64],
        matrix_too: bool,
    ) {
        if matrix_too {
            self.matrix.fill(0.0);
        }
        self.right.fill(0.0);
        let mut batch = vec![([[0.0; 9]; 9], [0.0; 9]); BATCH.min(mesh.triangles.len())];
        for first in (0..mesh.triangles.len()).step_by(BATCH) {
            let count = BATCH.min(mesh.triangles.len() - first);
            batch[..count]
                .par_iter_mut()
                .enumerate()
                .for_each(|(k, slot)| {
                    *slot = element_system(terms, mesh, constraints, first + k, matrix_too);
                });
            for (k, (matrix, right)) in batch[..count].iter().enumerate() {
                self.scatter_right(&mesh.triangles[first + k], right);
                if matrix_too {
                    self.scatter_matrix(first + k, matrix);
                }
            }
        }
        if matrix_too && terms.viscous_form == ViscousForm::Symmetric {
            self.add_open_edges(terms, mesh, constraints);
        }
        for (node, flux) in flux.iter().enumerate() {
            self.right[3 * node + 2] -= flux;
        }
    }

    fn add_open_edges(&mut self, terms: &Coefficients<'_>, mesh: &Mesh, constraints: &Constraints) {
        for edge in &constraints.open_edges {
            let element = Element::gather(terms, mesh, edge.triangle);
            let mut matrix: Matrix = [[0.0; 9]; 9];
            add_open_edge(&element, edge, &mut matrix);
            let nodes = &mesh.triangles[edge.triangle];
            turn(&constraints.frames, nodes, &mut matrix, &mut [0.0; 9]);
            self.scatter_matrix(edge.triangle, &matrix);
        }
    }

    #[inline]
    fn scatter_right(&mut self, nodes: &[usize; 3], right: &Vector) {
        for (k, &node) in nodes.iter().enumerate() {
            for q in 0..3 {
                self.right[3 * node + q] += right[3 * k + q];
            }
        }
    }

    #[inline]
    fn scatter_matrix(&mut self, triangle: usize, matrix: &Matrix) {
        let place = &self.pattern.place[triangle];
        for i in 0..3 {
            for j in 0..3 {
                let (begin, stride) = place[i][j];
                for f in 0..3 {
                    let at = (begin + f * stride) as usize;
                    for (d, slot) in self.matrix[at..at + 3].iter_mut().enumerate() {
                        *slot += matrix[3 * i + d][3 * j + f as usize];
                    }
                }
            }
        }
    }

    /// K x − r, the reaction on each unknown.
    pub fn reaction(&self, x: &[f64]) -> Vec<f64> {
        let mut residual = self.right.clone();
        self.pattern
            .subtract_product(&self.matrix, x, &mut residual);
        residual.iter_mut().for_each(|value| *value = -*value);
        residual
    }
}

/// Matrix (zero unless wanted) and right-hand side of triangle `t`.
fn element_system(
    terms: &Coefficients<'_>,
    mesh: &Mesh,
    constraints: &Constraints,
    t: usize,
    matrix_too: bool,
) -> (Matrix, Vector) {
    let element = Element::gather(terms, mesh, t);
    let (mut matrix, mut right) = ([[0.0; 9]; 9], [0.0; 9]);
    for at in element.points() {
        momentum::add_right_side(&at, &mut right);
        continuity::add_right_side(&at, &mut right);
        if matrix_too {
            momentum::add_matrix(&at, &mut matrix);
            continuity::add_matrix(&at, &mut matrix);
        }
    }
    turn(
        &constraints.frames,
        &mesh.triangles[t],
        &mut matrix,
        &mut right,
    );
    (matrix, right)
}

/// − ∮ μφ (∇v)ᵀn·w on an open edge: the natural condition becomes μφ ∂v/∂n = 0, which a
/// fully developed flow satisfies, in place of 2μφ D(v) n = 0, which bends it.
fn add_open_edge(element: &Element<'_>, edge: &BoundaryEdge, matrix: &mut Matrix) {
    for (position, weight) in EDGE_QUADRATURE {
        let mut shape = [0.0; 3];
        shape[edge.corner[0]] = 1.0 - position;
        shape[edge.corner[1]] = position;
        let at = element.point(shape, weight * edge.length);
        for i in edge.corner {
            for j in 0..3 {
                for d in 0..2 {
                    let traction = at.viscosity * at.test_gradient[j][d];
                    for f in 0..2 {
                        matrix[3 * i + d][3 * j + f] -=
                            at.weight * at.test[i] * traction * edge.normal[f];
                    }
                }
            }
        }
    }
}

/// Turn the velocity unknowns and equations of nodes on oblique slip walls to (n, t),
/// t = (−n_y, n_x).
fn turn(frames: &[Option<[f64; 2]>], nodes: &[usize; 3], matrix: &mut Matrix, right: &mut Vector) {
    for (k, &node) in nodes.iter().enumerate() {
        let Some(n) = frames[node] else { continue };
        let (x, y) = (3 * k, 3 * k + 1);
        let turned = |a: f64, b: f64| (n[0] * a + n[1] * b, n[0] * b - n[1] * a);
        (right[x], right[y]) = turned(right[x], right[y]);
        let (first, second) = (matrix[x], matrix[y]);
        for (column, (&a, &b)) in first.iter().zip(&second).enumerate() {
            (matrix[x][column], matrix[y][column]) = turned(a, b);
        }
        for row in matrix.iter_mut() {
            (row[x], row[y]) = turned(row[x], row[y]);
        }
    }
}

/// Velocity components from the unknowns of a node.
pub fn turn_back(frame: Option<[f64; 2]>, value: [f64; 2]) -> [f64; 2] {
    match frame {
        None => value,
        Some(n) => [
            n[0] * value[0] - n[1] * value[1],
            n[1] * value[0] + n[0] * value[1],
        ],
    }
}
