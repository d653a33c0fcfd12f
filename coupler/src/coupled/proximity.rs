//! Who may come into contact within a step, from geometry alone: for particle engines that do not
//! tell who touched.
//!
//! ```text
//!   gap_ij ≤ e_i + e_j,   e_i = Δt |v_i − v̄| + r_i/20,   v̄ mean velocity of all grains     (P1)
//!   gap_iw ≤ Δt |v_i| + r_i/20                                                              (P2)
//! ```
//!
//! |v_i − v_j| ≤ |v_i − v̄| + |v_j − v̄|, so no pair that closes its gap at these velocities is missed;
//! pairs that only pass each other by are counted too. Where so many are in reach that looking would take
//! minutes, everybody may touch.

use space::{Period, Vector, dot, grid::Grid, hypot};

use crate::state::{Contact, Grains};

/// Part of a radius that counts as touching whatever the velocity.
const NEAR: f64 = 0.05;

/// Distances a grain on the mean, above which everybody may touch somebody.
const DISTANCES_MAX: usize = 10_000;

/// What grains may touch besides each other.
#[derive(Debug, Clone)]
pub struct Proximity<const D: usize> {
    /// Corners of every wall \[m\]: a segment in the plane, a triangle in space.
    pub walls: Vec<[Vector<D>; D]>,
    /// Period along each axis \[m\].
    pub period: Period<D>,
}

impl<const D: usize> Proximity<D> {
    /// Contact states of grains about to move for `dt`: a grain that may touch does.
    pub fn contacts(&self, grains: &Grains<D>, dt: f64) -> Vec<Contact> {
        let state = |may| match may {
            true => Contact::Touches,
            false => Contact::Free,
        };
        self.may_touch(grains, dt).into_iter().map(state).collect()
    }

    /// For each grain: may it touch another grain or a wall within `dt`?
    fn may_touch(&self, grains: &Grains<D>, dt: f64) -> Vec<bool> {
        let count = grains.count();
        let mut may = vec![false; count];
        if count == 0 {
            return may;
        }
        let mean = grains.velocity.iter().sum::<Vector<D>>() / count as f64;
        let reach = |i: usize, frame: &Vector<D>| {
            grains.radius[i] * (1.0 + NEAR) + dt * hypot(&(grains.velocity[i] - frame))
        };
        let of_pairs: Vec<f64> = (0..count).map(|i| reach(i, &mean)).collect(); // (P1)
        let grid = Grid::build(&grains.position, &of_pairs, &self.period);
        let visited = grid.for_each_pair_within(DISTANCES_MAX * count, |i, j, _, _| {
            (may[i], may[j]) = (true, true);
        });
        if visited.is_err() {
            return vec![true; count];
        }
        for (i, may) in may.iter_mut().enumerate() {
            let to_wall = reach(i, &Vector::zeros()); // (P2)
            let near = |wall: &[Vector<D>; D]| distance(wall, &grains.position[i]) <= to_wall;
            *may |= self.walls.iter().any(near);
        }
        may
    }
}

/// From a point to the nearest one of a segment or a triangle with these corners \[m\].
fn distance<const D: usize>(corners: &[Vector<D>], point: &Vector<D>) -> f64 {
    let apart = point - corners[0];
    match corners {
        [a, b] => {
            let edge = b - a;
            let along = (dot(&apart, &edge) / dot(&edge, &edge)).clamp(0.0, 1.0);
            hypot(&(apart - edge * along))
        }
        [a, b, c] => {
            let (u, v) = (b - a, c - a);
            let (uu, uv, vv) = (dot(&u, &u), dot(&u, &v), dot(&v, &v));
            let (pu, pv) = (dot(&apart, &u), dot(&apart, &v));
            let determinant = uu * vv - uv * uv;
            let (second, third) = (vv * pu - uv * pv, uu * pv - uv * pu);
            if second >= 0.0 && third >= 0.0 && second + third <= determinant {
                return hypot(&(apart - u * (second / determinant) - v * (third / determinant)));
            }
            let edges = [[*a, *b], [*b, *c], [*c, *a]];
            let distances = edges.iter().map(|edge| distance(edge, point));
            distances.fold(f64::INFINITY, f64::min)
        }
        _ => hypot(&apart),
    }
}
