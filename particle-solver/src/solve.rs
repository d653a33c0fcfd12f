//! Which iteration is used when, and when it is enough.
//!
//! 1. Start from the remembered impulses or from none, whichever leaves the smaller residual;
//!    when no pair approaches, zero impulses are the answer and nothing is swept.
//! 2. A few plain sweeps, the first ones without relaxation: exact for contacts on their own.
//! 3. When these stall: momentum sweeps. The problem with friction is no minimisation, so these
//!    may circle; under-relaxed sweeps in turn with them, in phases of doubling length, end that.
//! 4. At the limit: the best impulses, marked as not converged.
//!
//! Why this order, from one scene and one seed: 2000 frictional disks fall into a box, 1500 steps
//! to 1e-3, sweeps a step over the hardest 75 of them and phases of 1600 iterations or more:
//! momentum alone 690 and 17, with under-relaxed phases 910 and 1. The mean is dearer, the worst
//! step cheaper. Projected gradients (diagonally scaled) as a third phase gave 810 and 4. Gradients
//! first, in long phases, and over-relaxed phases restarted from the best each failed at a step.

use crate::accelerate::MomentumSweeps;
use crate::delassus::{Residual, System};
use crate::nlgs::{RELAXATION, sweep};

/// Sweeps without relaxation at the start.
const PLAIN_SWEEPS: usize = 2;
/// Sweeps before a faster iteration takes over.
const STALL_SWEEPS: usize = 40;
/// Iterations of the first phases with friction.
const PHASE_SWEEPS: usize = 200;
/// Relaxation that ends cycles.
const UNDER_RELAXATION: f64 = 0.7;
/// Sweeps that a tolerance below the required one may cost.
const WISH_SWEEPS: usize = 2000;
/// A residual this many times the best is not worth starting from.
const FAR_OFF: f64 = 10.0;

/// How a solve ended.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Outcome {
    /// Sweeps, or iterations of the same cost.
    pub sweeps: usize,
    /// What is left.
    pub residual: Residual,
    /// Is it within the required tolerance?
    pub converged: bool,
}

/// The running solve: what was best, and what is allowed.
struct Run<'a> {
    system: &'a mut System,
    goal: Goal,
    sweeps_max: usize,
    sweeps: usize,
    best: Residual,
    best_impulses: Vec<[f64; 2]>,
}

/// When a solve may stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Residual wished for; given up after a number of sweeps.
    pub wished: f64,
    /// Residual without which the solve has failed.
    pub required: f64,
}

/// Solve the contact problem, starting from `warm` impulses.
pub fn solve(system: &mut System, warm: &[[f64; 2]], goal: Goal, sweeps_max: usize) -> Outcome {
    let cold = system.residual();
    let mut run = Run {
        best_impulses: system.impulses(),
        best: cold,
        system,
        goal,
        sweeps_max,
        sweeps: 0,
    };
    if cold.within(goal.wished) {
        return run.finish();
    }
    if warm.iter().any(|impulse| impulse[0] > 0.0) {
        run.system.set_impulses(warm);
        if !run.note() {
            run.restore();
        }
    }
    if run.is_enough() {
        return run.finish();
    }
    run.sweep_plainly();
    let mut phase = if run.system.has_friction() {
        PHASE_SWEEPS
    } else {
        usize::MAX
    };
    while !run.is_enough() && run.sweeps < sweeps_max {
        run.sweep_with_momentum(phase);
        if !run.is_enough() {
            run.iterate(phase, |system, _| {
                sweep(system, UNDER_RELAXATION);
            });
        }
        phase = phase.saturating_mul(2);
    }
    run.finish()
}

impl Run<'_> {
    fn is_enough(&self) -> bool {
        let gives_up = self.sweeps >= WISH_SWEEPS && self.best.within(self.goal.required);
        gives_up || self.best.within(self.goal.wished)
    }

    /// Residual now; keeps the impulses when they are the best so far.
    fn note(&mut self) -> bool {
        let residual = self.system.residual();
        let better = residual.size() < self.best.size();
        if better {
            self.best = residual;
            self.best_impulses.clear();
            let impulses = self
                .system
                .contacts
                .iter()
                .map(|c| [c.normal_impulse, c.tangential_impulse]);
            self.best_impulses.extend(impulses);
        }
        better
    }

    fn restore(&mut self) {
        let impulses = std::mem::take(&mut self.best_impulses);
        self.system.set_impulses(&impulses);
        self.best_impulses = impulses;
    }

    /// Iterate up to `limit` times, looking at the residual after 1, 2, 3, 4, 6, 8, 11, … .
    fn iterate(&mut self, limit: usize, mut once: impl FnMut(&mut System, usize)) {
        let limit = limit.min(self.sweeps_max.saturating_sub(self.sweeps));
        let mut look = 1;
        for done in 1..=limit {
            once(self.system, done);
            self.sweeps += 1;
            if done == look || done == limit {
                self.note();
                if self.is_enough() {
                    return;
                }
                look = done + (done / 3).clamp(1, 50);
            }
        }
    }

    fn sweep_plainly(&mut self) {
        self.iterate(STALL_SWEEPS, |system, done| {
            sweep(
                system,
                if done <= PLAIN_SWEEPS {
                    1.0
                } else {
                    RELAXATION
                },
            );
        });
    }

    /// Momentum sweeps from where the run is, unless that is much worse than the best.
    fn sweep_with_momentum(&mut self, limit: usize) {
        if self.system.residual().size() > FAR_OFF * self.best.size() {
            self.restore();
        }
        let mut momentum = MomentumSweeps::new(self.system);
        self.iterate(limit, |system, _| momentum.iterate(system));
    }

    /// The best impulses and exactly the velocities that follow from them.
    fn finish(mut self) -> Outcome {
        self.restore();
        let residual = self.system.residual();
        // Rebuilt velocities differ from swept ones by round-off only.
        let converged = self.best.within(self.goal.required.max(self.goal.wished));
        Outcome {
            sweeps: self.sweeps,
            residual,
            converged,
        }
    }
}
