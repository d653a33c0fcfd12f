//! Pairs that may touch within a sub-step.

use space::vector::from_fn;
use space::{Dim, Dimension, Vector, dot, norm};

use crate::contact::impulses::{Key, Pair};
use crate::error::Error;
use crate::grains::Grains;
use crate::search::neighbours::Neighbours;
use crate::search::place::Place;

/// How far each grain may move in a sub-step, and how far contacts may push it.
///
/// A pair is left out when `gap + δt n·(v_free,i − v_free,j) ≥ push_i + push_j`: then it cannot
/// touch as long as contacts change no velocity by more than `push/δt`, which is checked after
/// the solve. Only relative motion enters, in the frame of the mean velocity.
#[derive(Debug)]
pub struct Margin<'a, const D: usize> {
    /// Length of the sub-step \[s\].
    pub dt: f64,
    /// v_free \[m/s\].
    pub free_velocity: &'a [Vector<D>],
    /// Displacement by contacts allowed for \[m\].
    pub push: &'a [f64],
}

impl<const D: usize> Margin<'_, D> {
    /// Radius within which each grain can meet others \[m\].
    pub fn reach(&self, grains: &Grains) -> Vec<f64> {
        let frame = mean_velocity(self.free_velocity, &grains.fixed);
        (0..grains.count())
            .map(|grain| {
                let relative = norm(&(self.free_velocity[grain] - frame));
                grains.radius[grain] + self.dt * relative + self.push[grain]
            })
            .collect()
    }
}

/// Mean velocity of the grains that move.
pub fn mean_velocity<const D: usize>(velocity: &[Vector<D>], fixed: &[bool]) -> Vector<D> {
    let mut sum = Vector::zeros();
    let mut count = 0.0;
    for (velocity, &fixed) in velocity.iter().zip(fixed) {
        if !fixed {
            sum += velocity;
            count += 1.0;
        }
    }
    sum * (1.0 / f64::max(count, 1.0))
}

/// Candidates a grain on the mean in the plane, above which a sub-step is too long to be solved: three of them
/// touch in the densest packing, and sweeps cost in proportion.
const CROWD: usize = 32;
/// As many times that in space, where six touch.
const CROWD_OF_SPACE: usize = 2;

/// Candidates a grain with walls beyond which the same is so: a large grain lies on many facets at once.
const FACETS: usize = 256;

/// Most pairs that so many grains may have; the search takes no more than one above it.
fn most<const D: usize>(count: usize) -> usize {
    CROWD * CROWD_OF_SPACE.pow(D as u32 - 2) * count
}

/// Pairs that may touch, sorted by key; an error where they are too many to be solved.
pub fn pairs<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    margin: &Margin<'_, D>,
) -> Result<Vec<Pair<D>>, Error>
where
    Dim<D>: Dimension<D>,
{
    let grains = place.grains;
    if grains.fixed.iter().all(|&fixed| fixed) {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    pairs_of_grains(neighbours, place, margin, &mut found)?;
    not_above::<D>(found.len(), grains.count(), false)?;
    pairs_with_walls(neighbours, place, margin, &mut found);
    not_above::<D>(found.len(), grains.count(), true)?;
    Ok(sort(found, grains.count(), |pair| pair.key))
}

/// An error where so many pairs, with those with walls or without, are too many to be solved.
pub fn not_above<const D: usize>(pairs: usize, grains: usize, walls: bool) -> Result<(), Error> {
    let facets = if walls { FACETS * grains } else { 0 };
    let most = most::<D>(grains) + facets;
    match pairs > most {
        true => Err(Error::Crowded { most, grains }),
        false => Ok(()),
    }
}

fn pairs_of_grains<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    margin: &Margin<'_, D>,
    found: &mut Vec<Pair<D>>,
) -> Result<(), Error>
where
    Dim<D>: Dimension<D>,
{
    let grains = place.grains;
    let most = most::<D>(grains.count());
    neighbours.for_each_pair(place, &margin.reach(grains), |i, j, apart, image| {
        if grains.fixed[i] && grains.fixed[j] || found.len() > most {
            return;
        }
        let (normal, distance) = direction(&apart, grains.radius[i] + grains.radius[j], i, j);
        let gap = distance - grains.radius[i] - grains.radius[j];
        let relative = margin.free_velocity[i] - margin.free_velocity[j];
        if gap + margin.dt * dot(&relative, &normal) < margin.push[i] + margin.push[j] {
            let key = Key {
                first: i as u32,
                second: j as u32,
                image,
            };
            found.push(Pair { key, normal, gap });
        }
    })
}

fn pairs_with_walls<const D: usize>(
    neighbours: &mut Neighbours<D>,
    place: &Place<'_, D>,
    margin: &Margin<'_, D>,
    found: &mut Vec<Pair<D>>,
) where
    Dim<D>: Dimension<D>,
{
    let grains = place.grains;
    for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
        let free = margin.free_velocity[grain];
        let reach = margin.dt * norm(&free) + margin.push[grain];
        neighbours.walls_near(place, grain, reach, |wall| {
            if wall.gap + margin.dt * dot(&free, &wall.normal) < margin.push[grain] {
                let key = Key {
                    first: grain as u32,
                    second: (grains.count() + wall.feature) as u32,
                    image: wall.image,
                };
                let (normal, gap) = (wall.normal, wall.gap);
                found.push(Pair { key, normal, gap });
            }
        });
    }
}

/// Sort by key: by first grain with a counting sort, then the few of each grain.
pub fn sort<T: Copy>(found: Vec<T>, grain_count: usize, key: impl Fn(&T) -> Key) -> Vec<T> {
    let mut start = vec![0u32; grain_count + 1];
    for pair in &found {
        start[key(pair).first as usize + 1] += 1;
    }
    for grain in 0..grain_count {
        start[grain + 1] += start[grain];
    }
    let mut next = start.clone();
    let mut sorted = found.clone();
    for pair in found {
        let place = &mut next[key(&pair).first as usize];
        sorted[*place as usize] = pair;
        *place += 1;
    }
    for grain in 0..grain_count {
        sorted[start[grain] as usize..start[grain + 1] as usize].sort_unstable_by_key(&key);
    }
    sorted
}

/// Direction and length of `apart`. Coincident centres get a direction from their numbers, the
/// same in every step.
pub fn direction<const D: usize>(
    apart: &Vector<D>,
    size: f64,
    i: usize,
    j: usize,
) -> (Vector<D>, f64) {
    let distance = norm(apart);
    if distance > 1e-12 * size {
        return (apart * (1.0 / distance), distance);
    }
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let angle = GOLDEN_ANGLE * ((31 * i + 17 * j) % 10_007) as f64;
    let direction = from_fn(|axis| match axis {
        0 => angle.cos(),
        1 => angle.sin(),
        _ => 0.0,
    });
    (direction, distance)
}
