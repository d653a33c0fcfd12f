//! Grains already placed, by cells, with periodic images.
//!
//! Grains of like radius, a factor 2, share a level with cells as wide as its largest grain, so that a few
//! large ones do not crowd the cells of the small. Fixed grains may overlap each other, in any number: they
//! lie in a list of their own that fixed grains do not look at, and one that repeats the last is not kept.

use std::collections::BTreeMap;

/// Cell list of placed grains.
pub struct Neighbours<const D: usize> {
    /// Largest diameter \[m\].
    largest: f64,
    period: [Option<f64>; D],
    /// By how often the largest diameter is halved.
    levels: BTreeMap<u32, BTreeMap<[i64; D], Cell<D>>>,
}

#[derive(Default)]
struct Cell<const D: usize> {
    free: Vec<Placed<D>>,
    fixed: Vec<Placed<D>>,
}

#[derive(Clone, Copy, PartialEq)]
struct Placed<const D: usize> {
    position: [f64; D],
    radius: f64,
}

/// Distance of two points \[m\].
fn distance<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    let apart = a.iter().zip(b).map(|(a, b)| a - b);
    apart.reduce(f64::hypot).unwrap_or(0.0)
}

/// Cells from one to another along all axes, in order, but for the last axis, of which the ends are given with each.
fn columns<const D: usize>(
    low: [i64; D],
    high: [i64; D],
) -> impl Iterator<Item = ([i64; D], [i64; D])> {
    let ends = move |mut column: [i64; D]| {
        column[D - 1] = low[D - 1];
        let first = column;
        column[D - 1] = high[D - 1];
        (first, column)
    };
    let next = move |column: &[i64; D]| {
        let axis = (0..D - 1).rev().find(|&axis| column[axis] < high[axis])?;
        let mut next = *column;
        next[axis] += 1;
        next[axis + 1..].copy_from_slice(&low[axis + 1..]);
        Some(next)
    };
    std::iter::successors(Some(low), next).map(ends)
}

impl<const D: usize> Neighbours<D> {
    /// An empty list; `largest` is the largest diameter \[m\].
    pub fn new(largest: f64, period: [Option<f64>; D]) -> Self {
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

    /// A point and its images across periodic sides.
    fn images(&self, position: &[f64; D]) -> Vec<[f64; D]> {
        let mut images = vec![*position];
        for axis in 0..D {
            let Some(period) = self.period[axis] else {
                continue;
            };
            let own = std::mem::take(&mut images);
            images = own
                .into_iter()
                .flat_map(|place| {
                    [0.0, -period, period].map(|shift| {
                        let mut image = place;
                        image[axis] += shift;
                        image
                    })
                })
                .collect();
        }
        images
    }

    /// Add a grain and its images across periodic sides.
    pub fn insert(&mut self, position: &[f64; D], radius: f64, fixed: bool) {
        let level = (self.largest / (2.0 * radius)).log2().max(0.0) as u32;
        let width = self.cell_of_level(level);
        let images = self.images(position);
        let cells = self.levels.entry(level).or_default();
        for position in images {
            let place = position.map(|x| (x / width).floor() as i64);
            let cell = cells.entry(place).or_default();
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

    /// An overlap \[m\] with a placed grain by more than `allowed` \[m\]. Two fixed grains may overlap.
    pub fn overlap(
        &self,
        position: &[f64; D],
        radius: f64,
        fixed: bool,
        allowed: f64,
    ) -> Option<f64> {
        let with = |other: &Placed<D>| {
            let overlap = radius + other.radius - distance(&other.position, position);
            (overlap > allowed).then_some(overlap)
        };
        self.cells_near(position, radius).find_map(|cell| {
            let fixed = if fixed { &[][..] } else { &cell.fixed };
            cell.free.iter().chain(fixed).find_map(with)
        })
    }

    /// The smallest gap to a placed grain, of the smaller radius of the two, among those up to `within`. Two fixed
    /// grains have none.
    pub fn gap(&self, position: &[f64; D], radius: f64, fixed: bool, within: f64) -> Option<f64> {
        let gap = |other: &Placed<D>| {
            let apart = distance(&other.position, position);
            (apart - radius - other.radius) / radius.min(other.radius)
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
    fn cells_near(&self, position: &[f64; D], reach: f64) -> impl Iterator<Item = &Cell<D>> {
        self.levels.iter().flat_map(move |(&level, cells)| {
            let width = self.cell_of_level(level);
            let place = |x: f64| (x / width).floor() as i64;
            let reach = reach + 0.5 * width;
            let [low, high] = [-reach, reach].map(|reach| position.map(|x| place(x + reach)));
            let counts = (0..D - 1).map(|axis| high[axis].abs_diff(low[axis]) as f64 + 1.0);
            let some = counts.product::<f64>() < cells.len() as f64 + 1.0;
            let columns = some.then(|| columns(low, high)).into_iter().flatten();
            let near = columns.flat_map(move |(first, last)| cells.range(first..=last));
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
            least = grains.gap(&place, radius, fixed, within).or(least);
            grains.insert(&place, radius, fixed);
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
            grains.insert(&[0.05 * f64::from(number), 0.0], 1e-3, false);
        }
        assert_eq!(grains.overlap(&[9.5, 0.5], 0.4, false, 0.0), None);
        let across = grains.overlap(&[9.5, 0.3], 1.0, false, 0.0);
        println!("{across:?}");
        assert!(across.is_some_and(|overlap| overlap > 0.0));
        grains.insert(&[5.0, 5.0], 1.0, true);
        let small = grains.overlap(&[5.0, 5.9], 1e-3, false, 0.0);
        assert!(small.is_some_and(|overlap| (overlap - 0.101).abs() < 1e-12));
        assert_eq!(grains.overlap(&[5.0, 5.9], 1e-3, true, 0.0), None);
        assert_eq!(grains.overlap(&[5.0, 5.9], 1e-3, false, 0.2), None);
    }

    #[test]
    fn repeats_in_one_place_are_looked_at_once() {
        let mut grains = Neighbours::new(2.0, [None; 2]);
        let begun = std::time::Instant::now();
        for _ in 0..300_000 {
            assert_eq!(grains.overlap(&[0.0; 2], 1.0, true, 0.0), None);
            grains.insert(&[0.0; 2], 1.0, true);
            grains.insert(&[1e-3, 0.0], 1.0, true);
        }
        println!("{:?}", begun.elapsed());
        assert!(begun.elapsed() < std::time::Duration::from_secs(5));
    }
}
