//! Structured and graded rectangles, each cell cut into two triangles.
//!
//! ```text
//!   top          c ─ d      even cell: a–d      odd cell: b–c
//!   left  right  │ ╱ │
//!   bottom       a ─ b
//! ```

use space::Vector;

use super::simplices::Mesh;
use crate::error::FluidError;

/// How cells are cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Diagonals {
    /// Alternating from cell to cell: no preferred direction.
    Alternate,
    /// All the same: translation invariant.
    Uniform,
}

/// A rectangle of cells.
#[derive(Debug, Clone)]
pub struct Rectangle {
    /// Lower left corner \[m\].
    pub lower: Vector<2>,
    /// Upper right corner \[m\].
    pub upper: Vector<2>,
    /// Cells in x and y.
    pub cells: [usize; 2],
    /// How cells are cut.
    pub diagonals: Diagonals,
    /// Ratio of the largest cell (centre) to the smallest (both ends) in x and y.
    pub grading: Vector<2>,
    /// Joined left to right, bottom to top.
    pub periodic: [bool; 2],
}

/// Names of the sides, in the order of their numbers.
pub const SIDES: [&str; 4] = ["left", "right", "bottom", "top"];

impl Rectangle {
    /// Uniform rectangle with alternating diagonals, not periodic.
    pub fn new(
        lower: impl Into<Vector<2>>,
        upper: impl Into<Vector<2>>,
        cells: [usize; 2],
    ) -> Rectangle {
        Rectangle {
            lower: lower.into(),
            upper: upper.into(),
            cells,
            diagonals: Diagonals::Alternate,
            grading: [1.0; 2].into(),
            periodic: [false; 2],
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> Result<Mesh<2, 3>, FluidError> {
        self.validate()?;
        let [nx, ny] = self.cells;
        let lines = [0, 1].map(|d| self.grid_lines(d));
        // Nodes a row and rows: a periodic direction has no last one.
        let count = [0, 1].map(|d| self.cells[d] + usize::from(!self.periodic[d]));
        let node = |i: usize, j: usize| (j % count[1]) * count[0] + i % count[0];
        let mut position = Vec::with_capacity(count[0] * count[1]);
        for j in 0..count[1] {
            for i in 0..count[0] {
                position.push(Vector::from([lines[0][i], lines[1][j]]));
            }
        }
        let mut simplices = Vec::with_capacity(2 * nx * ny);
        let mut corners = Vec::with_capacity(2 * nx * ny);
        let mut sides = Vec::new();
        for j in 0..ny {
            for i in 0..nx {
                for cut in self.cut(i, j) {
                    let at = cut.map(|[di, dj]| [i + di, j + dj]);
                    self.note_sides(&at, simplices.len(), &mut sides);
                    simplices.push(at.map(|[i, j]| node(i, j)));
                    corners.push(at.map(|[i, j]| Vector::from([lines[0][i], lines[1][j]])));
                }
            }
        }
        let mut mesh = Mesh::without_facets(position, simplices, corners, |t| t)?;
        mesh.boundary_names = SIDES.map(String::from).to_vec();
        mesh.facets = sides
            .iter()
            .map(|&(t, k, side)| mesh.facet(t, k, side))
            .collect();
        mesh.period = [0, 1].map(|d| self.periodic[d].then(|| self.upper[d] - self.lower[d]));
        Ok(mesh)
    }

    /// Offsets of the corners of the two triangles of a cell, counter-clockwise.
    fn cut(&self, i: usize, j: usize) -> [[[usize; 2]; 3]; 2] {
        let (a, b, c, d) = ([0, 0], [1, 0], [0, 1], [1, 1]);
        if self.diagonals == Diagonals::Uniform || (i + j).is_multiple_of(2) {
            [[a, b, d], [a, d, c]]
        } else {
            [[a, b, c], [b, d, c]]
        }
    }

    /// Sides of a triangle that lie on a side of the rectangle which is not periodic.
    fn note_sides(
        &self,
        at: &[[usize; 2]; 3],
        triangle: usize,
        sides: &mut Vec<(usize, usize, usize)>,
    ) {
        for k in 0..3 {
            let (p, q) = (at[(k + 1) % 3], at[(k + 2) % 3]);
            for d in (0..2).filter(|&d| !self.periodic[d]) {
                for (end, side) in [(0, 2 * d), (self.cells[d], 2 * d + 1)] {
                    if p[d] == end && q[d] == end {
                        sides.push((triangle, k, side));
                    }
                }
            }
        }
    }

    /// Coordinates of the grid lines in a direction: cell k from the nearer end has the size
    /// s·r^(k/m), m the middle cell, r the grading.
    fn grid_lines(&self, d: usize) -> Vec<f64> {
        let n = self.cells[d];
        let middle = ((n - 1) / 2).max(1) as f64;
        let size = |k: usize| self.grading[d].powf(k.min(n - 1 - k) as f64 / middle);
        let mut sum = vec![0.0];
        for k in 0..n {
            sum.push(sum[k] + size(k));
        }
        let (lower, upper) = (self.lower[d], self.upper[d]);
        let mut lines: Vec<_> = sum
            .iter()
            .map(|s| lower + (upper - lower) * (s / sum[n]))
            .collect();
        lines[n] = upper;
        lines
    }

    fn validate(&self) -> Result<(), FluidError> {
        for d in 0..2 {
            let axis = ["x", "y"][d];
            let (lower, upper) = (self.lower[d], self.upper[d]);
            if !(lower.is_finite() && upper.is_finite() && upper > lower) {
                let why =
                    format!("rectangle: upper {axis} = {upper} must exceed lower {axis} = {lower}");
                return Err(FluidError::Mesh(why));
            }
            if self.cells[d] == 0 {
                return Err(FluidError::Mesh(format!(
                    "rectangle: 0 cells in {axis}; at least 1"
                )));
            }
            if !(self.grading[d] > 0.0 && self.grading[d].is_finite()) {
                let why = format!(
                    "rectangle: grading {} in {axis} must be positive",
                    self.grading[d]
                );
                return Err(FluidError::Mesh(why));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_sum_to_the_area_and_normals_point_outward() {
        let mut rectangle = Rectangle::new([-1.0, 0.5], [2.0, 1.5], [7, 5]);
        rectangle.grading = [4.0, 2.0].into();
        let mesh = rectangle.mesh().unwrap();
        assert!((mesh.nodal_mass.iter().sum::<f64>() - 3.0).abs() < 1e-13);
        let outward = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
        for facet in &mesh.facets {
            for (normal, exact) in facet.normal.iter().zip(outward[facet.boundary]) {
                assert!((normal - exact).abs() < 1e-14);
            }
        }
        assert_eq!(mesh.facets.len(), 24);
        let width = |i: usize| mesh.position[i + 1][0] - mesh.position[i][0];
        assert!((width(3) / width(0) - 4.0).abs() < 1e-12);
    }

    #[test]
    fn one_cell_across_a_period_is_a_mesh() {
        let mut rectangle = Rectangle::new([0.0, 0.0], [0.1, 1.0], [1, 10]);
        rectangle.periodic = [true, false];
        let mesh = rectangle.mesh().unwrap();
        assert_eq!((mesh.node_count(), mesh.facets.len()), (11, 2));
        assert!((mesh.nodal_mass.iter().sum::<f64>() - 0.1).abs() < 1e-15);
        let value: Vec<_> = mesh.position.iter().map(|x| 3.0 * x[1]).collect();
        for gradient in mesh.averaged_gradient(&value) {
            assert!(gradient[0].abs() < 1e-12 && (gradient[1] - 3.0).abs() < 1e-12);
        }
    }
}
