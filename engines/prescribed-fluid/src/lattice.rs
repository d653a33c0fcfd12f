//! A uniform rectangle or box cut into simplices, and the averaged gradient of a nodal field on it.

use space::dimension::factorial;
use space::{Dim, Dimension, Simplex, Vector, vector};

/// Orders of the axes, each one exchange from the one before; the first two are those of the plane.
const ORDERS: [[usize; 3]; 6] = [
    [0, 1, 2],
    [1, 0, 2],
    [1, 2, 0],
    [2, 1, 0],
    [2, 0, 1],
    [0, 2, 1],
];

/// Nodes and simplices.
#[derive(Debug, Clone, Default)]
pub struct Mesh<const D: usize, const N: usize> {
    /// Nodes \[m\].
    pub position: Vec<Vector<D>>,
    /// Corners, positively oriented.
    pub simplices: Vec<[u32; N]>,
    /// Coordinates of the corners \[m\], unwrapped across periodic sides.
    pub corners: Vec<[Vector<D>; N]>,
    /// ∫N of each node \[m^D\].
    pub mass: Vec<f64>,
}

/// What to cut.
#[derive(Debug, Clone, Copy)]
pub struct Lattice<const D: usize> {
    /// Corner with the lowest coordinates \[m\].
    pub lower: Vector<D>,
    /// Corner with the highest coordinates \[m\].
    pub upper: Vector<D>,
    /// Cells along each axis.
    pub cells: [usize; D],
    /// In the plane: diagonals alternate from cell to cell, or all are alike.
    pub alternate: bool,
    /// Which directions are periodic: their last nodes are their first ones.
    pub periodic: [bool; D],
}

impl<const D: usize> Lattice<D>
where
    Dim<D>: Dimension<D>,
{
    /// D! simplices a cell (Kuhn): from a corner along the axes in each of their orders.
    pub fn mesh<const N: usize>(&self) -> Mesh<D, N> {
        let nodes: [usize; D] =
            std::array::from_fn(|axis| self.cells[axis] + usize::from(!self.periodic[axis]));
        let count = nodes.iter().product();
        let mut mesh = Mesh {
            position: (0..count).map(|k| self.place(digits(k, nodes))).collect(),
            simplices: Vec::new(),
            corners: Vec::new(),
            mass: vec![0.0; count],
        };
        for cell in (0..self.cells.iter().product()).map(|k| digits(k, self.cells)) {
            for order in 0..factorial(D) {
                let at = self.simplex::<N>(cell, order);
                let corners = at.map(|corner| self.place(corner));
                let numbers = at.map(|corner| number(corner, nodes) as u32);
                let share = Simplex::new(&corners).volume / N as f64;
                for node in numbers {
                    mesh.mass[node as usize] += share;
                }
                mesh.simplices.push(numbers);
                mesh.corners.push(corners);
            }
        }
        mesh
    }

    /// Corners of a simplex of a cell, in cells from the lowest corner of all.
    fn simplex<const N: usize>(&self, cell: [usize; D], order: usize) -> [[usize; D]; N] {
        let mut offset = [0; D];
        let mut at = [offset; N];
        for k in 1..N {
            offset[ORDERS[order][k - 1]] = 1;
            at[k] = offset;
        }
        // Every second order is left-handed, and so is a cell seen in a mirror.
        let mirrored = self.alternate && cell.iter().sum::<usize>() % 2 == 1;
        if mirrored {
            at.iter_mut().for_each(|corner| corner[0] = 1 - corner[0]);
        }
        if (order % 2 == 1) != mirrored {
            at.swap(N - 2, N - 1);
        }
        at.map(|corner| std::array::from_fn(|axis| cell[axis] + corner[axis]))
    }

    fn place(&self, at: [usize; D]) -> Vector<D> {
        vector::from_fn(|axis| {
            let share = at[axis] as f64 / self.cells[axis] as f64;
            self.lower[axis] + share * (self.upper[axis] - self.lower[axis])
        })
    }
}

/// The digits of a number, the first one counting the units, each below its count.
fn digits<const D: usize>(number: usize, counts: [usize; D]) -> [usize; D] {
    let mut rest = number;
    counts.map(|count| {
        let digit = rest % count;
        rest /= count;
        digit
    })
}

/// The number with these digits, each taken around where it reaches its count.
fn number<const D: usize>(digits: [usize; D], counts: [usize; D]) -> usize {
    let axes = (0..D).rev();
    axes.fold(0, |sum, axis| {
        sum * counts[axis] + digits[axis] % counts[axis]
    })
}

impl<const D: usize, const N: usize> Mesh<D, N>
where
    Dim<D>: Dimension<D>,
{
    /// ℓ_α⁻¹ ∫N_α ∇p of a nodal field. A jump across a period (a pressure that falls along a periodic
    /// direction) is not seen: periodic fields only.
    pub fn averaged_gradient(&self, value: &[f64]) -> Vec<Vector<D>> {
        let mut sum = vec![Vector::zeros(); self.mass.len()];
        for (nodes, corners) in self.simplices.iter().zip(&self.corners) {
            let simplex = Simplex::new(corners);
            let gradient = simplex.gradient_of(&nodes.map(|node| value[node as usize]));
            for &node in nodes {
                sum[node as usize] += gradient * (simplex.volume / N as f64);
            }
        }
        let mass = self.mass.iter();
        sum.iter()
            .zip(mass)
            .map(|(sum, mass)| sum / *mass)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check<const D: usize, const N: usize>(lattice: Lattice<D>, volume: f64)
    where
        Dim<D>: Dimension<D>,
    {
        let mesh = lattice.mesh::<N>();
        let sum: f64 = mesh.mass.iter().sum();
        assert!((sum - volume).abs() < 1e-13, "{sum}");
        let least = mesh
            .corners
            .iter()
            .map(|corners| Simplex::new(corners).volume);
        assert!(least.fold(f64::INFINITY, f64::min) > 0.0);
        let slope: Vector<D> = vector::from_fn(|axis| match lattice.periodic[axis] {
            true => 0.0,
            false => [2.0, -3.0, 5.0][axis],
        });
        let value: Vec<f64> = mesh.position.iter().map(|x| slope.dot(x)).collect();
        for gradient in mesh.averaged_gradient(&value) {
            assert!((gradient - slope).abs().max() < 1e-12, "{gradient:?}");
        }
    }

    #[test]
    fn masses_sum_to_the_volume_and_linear_gradients_are_exact() {
        for (alternate, periodic) in [
            (false, [false; 2]),
            (true, [false; 2]),
            (false, [true, false]),
        ] {
            let rectangle = Lattice {
                lower: [-1.0, 0.5].into(),
                upper: [2.0, 2.5].into(),
                cells: [1, 4],
                alternate,
                periodic,
            };
            check::<2, 3>(rectangle, 6.0);
        }
        for periodic in [[false; 3], [true, false, true]] {
            let cuboid = Lattice {
                lower: [-1.0, 0.5, 0.0].into(),
                upper: [2.0, 2.5, 0.5].into(),
                cells: [1, 4, 3],
                alternate: false,
                periodic,
            };
            check::<3, 4>(cuboid, 3.0);
        }
    }
}
