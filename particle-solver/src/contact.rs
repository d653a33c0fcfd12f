//! Contacts: who touches whom, where, and the impulses that are remembered.

use crate::grains::Grains;
use crate::neighbours::{Neighbours, Place};
use crate::vector::{Vector, dot, norm, scale, sub};

/// Which contact it is: the same key means the same pair, whatever the step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// A grain.
    pub first: u32,
    /// A grain of larger number, or the number of grains plus a wall feature.
    pub second: u32,
    /// Periodic image of the pair.
    pub image: u8,
}

/// A pair that may touch within a sub-step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Which.
    pub key: Key,
    /// Unit normal from the second to the first.
    pub normal: Vector,
    /// Distance of the surfaces \[m\], negative when they overlap.
    pub gap: f64,
}

/// Impulses by contact, sorted by key; only those that act.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Impulses {
    /// Length of the sub-step that they belong to \[s\].
    pub dt: f64,
    /// (key, normal impulse, tangential impulse) \[N s\].
    pub entries: Vec<(Key, f64, f64)>,
}

impl Impulses {
    /// Impulses for these sorted candidates in a sub-step of length `dt`; 0 for new contacts.
    pub fn recall(&self, candidates: &[Candidate], dt: f64) -> Vec<[f64; 2]> {
        let rescale = if self.dt > 0.0 { dt / self.dt } else { 0.0 };
        let mut known = self.entries.iter().peekable();
        let mut impulses = Vec::with_capacity(candidates.len());
        for candidate in candidates {
            while known.peek().is_some_and(|entry| entry.0 < candidate.key) {
                known.next();
            }
            impulses.push(match known.peek() {
                Some((key, normal, tangential)) if *key == candidate.key => {
                    [rescale * normal, rescale * tangential]
                }
                _ => [0.0; 2],
            });
        }
        impulses
    }
}

/// How far each grain may move in a sub-step, and how far contacts may push it.
///
/// A pair is left out when `gap + δt n·(v_free,i − v_free,j) ≥ push_i + push_j`: then it cannot
/// touch as long as contacts change no velocity by more than `push/δt`, which is checked after
/// the solve. Only relative motion enters, in the frame of the mean velocity.
#[derive(Debug)]
pub struct Margin<'a> {
    /// Length of the sub-step \[s\].
    pub dt: f64,
    /// v_free \[m/s\].
    pub free_velocity: &'a [Vector],
    /// Displacement by contacts allowed for \[m\].
    pub push: &'a [f64],
}

impl Margin<'_> {
    /// Radius within which each grain can meet others \[m\].
    pub fn reach(&self, grains: &Grains) -> Vec<f64> {
        let frame = mean_velocity(self.free_velocity, &grains.fixed);
        (0..grains.count())
            .map(|grain| {
                let relative = norm(sub(self.free_velocity[grain], frame));
                grains.radius[grain] + self.dt * relative + self.push[grain]
            })
            .collect()
    }
}

/// Mean velocity of the grains that move.
pub fn mean_velocity(velocity: &[Vector], fixed: &[bool]) -> Vector {
    let mut sum = [0.0; 2];
    let mut count = 0.0;
    for (velocity, &fixed) in velocity.iter().zip(fixed) {
        if !fixed {
            sum = [sum[0] + velocity[0], sum[1] + velocity[1]];
            count += 1.0;
        }
    }
    scale(1.0 / f64::max(count, 1.0), sum)
}

/// Pairs that may touch, sorted by key.
pub fn candidates(
    neighbours: &mut Neighbours,
    place: &Place<'_>,
    margin: &Margin<'_>,
) -> Vec<Candidate> {
    let grains = place.grains;
    if grains.fixed.iter().all(|&fixed| fixed) {
        return Vec::new();
    }
    let mut found = Vec::new();
    neighbours.for_each_pair(place, &margin.reach(grains), |i, j, apart, image| {
        if grains.fixed[i] && grains.fixed[j] {
            return;
        }
        let (normal, distance) = direction(apart, grains.radius[i] + grains.radius[j], i, j);
        let gap = distance - grains.radius[i] - grains.radius[j];
        let relative = sub(margin.free_velocity[i], margin.free_velocity[j]);
        if gap + margin.dt * dot(relative, normal) < margin.push[i] + margin.push[j] {
            let key = Key {
                first: i as u32,
                second: j as u32,
                image,
            };
            found.push(Candidate { key, normal, gap });
        }
    });
    for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
        let free = margin.free_velocity[grain];
        let reach = margin.dt * norm(free) + margin.push[grain];
        neighbours.walls_near(place, grain, reach, |wall| {
            if wall.gap + margin.dt * dot(free, wall.normal) < margin.push[grain] {
                let second = (grains.count() + wall.feature) as u32;
                let key = Key {
                    first: grain as u32,
                    second,
                    image: wall.image,
                };
                found.push(Candidate {
                    key,
                    normal: wall.normal,
                    gap: wall.gap,
                });
            }
        });
    }
    sort(found, grains.count())
}

/// Sort by key: by first grain with a counting sort, then the few of each grain.
fn sort(found: Vec<Candidate>, grain_count: usize) -> Vec<Candidate> {
    let mut start = vec![0u32; grain_count + 1];
    for candidate in &found {
        start[candidate.key.first as usize + 1] += 1;
    }
    for grain in 0..grain_count {
        start[grain + 1] += start[grain];
    }
    let mut next = start.clone();
    let mut sorted = found.clone();
    for candidate in found {
        let place = &mut next[candidate.key.first as usize];
        sorted[*place as usize] = candidate;
        *place += 1;
    }
    for grain in 0..grain_count {
        sorted[start[grain] as usize..start[grain + 1] as usize]
            .sort_unstable_by_key(|candidate| candidate.key);
    }
    sorted
}

/// Direction and length of `apart`. Coincident centres get a direction from their numbers, the
/// same in every step.
fn direction(apart: Vector, size: f64, i: usize, j: usize) -> (Vector, f64) {
    let distance = norm(apart);
    if distance > 1e-12 * size {
        return (scale(1.0 / distance, apart), distance);
    }
    const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;
    let angle = GOLDEN_ANGLE * ((31 * i + 17 * j) % 10_007) as f64;
    ([angle.cos(), angle.sin()], distance)
}
