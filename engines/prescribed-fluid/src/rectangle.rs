//! A uniform rectangle cut into triangles, and the averaged gradient of a nodal field on it.

/// Nodes and triangles.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Interleaved node coordinates \[m\].
    pub position: Vec<f64>,
    /// Corners, counter-clockwise.
    pub triangles: Vec<[u32; 3]>,
    /// Corner coordinates \[m\], unwrapped across periodic sides.
    pub corners: Vec<[f64; 6]>,
    /// ∫N of each node \[m²\].
    pub mass: Vec<f64>,
}

/// What to cut.
#[derive(Debug, Clone, Copy)]
pub struct Rectangle {
    /// Lower left corner \[m\].
    pub lower: [f64; 2],
    /// Upper right corner \[m\].
    pub upper: [f64; 2],
    /// Cells in x and y.
    pub cells: [usize; 2],
    /// All diagonals alike, or alternating from cell to cell.
    pub uniform: bool,
    /// Which directions are periodic: their last nodes are their first ones.
    pub periodic: [bool; 2],
}

impl Rectangle {
    /// Two triangles a cell.
    pub fn mesh(&self) -> Mesh {
        let [nx, ny] = self.cells;
        let nodes = |axis: usize| self.cells[axis] + usize::from(!self.periodic[axis]);
        let (columns, rows) = (nodes(0), nodes(1));
        let place = |[i, j]: [usize; 2]| -> [f64; 2] {
            let along = |axis: usize, k: usize| {
                let share = k as f64 / self.cells[axis] as f64;
                self.lower[axis] + share * (self.upper[axis] - self.lower[axis])
            };
            [along(0, i), along(1, j)]
        };
        let node = |[i, j]: [usize; 2]| (j % rows * columns + i % columns) as u32;
        let mut mesh = Mesh {
            mass: vec![0.0; columns * rows],
            ..Mesh::default()
        };
        for j in 0..rows {
            (0..columns).for_each(|i| mesh.position.extend(place([i, j])));
        }
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            let [a, b, c, d] = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
            let rising = self.uniform || (i + j) % 2 == 0;
            let halves = if rising {
                [[a, b, c], [a, c, d]]
            } else {
                [[a, b, d], [b, c, d]]
            };
            for half in halves {
                let [p, q, r] = half.map(place);
                mesh.triangles.push(half.map(node));
                mesh.corners.push([p[0], p[1], q[0], q[1], r[0], r[1]]);
                let third = area(&[p[0], p[1], q[0], q[1], r[0], r[1]]) / 3.0;
                half.map(node)
                    .iter()
                    .for_each(|&n| mesh.mass[n as usize] += third);
            }
        }
        mesh
    }
}

fn area(p: &[f64; 6]) -> f64 {
    0.5 * ((p[2] - p[0]) * (p[5] - p[1]) - (p[4] - p[0]) * (p[3] - p[1]))
}

impl Mesh {
    /// ℓ_α⁻¹ ∫N_α ∇p of a nodal field, interleaved. A jump across a period (a pressure that falls along
    /// a periodic direction) is not seen: periodic fields only.
    pub fn averaged_gradient(&self, value: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (nodes, p) in self.triangles.iter().zip(&self.corners) {
            let [a, b, c] = nodes.map(|node| value[node as usize]);
            // A ∇p = ½ Σ p_k (edge opposite to corner k turned by a right angle)
            let x = a * (p[3] - p[5]) + b * (p[5] - p[1]) + c * (p[1] - p[3]);
            let y = a * (p[4] - p[2]) + b * (p[0] - p[4]) + c * (p[2] - p[0]);
            for &node in nodes {
                gradient[2 * node as usize] += x / 6.0;
                gradient[2 * node as usize + 1] += y / 6.0;
            }
        }
        for (k, sum) in gradient.iter_mut().enumerate() {
            *sum /= self.mass[k / 2];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_sum_to_the_area_and_linear_gradients_are_exact() {
        for (uniform, periodic) in [
            (true, [false; 2]),
            (false, [false; 2]),
            (true, [true, false]),
        ] {
            let mesh = Rectangle {
                lower: [-1.0, 0.5],
                upper: [2.0, 2.5],
                cells: [1, 4],
                uniform,
                periodic,
            }
            .mesh();
            let sum: f64 = mesh.mass.iter().sum();
            assert!((sum - 6.0).abs() < 1e-13, "{sum}");
            let slope = if periodic[0] { 0.0 } else { 2.0 };
            let (places, _) = mesh.position.as_chunks::<2>();
            let value: Vec<f64> = places.iter().map(|[x, y]| slope * x - 3.0 * y).collect();
            let mut gradient = vec![0.0; 2 * value.len()];
            mesh.averaged_gradient(&value, &mut gradient);
            for pair in gradient.as_chunks::<2>().0 {
                assert!(
                    (pair[0] - slope).abs() < 1e-13 && (pair[1] + 3.0).abs() < 1e-13,
                    "{pair:?}"
                );
            }
        }
    }
}
