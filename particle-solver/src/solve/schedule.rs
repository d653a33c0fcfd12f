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

use space::{Dim, Dimension};

use crate::contact::delassus::System;
use crate::contact::law::Local;
use crate::contact::residual::Residual;
use crate::solve::momentum::MomentumSweeps;
use crate::solve::sweep::{RELAXATION, sweep};

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
struct Run<'a, const D: usize>
where
    Dim<D>: Dimension<D>,
{
    system: &'a mut System<D>,
    goal: Goal,
    sweeps_max: usize,
    sweeps: usize,
    best: Residual,
    best_impulses: Vec<Local<D>>,
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
pub fn solve<const D: usize>(
    system: &mut System<D>,
    warm: &[Local<D>],
    goal: Goal,
    sweeps_max: usize,
) -> Outcome
where
    Dim<D>: Dimension<D>,
{
    let mut run = Run {
        best_impulses: system.impulses(),
        best: system.residual(),
        system,
        goal,
        sweeps_max,
        sweeps: 0,
    };
    if run.best.within(goal.wished) {
        return run.finish();
    }
    run.start_from(warm);
    if !run.is_enough() {
        run.sweep_plainly();
        run.sweep_in_phases();
    }
    run.finish()
}

impl<const D: usize> Run<'_, D>
where
    Dim<D>: Dimension<D>,
{
    /// Remembered impulses, when they leave less than none.
    fn start_from(&mut self, warm: &[Local<D>]) {
        if warm.iter().any(|impulse| impulse.normal > 0.0) {
            self.system.set_impulses(warm);
            if !self.keep_if_best() {
                self.restore();
            }
        }
    }

    /// Momentum sweeps, with friction in turn with under-relaxed ones.
    fn sweep_in_phases(&mut self) {
        let mut phase = if self.system.has_friction() {
            PHASE_SWEEPS
        } else {
            usize::MAX
        };
        while !self.is_enough() && self.sweeps < self.sweeps_max {
            self.sweep_with_momentum(phase);
            if !self.is_enough() {
                self.iterate(phase, |system, _| {
                    sweep(system, UNDER_RELAXATION);
                });
            }
            phase = phase.saturating_mul(2);
        }
    }

    fn is_enough(&self) -> bool {
        let gives_up = self.sweeps >= WISH_SWEEPS && self.best.within(self.goal.required);
        gives_up || self.best.within(self.goal.wished)
    }

    /// Keeps the impulses when their residual is the best so far; was it?
    fn keep_if_best(&mut self) -> bool {
        let residual = self.system.residual();
        let better = residual.size() < self.best.size();
        if better {
            self.best = residual;
            self.best_impulses.clear();
            let contacts = self.system.contacts.iter();
            self.best_impulses
                .extend(contacts.map(|contact| contact.impulse));
        }
        better
    }

    fn restore(&mut self) {
        let impulses = std::mem::take(&mut self.best_impulses);
        self.system.set_impulses(&impulses);
        self.best_impulses = impulses;
    }

    /// Iterate up to `limit` times, looking at the residual after 1, 2, 3, 4, 6, 8, 11, … .
    fn iterate(&mut self, limit: usize, mut once: impl FnMut(&mut System<D>, usize)) {
        let limit = limit.min(self.sweeps_max.saturating_sub(self.sweeps));
        let mut look = 1;
        for done in 1..=limit {
            once(self.system, done);
            self.sweeps += 1;
            if done == look || done == limit {
                self.keep_if_best();
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
