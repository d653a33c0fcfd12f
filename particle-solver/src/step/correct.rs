//! Overlaps that are already there: grains are moved apart without being given velocity.
//!
//! ```text
//!   minimise ½ Σ m_i |d_i|²  subject to  n·(d_i − d_j) ≥ target                            (P1)
//!   target = min(β (−g − s), cap)   overlap beyond the slop, −g > s
//!          = −max(g, 0)             otherwise: no gap is closed beyond touching
//! ```
//!
//! g is the gap that the velocities of this sub-step lead to, β = 0.2, s = 1e-4 and cap = 0.02
//! of the smaller radius. A few Gauss–Seidel sweeps are enough, because what is left is taken up
//! by the next sub-step. Energy: velocities are untouched; the potential energy regained by
//! lifting a grain is what it lost by sinking. A scene without overlaps skips all this.

use space::{Vector, dot, norm};

use crate::contact::impulses::Pair;
use crate::grains::Grains;

/// Part of an overlap removed in a sub-step.
pub const RECOVERY: f64 = 0.2;
/// Overlap left alone, of the smaller radius.
pub const SLOP: f64 = 1e-4;
/// Largest recovery in a sub-step, of the smaller radius.
pub const RECOVERY_MAX: f64 = 0.02;

/// Sweeps where a sub-step is solved to the end.
pub const SWEEPS: usize = 20;

/// Radius of the smaller grain of a contact.
pub fn smaller_radius<const D: usize>(grains: &Grains, pair: &Pair<D>) -> f64 {
    let first = grains.radius[pair.key.first as usize];
    grains
        .radius
        .get(pair.key.second as usize)
        .map_or(first, |second| first.min(*second))
}

/// Add to `displacement` \[m\] what removes a part of the overlaps, after so many sweeps.
pub fn correct<const D: usize>(
    grains: &Grains,
    pairs: &[Pair<D>],
    displacement: &mut [Vector<D>],
    sweeps: usize,
) {
    if let Some(targets) = targets(grains, pairs, displacement) {
        let moved = move_apart(grains, pairs, &targets, sweeps);
        for (displacement, moved) in displacement.iter_mut().zip(moved) {
            *displacement += moved;
        }
    }
}

/// How far each pair must be moved apart (P1); none when nothing overlaps.
fn targets<const D: usize>(
    grains: &Grains,
    pairs: &[Pair<D>],
    displacement: &[Vector<D>],
) -> Option<Vec<f64>> {
    let mut overlaps = false;
    let targets = pairs.iter().map(|pair| {
        let (gap, radius) = (gap_along(pair, displacement), smaller_radius(grains, pair));
        if -gap > SLOP * radius {
            overlaps = true;
            (RECOVERY * (-gap - SLOP * radius)).min(RECOVERY_MAX * radius)
        } else {
            -gap.max(0.0)
        }
    });
    let targets = targets.collect();
    overlaps.then_some(targets)
}

/// g: the gap of a pair after these displacements, along its normal \[m\].
fn gap_along<const D: usize>(pair: &Pair<D>, displacement: &[Vector<D>]) -> f64 {
    pair.gap + dot(&apart(pair, displacement), &pair.normal)
}

/// d_i − d_j; a wall does not move.
fn apart<const D: usize>(pair: &Pair<D>, displacement: &[Vector<D>]) -> Vector<D> {
    let (first, second) = (pair.key.first as usize, pair.key.second as usize);
    let other = displacement
        .get(second)
        .copied()
        .unwrap_or_else(Vector::zeros);
    displacement[first] - other
}

/// Gauss–Seidel on (P1).
fn move_apart<const D: usize>(
    grains: &Grains,
    pairs: &[Pair<D>],
    targets: &[f64],
    sweeps: usize,
) -> Vec<Vector<D>> {
    let inverse_mass = |grain: u32| match grains.fixed.get(grain as usize) {
        Some(false) => 1.0 / grains.mass[grain as usize],
        _ => 0.0,
    };
    let mut moved = vec![Vector::zeros(); grains.count()];
    let mut multipliers = vec![0.0f64; pairs.len()];
    for _ in 0..sweeps {
        for ((pair, target), multiplier) in pairs.iter().zip(targets).zip(&mut multipliers) {
            let (one, two) = (inverse_mass(pair.key.first), inverse_mass(pair.key.second));
            let missing = target - dot(&apart(pair, &moved), &pair.normal);
            let new = (*multiplier + missing / (one + two)).max(0.0);
            let change = new - *multiplier;
            *multiplier = new;
            moved[pair.key.first as usize] += pair.normal * (change * one);
            if let Some(other) = moved.get_mut(pair.key.second as usize) {
                *other -= pair.normal * (change * two);
            }
        }
    }
    moved
}

/// Gap of a pair after these displacements \[m\]; exact for two grains and for faces.
pub fn gap_after<const D: usize>(
    grains: &Grains,
    pair: &Pair<D>,
    displacement: &[Vector<D>],
) -> f64 {
    let (first, second) = (pair.key.first as usize, pair.key.second as usize);
    let moved = apart(pair, displacement);
    match grains.radius.get(second) {
        Some(radius) => {
            let size = grains.radius[first] + radius;
            norm(&(pair.normal * (size + pair.gap) + moved)) - size
        }
        None => (0..D).fold(pair.gap, |gap, d| gap + moved[d] * pair.normal[d]),
    }
}
