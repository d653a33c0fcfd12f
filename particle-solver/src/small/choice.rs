//! Whether a step is made in small steps, or with converged sweeps.

use space::{Dim, Dimension};

use crate::grains::{Grains, State};

/// How the contacts of a step are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// Many sub-steps with one relaxed sweep each.
    SmallSteps,
    /// Few sub-steps, sweeps until the laws hold to a tolerance.
    Converged,
}

/// Fewer contacts that act are solved to the end at no cost worth saving.
const CONTACTS: usize = 100;

/// Which of them serves a step of length `dt` \[s\] from this state under these drags γ \[kg/s\], where the scene
/// does not say.
///
/// Small steps pay where grains press on each other for long: at least every second one that moves acts on another or
/// on a wall. They start from impulses that hold the load; a state that has none, at the start of a run, is solved to
/// the end first. With stiff drag, Σ γ Δt > Σ m, sweeps converge fast and small steps would cost more.
pub fn choose<const D: usize>(
    wished: Option<Solver>,
    grains: &Grains,
    state: &State<D>,
    drag: Option<&[f64]>,
    dt: f64,
) -> Solver
where
    Dim<D>: Dimension<D>,
{
    let acting = state.impulses.entries.len();
    let cold = state.impulses.dt == 0.0;
    if cold || wished == Some(Solver::Converged) {
        return Solver::Converged;
    }
    let (mut moving, mut mass, mut drags) = (0, 0.0, 0.0);
    for grain in (0..grains.count()).filter(|&grain| !grains.fixed[grain]) {
        moving += 1;
        mass += grains.mass[grain];
        drags += drag.map_or(0.0, |drag| drag[grain]);
    }
    let pressed = acting >= CONTACTS && 2 * acting >= moving && drags * dt <= mass;
    match wished {
        None if !pressed => Solver::Converged,
        _ => Solver::SmallSteps,
    }
}
