//! Square and hexagonal lattices in a rectangle.
//!
//! Along an axis over which the domain is periodic, whole cells fill the rectangle, so that the
//! lattice continues across the side. Elsewhere whole grains must fit: the outermost ones keep
//! their radius, or their share of a cell, from the side.

use crate::keys::{Lattice, Pattern};

/// A rectangle to be filled, with what decides how near to its sides grains may be.
pub struct Frame<'a> {
    /// Keys of the lattice.
    pub lattice: &'a Lattice,
    /// Largest radius \[m\].
    pub radius: f64,
    /// Does the rectangle span a whole period in x and y?
    pub wraps: [bool; 2],
}

/// Points along one axis: the first, the distance between two, how many.
#[derive(Clone, Copy)]
struct Row {
    first: f64,
    pitch: f64,
    count: f64,
}

/// A lattice that is decided, and not made yet.
pub struct Rows {
    across: Row,
    up: Row,
    /// How far every second row is shifted \[m\].
    shift: f64,
}

impl Frame<'_> {
    fn side(&self, axis: usize) -> f64 {
        self.lattice.upper[axis] - self.lattice.lower[axis]
    }

    fn hexagonal(&self) -> bool {
        self.lattice.pattern == Pattern::Hexagonal
    }

    /// How far rows are shifted against each other, in pitches: only along x of a hexagonal one.
    fn shift(&self, axis: usize) -> f64 {
        if self.hexagonal() && axis == 0 {
            0.5
        } else {
            0.0
        }
    }

    /// Height over width of a lattice cell.
    fn aspect(&self) -> f64 {
        if self.hexagonal() {
            0.75_f64.sqrt()
        } else {
            1.0
        }
    }

    fn rows(&self, [across, up]: [Row; 2]) -> Rows {
        let shift = self.shift(0) * across.pitch;
        Rows { across, up, shift }
    }

    /// A lattice with this distance between neighbours, centred.
    pub fn with_spacing(&self, spacing: f64) -> Rows {
        let rows = [spacing, spacing * self.aspect()];
        let rows = [0, 1].map(|axis| {
            let (side, pitch, shift) = (self.side(axis), rows[axis], self.shift(axis));
            let room = if self.wraps[axis] {
                side / pitch
            } else {
                (side - 2.0 * self.radius) / pitch + 1.0 - shift
            };
            // A rectangle made for whole cells must not lose one to round-off.
            let count = (room * (1.0 + 1e-12)).floor().max(0.0);
            let extent = (count - 1.0 + shift) * pitch;
            Row {
                first: self.lattice.lower[axis] + 0.5 * (side - extent),
                pitch,
                count,
            }
        });
        self.rows(rows)
    }

    /// A lattice with as many grains as make this solid fraction of the rectangle.
    pub fn with_fraction(&self, fraction: f64, grain_area: f64) -> Rows {
        let cell_area = grain_area / fraction;
        let ideal = (cell_area / self.aspect()).sqrt();
        let columns = (self.side(0) / ideal).round().max(1.0);
        // Rows make up for what rounding the columns changed.
        let rows = (self.side(0) * self.side(1) / cell_area / columns)
            .round()
            .max(1.0);
        self.rows([(0, columns), (1, rows)].map(|(axis, count)| self.fitted(axis, count)))
    }

    /// `count` points over the whole side.
    fn fitted(&self, axis: usize, count: f64) -> Row {
        let (side, shift) = (self.side(axis), self.shift(axis));
        let cell = side / count;
        let share = 0.5 * (1.0 - shift) * cell;
        let margin = if self.wraps[axis] {
            share
        } else {
            share.max(self.radius)
        };
        let steps = count - 1.0 + shift;
        let pitch = if steps > 0.0 {
            (side - 2.0 * margin) / steps
        } else {
            side
        };
        let first = if steps > 0.0 { margin } else { 0.5 * side };
        Row {
            first: self.lattice.lower[axis] + first,
            pitch,
            count,
        }
    }
}

impl Rows {
    /// How many points.
    pub fn count(&self) -> f64 {
        self.across.count * self.up.count
    }

    /// The smallest distance between two points \[m\].
    pub fn nearest(&self) -> f64 {
        let apart = |row: Row, distance: f64| match row.count > 1.0 {
            true => distance,
            false => f64::INFINITY,
        };
        let within_row = apart(self.across, self.across.pitch);
        within_row.min(apart(self.up, self.shift.hypot(self.up.pitch)))
    }

    /// The points.
    pub fn points(&self) -> Vec<[f64; 2]> {
        let (columns, rows) = (self.across.count as usize, self.up.count as usize);
        let mut positions = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            let shift = self.shift * (row % 2) as f64;
            for column in 0..columns {
                let x = self.across.first + shift + column as f64 * self.across.pitch;
                positions.push([x, self.up.first + row as f64 * self.up.pitch]);
            }
        }
        positions
    }
}
