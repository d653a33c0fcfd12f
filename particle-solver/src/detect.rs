//! Pairs of grains within reach, from cell lists.
//!
//! Each grain has a reach (its radius plus how far it may move); a pair is visited when the two
//! reaches overlap. Grains are sorted into levels by reach, a factor 2 wide, each with cells of
//! its own largest diameter, so that a few large or fast grains do not spoil the cells of the
//! others. A grain looks into the 3×3 cells around it on its own level and on all coarser ones.
//! Cells lie in a table no larger than a few times the number of grains, whatever the extent:
//! cells that share a slot are told apart by their coordinates.

use crate::vector::{Vector, shortest_image};
use crate::walls::image_code;

/// A grain in a level.
#[derive(Debug, Clone, Copy)]
struct Entry {
    position: Vector,
    reach: f64,
    grain: u32,
    cell: [i32; 2],
}

/// Grains of like reach.
#[derive(Debug)]
struct Level {
    /// Lower corner \[m\].
    origin: Vector,
    /// Width of a cell in x and y \[m\].
    cell: Vector,
    /// Cells in a period; 0 along an axis that is not periodic.
    cells: [i32; 2],
    /// Distance in the table between cells that are neighbours in y.
    stride: i64,
    /// Slots of the table, less one; a power of two less one.
    mask: i64,
    /// First entry of each slot.
    start: Vec<u32>,
    /// Grains, by slot, then by number.
    entries: Vec<Entry>,
}

/// Cell lists over all levels.
#[derive(Debug)]
pub struct Grid {
    levels: Vec<Level>,
    period: [Option<f64>; 2],
}

impl Grid {
    /// Sort the grains; `reach` \[m\] must be positive.
    pub fn build(position: &[Vector], reach: &[f64], period: [Option<f64>; 2]) -> Grid {
        let smallest = reach.iter().copied().fold(f64::INFINITY, f64::min);
        let mut members: Vec<Vec<u32>> = Vec::new();
        for (grain, reach) in reach.iter().enumerate() {
            let level = (reach / smallest).log2() as usize;
            if members.len() <= level {
                members.resize(level + 1, Vec::new());
            }
            members[level].push(grain as u32);
        }
        let levels = members
            .iter()
            .filter(|members| !members.is_empty())
            .map(|members| Level::build(members, position, reach, period))
            .collect();
        Grid { levels, period }
    }

    /// About how many distances `for_each_pair` will compute.
    pub fn work(&self) -> f64 {
        let of_cells = |level: &Level| -> usize {
            let slots = level.start.windows(2).map(|slot| {
                let entries = &level.entries[slot[0] as usize..slot[1] as usize];
                let same = |entry: &Entry| entries.iter().filter(|e| e.cell == entry.cell).count();
                entries.iter().map(same).sum::<usize>()
            });
            slots.sum()
        };
        let levels = self.levels.iter();
        levels.map(|level| 4.5 * of_cells(level) as f64).sum()
    }

    /// Visit every pair (i < j, xᵢ − xⱼ, image) whose reaches overlap, each image of it once,
    /// always in the same order.
    pub fn for_each_pair(&self, mut visit: impl FnMut(usize, usize, Vector, u8)) {
        for (number, own) in self.levels.iter().enumerate() {
            for (coarse, other) in self.levels.iter().enumerate().skip(number) {
                let same = coarse == number;
                let search = Search::new(other, same);
                for (place, entry) in own.entries.iter().enumerate() {
                    self.around(entry, place, other, &search, &mut visit);
                }
            }
        }
    }

    /// Visit the pairs of one grain with those of `level`.
    fn around(
        &self,
        entry: &Entry,
        place: usize,
        level: &Level,
        search: &Search,
        visit: &mut impl FnMut(usize, usize, Vector, u8),
    ) {
        let home = if search.same {
            entry.cell
        } else {
            level.cell_of(entry.position)
        };
        for &offset in &search.offsets {
            let cell = level.neighbour(home, offset);
            let slot = level.slot(cell);
            let (first, last) = (level.start[slot] as usize, level.start[slot + 1] as usize);
            for (at, other) in level.entries[first..last].iter().enumerate() {
                let repeated = match search.rule {
                    Rule::Later => offset == [0, 0] && first + at <= place,
                    Rule::LargerNumber => other.grain <= entry.grain,
                    Rule::All => false,
                };
                if other.cell == cell && !repeated {
                    self.pair(entry, other, search.images, visit);
                }
            }
        }
    }

    /// Visit one pair, as the lower number sees it.
    #[inline]
    fn pair(
        &self,
        entry: &Entry,
        other: &Entry,
        images: bool,
        visit: &mut impl FnMut(usize, usize, Vector, u8),
    ) {
        let (low, high) = if entry.grain < other.grain {
            (entry, other)
        } else {
            (other, entry)
        };
        let mut apart = [
            low.position[0] - high.position[0],
            low.position[1] - high.position[1],
        ];
        if self.period != [None, None] {
            apart = shortest_image(apart, self.period);
        }
        let reach = low.reach + high.reach;
        let mut near = |apart: Vector, image: u8| {
            if apart[0] * apart[0] + apart[1] * apart[1] <= reach * reach {
                visit(low.grain as usize, high.grain as usize, apart, image);
            }
        };
        if !images {
            return near(apart, image_code(0, 0));
        }
        let range = |axis: usize| {
            if self.period[axis].is_some() {
                -1..=1i8
            } else {
                0..=0
            }
        };
        for kx in range(0) {
            for ky in range(1) {
                let shifted = [
                    apart[0] + f64::from(kx) * self.period[0].unwrap_or(0.0),
                    apart[1] + f64::from(ky) * self.period[1].unwrap_or(0.0),
                ];
                near(shifted, image_code(kx, ky));
            }
        }
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
struct Search {
    same: bool,
    offsets: Vec<[i32; 2]>,
    rule: Rule,
    /// Two images of a pair may be in reach at once.
    images: bool,
}

impl Search {
    fn new(level: &Level, same: bool) -> Search {
        let few = level.cells.iter().any(|&cells| cells == 1 || cells == 2);
        if same && !few {
            let offsets = vec![[0, 0], [1, 0], [-1, 1], [0, 1], [1, 1]];
            return Search {
                same,
                offsets,
                rule: Rule::Later,
                images: false,
            };
        }
        let range = |cells: i32| match cells {
            1 => 0..=0,
            2 => 0..=1,
            _ => -1..=1,
        };
        let mut offsets = Vec::new();
        for y in range(level.cells[1]) {
            for x in range(level.cells[0]) {
                offsets.push([x, y]);
            }
        }
        let rule = if same { Rule::LargerNumber } else { Rule::All };
        Search {
            same,
            offsets,
            rule,
            images: few,
        }
    }
}

impl Level {
    fn build(
        members: &[u32],
        position: &[Vector],
        reach: &[f64],
        period: [Option<f64>; 2],
    ) -> Level {
        let widest = members
            .iter()
            .map(|&g| 2.0 * reach[g as usize])
            .fold(0.0, f64::max);
        let mut level = Level {
            origin: [0.0; 2],
            cell: [widest; 2],
            cells: [0; 2],
            stride: 0,
            mask: (2 * members.len()).next_power_of_two() as i64 - 1,
            start: Vec::new(),
            entries: Vec::new(),
        };
        for axis in 0..2 {
            let along = members.iter().map(|&g| position[g as usize][axis]);
            if let Some(length) = period[axis] {
                level.cells[axis] = ((length / widest) as i32).max(1);
                level.cell[axis] = length / f64::from(level.cells[axis]);
            } else {
                let (low, high) = along
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                        (low.min(x), high.max(x))
                    });
                // The cell's number must fit; wider cells only cost time.
                level.cell[axis] = widest.max((high - low) * 1e-9);
                level.origin[axis] = low;
                if axis == 0 {
                    level.stride = ((high - low) / level.cell[0]) as i64 + 3;
                }
            }
        }
        if level.cells[0] > 0 {
            level.stride = i64::from(level.cells[0]);
        }
        level.fill(members, position, reach);
        level
    }

    /// Counting sort by slot.
    fn fill(&mut self, members: &[u32], position: &[Vector], reach: &[f64]) {
        let cells: Vec<[i32; 2]> = members
            .iter()
            .map(|&g| self.cell_of(position[g as usize]))
            .collect();
        self.start = vec![0; self.mask as usize + 2];
        for &cell in &cells {
            let slot = self.slot(cell);
            self.start[slot + 1] += 1;
        }
        for slot in 1..self.start.len() {
            self.start[slot] += self.start[slot - 1];
        }
        let blank = Entry {
            position: [0.0; 2],
            reach: 0.0,
            grain: 0,
            cell: [0; 2],
        };
        let mut next = self.start.clone();
        self.entries = vec![blank; members.len()];
        for (&grain, &cell) in members.iter().zip(&cells) {
            let place = &mut next[self.slot(cell)];
            let (position, reach) = (position[grain as usize], reach[grain as usize]);
            self.entries[*place as usize] = Entry {
                position,
                reach,
                grain,
                cell,
            };
            *place += 1;
        }
    }

    fn cell_of(&self, position: Vector) -> [i32; 2] {
        let along = |axis: usize| {
            let place = ((position[axis] - self.origin[axis]) / self.cell[axis]).floor();
            match self.cells[axis] {
                0 => place as i32,
                cells => (place as i64).rem_euclid(i64::from(cells)) as i32,
            }
        };
        [along(0), along(1)]
    }

    fn neighbour(&self, cell: [i32; 2], offset: [i32; 2]) -> [i32; 2] {
        let along = |axis: usize| match self.cells[axis] {
            0 => cell[axis].saturating_add(offset[axis]),
            cells => (cell[axis] + offset[axis]).rem_euclid(cells),
        };
        [along(0), along(1)]
    }

    fn slot(&self, cell: [i32; 2]) -> usize {
        let place = i64::from(cell[1])
            .wrapping_mul(self.stride)
            .wrapping_add(i64::from(cell[0]));
        (place & self.mask) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small generator, so that the test needs nothing else.
    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64
    }

    fn brute_force(
        position: &[Vector],
        reach: &[f64],
        period: [Option<f64>; 2],
    ) -> Vec<(usize, usize, u8)> {
        let mut pairs = Vec::new();
        for i in 0..position.len() {
            for j in i + 1..position.len() {
                let apart = [
                    position[i][0] - position[j][0],
                    position[i][1] - position[j][1],
                ];
                let nearest = shortest_image(apart, period);
                for kx in -1..=1i8 {
                    for ky in -1..=1i8 {
                        if (kx != 0 && period[0].is_none()) || (ky != 0 && period[1].is_none()) {
                            continue;
                        }
                        let x = nearest[0] + f64::from(kx) * period[0].unwrap_or(0.0);
                        let y = nearest[1] + f64::from(ky) * period[1].unwrap_or(0.0);
                        let sum = reach[i] + reach[j];
                        if x * x + y * y <= sum * sum {
                            pairs.push((i, j, image_code(kx, ky)));
                        }
                    }
                }
            }
        }
        pairs
    }

    #[test]
    fn the_cells_find_exactly_the_pairs_that_all_distances_find() {
        let mut seed = 7;
        let cases: [(f64, [Option<f64>; 2]); 6] = [
            (1.0, [None, None]),
            (100.0, [None, None]),
            (1.0, [Some(1.0), None]),
            (30.0, [Some(0.3), Some(1.0)]),
            (2.0, [Some(0.05), Some(0.07)]),
            (5.0, [None, Some(0.11)]),
        ];
        println!("ratio  period              pairs");
        for (ratio, period) in cases {
            let count = 300;
            let position: Vec<Vector> = (0..count)
                .map(|_| [3.0 * random(&mut seed) - 1.0, random(&mut seed)])
                .collect();
            let reach: Vec<f64> = (0..count)
                .map(|_| 0.01 * ratio.powf(random(&mut seed)).min(10.0))
                .collect();
            let mut found = Vec::new();
            Grid::build(&position, &reach, period)
                .for_each_pair(|i, j, _, image| found.push((i, j, image)));
            found.sort_unstable();
            let expected = brute_force(&position, &reach, period);
            println!("{ratio:5}  {period:?}  {}", expected.len());
            assert_eq!(found, expected);
        }
    }
}
