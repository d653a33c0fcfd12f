//! The policy of λ: which share of its response D q a grain is given, and when that changes.
//!
//! ```text
//!   λ = 1   no contact held by a wall: exact where there is no contact at all, one pass       (L1)
//!   λ = 0   held: contacts lead to a wall or a fixed grain, nothing moves under q             (L2)
//!   λ = ½   where that proves wrong: contracts for every frictionless contact set             (L3)
//! ```
//!
//! With λ = ½ a pass is a Peaceman–Rachford step on the contact problem. An engine that does not tell
//! who is held gets ½ for every grain that may touch something.
//!
//! | trouble | grains | new λ |
//! | --- | --- | --- |
//! | first: a pass with held grains, or no progress | wrong ones with λ < ½ | 1 if let go, else ½ |
//! | second: no progress | wrong ones that touch, or with λ < ½ | ½ |
//! | third: no progress | all that touch, or with λ < ½ | ½ |

use crate::coupled::defect::Defect;
use crate::state::Contact;

/// Passes may go on without bringing the defect below this part of its smallest value so far…
const CONTRACTION: f64 = 0.7;
/// … this many times.
const PATIENCE: u32 = 4;
/// A defect that grows by this factor has no patience.
const GROWTH_MAX: f64 = 5.0;
/// A grain's model is wrong when its own defect is above this multiple of the tolerance.
const WRONG: f64 = 10.0;
/// Of (L3).
const HALF: f64 = 0.5;
/// How often λ is raised in a step.
const RAISED_MAX: u32 = 3;

/// The first λ of a step.
#[derive(Debug, Clone, Copy)]
pub struct Policy {
    /// λ of a grain that nothing holds; only tests change it from 1.
    pub free: f64,
    /// Does the particle engine tell who is held?
    pub contacts_told: bool,
}

impl Policy {
    /// λ by the contact state of a candidate (empty: all free); fixed grains have 0.
    pub fn choose(&self, lambda: &mut [f64], fixed: &[bool], contact: &[Contact]) {
        for (grain, lambda) in lambda.iter_mut().enumerate() {
            let contact = contact.get(grain).copied().unwrap_or_default();
            *lambda = match contact {
                _ if fixed[grain] => 0.0,
                Contact::Held => 0.0, // (L2)
                Contact::Touches if !self.contacts_told => HALF,
                Contact::Touches | Contact::Free => self.free, // (L1)
            };
        }
    }
}

/// What a pass showed.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// Its defect.
    pub defect: &'a Defect,
    /// Who touched.
    pub contact: &'a [Contact],
    /// Who never moves.
    pub fixed: &'a [bool],
    /// Defect at which the passes end.
    pub tolerance: f64,
}

/// λ over the passes of one step.
#[derive(Debug, Clone)]
pub struct Progress {
    /// Was λ chosen by a contact solve?
    predicted: bool,
    /// Times λ was raised where the model was wrong.
    raised: u32,
    /// Smallest defect with this matrix, and passes since it was set.
    smallest: f64,
    passes_without: u32,
}

impl Progress {
    /// Before the first pass; `predicted`: λ comes from a contact solve.
    pub fn new(predicted: bool) -> Progress {
        Progress {
            predicted,
            raised: 0,
            smallest: f64::INFINITY,
            passes_without: 0,
        }
    }

    /// The matrix is new: what was reached with the old one does not count.
    pub fn restart(&mut self) {
        self.smallest = f64::INFINITY;
        self.passes_without = 0;
    }

    /// λ for the next pass; says whether the matrix is to be made anew.
    pub fn revise(&mut self, policy: &Policy, lambda: &mut [f64], shown: &Shown<'_>) -> bool {
        self.note(shown.defect.relative);
        if !self.predicted {
            // the first pass had no prediction: it is the prediction of the next
            self.predicted = true;
            policy.choose(lambda, shown.fixed, shown.contact);
            return true;
        }
        if !self.is_stuck(lambda, shown) {
            return false;
        }
        self.raised += 1;
        self.raise(lambda, shown)
    }

    fn note(&mut self, defect: f64) {
        if defect <= CONTRACTION * self.smallest {
            self.smallest = defect;
            self.passes_without = 0;
        } else {
            self.passes_without += 1;
        }
    }

    /// The first pass with held grains (λ = 0 is right or wrong at once), then any lack of progress.
    fn is_stuck(&self, lambda: &[f64], shown: &Shown<'_>) -> bool {
        let mut movable = lambda.iter().zip(shown.fixed).filter(|(_, fixed)| !**fixed);
        let first = self.raised == 0 && movable.any(|(&lambda, _)| lambda == 0.0);
        let grows = shown.defect.relative > GROWTH_MAX * self.smallest;
        self.raised < RAISED_MAX && (first || grows || self.passes_without >= PATIENCE)
    }

    /// Raise λ where the model is wrong; says whether any changed.
    fn raise(&self, lambda: &mut [f64], shown: &Shown<'_>) -> bool {
        let first = self.raised == 1;
        let mut changed = false;
        for (grain, lambda) in lambda.iter_mut().enumerate() {
            let contact = shown.contact[grain];
            let own = shown.defect.of_grains[grain];
            let wrong = self.raised > 2 || own > WRONG * shown.tolerance;
            let suspect = *lambda < HALF || (!first && contact >= Contact::Touches);
            if !wrong || !suspect || shown.fixed[grain] {
                continue;
            }
            // let go by the wall it may move as one with those it touches
            let let_go = first && contact < Contact::Held;
            let better = if let_go { 1.0 } else { HALF };
            changed |= *lambda != better;
            *lambda = better;
        }
        changed
    }
}
