//! Grains already placed, by cells, with periodic images.
//!
//! Grains of like radius, a factor 2, share a level with cells as wide as its largest grain, so that a few
//! large ones do not crowd the cells of the small. Fixed grains may overlap each other, in any number: they
//! lie in a list of their own that fixed grains do not look at, and one that repeats the last is not kept.

use std::collections::BTreeMap;

/// Cell list of placed grains.
pub struct Neighbours {
    /// Largest diameter \[m\].
    largest: f64,
    period: [Option<f64>; 2],
    /// By how often the largest diameter is halved.
    levels: BTreeMap<u32, BTreeMap<(i64, i64), Cell>>,
}

#[derive(Default)]
struct Cell {
    free: Vec<Placed>,
    fixed: Vec<Placed>,
}

#[derive(Clone, Copy, PartialEq)]
struct Placed {
    position: [f64; 2],
    radius: f64,
}

impl Neighbours {
    /// An empty list; `largest` is the largest diameter \[m\].
    pub fn new(largest: f64, period: [Option<f64>; 2]) -> Self {
        Neighbours {
            largest: largest.max(f64::MIN_POSITIVE),
            period,
            levels: BTreeMap::new(),
        }
    }

    /// An empty list with the same cells and periods.
    pub fn like(&self) -> Self {
        Neighbours::new(self.largest, self.period)
    }

    fn cell_of_level(&self, level: u32) -> f64 {
        (self.largest / 2f64.powi(level as i32)).max(f64::MIN_POSITIVE)
    }

    /// Add a grain and its images across periodic sides.
    pub fn insert(&mut self, position: [f64; 2], radius: f64, fixed: bool) {
        let level = (self.largest / (2.0 * radius)).log2().max(0.0) as u32;
        let width = self.cell_of_level(level);
        let cells = self.levels.entry(level).or_default();
        let shifts = |period: Option<f64>| match period {
            Some(period) => [Some(0.0), Some(-period), Some(period)],
            None => [Some(0.0), None, None],
        };
        for dx in shifts(self.period[0]).into_iter().flatten() {
            for dy in shifts(self.period[1]).into_iter().flatten() {
                let position = [position[0] + dx, position[1] + dy];
                let place = position.map(|x| (x / width).floor() as i64);
                let cell = cells.entry((place[0], place[1])).or_default();
                let list = if fixed {
                    &mut cell.fixed
                } else {
                    &mut cell.free
                };
                let placed = Placed { position, radius };
                if list.last() != Some(&placed) {
                    list.push(placed);
                }
            }
        }
    }

    /// An overlap \[m\] with a placed grain by more than `allowed` \[m\]. Two fixed grains may overlap.
    pub fn overlap(
        &self,
        position: [f64; 2],
        radius: f64,
        fixed: bool,
        allowed: f64,
    ) -> Option<f64> {
        let with = |other: &Placed| {
            let dx = other.position[0] - position[0];
            let dy = other.position[1] - position[1];
            let overlap = radius + other.radius - dx.hypot(dy);
            (overlap > allowed).then_some(overlap)
        };
        self.cells_near(position, radius).find_map(|cell| {
            let fixed = if fixed { &[][..] } else { &cell.fixed };
            cell.free.iter().chain(fixed).find_map(with)
        })
    }

    /// The smallest gap to a placed grain, of the smaller radius of the two, among those up to `within`. Two fixed
    /// grains have none.
    pub fn gap(&self, position: [f64; 2], radius: f64, fixed: bool, within: f64) -> Option<f64> {
        let gap = |other: &Placed| {
            let dx = other.position[0] - position[0];
            let dy = other.position[1] - position[1];
            (dx.hypot(dy) - radius - other.radius) / radius.min(other.radius)
        };
        let near = self.cells_near(position, radius + within.max(0.0) * radius);
        let others = near.flat_map(|cell| {
            let fixed = if fixed { &[][..] } else { &cell.fixed };
            cell.free.iter().chain(fixed)
        });
        others
            .map(gap)
            .reduce(f64::min)
            .filter(|gap| *gap <= within)
    }

    /// Cells with all grains that come as near to a position as this, and some more.
    fn cells_near(&self, position: [f64; 2], reach: f64) -> impl Iterator<Item = &Cell> {
        self.levels.iter().flat_map(move |(&level, cells)| {
            let width = self.cell_of_level(level);
            let place = |x: f64| (x / width).floor() as i64;
            let reach = reach + 0.5 * width;
            let [low, high] = [-reach, reach].map(|reach| position.map(|x| place(x + reach)));
            let some = high[0].abs_diff(low[0]) < cells.len() as u64;
            let columns = some.then_some(low[0]..=high[0]).into_iter().flatten();
            let near =
                columns.flat_map(move |column| cells.range((column, low[1])..=(column, high[1])));
            let all = (!some).then_some(cells.iter()).into_iter().flatten();
            near.chain(all).map(|(_, cell)| cell)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_gap_is_that_of_all_pairs() {
        // Golden ratio points, radii over two decades, every third grain fixed.
        let part = |k: usize, by: f64| (k as f64 * by).fract();
        let all: Vec<([f64; 2], f64, bool)> = (0..300)
            .map(|k| {
                let place = [10.0 * part(k, 0.618_034), 10.0 * part(k, 0.754_878)];
                (place, 2e-3 * 100.0_f64.powf(part(k, 0.569_84)), k % 3 == 0)
            })
            .collect();
        let mut grains = Neighbours::new(0.4, [None, None]);
        let (mut least, mut of_pairs) = (None, f64::INFINITY);
        for (k, &(place, radius, fixed)) in all.iter().enumerate() {
            let within = least.unwrap_or(f64::INFINITY);
            least = grains.gap(place, radius, fixed, within).or(least);
            grains.insert(place, radius, fixed);
            for &(other, size, _) in all[..k].iter().filter(|other| !(fixed && other.2)) {
                let distance = (place[0] - other[0]).hypot(place[1] - other[1]);
                of_pairs = of_pairs.min((distance - radius - size) / radius.min(size));
            }
            assert_eq!(least.unwrap_or(f64::INFINITY), of_pairs, "{k}");
        }
    }

    #[test]
    fn overlaps_are_found_between_grains_of_all_sizes_and_across_periods() {
        let mut grains = Neighbours::new(2.0, [Some(10.0), None]);
        for number in 0..100 {
            grains.insert([0.05 * f64::from(number), 0.0], 1e-3, false);
        }
        assert_eq!(grains.overlap([9.5, 0.5], 0.4, false, 0.0), None);
        let across = grains.overlap([9.5, 0.3], 1.0, false, 0.0);
        println!("{across:?}");
        assert!(across.is_some_and(|overlap| overlap > 0.0));
        grains.insert([5.0, 5.0], 1.0, true);
        let small = grains.overlap([5.0, 5.9], 1e-3, false, 0.0);
        assert!(small.is_some_and(|overlap| (overlap - 0.101).abs() < 1e-12));
        assert_eq!(grains.overlap([5.0, 5.9], 1e-3, true, 0.0), None);
        assert_eq!(grains.overlap([5.0, 5.9], 1e-3, false, 0.2), None);
    }

    #[test]
    fn repeats_in_one_place_are_looked_at_once() {
        let mut grains = Neighbours::new(2.0, [None; 2]);
        let begun = std::time::Instant::now();
        for _ in 0..300_000 {
            assert_eq!(grains.overlap([0.0; 2], 1.0, true, 0.0), None);
            grains.insert([0.0; 2], 1.0, true);
            grains.insert([1e-3, 0.0], 1.0, true);
        }
        println!("{:?}", begun.elapsed());
        assert!(begun.elapsed() < std::time::Duration::from_secs(5));
    }
}
