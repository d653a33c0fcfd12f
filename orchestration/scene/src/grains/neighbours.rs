//! Grains already placed, by cells as large as the largest grain, with periodic images.

use std::collections::BTreeMap;

/// Cell list of placed grains.
pub struct Neighbours {
    cell: f64,
    period: [Option<f64>; 2],
    cells: BTreeMap<(i64, i64), Vec<Placed>>,
}

#[derive(Clone, Copy)]
struct Placed {
    position: [f64; 2],
    radius: f64,
    fixed: bool,
}

impl Neighbours {
    /// An empty list; `cell` is the largest diameter.
    pub fn new(cell: f64, period: [Option<f64>; 2]) -> Self {
        Neighbours {
            cell: cell.max(f64::MIN_POSITIVE),
            period,
            cells: BTreeMap::new(),
        }
    }

    /// An empty list with the same cells and periods.
    pub fn like(&self) -> Self {
        Neighbours::new(self.cell, self.period)
    }

    fn index(&self, position: [f64; 2]) -> (i64, i64) {
        (
            (position[0] / self.cell).floor() as i64,
            (position[1] / self.cell).floor() as i64,
        )
    }

    /// Add a grain and its images across periodic sides.
    pub fn insert(&mut self, position: [f64; 2], radius: f64, fixed: bool) {
        let shifts = self.period.map(|period| match period {
            Some(period) => vec![0.0, -period, period],
            None => vec![0.0],
        });
        for dx in &shifts[0] {
            for dy in &shifts[1] {
                let image = [position[0] + dx, position[1] + dy];
                let cell = self.index(image);
                self.cells.entry(cell).or_default().push(Placed {
                    position: image,
                    radius,
                    fixed,
                });
            }
        }
    }

    /// Largest overlap \[m\] with a placed grain; 0 for none. Two fixed grains may overlap.
    pub fn deepest_overlap(&self, position: [f64; 2], radius: f64, fixed: bool) -> f64 {
        let (column, row) = self.index(position);
        let mut deepest: f64 = 0.0;
        for i in column - 1..=column + 1 {
            for j in row - 1..=row + 1 {
                for other in self.cells.get(&(i, j)).into_iter().flatten() {
                    let dx = other.position[0] - position[0];
                    let dy = other.position[1] - position[1];
                    let overlap = radius + other.radius - dx.hypot(dy);
                    if !(fixed && other.fixed) {
                        deepest = deepest.max(overlap);
                    }
                }
            }
        }
        deepest
    }
}
