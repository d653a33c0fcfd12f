//! Who may come into contact within a step, from geometry alone: for particle engines that do not
//! tell who touched.
//!
//! ```text
//!   gap_ij ≤ e_i + e_j,   e_i = Δt |v_i − v̄| + r_i/20,   v̄ mean velocity of all grains     (P1)
//!   gap_iw ≤ Δt |v_i| + r_i/20                                                              (P2)
//! ```
//!
//! |v_i − v_j| ≤ |v_i − v̄| + |v_j − v̄|, so no pair that closes its gap at these velocities is missed;
//! pairs that only pass each other by are counted too.

use std::collections::BTreeMap;

use protocol::configure::ParticleScene;

use crate::coupling::GrainState;

/// Part of a radius that counts as touching whatever the velocity.
const NEAR: f64 = 0.05;

/// For each grain: may it touch another grain or a wall within `dt`?
pub fn may_touch(grains: &GrainState, scene: &ParticleScene, dt: f64) -> Vec<bool> {
    let count = grains.count();
    let mut may = vec![false; count];
    if count == 0 {
        return may;
    }
    let mean = [0, 1].map(|axis| {
        let along = grains.velocity.iter().skip(axis).step_by(2);
        along.sum::<f64>() / count as f64
    });
    let speed = |i: usize, frame: [f64; 2]| {
        (grains.velocity[2 * i] - frame[0]).hypot(grains.velocity[2 * i + 1] - frame[1])
    };
    let reach: Vec<f64> = (0..count)
        .map(|i| grains.radius[i] * (1.0 + NEAR) + dt * speed(i, mean)) // (P1)
        .collect();
    let grid = Grid::new(grains, scene.period, &reach);
    for i in 0..count {
        grid.for_each_near(i, |j| {
            let [dx, dy] = grid.apart(i, j);
            if dx.hypot(dy) <= reach[i] + reach[j] {
                (may[i], may[j]) = (true, true);
            }
        });
        let position = [grains.position[2 * i], grains.position[2 * i + 1]];
        let to_wall = grains.radius[i] * (1.0 + NEAR) + dt * speed(i, [0.0, 0.0]); // (P2)
        may[i] |= scene
            .walls
            .iter()
            .any(|wall| wall.distance(position) <= to_wall);
    }
    may
}

/// Grains by cells that are as large as the largest reach of a pair.
struct Grid<'a> {
    position: &'a [f64],
    period: [Option<f64>; 2],
    size: [f64; 2],
    /// Cells along a periodic direction.
    turn: [Option<i64>; 2],
    cells: BTreeMap<[i64; 2], Vec<usize>>,
}

impl<'a> Grid<'a> {
    fn new(grains: &'a GrainState, period: [Option<f64>; 2], reach: &[f64]) -> Grid<'a> {
        let wanted = 2.0 * reach.iter().fold(0.0_f64, |max, &own| max.max(own));
        let turn = period.map(|length| length.map(|length| ((length / wanted) as i64).max(1)));
        let size = [0, 1].map(|axis| match (period[axis], turn[axis]) {
            (Some(length), Some(turn)) => length / turn as f64,
            _ => wanted,
        });
        let mut grid = Grid {
            position: &grains.position,
            period,
            size,
            turn,
            cells: BTreeMap::new(),
        };
        for i in 0..grains.count() {
            grid.cells.entry(grid.cell(i, [0, 0])).or_default().push(i);
        }
        grid
    }

    fn cell(&self, i: usize, offset: [i64; 2]) -> [i64; 2] {
        [0, 1].map(|axis| {
            let cell =
                (self.position[2 * i + axis] / self.size[axis]).floor() as i64 + offset[axis];
            self.turn[axis].map_or(cell, |turn| cell.rem_euclid(turn))
        })
    }

    /// Every j < i in this or a neighbouring cell, some more than once across a short period.
    fn for_each_near(&self, i: usize, mut visit: impl FnMut(usize)) {
        for x in -1..=1 {
            for y in -1..=1 {
                let near = self.cells.get(&self.cell(i, [x, y]));
                near.into_iter()
                    .flatten()
                    .filter(|&&j| j < i)
                    .for_each(|&j| visit(j));
            }
        }
    }

    /// From j to i, the shortest way around.
    fn apart(&self, i: usize, j: usize) -> [f64; 2] {
        [0, 1].map(|axis| {
            let apart = self.position[2 * i + axis] - self.position[2 * j + axis];
            self.period[axis].map_or(apart, |length| apart - length * (apart / length).round())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::configure::Wall;

    fn scene(walls: Vec<Wall>, period: [Option<f64>; 2]) -> ParticleScene {
        ParticleScene {
            gravity: [0.0, -9.81],
            walls,
            period,
            friction: 0.0,
            wall_friction: 0.0,
            inertia_factor: 0.5,
            tolerance: 1e-3,
            sweeps_max: 1,
            sub_steps_max: 1,
            threads: 1,
        }
    }

    fn grains(position: &[f64], velocity: &[f64]) -> GrainState {
        let count = position.len() / 2;
        GrainState {
            position: position.to_vec(),
            velocity: velocity.to_vec(),
            radius: vec![0.1; count],
            mass: vec![1.0; count],
            ..GrainState::default()
        }
    }

    #[test]
    fn only_what_relative_motion_can_bring_together_may_touch() {
        let rest = scene(Vec::new(), [None, None]);
        let pair = [0.0, 0.0, 0.3, 0.0];
        assert_eq!(may_touch(&grains(&pair, &[0.0; 4]), &rest, 0.1), [false; 2]);
        // as a block they keep their distance, at any speed
        let block = grains(&pair, &[9.0, 0.0, 9.0, 0.0]);
        assert_eq!(may_touch(&block, &rest, 0.1), [false; 2]);
        let closing = grains(&pair, &[0.5, 0.0, -0.5, 0.0]);
        assert_eq!(may_touch(&closing, &rest, 0.1), [true; 2]);
        assert_eq!(may_touch(&closing, &rest, 0.05), [false; 2]);
    }

    #[test]
    fn walls_and_periods_count() {
        let floor = Wall {
            a: [-1.0, 0.0],
            b: [1.0, 0.0],
        };
        let over = grains(&[0.0, 0.103, 0.0, 0.5], &[0.0; 4]);
        let with_floor = scene(vec![floor], [None, None]);
        assert_eq!(may_touch(&over, &with_floor, 1e-3), [true, false]);
        let across = grains(&[0.05, 5.0, 1.95, 5.0, 1.0, 5.0], &[0.0; 6]);
        let ring = scene(Vec::new(), [Some(2.0), None]);
        assert_eq!(may_touch(&across, &ring, 1e-3), [true, true, false]);
        let unwrapped = grains(&[0.05, 5.0, -4.05, 5.0, 7.0, 5.0], &[0.0; 6]);
        assert_eq!(may_touch(&unwrapped, &ring, 1e-3), [true, true, false]);
    }

    #[test]
    fn the_grid_finds_what_all_pairs_find() {
        let number = |k: usize| ((k as f64 + 1.0).sin() * 43_758.545).rem_euclid(1.0);
        let position: Vec<f64> = (0..400).map(|k| 6.0 * number(k) - 3.0).collect();
        let velocity: Vec<f64> = (0..400).map(|k| number(3 * k + 1) - 0.5).collect();
        let cloud = grains(&position, &velocity);
        let open = scene(Vec::new(), [None, None]);
        let found = may_touch(&cloud, &open, 0.05);
        let mean = [0, 1].map(|a| velocity.iter().skip(a).step_by(2).sum::<f64>() / 200.0);
        let reach = |i: usize| {
            0.105 + 0.05 * (velocity[2 * i] - mean[0]).hypot(velocity[2 * i + 1] - mean[1])
        };
        let apart = |i: usize, j: usize| {
            (position[2 * i] - position[2 * j]).hypot(position[2 * i + 1] - position[2 * j + 1])
        };
        let expected: Vec<bool> = (0..200)
            .map(|i| (0..200).any(|j| j != i && apart(i, j) <= reach(i) + reach(j)))
            .collect();
        let count = expected.iter().filter(|&&may| may).count();
        println!("{count} of 200 may touch");
        assert!(count > 20 && count < 200);
        assert_eq!(found, expected);
    }
}
