//! The one cell grid: pairs of bodies within reach of each other.
//!
//! Each body has a reach (its radius plus how far it may move); a pair is visited when the two
//! reaches overlap. Bodies are sorted into levels by reach, a factor 2 wide, each with cells of
//! its own largest diameter, so that a few large or fast bodies do not spoil the cells of the
//! others. A body looks into the 3^D cells around it on its own level and on all coarser ones.
//! Cells lie in a table no larger than a few times the number of bodies, whatever the extent:
//! cells that share a slot are told apart by their coordinates.

use crate::periodic::{Image, Period, each_image, is_periodic, shifted, shortest_image};
use crate::vector::{Vector, dot};

/// Spare reach of a search whose pairs are kept for the steps that follow, of the radius.
pub const SPARE: f64 = 0.4;

/// A body in a level.
#[derive(Debug, Clone, Copy)]
struct Entry<const D: usize> {
    position: Vector<D>,
    reach: f64,
    body: u32,
    cell: [i32; D],
}

/// Bodies of like reach.
#[derive(Debug)]
struct Level<const D: usize> {
    /// Lower corner \[m\].
    origin: Vector<D>,
    /// Width of a cell along each axis \[m\].
    cell: Vector<D>,
    /// Cells in a period; 0 along an axis that is not periodic.
    cells: [i32; D],
    /// Distance in the table between cells that are neighbours along each axis.
    stride: [i64; D],
    /// Slots of the table, less one; a power of two less one.
    mask: i64,
    /// First entry of each slot.
    start: Vec<u32>,
    /// Bodies, by slot, then by number.
    entries: Vec<Entry<D>>,
}

/// A search was given up: bodies reach so far that there are more than so many distances between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooFar {
    /// Distances that the search was allowed.
    pub most: usize,
}

/// Cell lists over all levels.
///
/// ```
/// use space::{Vector, grid::Grid};
/// let position = [[0.1, 0.0], [0.9, 0.0], [0.5, 0.0]].map(Vector::from);
/// let mut pairs = Vec::new();
/// let grid = Grid::build(&position, &[0.15; 3], &[Some(1.0), None]);
/// grid.for_each_pair(|i, j, apart, _| pairs.push((i, j, apart[0])));
/// assert_eq!((pairs.len(), pairs[0].0, pairs[0].1), (1, 0, 1));
/// assert!((pairs[0].2 - 0.2).abs() < 1e-15);
/// ```
#[derive(Debug)]
pub struct Grid<const D: usize> {
    levels: Vec<Level<D>>,
    period: Period<D>,
}

impl<const D: usize> Grid<D> {
    /// Sort the bodies; `reach` \[m\] must be positive.
    pub fn build(position: &[Vector<D>], reach: &[f64], period: &Period<D>) -> Grid<D> {
        let smallest = reach.iter().copied().fold(f64::INFINITY, f64::min);
        let mut members: Vec<Vec<u32>> = Vec::new();
        for (body, reach) in reach.iter().enumerate() {
            let level = (reach / smallest).log2() as usize;
            if members.len() <= level {
                members.resize(level + 1, Vec::new());
            }
            members[level].push(body as u32);
        }
        let levels = members
            .iter()
            .filter(|members| !members.is_empty())
            .map(|members| Level::build(members, position, reach, period))
            .collect();
        let period = *period;
        Grid { levels, period }
    }

    /// Will `for_each_pair` compute about so many distances at most? Found out with no more work than that.
    pub fn works_within(&self, most: f64) -> bool {
        let half = 0.5 * 3f64.powi(D as i32);
        let mut left = (most / half) as usize;
        let mut levels = self.levels.iter();
        levels.all(|level| level.shares_within(&mut left))
    }

    /// Visit every pair (i < j, xᵢ − xⱼ, image) whose reaches overlap, each image of it once,
    /// always in the same order.
    pub fn for_each_pair(&self, visit: impl FnMut(usize, usize, Vector<D>, Image)) {
        let all = self.for_each_pair_within(usize::MAX, visit);
        debug_assert!(all.is_ok(), "there is no limit");
    }

    /// The same, given up when more than about so many distances are looked at: some pairs have been visited then.
    pub fn for_each_pair_within(
        &self,
        most: usize,
        mut visit: impl FnMut(usize, usize, Vector<D>, Image),
    ) -> Result<(), TooFar> {
        let mut looks = 0;
        for (number, own) in self.levels.iter().enumerate() {
            for (coarse, other) in self.levels.iter().enumerate().skip(number) {
                let same = coarse == number;
                let search = Search::new(other, same);
                for (place, entry) in own.entries.iter().enumerate() {
                    looks += self.around(entry, place, other, &search, &mut visit);
                    if looks > most {
                        return Err(TooFar { most });
                    }
                }
            }
        }
        Ok(())
    }

    /// Visit the pairs of one body with those of `level`; how many bodies were looked at.
    fn around(
        &self,
        entry: &Entry<D>,
        place: usize,
        level: &Level<D>,
        search: &Search<D>,
        visit: &mut impl FnMut(usize, usize, Vector<D>, Image),
    ) -> usize {
        let mut looks = 0;
        let home = if search.same {
            entry.cell
        } else {
            level.cell_of(&entry.position)
        };
        for &offset in &search.offsets {
            let cell = level.neighbour(home, offset);
            let slot = level.slot(cell);
            let (first, last) = (level.start[slot] as usize, level.start[slot + 1] as usize);
            looks += last - first;
            for (at, other) in level.entries[first..last].iter().enumerate() {
                let repeated = match search.rule {
                    Rule::Later => offset == [0; D] && first + at <= place,
                    Rule::LargerNumber => other.body <= entry.body,
                    Rule::All => false,
                };
                if other.cell == cell && !repeated {
                    self.pair(entry, other, search.images, visit);
                }
            }
        }
        looks
    }

    /// Visit one pair, as the lower number sees it.
    #[inline]
    fn pair(
        &self,
        entry: &Entry<D>,
        other: &Entry<D>,
        images: bool,
        visit: &mut impl FnMut(usize, usize, Vector<D>, Image),
    ) {
        let (low, high) = if entry.body < other.body {
            (entry, other)
        } else {
            (other, entry)
        };
        let reach = low.reach + high.reach;
        let apart = low.position - high.position;
        pair_images(apart, &self.period, images, reach, |apart, image| {
            visit(low.body as usize, high.body as usize, apart, image);
        });
    }
}

/// Visit the images of a pair that are no farther apart than `reach`: the nearest one, and with
/// `images` all that lie a period beside it.
#[inline]
pub fn pair_images<const D: usize>(
    apart: Vector<D>,
    period: &Period<D>,
    images: bool,
    reach: f64,
    mut visit: impl FnMut(Vector<D>, Image),
) {
    let nearest = if is_periodic(period) {
        shortest_image(apart, period)
    } else {
        apart
    };
    let mut test = |apart: Vector<D>, image: Image| {
        if dot(&apart, &apart) <= reach * reach {
            visit(apart, image);
        }
    };
    if images {
        each_image(period, |shift| {
            test(shifted(&nearest, shift, period), Image::of(shift));
        });
    } else {
        test(nearest, Image::of([0; D]));
    }
}

/// Which pairs of a cell are new.
enum Rule {
    /// Half of the neighbours, and in the own cell those that come later.
    Later,
    /// All neighbours: each pair is met from both sides.
    LargerNumber,
    /// Two different levels.
    All,
}

/// Where to look on a level.
struct Search<const D: usize> {
    same: bool,
    offsets: Vec<[i32; D]>,
    rule: Rule,
    /// Two images of a pair may be in reach at once.
    images: bool,
}

impl<const D: usize> Search<D> {
    fn new(level: &Level<D>, same: bool) -> Search<D> {
        let few = level.cells.iter().any(|&cells| cells == 1 || cells == 2);
        let mut offsets = offsets(&level.cells);
        let half = same && !few;
        if half {
            // The other half meets this cell from its own side.
            let own = offsets.iter().position(|offset| *offset == [0; D]);
            offsets.drain(..own.unwrap_or(0));
        }
        let rule = match (same, half) {
            (_, true) => Rule::Later,
            (true, false) => Rule::LargerNumber,
            (false, _) => Rule::All,
        };
        Search {
            same,
            offsets,
            rule,
            images: few,
        }
    }
}

/// Cells around a cell, the first axis fastest; each once where a period has few cells.
fn offsets<const D: usize>(cells: &[i32; D]) -> Vec<[i32; D]> {
    let range = |axis: usize| match cells[axis] {
        1 => 0..=0,
        2 => 0..=1,
        _ => -1..=1,
    };
    let mut offsets = vec![[0; D]];
    for axis in 0..D {
        let with = |step: i32| {
            let all = offsets.iter();
            all.map(move |offset| {
                let mut offset = *offset;
                offset[axis] = step;
                offset
            })
        };
        offsets = range(axis).flat_map(with).collect();
    }
    offsets
}

impl<const D: usize> Level<D> {
    fn build(
        members: &[u32],
        position: &[Vector<D>],
        reach: &[f64],
        period: &Period<D>,
    ) -> Level<D> {
        let widest = members
            .iter()
            .map(|&body| 2.0 * reach[body as usize])
            .fold(0.0, f64::max);
        let mut level = Level {
            origin: Vector::zeros(),
            cell: Vector::repeat(widest),
            cells: [0; D],
            stride: [1; D],
            mask: (2 * members.len()).next_power_of_two() as i64 - 1,
            start: Vec::new(),
            entries: Vec::new(),
        };
        for axis in 0..D {
            let along = members.iter().map(|&body| position[body as usize][axis]);
            let extent = level.divide(axis, along, widest, period[axis]);
            if axis + 1 < D {
                level.stride[axis + 1] = level.stride[axis].wrapping_mul(extent);
            }
        }
        level.fill(members, position, reach);
        level
    }

    /// Choose cells along an axis; about how many there are.
    fn divide(
        &mut self,
        axis: usize,
        along: impl Iterator<Item = f64>,
        widest: f64,
        period: Option<f64>,
    ) -> i64 {
        if let Some(length) = period {
            self.cells[axis] = ((length / widest) as i32).max(1);
            self.cell[axis] = length / f64::from(self.cells[axis]);
            return i64::from(self.cells[axis]);
        }
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        // The cell's number must fit; wider cells only cost time.
        self.cell[axis] = widest.max((high - low) * 1e-9);
        self.origin[axis] = low;
        ((high - low) / self.cell[axis]) as i64 + 3
    }

    /// Counting sort by slot.
    fn fill(&mut self, members: &[u32], position: &[Vector<D>], reach: &[f64]) {
        let entry = |&body: &u32| Entry {
            position: position[body as usize],
            reach: reach[body as usize],
            body,
            cell: self.cell_of(&position[body as usize]),
        };
        let unsorted: Vec<Entry<D>> = members.iter().map(entry).collect();
        self.start = vec![0; self.mask as usize + 2];
        for entry in &unsorted {
            let slot = self.slot(entry.cell);
            self.start[slot + 1] += 1;
        }
        for slot in 1..self.start.len() {
            self.start[slot] += self.start[slot - 1];
        }
        let mut next = self.start.clone();
        self.entries.clone_from(&unsorted);
        for entry in unsorted {
            let place = &mut next[self.slot(entry.cell)];
            self.entries[*place as usize] = entry;
            *place += 1;
        }
    }

    /// Take Σ over bodies of the bodies in the same cell off what is left; false when that is less.
    fn shares_within(&self, left: &mut usize) -> bool {
        let mut slots = self.start.windows(2);
        slots.all(|slot| {
            let entries = &self.entries[slot[0] as usize..slot[1] as usize];
            let same = |entry: &Entry<D>| entries.iter().filter(|e| e.cell == entry.cell).count();
            entries.iter().all(|entry| {
                let rest = left.checked_sub(same(entry));
                *left = rest.unwrap_or(0);
                rest.is_some()
            })
        })
    }

    #[inline]
    fn cell_of(&self, position: &Vector<D>) -> [i32; D] {
        std::array::from_fn(|axis| {
            let place = ((position[axis] - self.origin[axis]) / self.cell[axis]).floor();
            match self.cells[axis] {
                0 => place as i32,
                cells => (place as i64).rem_euclid(i64::from(cells)) as i32,
            }
        })
    }

    #[inline]
    fn neighbour(&self, cell: [i32; D], offset: [i32; D]) -> [i32; D] {
        std::array::from_fn(|axis| match self.cells[axis] {
            0 => cell[axis].saturating_add(offset[axis]),
            cells => (cell[axis] + offset[axis]).rem_euclid(cells),
        })
    }

    #[inline]
    fn slot(&self, cell: [i32; D]) -> usize {
        let place = (0..D).rev().fold(0i64, |place, axis| {
            place.wrapping_add(i64::from(cell[axis]).wrapping_mul(self.stride[axis]))
        });
        (place & self.mask) as usize
    }
}
