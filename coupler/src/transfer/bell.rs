//! The kernel of a grain: how its volume is spread around its centre.
//!
//! ```text
//!   K(x) ∝ (1 − |x|²/R²)²,   ∫K = 1,   R = max(2.75 r, 2 h)      (T3)
//!   d ≤ h/4: the centre alone
//! ```
//!
//! | symbol | meaning                                              | unit |
//! | ------ | ---------------------------------------------------- | ---- |
//! | r, d   | radius and diameter of the grain                     | m    |
//! | h      | edge of the square or cube of D! simplices around it | m    |
//!
//! The bell is as wide (mean square) as a uniform disk of 1.94 r. Alone it leaves a porosity of 0.6 (disk)
//! or 0.8 (sphere) in the middle of its grain; those of disks packed as densely as they can be add up to at
//! most 0.96, where narrower or flatter ones pass 1. Grains smaller than a cell need 2 h: nodes with little
//! mass carry the noise of single grains otherwise, and grains that touch are dragged apart.

use protocol::scene::LUMPED_RATIO_MAX;
use space::{Vector, simplex, vector};

/// R of the radius.
const RADII: f64 = 2.75;
/// R of the cell, at least.
const CELLS: f64 = 2.0;
/// Lattice points along the edge of a cell for grains of which 2.75 r is less than a cell, and for larger
/// ones: whole numbers, so that a uniform bed is uniform on a regular mesh wherever the two lattices lie.
const POINTS: [f64; 2] = [2.0, 3.0];
/// Points that are looked at for one grain; a wider lattice is coarser.
const POINTS_MAX: f64 = 4e6;
/// A ratio that differs from the limit by round-off is the limit.
const ROUND_OFF: f64 = 1e-9;

/// Points of the bell: those of a square or cubic lattice within its radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bell {
    /// R \[m\].
    radius: f64,
    /// Between neighbours of the lattice \[m\].
    spacing: f64,
}

impl Bell {
    /// Of a grain of this radius \[m\] among cells of this size \[m\]; none: its centre is enough.
    pub fn of<const D: usize>(radius: f64, cell: f64) -> Option<Bell> {
        if 2.0 * radius <= LUMPED_RATIO_MAX * cell * (1.0 + ROUND_OFF) {
            return None;
        }
        let (own, needed) = (RADII * radius, CELLS * cell);
        let spacing = cell / POINTS[usize::from(own > cell)];
        let radius = own.max(needed);
        let most = 0.5 * simplex::cube_edge::<D>(POINTS_MAX);
        Some(Bell {
            radius,
            spacing: spacing.max(radius / most),
        })
    }

    /// Between neighbours of its lattice \[m\].
    pub fn spacing(&self) -> f64 {
        self.spacing
    }
}

/// The lattice of a bell, which is the same for all with the same R over the spacing.
#[derive(Debug, Default)]
pub struct Lattice<const D: usize> {
    ratio: f64,
    points: Vec<(Vector<D>, f64)>,
}

impl<const D: usize> Lattice<D> {
    /// The points of a bell from the centre, in spacings, and their weights, which do not sum to one; line by line.
    pub fn of(&mut self, bell: &Bell) -> &[(Vector<D>, f64)] {
        let ratio = bell.radius / bell.spacing;
        if ratio != self.ratio {
            self.ratio = ratio;
            self.points.clear();
            self.points.extend(points(ratio));
        }
        &self.points
    }
}

/// Each next to the one before it as far as that can be: every second line, and every second plane of lines, runs
/// backwards.
fn points<const D: usize>(ratio: f64) -> impl Iterator<Item = (Vector<D>, f64)> {
    let rings = ratio as i64;
    let side = 2 * rings + 1;
    (0..side.pow(D as u32)).filter_map(move |number| {
        let at: [i64; D] = std::array::from_fn(|axis| {
            let lines = number / side.pow(axis as u32);
            let along = lines % side;
            let backwards = lines / side % 2 == 1;
            (if backwards { side - 1 - along } else { along }) - rings
        });
        let square: i64 = at.iter().map(|x| x * x).sum();
        let height = 1.0 - square as f64 / (ratio * ratio);
        let point = || vector::from_fn(|axis| at[axis] as f64);
        (height > 0.0).then(|| (point(), height * height))
    })
}
