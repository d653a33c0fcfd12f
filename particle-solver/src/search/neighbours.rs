//! Who is near whom, found by one search and looked at again until somebody may have come from
//! farther away.
//!
//! A search with the cell lists takes every pair whose surfaces are within s_i + s_j, a little more
//! than the step needs. Later the same list holds every pair that can meet as long as
//!
//! ```text
//!   |x_i − X_i − M| + e_i ≤ s_i   for every grain                                          (V1)
//! ```
//!
//! X where the grain was at the search, M the mean displacement of all since, e_i how far the grain's
//! reach goes beyond its radius now: distances of pairs have changed by at most the sum of the first
//! terms (Verlet 1967). What is visited is tested as the search tests it, so the answer has the same
//! bits as a new search. A grain whose distance from all walls has not been used up by its own
//! displacement looks at no wall.

use std::sync::Arc;

use space::grid::{Grid, SPARE, TooFar, pair_images};
use space::periodic::{Image, shortest_image};
use space::{Dim, Dimension, Vector, norm};

use crate::error::Error;
use crate::search::place::Place;
use crate::walls::near::WallContact;

/// Part of s that round-off of positions may take.
const SAFE: f64 = 1.0 - 1e-6;
/// Reach beyond the radius, of the radius, above which a list is too long to be worth keeping.
const LOOK_AHEAD_MAX: f64 = 2.0;

/// Distances a grain that a search may cost in the plane: grains that overlap little and are looked for three
/// radii far have 300 at most.
const DISTANCES_MAX: usize = 2000;
/// As many times that in space.
const DISTANCES_OF_SPACE: usize = 14;

/// Who is near whom, and how often that was looked for.
#[derive(Debug, Clone, Default)]
pub struct Neighbours<const D: usize> {
    /// Search anew each time, keep nothing.
    pub search_always: bool,
    /// Searches with cell lists so far.
    pub searches: u64,
    /// Grains for which walls were looked at so far.
    pub wall_looks: u64,
    /// What the last search found.
    pub found: Arc<Found<D>>,
}

/// What a search found.
#[derive(Debug, Clone, Default)]
pub struct Found<const D: usize> {
    /// X \[m\]; empty: nothing is known.
    pub reference: Vec<Vector<D>>,
    /// s \[m\]
    pub spare: Vec<f64>,
    /// Pairs (i < j).
    pairs: Vec<(u32, u32)>,
    /// From X to the nearest wall \[m\].
    wall_distance: Vec<f64>,
}

impl<const D: usize> Found<D>
where
    Dim<D>: Dimension<D>,
{
    /// Search for every pair whose surfaces are within s of each other, where the grains of `place` are; an
    /// error where that takes too long.
    pub fn search(place: &Place<'_, D>, spare: Vec<f64>) -> Result<Found<D>, Error> {
        let radius = &place.grains.radius;
        let wider: Vec<f64> = spare.iter().zip(radius).map(|(s, r)| s + r).collect();
        let mut pairs = Vec::new();
        let grid = Grid::build(place.position, &wider, &place.period);
        limited(&grid, radius.len(), |i, j, _, _| {
            let pair = (i as u32, j as u32);
            // Images of a pair follow each other.
            if pairs.last() != Some(&pair) {
                pairs.push(pair);
            }
        })?;
        let distances = place.position.iter().map(|x| place.walls.distance(x));
        Ok(Found {
            reference: place.position.to_vec(),
            spare,
            pairs,
            wall_distance: distances.collect(),
        })
    }
}

impl<const D: usize> Neighbours<D>
where
    Dim<D>: Dimension<D>,
{
    /// Forget the last search: the grains have been put elsewhere.
    pub fn forget(&mut self) {
        self.found = Arc::default();
    }

    /// Visit every pair (i < j, xᵢ − xⱼ, image) whose reaches overlap, each image of it once; an error
    /// where grains reach so far that looking takes too long.
    pub fn for_each_pair(
        &mut self,
        place: &Place<'_, D>,
        reach: &[f64],
        mut visit: impl FnMut(usize, usize, Vector<D>, Image),
    ) -> Result<(), Error> {
        if self.search_always || !self.cover(place, reach)? {
            self.searches += 1;
            let grid = Grid::build(place.position, reach, &place.period);
            return limited(&grid, place.grains.count(), visit);
        }
        let largest = reach.iter().copied().fold(0.0, f64::max);
        let mut periods = place.period.iter().flatten();
        // Can another image than the nearest be within reach?
        let images = periods.any(|&length| length < 6.0 * largest);
        for &(i, j) in &self.found.pairs {
            let (i, j) = (i as usize, j as usize);
            let apart = place.position[i] - place.position[j];
            let both = reach[i] + reach[j];
            pair_images(apart, &place.period, images, both, |apart, image| {
                visit(i, j, apart, image);
            });
        }
        Ok(())
    }

    /// Is the list as good as a search whose work is limited: is it certain that no cell of the search
    /// would hold more than 22 grains (in space 100)? (Its cells are twice the largest reach wide, and
    /// reaches in it differ by less than a factor of 2.) Two cases are:
    ///
    /// * no two reaches overlap, so that balls of half the largest reach R fit side by side into a
    ///   cube of side 2R + R (periodic: 2.7R + R, six R or more in a period);
    /// * reaches are at most a quarter of a radius beyond the radius and no two grains overlap by
    ///   more than a tenth, so that balls of 0.36 R do, in 2R + 0.72R (2.2R, twenty R).
    pub fn replaces_limited_search(
        &mut self,
        place: &Place<'_, D>,
        reach: &[f64],
    ) -> Result<bool, Error> {
        if self.search_always || !self.cover(place, reach)? {
            return Ok(false);
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
            return Ok(false);
        }
        let mut pairs = self.found.pairs.iter();
        Ok(pairs.all(|&(i, j)| {
            let (i, j) = (i as usize, j as usize);
            let least = match close {
                true => 0.9 * (radius[i] + radius[j]),
                false => reach[i] + reach[j],
            };
            let apart = place.position[i] - place.position[j];
            norm(&shortest_image(apart, &place.period)) > least
        }))
    }

    /// Call `visit` for every wall closer than `reach` to the surface of a grain.
    pub fn walls_near(
        &mut self,
        place: &Place<'_, D>,
        grain: usize,
        reach: f64,
        visit: impl FnMut(WallContact<'_, D>),
    ) {
        let (centre, radius) = (&place.position[grain], place.grains.radius[grain]);
        if self.is_away_from_walls(place, grain, reach) {
            return;
        }
        self.wall_looks += 1;
        place.walls.near(centre, radius, reach, visit);
    }

    /// Call `visit` for every wall, by number, offset of the grain and image, that may come within `reach` of the
    /// surface of a grain that moves no farther than that.
    pub fn walls_around(
        &mut self,
        place: &Place<'_, D>,
        grain: usize,
        reach: f64,
        visit: impl FnMut(usize, Vector<D>, Image),
    ) {
        let (centre, radius) = (&place.position[grain], place.grains.radius[grain]);
        if self.is_away_from_walls(place, grain, reach) {
            return;
        }
        self.wall_looks += 1;
        place.walls.around(centre, radius + reach, visit);
    }

    /// Has a grain not used up its distance from all walls?
    fn is_away_from_walls(&self, place: &Place<'_, D>, grain: usize, reach: f64) -> bool {
        let (centre, radius) = (&place.position[grain], place.grains.radius[grain]);
        if let (false, Some(from)) = (self.search_always, self.found.reference.get(grain)) {
            let distance = SAFE * self.found.wall_distance[grain] - norm(&(centre - from));
            return distance > place.walls.reach_of_faces(radius + reach);
        }
        false
    }

    /// Let the list hold every pair within reach; false when that is not worth it.
    fn cover(&mut self, place: &Place<'_, D>, reach: &[f64]) -> Result<bool, Error> {
        if self.still_holds(place, reach) {
            return Ok(true);
        }
        let radius = &place.grains.radius;
        let far = |(reach, radius): (&f64, &f64)| reach - radius > LOOK_AHEAD_MAX * radius;
        if reach.iter().zip(radius).any(far) {
            return Ok(false);
        }
        self.forget();
        self.renew(place, reach)?;
        Ok(true)
    }

    /// Search for every pair within reach and some more.
    fn renew(&mut self, place: &Place<'_, D>, reach: &[f64]) -> Result<(), Error> {
        let pairs = reach.iter().zip(&place.grains.radius);
        let spare = pairs.map(|(reach, radius)| reach - radius + SPARE * radius);
        self.searches += 1;
        // An error leaves nothing known.
        self.found = Arc::default();
        self.found = Arc::new(Found::search(place, spare.collect())?);
        Ok(())
    }

    /// (V1)
    fn still_holds(&self, place: &Place<'_, D>, reach: &[f64]) -> bool {
        let count = place.position.len();
        if self.found.reference.len() != count || count == 0 {
            return false;
        }
        let moved = |grain: usize| place.position[grain] - self.found.reference[grain];
        let sum = (0..count).fold(Vector::zeros(), |sum, grain| sum + moved(grain));
        let mean = sum * (1.0 / count as f64);
        (0..count).all(|grain| {
            let need = reach[grain] - place.grains.radius[grain];
            norm(&(moved(grain) - mean)) + need <= SAFE * self.found.spare[grain]
        })
    }
}

/// Visit every pair of a new search, unless there are too many distances.
pub fn limited<const D: usize>(
    grid: &Grid<D>,
    grains: usize,
    visit: impl FnMut(usize, usize, Vector<D>, Image),
) -> Result<(), Error> {
    let most = DISTANCES_MAX * DISTANCES_OF_SPACE.pow(D as u32 - 2) * grains;
    let visited = grid.for_each_pair_within(most, visit);
    visited.map_err(|TooFar { most }| Error::TooFar { most, grains })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grains::Grains;
    use crate::walls::facet::Facet;
    use crate::walls::near::Walls;
    use space::Period;
    use space::vector::from_fn;

    /// A small generator, so that the test needs nothing else.
    fn random(seed: &mut u64) -> f64 {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 7;
        *seed ^= *seed << 17;
        (*seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    }

    type Listed<const D: usize> = Vec<(usize, usize, Image, [u64; D])>;

    fn pairs<const D: usize>(
        neighbours: &mut Neighbours<D>,
        place: &Place<'_, D>,
        reach: &[f64],
    ) -> Listed<D>
    where
        Dim<D>: Dimension<D>,
    {
        let mut found = Vec::new();
        let visited = neighbours.for_each_pair(place, reach, |i, j, apart, image| {
            found.push((i, j, image, <[f64; D]>::from(apart).map(f64::to_bits)));
        });
        visited.expect("few distances");
        found.sort_unstable();
        found
    }

    fn walls<const D: usize>(
        neighbours: &mut Neighbours<D>,
        place: &Place<'_, D>,
        reach: &[f64],
    ) -> Vec<[u64; 3]>
    where
        Dim<D>: Dimension<D>,
    {
        let mut found = Vec::new();
        for (grain, reach) in reach.iter().enumerate() {
            let beyond = reach - place.grains.radius[grain];
            neighbours.walls_near(place, grain, beyond, |wall| {
                found.push([grain as u64, wall.feature as u64, wall.gap.to_bits()]);
            });
        }
        found
    }

    /// The sides of the unit square.
    fn square() -> Vec<Facet<2>> {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vector::from);
        let side = |k: usize| Facet::at_rest([corners[k], corners[(k + 1) % 4]]);
        (0..4).map(side).collect()
    }

    /// Two triangles a side of the unit cube.
    fn cube() -> Vec<Facet<3>> {
        let mut facets = Vec::new();
        for axis in 0..3 {
            for end in [0.0, 1.0] {
                let corner = |u: f64, v: f64| {
                    from_fn(|d| match (d + 3 - axis) % 3 {
                        0 => end,
                        1 => u,
                        _ => v,
                    })
                };
                let mut corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
                if end == 1.0 {
                    corners.reverse();
                }
                let [a, b, c, d] = corners.map(|[u, v]| corner(u, v));
                facets.extend([[a, b, c], [a, c, d]].map(Facet::at_rest));
            }
        }
        facets
    }

    /// Grains that drift together, and each on its own; sometimes one of them far.
    fn compare<const D: usize>(facets: &[Facet<D>], radius: f64, period: Period<D>)
    where
        Dim<D>: Dimension<D>,
    {
        let mut seed = 11;
        let count = 150;
        let grains = Grains {
            radius: (0..count)
                .map(|_| radius * (1.2 + random(&mut seed)))
                .collect(),
            mass: vec![1.0; count],
            fixed: vec![false; count],
        };
        let mut position: Vec<Vector<D>> = (0..count)
            .map(|_| from_fn(|_| random(&mut seed) + 0.5))
            .collect();
        let walls_of = Walls::new(facets, &period).unwrap();
        let mut kept = Neighbours::default();
        let mut always = Neighbours {
            search_always: true,
            ..Neighbours::default()
        };
        let (mut pair_count, mut wall_count) = (0, 0);
        for step in 0..120 {
            for (grain, place) in position.iter_mut().enumerate() {
                let stray = if 10 * grain == step { 0.1 } else { 1e-3 };
                let drift = [2e-3, -1e-3, 1e-3];
                *place += from_fn(|axis| drift[axis] + stray * random(&mut seed));
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

    #[test]
    fn a_kept_list_gives_the_pairs_and_walls_of_a_new_search_to_the_bit() {
        println!("period                    steps  pairs   walls  searches kept, always");
        for period in [
            [None, None],
            [Some(0.07), None],
            [Some(1.0), Some(0.3)],
            [Some(0.05), Some(0.07)],
        ] {
            compare(&square(), 0.01, period);
        }
        for period in [
            [None; 3],
            [Some(0.3), None, Some(1.0)],
            [Some(0.25), Some(0.3), Some(0.2)],
        ] {
            compare(&cube(), 0.03, period);
        }
    }
}
