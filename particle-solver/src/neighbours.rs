//! Who is near whom, found by one search and looked at again until somebody may have come from
//! farther away.
//!
//! A search with the cell lists takes every pair whose surfaces are within s_i + s_j, a little more
//! than the step needs. Later the same list holds every pair that can meet as long as
//!
//! ```text
//!   |x_i − X_i − D| + e_i ≤ s_i   for every grain                                          (V1)
//! ```
//!
//! X where the grain was at the search, D the mean displacement of all since, e_i how far the grain's
//! reach goes beyond its radius now: distances of pairs have changed by at most the sum of the first
//! terms (Verlet 1967). What is visited is tested as the search tests it, so the answer has the same
//! bits as a new search. A grain whose distance from all walls has not been used up by its own
//! displacement looks at no wall.

use crate::detect::Grid;
use crate::grains::Grains;
use crate::vector::{Vector, add, norm, scale, shortest_image, sub};
use crate::walls::{WallContact, Walls, image_code};

/// Reach of the list beyond what the step needs, of the radius.
pub const SPARE: f64 = 0.4;
/// Part of s that round-off of positions may take.
const SAFE: f64 = 1.0 - 1e-6;
/// Reach beyond the radius, of the radius, above which a list is too long to be worth keeping.
const LOOK_AHEAD_MAX: f64 = 2.0;

/// The pairs of the last search.
#[derive(Debug, Clone, Default)]
pub struct Neighbours {
    /// Search anew each time, keep nothing.
    pub search_always: bool,
    /// Searches with cell lists so far.
    pub searches: u64,
    /// Grains for which walls were looked at so far.
    pub wall_looks: u64,
    /// X \[m\]; empty: nothing is known.
    reference: Vec<Vector>,
    /// s \[m\]
    spare: Vec<f64>,
    /// Pairs (i < j).
    pairs: Vec<(u32, u32)>,
    /// From X to the nearest wall \[m\].
    wall_distance: Vec<f64>,
}

/// Where grains and walls are.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// Grains.
    pub grains: &'a Grains,
    /// Their centres \[m\].
    pub position: &'a [Vector],
    /// Walls.
    pub walls: &'a Walls,
    /// Period in x and y \[m\].
    pub period: [Option<f64>; 2],
}

impl Neighbours {
    /// Forget the last search: the grains have been put elsewhere.
    pub fn forget(&mut self) {
        self.reference.clear();
    }

    /// Visit every pair (i < j, xᵢ − xⱼ, image) whose reaches overlap, each image of it once.
    pub fn for_each_pair(
        &mut self,
        place: &Place<'_>,
        reach: &[f64],
        mut visit: impl FnMut(usize, usize, Vector, u8),
    ) {
        if self.search_always || !self.cover(place, reach) {
            self.searches += 1;
            return Grid::build(place.position, reach, place.period).for_each_pair(visit);
        }
        let images = images(place.period, reach);
        for &(i, j) in &self.pairs {
            let (i, j) = (i as usize, j as usize);
            near(place, reach, images, (i, j), |apart, image| {
                visit(i, j, apart, image);
            });
        }
    }

    /// May the list stand for a search whose work is limited: is it certain that no cell of the search
    /// would hold more than 22 grains? (Its cells are twice the largest reach wide, and reaches in it
    /// differ by less than a factor of 2.) Two cases are:
    ///
    /// * no two reaches overlap, so that disks of half the largest reach R fit side by side into a
    ///   square of side 2R + R (periodic: 2.7R + R, six R or more in a period);
    /// * reaches are at most a quarter of a radius beyond the radius and no two grains overlap by
    ///   more than a tenth, so that disks of 0.36 R do, in 2R + 0.72R (2.2R, twenty R).
    pub fn stand_for_search(&mut self, place: &Place<'_>, reach: &[f64]) -> bool {
        if self.search_always || !self.cover(place, reach) {
            return false;
        }
        let radius = &place.grains.radius;
        let largest = reach.iter().copied().fold(0.0, f64::max);
        let periods = |least: f64| {
            let mut periods = place.period.iter().flatten();
            periods.all(|length| *length >= least * largest)
        };
        let mut close = reach.iter().zip(radius);
        let close = periods(20.0) && close.all(|(reach, radius)| *reach <= 1.25 * radius);
        if !periods(6.0) {
            return false;
        }
        self.pairs.iter().all(|&(i, j)| {
            let (i, j) = (i as usize, j as usize);
            let least = match close {
                true => 0.9 * (radius[i] + radius[j]),
                false => reach[i] + reach[j],
            };
            let apart = sub(place.position[i], place.position[j]);
            norm(shortest_image(apart, place.period)) > least
        })
    }

    /// Call `visit` for every wall closer than `reach` to the surface of a grain.
    pub fn walls_near(
        &mut self,
        place: &Place<'_>,
        grain: usize,
        reach: f64,
        visit: impl FnMut(WallContact),
    ) {
        let (centre, radius) = (place.position[grain], place.grains.radius[grain]);
        if let (false, Some(from)) = (self.search_always, self.reference.get(grain)) {
            let distance = SAFE * self.wall_distance[grain] - norm(sub(centre, *from));
            // A face reaches beyond its end by as much as the grain does: √2 of it in a corner.
            if distance > std::f64::consts::SQRT_2 * (radius + reach) {
                return;
            }
        }
        self.wall_looks += 1;
        place.walls.near(centre, radius, reach, visit);
    }

    /// Let the list hold every pair within reach; false when that is not worth it.
    fn cover(&mut self, place: &Place<'_>, reach: &[f64]) -> bool {
        if self.holds(place, reach) {
            return true;
        }
        let radius = &place.grains.radius;
        let far = |(reach, radius): (&f64, &f64)| reach - radius > LOOK_AHEAD_MAX * radius;
        if reach.iter().zip(radius).any(far) {
            return false;
        }
        self.spare.clear();
        let pairs = reach.iter().zip(radius);
        self.spare
            .extend(pairs.map(|(reach, radius)| reach - radius + SPARE * radius));
        let wider: Vec<f64> = self.spare.iter().zip(radius).map(|(s, r)| s + r).collect();
        let found = &mut self.pairs;
        found.clear();
        Grid::build(place.position, &wider, place.period).for_each_pair(|i, j, _, _| {
            let pair = (i as u32, j as u32);
            // Images of a pair follow each other.
            if found.last() != Some(&pair) {
                found.push(pair);
            }
        });
        self.searches += 1;
        self.reference.clear();
        self.reference.extend_from_slice(place.position);
        self.wall_distance.clear();
        let distances = place.position.iter().map(|x| place.walls.distance(*x));
        self.wall_distance.extend(distances);
        true
    }

    /// (V1)
    fn holds(&self, place: &Place<'_>, reach: &[f64]) -> bool {
        let count = place.position.len();
        if self.reference.len() != count || count == 0 {
            return false;
        }
        let moved = |grain: usize| sub(place.position[grain], self.reference[grain]);
        let sum = (0..count).fold([0.0; 2], |sum, grain| add(sum, moved(grain)));
        let mean = scale(1.0 / count as f64, sum);
        (0..count).all(|grain| {
            let need = reach[grain] - place.grains.radius[grain];
            norm(sub(moved(grain), mean)) + need <= SAFE * self.spare[grain]
        })
    }
}

/// Axes along which another image than the nearest may be within reach.
fn images(period: [Option<f64>; 2], reach: &[f64]) -> [bool; 2] {
    let largest = reach.iter().copied().fold(0.0, f64::max);
    period.map(|length| length.is_some_and(|length| length < 6.0 * largest))
}

/// Visit the images of a pair whose reaches overlap, in the arithmetic of `Grid`.
#[inline]
fn near(
    place: &Place<'_>,
    reach: &[f64],
    images: [bool; 2],
    (i, j): (usize, usize),
    mut visit: impl FnMut(Vector, u8),
) {
    let mut apart = sub(place.position[i], place.position[j]);
    if place.period != [None, None] {
        apart = shortest_image(apart, place.period);
    }
    let reach = reach[i] + reach[j];
    let mut test = |apart: Vector, image: u8| {
        if apart[0] * apart[0] + apart[1] * apart[1] <= reach * reach {
            visit(apart, image);
        }
    };
    if images == [false; 2] {
        return test(apart, image_code(0, 0));
    }
    let range = |axis: usize| if images[axis] { -1..=1i8 } else { 0..=0 };
    for kx in range(0) {
        for ky in range(1) {
            let shifted = [
                apart[0] + f64::from(kx) * place.period[0].unwrap_or(0.0),
                apart[1] + f64::from(ky) * place.period[1].unwrap_or(0.0),
            ];
            test(shifted, image_code(kx, ky));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls::Segment;

    /// A small generator, so that the test needs nothing else.
    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    type Found = Vec<(usize, usize, u8, [u64; 2])>;

    fn pairs(neighbours: &mut Neighbours, place: &Place<'_>, reach: &[f64]) -> Found {
        let mut found = Found::new();
        neighbours.for_each_pair(place, reach, |i, j, apart, image| {
            found.push((i, j, image, apart.map(f64::to_bits)));
        });
        found.sort_unstable();
        found
    }

    fn walls(neighbours: &mut Neighbours, place: &Place<'_>, reach: &[f64]) -> Vec<[u64; 4]> {
        let mut found = Vec::new();
        for (grain, reach) in reach.iter().enumerate() {
            let beyond = reach - place.grains.radius[grain];
            neighbours.walls_near(place, grain, beyond, |wall| {
                let along = wall.along.map_or(0, |[back, _]| back.to_bits());
                found.push([grain as u64, wall.feature as u64, wall.gap.to_bits(), along]);
            });
        }
        found
    }

    #[test]
    fn a_kept_list_gives_the_pairs_and_walls_of_a_new_search_to_the_bit() {
        let box_of = |[x, y]: [f64; 2]| {
            let corners = [[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]];
            let side = |k: usize| Segment {
                a: corners[k],
                b: corners[(k + 1) % 4],
            };
            (0..4).map(side).collect::<Vec<_>>()
        };
        println!("period                    steps  pairs   walls  searches kept, always");
        for period in [
            [None, None],
            [Some(0.07), None],
            [Some(1.0), Some(0.3)],
            [Some(0.05), Some(0.07)],
        ] {
            let mut seed = 11;
            let count = 150;
            let grains = Grains {
                radius: (0..count)
                    .map(|_| 0.01 * (1.2 + random(&mut seed)))
                    .collect(),
                mass: vec![1.0; count],
                fixed: vec![false; count],
            };
            let mut position: Vec<Vector> = (0..count)
                .map(|_| [random(&mut seed) + 0.5, random(&mut seed) + 0.5])
                .collect();
            let walls_of = Walls::new(&box_of([1.0, 1.0]), period).unwrap();
            let mut kept = Neighbours::default();
            let mut always = Neighbours {
                search_always: true,
                ..Neighbours::default()
            };
            let (mut pair_count, mut wall_count) = (0, 0);
            for step in 0..120 {
                // All drift together, and each on its own; sometimes one of them far.
                for (grain, place) in position.iter_mut().enumerate() {
                    let stray = if 10 * grain == step { 0.1 } else { 1e-3 };
                    let own = [random(&mut seed), random(&mut seed)];
                    *place = add(*place, add([2e-3, -1e-3], scale(stray, own)));
                }
                let place = Place {
                    grains: &grains,
                    position: &position,
                    walls: &walls_of,
                    period,
                };
                let reach: Vec<f64> = grains
                    .radius
                    .iter()
                    .map(|radius| radius * (1.1 + 0.1 * random(&mut seed)))
                    .collect();
                let [a, b] = [&mut kept, &mut always].map(|n| pairs(n, &place, &reach));
                assert_eq!(a, b, "step {step}, period {period:?}");
                pair_count += a.len();
                let [a, b] = [&mut kept, &mut always].map(|n| walls(n, &place, &reach));
                assert_eq!(a, b, "step {step}, period {period:?}");
                wall_count += a.len();
            }
            let (few, all) = (kept.searches, always.searches);
            println!("{period:?}  120  {pair_count}  {wall_count}  {few}, {all}");
            assert!(few < all && kept.wall_looks < always.wall_looks);
            assert!(pair_count > 100 && wall_count > 10);
        }
    }
}
