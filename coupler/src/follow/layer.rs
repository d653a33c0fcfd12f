//! Places where cells are small, and when they are no longer the right ones.
//!
//! ```text
//!   C = cells of a lattice that are wished small              zone = C and the rings around it: h = size
//!   ask anew when an urgent cell is beyond C and the inner rings, or the zone is too much larger than one made now (A1)
//! ```
//!
//! The cells are those of one lattice throughout, so that the mesh depends on what is wished and not on how that came.

use protocol::scene::Region;
use space::{Period, Vector};

/// Numbers of cells at most: what is farther away is in no mesh.
const FARTHEST: i64 = 1 << 40;

/// A cell of the lattice.
pub type Cell<const D: usize> = [i64; D];

/// When a zone is made anew.
#[derive(Debug, Clone, Copy)]
pub struct Rule {
    /// Rings around the cells of a new zone.
    pub outer: i64,
    /// Those that an urgent cell may be in.
    pub inner: i64,
    /// A zone that is larger than this many times the one made now is made anew.
    pub too_large: f64,
}

/// A lattice, and the cells of it that are small.
#[derive(Debug, Clone)]
pub struct Layer<const D: usize> {
    /// h in the zone \[m\].
    pub size: f64,
    rule: Rule,
    /// Edges of a cell \[m\]: of a period a whole number.
    edge: [f64; D],
    /// Cells in a period.
    count: [Option<i64>; D],
    /// Cells when it was asked for, those with the inner rings, and how large the zone was.
    asked: Vec<Cell<D>>,
    within: Vec<Cell<D>>,
    zone: usize,
}

impl<const D: usize> Layer<D> {
    /// Of cells of this edge \[m\].
    pub fn new(size: f64, edge: f64, period: &Period<D>, rule: Rule) -> Layer<D> {
        let count = period.map(|length| length.map(|length| (length / edge).floor().max(1.0)));
        let edge = std::array::from_fn(|d| match (period[d], count[d]) {
            (Some(length), Some(count)) => length / count,
            _ => edge,
        });
        Layer {
            size,
            rule,
            edge,
            count: count.map(|count| count.map(|count| count as i64)),
            asked: Vec::new(),
            within: Vec::new(),
            zone: 0,
        }
    }

    /// Must the zone be made anew (A1), where these cells are wished small, and these of them urgently?
    pub fn is_outdated(&self, cells: &[Cell<D>], urgent: &[Cell<D>]) -> bool {
        if cells == self.asked {
            return false;
        }
        let outside = |cell| self.within.binary_search(cell).is_err();
        let now = || self.around(cells, self.rule.outer).len();
        urgent.iter().any(outside) || self.zone as f64 > self.rule.too_large * now() as f64
    }

    /// Make the zone of these cells.
    pub fn ask(&mut self, cells: Vec<Cell<D>>) {
        self.within = self.around(&cells, self.rule.inner);
        self.zone = self.around(&cells, self.rule.outer).len();
        self.asked = cells;
    }

    /// The cells of the zone as it was made last, D numbers each.
    pub fn asked(&self) -> Vec<i64> {
        self.asked.concat()
    }

    /// The zone as few boxes, of a lattice that is this often coarser by two.
    pub fn zone(&self, coarser: u32) -> Vec<Region> {
        let cells = self.around(&self.asked, self.rule.outer);
        let coarse = cells.iter().map(|cell| cell.map(|k| k >> coarser));
        let corner = |cell: Cell<D>| -> Vec<f64> {
            let along = |d: usize| (cell[d] << coarser) as f64 * self.edge[d];
            (0..D).map(along).collect()
        };
        let region = |[low, high]: [Cell<D>; 2]| Region::Box {
            lower: corner(low),
            upper: corner(high),
            size: self.size,
        };
        let boxes = merged(sorted(coarse.collect()));
        boxes.into_iter().map(region).collect()
    }

    /// Cells that a ball touches, added to `cells`.
    pub fn add(&self, centre: &Vector<D>, radius: f64, cells: &mut Vec<Cell<D>>) {
        let cell = |d: usize, x: f64| {
            let cell = (x / self.edge[d]).floor() as i64;
            cell.clamp(-FARTHEST, FARTHEST)
        };
        let middle: Cell<D> = std::array::from_fn(|d| self.wrap(d, cell(d, centre[d])));
        let reach: [i64; D] = std::array::from_fn(|d| {
            let [low, high] = [-radius, radius].map(|r| cell(d, centre[d] + r));
            (high - low + 1) / 2
        });
        self.box_around(&middle, reach, cells);
    }

    fn wrap(&self, axis: usize, cell: i64) -> i64 {
        self.count[axis].map_or(cell, |count| cell.rem_euclid(count))
    }

    /// Cells and the rings around them.
    fn around(&self, cells: &[Cell<D>], rings: i64) -> Vec<Cell<D>> {
        let mut all = Vec::new();
        for cell in cells {
            self.box_around(cell, [rings; D], &mut all);
        }
        sorted(all)
    }

    fn box_around(&self, cell: &Cell<D>, reach: [i64; D], all: &mut Vec<Cell<D>>) {
        let mut offset: Cell<D> = reach.map(|reach| -reach);
        loop {
            all.push(std::array::from_fn(|d| self.wrap(d, cell[d] + offset[d])));
            let Some(axis) = (0..D).find(|&d| offset[d] < reach[d]) else {
                return;
            };
            offset[axis] += 1;
            for before in 0..axis {
                offset[before] = -reach[before];
            }
        }
    }
}

/// Cells of numbers that were kept; none where these are no cells.
pub fn cells_of<const D: usize>(numbers: &[i64]) -> Option<Vec<Cell<D>>> {
    let cells = numbers.chunks_exact(D);
    let whole = cells.remainder().is_empty() && numbers.iter().all(|k| k.abs() <= FARTHEST);
    whole.then(|| cells.filter_map(|cell| cell.try_into().ok()).collect())
}

/// In ascending order, each once.
pub fn sorted<const D: usize>(mut cells: Vec<Cell<D>>) -> Vec<Cell<D>> {
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// Cells as boxes that cover them and no other, from the lower corner to the one beyond the upper: along one axis
/// after the other, boxes that continue each other are one.
fn merged<const D: usize>(cells: Vec<Cell<D>>) -> Vec<[Cell<D>; 2]> {
    let mut boxes: Vec<[Cell<D>; 2]> = cells.into_iter().map(|c| [c, c.map(|k| k + 1)]).collect();
    for axis in 0..D {
        // those that agree along the other axes beside each other, in the order of this one
        let key = |[low, high]: &[Cell<D>; 2]| {
            let others = |d: usize| match d == axis {
                true => [0, 0],
                false => [low[d], high[d]],
            };
            (std::array::from_fn::<_, D, _>(others), low[axis])
        };
        boxes.sort_unstable_by_key(key);
        let mut fewer: Vec<[Cell<D>; 2]> = Vec::with_capacity(boxes.len());
        for next in boxes {
            match fewer.last_mut() {
                Some(last) if key(last).0 == key(&next).0 && last[1][axis] == next[0][axis] => {
                    last[1][axis] = next[1][axis];
                }
                _ => fewer.push(next),
            }
        }
        boxes = fewer;
    }
    boxes
}
