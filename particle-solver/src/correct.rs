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

use crate::contact::Candidate;
use crate::grains::Grains;
use crate::vector::{Vector, add, dot, scale, sub};

/// Part of an overlap removed in a sub-step.
pub const RECOVERY: f64 = 0.2;
/// Overlap left alone, of the smaller radius.
pub const SLOP: f64 = 1e-4;
/// Largest recovery in a sub-step, of the smaller radius.
pub const RECOVERY_MAX: f64 = 0.02;

const SWEEPS: usize = 20;

/// Radius of the smaller grain of a contact.
pub fn smaller_radius(grains: &Grains, candidate: &Candidate) -> f64 {
    let first = grains.radius[candidate.key.first as usize];
    grains
        .radius
        .get(candidate.key.second as usize)
        .map_or(first, |second| first.min(*second))
}

/// Add to `displacement` \[m\] what removes a part of the overlaps.
pub fn correct(grains: &Grains, candidates: &[Candidate], displacement: &mut [Vector]) {
    let gap_after = |candidate: &Candidate| {
        let first = displacement[candidate.key.first as usize];
        let second = displacement
            .get(candidate.key.second as usize)
            .copied()
            .unwrap_or_default();
        candidate.gap + dot(sub(first, second), candidate.normal)
    };
    let mut overlaps = false;
    let targets: Vec<f64> = candidates
        .iter()
        .map(|candidate| {
            let (gap, radius) = (gap_after(candidate), smaller_radius(grains, candidate));
            if -gap > SLOP * radius {
                overlaps = true;
                (RECOVERY * (-gap - SLOP * radius)).min(RECOVERY_MAX * radius)
            } else {
                -gap.max(0.0)
            }
        })
        .collect();
    if !overlaps {
        return;
    }
    let inverse_mass = |grain: usize| match grains.fixed.get(grain) {
        Some(false) => 1.0 / grains.mass[grain],
        _ => 0.0,
    };
    let mut moved = vec![[0.0; 2]; grains.count()];
    let mut multipliers = vec![0.0f64; candidates.len()];
    for _ in 0..SWEEPS {
        for ((candidate, target), multiplier) in
            candidates.iter().zip(&targets).zip(&mut multipliers)
        {
            let (first, second) = (candidate.key.first as usize, candidate.key.second as usize);
            let (one, two) = (inverse_mass(first), inverse_mass(second));
            let other = moved.get(second).copied().unwrap_or_default();
            let missing = target - dot(sub(moved[first], other), candidate.normal);
            let new = (*multiplier + missing / (one + two)).max(0.0);
            let change = new - *multiplier;
            *multiplier = new;
            moved[first] = add(moved[first], scale(change * one, candidate.normal));
            if let Some(other) = moved.get_mut(second) {
                *other = sub(*other, scale(change * two, candidate.normal));
            }
        }
    }
    for (displacement, moved) in displacement.iter_mut().zip(moved) {
        *displacement = add(*displacement, moved);
    }
}
