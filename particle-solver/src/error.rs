//! What can go wrong.

use std::path::PathBuf;

/// An error of the particle engine.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The scene's part or the grains are not usable.
    #[error("{0}")]
    Setup(String),
    /// An argument of a call does not fit the engine's state.
    #[error("{0}")]
    Request(String),
    /// A value is not finite.
    #[error("{what} of grain {grain} is {value}, must be finite")]
    NotFinite {
        /// Which quantity.
        what: &'static str,
        /// Whose.
        grain: usize,
        /// The value.
        value: f64,
    },
    /// The contact solve stopped at its limit.
    #[error(
        "contact residual {residual:.3e} (worst contact {residual_max:.3e}) above tolerance {tolerance:.1e} \
         after {sweeps} of {sweeps_max} sweeps, {contacts} candidate contacts, sub-step {sub_step} of {sub_steps}"
    )]
    NotConverged {
        /// Root mean square of the natural map over engaged contacts.
        residual: f64,
        /// Its largest value.
        residual_max: f64,
        /// The tolerance asked for.
        tolerance: f64,
        /// Sweeps done.
        sweeps: usize,
        /// Sweeps allowed.
        sweeps_max: usize,
        /// Candidate contacts.
        contacts: usize,
        /// Sub-step where it happened, from 1.
        sub_step: u32,
        /// Sub-steps of this advance.
        sub_steps: u32,
    },
    /// Relative motion needs more sub-steps than allowed.
    #[error(
        "relative motion of grains {first} and {second} over the step of {dt:.3e} s needs {needed} sub-steps, \
         at most {sub_steps_max} allowed"
    )]
    SubSteps {
        /// Sub-steps needed.
        needed: u64,
        /// Sub-steps allowed.
        sub_steps_max: u32,
        /// Length of the step \[s\].
        dt: f64,
        /// A grain of the pair that needs them.
        first: usize,
        /// The other one, or a wall when not below the number of grains.
        second: usize,
    },
    /// Load or motion need more small steps than allowed.
    #[error(
        "the load on the grains needs {by_load:.0} and their motion {by_motion:.0} small steps in the step of \
         {dt:.3e} s, at most {sub_steps_max} allowed (contact.sub_steps_max); take a smaller coupling step"
    )]
    SmallSteps {
        /// By the load on contacts.
        by_load: f64,
        /// By the motion of pairs.
        by_motion: f64,
        /// Length of the step \[s\].
        dt: f64,
        /// Sub-steps allowed.
        sub_steps_max: u32,
    },
    /// Grains overlap too much at the end of a step made in small steps.
    #[error(
        "grains overlap by {overlap:.3e} of the radius after {sub_steps} small steps, at most {limit:.3e} allowed, \
         and twice as many steps are more than {sub_steps_max} (contact.sub_steps_max); take a smaller coupling step \
         or contact.solver = \"converged\""
    )]
    Overlap {
        /// Largest, of the smaller radius.
        overlap: f64,
        /// Allowed.
        limit: f64,
        /// Sub-steps made.
        sub_steps: u32,
        /// Sub-steps allowed.
        sub_steps_max: u32,
    },
    /// A sub-step in which grains may meet far more others than they can touch.
    #[error(
        "more than {most} pairs of {grains} grains may meet in one sub-step: it is too long; take a smaller \
         coupling step"
    )]
    Crowded {
        /// Pairs that may be.
        most: usize,
        /// Grains.
        grains: usize,
    },
    /// Grains move so far in a step, or a part of it, that everybody may meet everybody.
    #[error(
        "grains move so far that there are more than {most} distances between {grains} of them to look at: the \
         step is too long; take a smaller coupling step"
    )]
    TooFar {
        /// Distances that a search may cost.
        most: usize,
        /// Grains.
        grains: usize,
    },
    /// The contact margin kept growing.
    #[error(
        "grain {grain} is pushed {moved:.3e} m by contacts in one sub-step, beyond its margin of {margin:.3e} m, \
         after {attempts} attempts"
    )]
    Margin {
        /// The grain.
        grain: usize,
        /// How far contacts push it \[m\].
        moved: f64,
        /// The margin it had \[m\].
        margin: f64,
        /// Attempts made.
        attempts: usize,
    },
    /// A checkpoint cannot be written or read.
    #[error("checkpoint {path}: {why}")]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// Why.
        why: String,
    },
}
