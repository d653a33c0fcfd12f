//! Lattices in a rectangle or box: rows above each other, or hexagonal.
//!
//! Along an axis over which the domain is periodic, whole cells fill it, so that the lattice continues across
//! the side. Elsewhere whole grains must fit: the outermost ones keep their radius, or their share of a cell,
//! from the side.

use space::Dim;

use crate::dimensions::Scenic;
use crate::keys::Lattice;

/// The axis along which rows or layers lie above each other.
const UP: usize = 1;

/// A place to be filled, with what decides how near to its sides grains may be.
pub struct Frame<'a, const D: usize> {
    /// Keys of the lattice.
    pub lattice: &'a Lattice<D>,
    /// Largest radius \[m\].
    pub radius: f64,
    /// Does it span a whole period along each axis?
    pub wraps: [bool; D],
}

/// Points along one axis: the first, the distance between two, how many.
#[derive(Clone, Copy)]
struct Row {
    first: f64,
    pitch: f64,
    count: f64,
}

/// A lattice that is decided, and not made yet.
pub struct Rows<'a, const D: usize> {
    lattice: &'a Lattice<D>,
    rows: [Row; D],
}

impl<'a, const D: usize> Frame<'a, D>
where
    Dim<D>: Scenic<D>,
{
    fn side(&self, axis: usize) -> f64 {
        self.lattice.upper[axis] - self.lattice.lower[axis]
    }

    /// How far rows are shifted against each other at most, in pitches.
    fn shift(&self, axis: usize) -> f64 {
        // Even and odd rows along every axis.
        let rows = (0..1 << D).map(|bits: usize| std::array::from_fn(|k| bits >> k & 1));
        let shifts = rows.map(|row| Dim::<D>::shift(self.lattice.pattern, &row)[axis]);
        shifts.fold(0.0, f64::max)
    }

    /// Distance along an axis, of that between neighbours.
    fn aspect(&self, axis: usize) -> f64 {
        Dim::<D>::pitch(self.lattice.pattern, axis)
    }

    fn rows(&self, rows: [Row; D]) -> Rows<'a, D> {
        let lattice = self.lattice;
        Rows { lattice, rows }
    }

    /// A lattice with this distance between neighbours, centred.
    pub fn with_spacing(&self, spacing: f64) -> Rows<'a, D> {
        self.rows(std::array::from_fn(|axis| {
            let (side, shift) = (self.side(axis), self.shift(axis));
            let pitch = spacing * self.aspect(axis);
            let room = if self.wraps[axis] {
                side / pitch
            } else {
                (side - 2.0 * self.radius) / pitch + 1.0 - shift
            };
            // A domain made for whole cells must not lose one to round-off.
            let count = (room * (1.0 + 1e-12)).floor().max(0.0);
            let extent = (count - 1.0 + shift) * pitch;
            Row {
                first: self.lattice.lower[axis] + 0.5 * (side - extent),
                pitch,
                count,
            }
        }))
    }

    /// A lattice with as many grains as make this solid fraction.
    pub fn with_fraction(&self, fraction: f64, grain: f64) -> Rows<'a, D> {
        let cell = grain / fraction;
        let aspects: f64 = (0..D).map(|axis| self.aspect(axis)).product();
        let ideal = space::simplex::cube_edge::<D>(cell / aspects);
        let mut counts = [1.0; D];
        for axis in (0..D).filter(|&axis| axis != UP) {
            counts[axis] = (self.side(axis) / (self.aspect(axis) * ideal))
                .round()
                .max(1.0);
        }
        // The rows above each other make up for what rounding the others changed.
        let content: f64 = (0..D).map(|axis| self.side(axis)).product();
        let others: f64 = counts.iter().product();
        counts[UP] = (content / cell / others).round().max(1.0);
        self.rows(std::array::from_fn(|axis| self.fitted(axis, counts[axis])))
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

impl<const D: usize> Rows<'_, D>
where
    Dim<D>: Scenic<D>,
{
    /// How many points.
    pub fn count(&self) -> f64 {
        self.rows.iter().map(|row| row.count).product()
    }

    /// The smallest distance between two points \[m\].
    pub fn nearest(&self) -> f64 {
        let few = self.rows.map(|row| row.count.min(3.0) as usize);
        let points = self.first(few);
        let apart = |(k, a): (usize, &[f64; D])| {
            let others = points[..k].iter();
            let distance = |b: &[f64; D]| (0..D).fold(0.0, |sum, d| f64::hypot(sum, a[d] - b[d]));
            others.map(distance).fold(f64::INFINITY, f64::min)
        };
        points
            .iter()
            .enumerate()
            .map(apart)
            .fold(f64::INFINITY, f64::min)
    }

    /// The points.
    pub fn points(&self) -> Vec<[f64; D]> {
        self.first(self.rows.map(|row| row.count as usize))
    }

    /// As many points along each axis, row by row and layer by layer.
    fn first(&self, counts: [usize; D]) -> Vec<[f64; D]> {
        let mut points = Vec::with_capacity(counts.iter().product());
        // Along x first, upward last.
        let order: Vec<usize> = (0..D).filter(|&axis| axis != UP).chain([UP]).collect();
        let mut number = [0; D];
        if counts.contains(&0) {
            return points;
        }
        loop {
            let shift = Dim::<D>::shift(self.lattice.pattern, &number);
            points.push(std::array::from_fn(|axis| {
                let Row { first, pitch, .. } = self.rows[axis];
                first + shift[axis] * pitch + number[axis] as f64 * pitch
            }));
            let next = order.iter().find(|&&axis| number[axis] + 1 < counts[axis]);
            let Some(&axis) = next else {
                return points;
            };
            for &before in order.iter().take_while(|&&before| before != axis) {
                number[before] = 0;
            }
            number[axis] += 1;
        }
    }
}
