//! Small steps: a step is cut into many sub-steps with one relaxed sweep each, and no contact problem is solved to
//! its end.
//!
//! What a sweep leaves is found again by the next one, one sub-step later: load travels through a heap as a wave, in
//! as many sub-steps as it has layers, where converged sweeps need the square of that. A force F that appears lets a
//! contact sink by δ = W F h² first, as a spring of stiffness 1/(W h²) would; h is chosen so that this is little
//! (count). After Macklin et al. (2019), who cut steps so for position-based dynamics; here the unknowns are impulses
//! and the law is that of `contact::law`. Read in this order:
//!
//! * [`records`]: what a sub-step reads and writes;
//! * [`pass`]: one sub-step;
//! * [`near`]: which contacts may act before the end of the step;
//! * [`count`]: how many sub-steps;
//! * [`choice`]: whether a step is made so, or with converged sweeps;
//! * [`stretch`]: some in a row, with the same candidates;
//! * [`run`]: all of them, and what is done about overlaps.

pub mod choice;
pub mod count;
pub mod near;
pub mod pass;
pub mod records;
pub mod run;
pub mod stretch;
